#include "io/image/color_image.h"

#include <array>
#include <string>

#include "io/image/color_formats.h"
#include "kernels/core/status.h"

namespace meander {

namespace {

struct ImageFormat {
  bool (*is)(std::span<const std::byte> bytes);
  ImageMemory (*memory)(std::span<const std::byte> bytes);
  ColorImage (*decode)(std::span<const std::byte> bytes, const CancelToken& cancel);
};

// Null where the bytes begin like none of the formats that are read. TGA has no mark of its own.
const ImageFormat* image_format_of(std::span<const std::byte> bytes) {
  static constexpr std::array<ImageFormat, 6> formats = {{
      {is_png, memory_of_png, decode_color_png},
      {is_jpeg, memory_of_jpeg, decode_color_jpeg},
      {is_webp, memory_of_webp, decode_color_webp},
      {is_gif, memory_of_gif, decode_color_gif},
      {is_bmp, memory_of_bmp, decode_color_bmp},
      {is_tga, memory_of_tga, decode_color_tga},
  }};
  for (const ImageFormat& format : formats) {
    if (format.is == is_tga && !unread_image_format(bytes).empty()) return nullptr;
    if (format.is(bytes)) return &format;
  }
  return nullptr;
}

}  // namespace

void check_image_size(std::uint64_t width, std::uint64_t height) {
  const std::string size = std::to_string(width) + " x " + std::to_string(height) + " pixels";
  if (width == 0 || height == 0) throw ItemError(Status::unreadable, size + " are none");
  if (height > most_image_pixels / width)
    throw ImageError(Note::image_too_large,
                     size + " are more than the " + std::to_string(most_image_pixels) + " that are decoded");
}

ImageMemory memory_of_image(std::span<const std::byte> bytes) {
  try {
    if (const ImageFormat* const format = image_format_of(bytes)) return format->memory(bytes);
  } catch (const ItemError&) {  // it will not be decoded either
  }
  return {};
}

ColorImage decode_color_image(std::span<const std::byte> bytes, const CancelToken& cancel) {
  ColorImage lost;
  try {
    if (const ImageFormat* const format = image_format_of(bytes)) return format->decode(bytes, cancel);
    lost.loss = Note::image_unsupported;
    const std::string_view name = unread_image_format(bytes);
    lost.problem = name.empty() ? "neither a PNG, JPEG, WebP, GIF, BMP nor TGA file"
                                : std::string(name) + "; PNG, JPEG, WebP, GIF, BMP and TGA are read";
    if (bytes.empty()) {
      lost.loss = Note::image_unreadable;
      lost.problem = "the file is empty";
    }
  } catch (const ImageError& error) {
    lost.problem = error.what();
    lost.loss = error.loss();
  } catch (const ItemError& error) {
    if (error.status() != Status::unreadable) throw;
    lost.problem = error.what();
    lost.loss = Note::image_unreadable;
  }
  return lost;
}

}  // namespace meander
