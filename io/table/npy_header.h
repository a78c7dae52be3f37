// The header of numpy's file format.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace meander {

// The header of an .npy file (version 1.0 of the format) for an array in C order. `type` as numpy writes it
// ("<f4", "|u1"). The values begin at a multiple of 64 bytes.
std::string npy_header(std::string_view type, std::span<const std::uint64_t> shape);

// The type of numbers, as numpy writes it; empty for others.
template <class Number>
constexpr std::string_view numpy_type = "";
template <>
inline constexpr std::string_view numpy_type<float> = "<f4";
template <>
inline constexpr std::string_view numpy_type<double> = "<f8";
template <>
inline constexpr std::string_view numpy_type<std::int32_t> = "<i4";
template <>
inline constexpr std::string_view numpy_type<std::uint32_t> = "<u4";
template <>
inline constexpr std::string_view numpy_type<std::uint8_t> = "|u1";

// The contents of the header of a file.
struct NpyHeader {
  std::string type;                  // "<f8"; empty for values with fields
  bool fortran_order = false;        // the first index varies fastest
  std::vector<std::uint64_t> shape;  // as stated, not checked against the length of the file
  std::size_t bytes = 0;             // the offset of the values
};

// Reads the header of a whole file of versions 1 to 3, by any writer: keys in any order, any blanks. Throws
// ItemError: unreadable for a missing or damaged header, unsupported_format for later versions. O(header).
NpyHeader read_npy_header(std::string_view content);
// Whether the content begins like a file of this format.
bool looks_like_npy(std::string_view content);

}  // namespace meander
