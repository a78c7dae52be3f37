// The header of numpy's file format.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace meander {

// What stands in an .npy file (version 1.0 of the format) before the values of an array in C order. `type` as
// numpy writes it ("<f4", "|u1"). The values begin at a multiple of 64 bytes.
std::string npy_header(std::string_view type, std::span<const std::uint64_t> shape);

}  // namespace meander
