// Reading pictures as gray values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace meander {

// height rows from top to bottom of width values from left to right, each in [0,1]: 0 black, 1 white.
struct GrayImage {
  std::uint32_t width = 0, height = 0;
  std::vector<float> values;  // width x height
};

// Reads any PNG file: gray of 1, 2, 4, 8 and 16 bits, palette, RGB; interlaced or not. A value is the stored
// sample over its largest value; colors become the luma 0.2126 R + 0.7152 G + 0.0722 B (ITU-R BT.709) of
// their stored samples, so that a gray picture gives the same values in every color type. No gamma and no
// color profile is applied. Alpha and transparency are dropped.
//
// Throws ItemError(unreadable) with a sentence: the file cannot be opened, is not a PNG file, is cut or
// damaged in what the picture needs, promises more pixels than its bytes can hold, or needs more than
// `most_bytes` of memory (4 bytes a pixel; interlaced ones 5 to 10). Sizes are checked before memory is
// taken. bad_alloc passes. Cost: linear.
GrayImage read_gray_png(const std::filesystem::path& path, std::uint64_t most_bytes = std::uint64_t{2} << 30);
// The same for the bytes of a file.
GrayImage decode_gray_png(std::span<const std::byte> bytes,
                          std::uint64_t most_bytes = std::uint64_t{2} << 30);

}  // namespace meander
