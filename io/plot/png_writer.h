// Writes pictures as PNG.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "kernels/data/rgb_image.h"

namespace meander {

// The bytes of an 8-bit RGB PNG file (sRGB). The same picture gives the same bytes. Throws
// std::invalid_argument for a picture without pixels or whose buffer does not fit its size,
// std::runtime_error with libpng's reason.
std::vector<std::byte> encode_png(const RgbImage& image);

// Writes the picture under a temporary name beside `path`, syncs and renames it, so that `path` is the old
// picture or the complete new one. Throws what encode_png throws, and FileError.
void write_png(const std::filesystem::path& path, const RgbImage& image);

}  // namespace meander
