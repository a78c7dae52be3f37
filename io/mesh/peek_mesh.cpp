// Estimates of mesh sizes from 256 KiB of a file.
//
// Headers are believed where the size of the file agrees. Text is sampled: a file of up to 256 KiB is looked
// at whole, a larger one at its beginning and at one spot in each of equal strata, so that the share of the
// file that vertices and faces take is known to about one stratum.
#include "io/mesh/mesh_peek.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/file/input_file.h"
#include "io/mesh/format_readers.h"
#include "io/mesh/text_cursor.h"

namespace meander {

namespace {

using text::TextCursor;
using text::Token;

constexpr std::uint64_t most_bytes = 256 << 10;
constexpr std::uint64_t head_bytes = 64 << 10;
constexpr std::size_t spots = 48;
constexpr std::size_t spot_bytes = (most_bytes - head_bytes) / spots;

// Whole lines of a part of the file, and how many bytes of the file they stand for.
struct Stratum {
  std::string lines;
  double bytes = 0;
};

std::vector<Stratum> strata_of(const MeshPeek& peek) {
  std::vector<Stratum> result;
  if (peek.whole) return {{peek.head, static_cast<double>(peek.head.size())}};
  const std::size_t last = peek.head.rfind('\n');
  if (last != std::string::npos)
    result.push_back({peek.head.substr(0, last + 1), static_cast<double>(peek.head.size())});
  const double width = static_cast<double>(peek.file.bytes() - head_bytes) / spots;
  for (std::size_t s = 0; s < spots; ++s) {
    // Golden-ratio steps keep the spots out of step with anything periodic in the file.
    const double within = std::fmod(0.5 + 0.6180339887498949 * static_cast<double>(s), 1.0);
    const double room = std::max(0.0, width - static_cast<double>(spot_bytes));
    const auto offset =
        head_bytes + static_cast<std::uint64_t>(static_cast<double>(s) * width + within * room);
    const std::string bytes = peek.file.read(offset, spot_bytes);
    const std::size_t first = bytes.find('\n'), end = bytes.rfind('\n');
    if (first != end) result.push_back({bytes.substr(first + 1, end - first), width});
  }
  return result;
}

// See estimate_from_counts.
ElementCounts count_polygon_lines(std::string_view lines, std::size_t before, bool hash_comments) {
  ElementCounts counts;
  TextCursor cursor{lines.data(), lines.data() + lines.size(), hash_comments};
  while (cursor.skip_to_token()) {
    const char* const line_end = text::find_line_end(cursor.at, cursor.end);
    TextCursor line{cursor.at, line_end, hash_comments};
    cursor.at = line_end;
    for (std::size_t k = 0; k < before; ++k) line.word();
    std::int64_t corners = 0, number = 0;
    if (line.integer(corners) != Token::ok || corners < 3) continue;
    std::int64_t k = 0;
    while (k < corners && line.integer(number) == Token::ok) ++k;
    if (k < corners) continue;
    ++counts.faces;
    counts.triangles += static_cast<double>(corners - 2);
  }
  return counts;
}

}  // namespace

MeshPeek::MeshPeek(const ByteSource& opened, MeshFormat format_by_name)
    : file(opened),
      format(format_by_name),
      head(opened.read(0, opened.bytes() <= most_bytes ? most_bytes : head_bytes)),
      whole(opened.bytes() <= most_bytes) {}

std::optional<ElementCounts> sampled(const MeshPeek& peek,
                                     const std::function<ElementCounts(std::string_view)>& count_lines) {
  ElementCounts total;
  double covered = 0;
  for (const Stratum& stratum : strata_of(peek)) {
    if (stratum.lines.empty()) continue;
    total.add(count_lines(std::string_view(stratum.lines)),
              stratum.bytes / static_cast<double>(stratum.lines.size()));
    covered += stratum.bytes;
  }
  if (covered == 0) return std::nullopt;
  const double scale = static_cast<double>(peek.file.bytes()) / covered;
  if (peek.whole) return total;
  ElementCounts raised;
  raised.add(total, scale);
  return raised;
}

MeshEstimate estimate_from_size(std::uint64_t bytes) { return {bytes, bytes / 6 + 1, bytes / 6 + 1}; }

MeshEstimate estimate_from_reader(const MeshPeek& peek) {
  try {
    const PolygonMesh mesh = read_mesh(std::as_bytes(std::span(peek.head)), peek.format);
    std::uint64_t triangles = 0;
    for (std::size_t p = 0; p < mesh.polygon_count(); ++p) {
      const std::uint32_t corners = mesh.polygon_begin[p + 1] - mesh.polygon_begin[p];
      triangles += corners < 3 ? 0 : corners - 2;
    }
    return {peek.file.bytes(), mesh.vertex_count(), triangles};
  } catch (const ItemError&) {
    return estimate_from_size(peek.file.bytes());
  }
}

MeshEstimate estimate_from_counts(const MeshPeek& peek, std::uint64_t vertices, std::uint64_t faces,
                                  std::size_t before, bool hash_comments) {
  const std::uint64_t bytes = peek.file.bytes();
  vertices = std::min(vertices, bytes / 6 + 1);
  const std::optional<ElementCounts> counts = sampled(
      peek, [&](std::string_view lines) { return count_polygon_lines(lines, before, hash_comments); });
  const bool seen = counts.has_value() && counts->faces > 0;
  if (peek.whole) {
    if (seen && static_cast<std::uint64_t>(counts->faces) == faces)
      return {bytes, vertices, static_cast<std::uint64_t>(counts->triangles)};
    return estimate_from_reader(peek);
  }
  if (!seen) return {bytes, vertices, std::min(2 * std::min(faces, bytes), bytes / 6 + 1)};
  const double there = std::min(static_cast<double>(faces), sampling_margin * counts->faces);
  const double each = counts->triangles / counts->faces;
  return {bytes, vertices, rounded_up(there * (each == 1 ? 1 : 1.1 * each))};
}

MeshEstimate most_in_text(std::uint64_t bytes) { return {bytes, bytes / 2, bytes / 2}; }

MeshEstimate peek_mesh(const std::filesystem::path& path, MeshFormat format) {
  return peek_mesh(InputFile(path), format);
}

MeshEstimate peek_mesh(const ByteSource& file, MeshFormat format) {
  if (file.bytes() == 0) return {};
  const FormatRow& row = row_of(format);
  if (row.peek_file != nullptr)
    if (const std::optional<MeshEstimate> estimate = row.peek_file(file)) return *estimate;
  MeshPeek peek(file, format);
  const bool utf16 = peek.head.starts_with("\xFF\xFE") || peek.head.starts_with("\xFE\xFF");
  if (utf16) return peek.whole ? estimate_from_reader(peek) : estimate_from_size(file.bytes() / 2);
  // Files that may be binary keep their offsets.
  if (row.is_raw == nullptr && peek.head.starts_with("\xEF\xBB\xBF")) peek.head.erase(0, 3);
  try {
    return row.peek(peek);
  } catch (const ItemError&) {
    // The header cannot be read: neither will the mesh be.
  }
  return estimate_from_size(file.bytes());
}

}  // namespace meander
