// Internal to io/mesh: the header of a PLY file.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace meander {

// Those of 64 bits are not in the format, but programs write them.
enum class PlyType : std::uint8_t {
  int8,
  uint8,
  int16,
  uint16,
  int32,
  uint32,
  float32,
  float64,
  int64,
  uint64
};
inline constexpr std::size_t ply_type_bytes[] = {1, 1, 2, 2, 4, 4, 4, 8, 8, 8};
constexpr bool is_real(PlyType type) { return type == PlyType::float32 || type == PlyType::float64; }
constexpr std::size_t bytes_of(PlyType type) { return ply_type_bytes[static_cast<std::size_t>(type)]; }

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::float32;  // of the value, or of the list's entries
  bool is_list = false;
  PlyType count_type = PlyType::uint8;  // of the list's length
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  bool has_lists() const;
  // Bytes of a row of a binary file without its lists' entries.
  std::size_t fixed_bytes() const;
  // The position of the list of vertex numbers among the properties, or -1. Only faces and strips have one.
  int index_list() const;
  // The position of the scalar of this name, or -1. Some programs write names in capitals: one of exactly
  // this name goes first.
  int scalar_named(std::string_view lower_case) const;
};

enum class PlyEncoding : std::uint8_t { ascii, little_endian, big_endian };

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::ascii;
  std::vector<PlyElement> elements;
  // The images that textures show, as `comment TextureFile NAME` gives them (MeshLab, VCG), in order.
  std::vector<std::string> texture_files;
  std::size_t body = 0;  // the first byte behind the header

  const PlyElement* find(std::string_view name) const;
  // Whether binary numbers have the other byte order than this machine's.
  bool swaps_bytes() const {
    return (encoding == PlyEncoding::big_endian) == (std::endian::native == std::endian::little);
  }
};

// Line ends may be LF, CRLF, CR or LF CR. Throws ItemError(unreadable) with the line; the word of a version
// is not looked at.
PlyHeader parse_ply_header(std::string_view text);

// The paths of those images from the model's folder, each once; none for a file that cannot be read.
std::vector<std::string> ply_image_paths(std::span<const std::byte> bytes);

}  // namespace meander
