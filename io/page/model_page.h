// A page with models that turn: one HTML file that opens from disk, with points, script and style inside.
//
// The points of each model are a data block in base64, decoded when the model is first seen; another block
// has the facts about all models as one JSON object. Nothing of a store becomes markup: the script sets it as
// text. By its Content-Security-Policy the page loads nothing, and runs no script but the one it was written
// with.
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
//   u16 x 3   position: low + value / 65535 (high - low) for each axis, low and high being the box of the
//   points;
//             the error is at most 2^-17 of the box
//   i8 x 2    normal, octahedral (Meyer, Suessmuth, Sussner, Stamminger and Greiner 2010), / 127; the error
//   is
//             less than 1 degree
//   u8        density between the lowest (0) and the highest (255), in logarithms if all are > 0
//   u8        rank along the curve, over the largest rank of the row
struct PackedPoints {
  std::array<double, 3> low{}, high{};
  double density_low = 0, density_high = 0;
  std::vector<std::byte> bytes;
};

// Packs the samples with these numbers in this order. Throws std::out_of_range for an invalid number.
PackedPoints pack_points(const Samples& samples, std::span<const std::uint32_t> chosen);

// The two coordinates of a unit vector on the unfolded octahedron, in 1/127.
std::array<std::int8_t, 2> octahedral_normal(const float* normal);

// RFC 4648, with padding.
std::string base64(std::span<const std::byte> bytes);

// The JSON text for a script element of HTML: every `<` is written as \u003c, so that neither `</script` nor
// `<!--` occurs.
std::string json_in_markup(std::string_view json);

// Writes the page piece by piece, one model in memory at a time. Throws FileError; without finish() no file
// is left and an existing one is kept.
class ModelPageWriter {
 public:
  explicit ModelPageWriter(const std::filesystem::path& path);
  // Appends the next model: its packed points, and the data that `facts_json` announces after them.
  void append_model(std::span<const std::byte> bytes);
  // facts_json: the facts about the models for the script (viewer.js, points.js). Returns the bytes of the
  // file.
  std::uint64_t finish(std::string_view facts_json);

 private:
  void append(std::string_view text);
  AtomicFile file_;
  std::uint64_t size_ = 0, models_ = 0;
};

}  // namespace meander
