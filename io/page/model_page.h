// A page to turn models in: one HTML file that opens from disk, with points, script and style inside.
//
// The points of a model are base64 in a data block of their own, decoded when the model is first seen; what
// is known of the models is one JSON object in another. Nothing of a store is ever markup: the script sets it
// as text. The page forbids itself by its Content-Security-Policy to load anything, and to run any script but
// the one it was written with.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/file/atomic_file.h"
#include "kernels/data/samples.h"

namespace meander {

inline constexpr std::size_t packed_point_bytes = 10;

// Points as the page draws them, 10 bytes each, little-endian:
//   u16 x 3   place: coordinate = low + value / 65535 (high - low), an axis; low and high are the box of the
//             points, so it is off by at most 2^-17 of the box
//   i8 x 2    normal, octahedral (Meyer, Suessmuth, Sussner, Stamminger and Greiner 2010), / 127; off by less
//             than 1 degree
//   u8        density: its share of the way from the lowest to the highest, in logarithms where all are > 0
//   u8        rank along the curve over its largest value in the store's row
struct PackedPoints {
  std::array<double, 3> low{}, high{};
  double density_low = 0, density_high = 0;
  std::vector<std::byte> bytes;
};

// The samples of these numbers, in this order. Throws std::out_of_range for a number that is none.
PackedPoints pack_points(const Samples& samples, std::span<const std::uint32_t> chosen);

// The two coordinates of a unit vector on the unfolded octahedron, in 1/127.
std::array<std::int8_t, 2> octahedral_normal(const float* normal);

// RFC 4648, with padding.
std::string base64(std::span<const std::byte> bytes);

// JSON that may stand inside a script element of HTML: every `<` as \u003c, so that neither `</script` nor
// `<!--` occurs.
std::string json_in_markup(std::string_view json);

// Writes the page piece by piece, one model in memory at a time. Throws FileError; without finish() no file
// is left and an existing one is kept.
class ModelPageWriter {
 public:
  explicit ModelPageWriter(const std::filesystem::path& path);
  // The packed points of the next model and whatever follows them, as `facts` explains.
  void append_model(std::span<const std::byte> bytes);
  // facts: what the script (viewer.js, points.js) knows of the models. Returns the bytes of the file.
  std::uint64_t finish(std::string_view facts_json);

 private:
  void append(std::string_view text);
  AtomicFile file_;
  std::uint64_t size_ = 0, models_ = 0;
};

}  // namespace meander
