// Internal to io/image: the decoders behind decode_color_image, one per format.
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

bool is_png(std::span<const std::byte> bytes);
bool is_jpeg(std::span<const std::byte> bytes);
bool is_webp(std::span<const std::byte> bytes);
bool is_gif(std::span<const std::byte> bytes);
bool is_bmp(std::span<const std::byte> bytes);
// TGA files begin with no mark: to be asked after all others. Holds where each field of the header is one
// that the format has; text, and files that begin with any of the other marks, have none such.
bool is_tga(std::span<const std::byte> bytes);
ImageMemory memory_of_png(std::span<const std::byte> bytes);
ImageMemory memory_of_jpeg(std::span<const std::byte> bytes);
ImageMemory memory_of_webp(std::span<const std::byte> bytes);
ImageMemory memory_of_gif(std::span<const std::byte> bytes);
ImageMemory memory_of_bmp(std::span<const std::byte> bytes);
ImageMemory memory_of_tga(std::span<const std::byte> bytes);
ColorImage decode_color_png(std::span<const std::byte> bytes, const CancelToken& cancel);
ColorImage decode_color_jpeg(std::span<const std::byte> bytes, const CancelToken& cancel);
ColorImage decode_color_webp(std::span<const std::byte> bytes, const CancelToken& cancel);
ColorImage decode_color_gif(std::span<const std::byte> bytes, const CancelToken& cancel);
ColorImage decode_color_bmp(std::span<const std::byte> bytes, const CancelToken& cancel);
ColorImage decode_color_tga(std::span<const std::byte> bytes, const CancelToken& cancel);

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
