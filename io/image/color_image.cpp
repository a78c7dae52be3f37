#include "io/image/color_image.h"

#include <algorithm>
#include <array>
#include <string>

#include "io/image/color_formats.h"
#include "io/word_list.h"
#include "kernels/core/status.h"

namespace meander {

extern const ImageFormat png_image_format, jpeg_image_format, webp_image_format, gif_image_format,
    bmp_image_format, tga_image_format;

namespace {

constexpr std::array<const ImageFormat*, 6> image_formats = {&png_image_format,  &jpeg_image_format,
                                                             &webp_image_format, &gif_image_format,
                                                             &bmp_image_format,  &tga_image_format};

std::string names_of_images(std::string_view conjunction) {
  std::array<std::string_view, image_formats.size()> names;
  std::transform(image_formats.begin(), image_formats.end(), names.begin(),
                 [](const ImageFormat* format) { return format->name; });
  return word_list(names, conjunction);
}

// Null where the bytes begin like none of the formats that are read.
const ImageFormat* image_format_of(std::span<const std::byte> bytes) {
  for (const ImageFormat* const format : image_formats) {
    if (!format->has_mark && !unread_image_format(bytes).empty()) return nullptr;
    if (format->is(bytes)) return format;
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
    lost.problem = name.empty() ? "neither a " + names_of_images("nor") + " file"
                                : std::string(name) + "; " + names_of_images("and") + " are read";
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
