// Internal to io/image: what the decoders behind decode_color_image share.
//
// Each throws ItemError(unreadable) with the sentence that the image gets as its problem: an ImageError where
// the loss is another one than image_unreadable.
#pragma once

#include <string>
#include <string_view>

#include "io/image/color_image.h"
#include "kernels/core/status.h"

namespace meander {

class ImageError : public ItemError {
 public:
  ImageError(Note loss, const std::string& reason) : ItemError(Status::unreadable, reason), loss_(loss) {}
  Note loss() const { return loss_; }

 private:
  Note loss_;
};

// A format of images. Each decoder defines its own row, and the list in color_image.cpp names all.
struct ImageFormat {
  std::string_view name;
  bool (*is)(std::span<const std::byte> bytes);
  ImageMemory (*memory)(std::span<const std::byte> bytes);  // see memory_of_image
  ColorImage (*decode)(std::span<const std::byte> bytes, const CancelToken& cancel);
  // Whether files begin with a mark. One without is asked after all others: it holds where each field of the
  // header is one that the format has; text, and files that begin with any of the other marks, have none
  // such.
  bool has_mark = true;
};

// The name of a format that is told apart but not read, as "a KTX2 file"; empty: none of them.
std::string_view unread_image_format(std::span<const std::byte> bytes);

// Throws where such an image has too many pixels, or none.
void check_image_size(std::uint64_t width, std::uint64_t height);
inline constexpr std::size_t image_rows_between_checks = 64;

// A value of 0 .. most as one of 0 .. 255, rounded.
constexpr std::uint8_t byte_of_value(std::uint32_t value, std::uint32_t most) {
  return static_cast<std::uint8_t>((std::uint64_t{value} * 255 + most / 2) / most);
}

}  // namespace meander
