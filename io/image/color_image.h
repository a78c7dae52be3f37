// Reading pictures as colors: PNG, JPEG, WebP, GIF, BMP and TGA, by what they contain whatever their name
// is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "kernels/core/cancel.h"
#include "kernels/mesh/surface_textures.h"

namespace meander {

// Larger ones are not decoded: 8192 x 8192, 192 MiB as RGB.
inline constexpr std::uint64_t most_image_pixels = std::uint64_t{1} << 26;

// What decoding takes, from the header alone: for good, and beside that while it is under way. Zeros for what
// decode_color_image would not decode. Of damaged files perhaps too much. O(header).
struct ImageMemory {
  std::uint64_t kept_bytes = 0, working_bytes = 0;
};
ImageMemory memory_of_image(std::span<const std::byte> bytes);

// Any PNG file: gray of 1, 2, 4, 8 and 16 bits, palette, RGB; 16 bits are rounded to 8. Any JPEG file of 8
// bits by libjpeg: gray, RGB, YCbCr, CMYK, YCCK; baseline and progressive. WebP by libwebp, lossy and
// lossless. GIF, with one palette or two, interlaced. BMP of 1, 2, 4, 8, 16, 24 and 32 bits, with masks, and
// with runs of 4 and 8 bits. TGA of 15, 16, 24 and 32 bits, gray and palettes, with runs, from any corner. Of
// an animation the first picture; what that leaves out of the whole has the background's color. Alpha,
// gamma, color profiles and the orientation that a camera notes are not applied: values are as stored, taken
// as sRGB.
//
// An image that is none of these, is cut or damaged, has more than most_image_pixels, or promises more pixels
// than its bytes can hold comes back without pixels, with a sentence and the kind of its loss. Sizes are
// checked before memory is taken. Throws what `cancel` throws, and bad_alloc. Cost: linear.
ColorImage decode_color_image(std::span<const std::byte> bytes, const CancelToken& cancel = {});

}  // namespace meander
