// Internal to io/image: the decoders behind decode_color_image, one per format.
//
// Each throws ItemError(unreadable) with the sentence that the image gets as its problem.
#pragma once

#include "io/image/color_image.h"

namespace meander {

bool is_png(std::span<const std::byte> bytes);
bool is_jpeg(std::span<const std::byte> bytes);
ImageMemory memory_of_png(std::span<const std::byte> bytes);
ImageMemory memory_of_jpeg(std::span<const std::byte> bytes);
ColorImage decode_color_png(std::span<const std::byte> bytes, const CancelToken& cancel);
ColorImage decode_color_jpeg(std::span<const std::byte> bytes, const CancelToken& cancel);

// Throws where such an image has too many pixels, or none.
void check_image_size(std::uint64_t width, std::uint64_t height);
inline constexpr std::size_t image_rows_between_checks = 64;

}  // namespace meander
