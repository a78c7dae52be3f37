#include "io/image/color_image.h"

#include <string>

#include "io/image/color_formats.h"
#include "kernels/core/status.h"

namespace meander {

void check_image_size(std::uint64_t width, std::uint64_t height) {
  const std::string size = std::to_string(width) + " x " + std::to_string(height) + " pixels";
  if (width == 0 || height == 0) throw ItemError(Status::unreadable, size + " are none");
  if (height > most_image_pixels / width)
    throw ItemError(Status::unreadable,
                    size + " are more than the " + std::to_string(most_image_pixels) + " that are decoded");
}

ImageMemory memory_of_image(std::span<const std::byte> bytes) {
  try {
    if (is_png(bytes)) return memory_of_png(bytes);
    if (is_jpeg(bytes)) return memory_of_jpeg(bytes);
  } catch (const ItemError&) {  // it will not be decoded either
  }
  return {};
}

ColorImage decode_color_image(std::span<const std::byte> bytes, const CancelToken& cancel) {
  ColorImage lost;
  lost.problem = "neither a PNG nor a JPEG file";
  try {
    if (is_png(bytes)) return decode_color_png(bytes, cancel);
    if (is_jpeg(bytes)) return decode_color_jpeg(bytes, cancel);
  } catch (const ItemError& error) {
    if (error.status() != Status::unreadable) throw;
    lost.problem = error.what();
  }
  return lost;
}

}  // namespace meander
