// The header of numpy's file format.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace meander {

// What stands in an .npy file (version 1.0 of the format) before the values of an array in C order. `type` as
// numpy writes it ("<f4", "|u1"). The values begin at a multiple of 64 bytes.
std::string npy_header(std::string_view type, std::span<const std::uint64_t> shape);

// The type of numbers, as numpy writes it.
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

// What the header of a file says about the values behind it.
struct NpyHeader {
  std::string type;                  // "<f8"; empty where the values have fields
  bool fortran_order = false;        // the first index runs fastest
  std::vector<std::uint64_t> shape;  // as the file states it: nothing is checked against its length
  std::size_t bytes = 0;             // where the values begin
};

// Reads the header of a whole file, of versions 1 to 3, from any writer: keys in any order, any blanks.
// Throws ItemError with a sentence: unreadable for no or a damaged header, unsupported_format for later
// versions. O(header).
NpyHeader read_npy_header(std::string_view content);
// Whether the content begins as files of this format do.
bool looks_like_npy(std::string_view content);

}  // namespace meander
