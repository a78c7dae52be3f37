// OBJ: what is known of a file without reading its faces.
#include <algorithm>
#include <bit>
#include <optional>
#include <string>
#include <vector>

#include "io/mesh/format_readers.h"
#include "io/mesh/mtl_reader.h"
#include "io/mesh/obj_blocks.h"
#include "io/mesh/text_cursor.h"
#include "kernels/core/vector_instructions.h"

namespace meander {

namespace {

using text::TextCursor;
using text::Token;

LooksLike looks_like_obj(std::string_view head) {
  TextCursor cursor{head.data(), head.data() + head.size()};
  std::size_t vertices = 0;
  while (cursor.skip_to_token()) {
    const std::string_view word = cursor.word();
    double number = 0;
    if (word == "v") {
      for (int k = 0; k < 3; ++k)
        if (!cursor.token_on_line() || cursor.number(number) != Token::ok) return LooksLike::other;
      if (++vertices == 3) return LooksLike::mesh;
    } else if (word != "vn" && word != "vt" && word != "o" && word != "g" && word != "s" &&
               word != "mtllib" && word != "usemtl") {
      return LooksLike::other;
    }
    cursor.skip_line();
  }
  return LooksLike::other;
}

// Counts the tokens from the one that the cursor stands at to the end of its line or a comment, and moves
// there. Sixteen bytes at a time: faces are most of many files.
std::size_t tokens_on_line(TextCursor& cursor) {
  std::size_t tokens = 0;
  std::uint32_t after_separator = 1;
  const auto mask = [](__m128i bytes) { return static_cast<std::uint32_t>(_mm_movemask_epi8(bytes)); };
  for (; cursor.end - cursor.at >= 16; cursor.at += 16) {
    const __m128i bytes = _mm_loadu_si128(reinterpret_cast<const __m128i*>(cursor.at));
    const std::uint32_t separators = mask(_mm_cmpeq_epi8(_mm_min_epu8(bytes, _mm_set1_epi8(' ')), bytes));
    const std::uint32_t starts = ~separators & (separators << 1 | after_separator);
    std::uint32_t stops = mask(_mm_cmpeq_epi8(bytes, _mm_set1_epi8('\n')));
    if (cursor.hash_comments) stops |= mask(_mm_cmpeq_epi8(bytes, _mm_set1_epi8('#'))) & starts;
    // Bit 16 of the starts belongs to the next bytes.
    const int length = std::min(std::countr_zero(stops), 16);
    tokens += static_cast<std::size_t>(std::popcount(starts & ((1u << length) - 1)));
    if (stops != 0) {
      cursor.at += length;
      return tokens;
    }
    after_separator = separators >> 15;
  }
  if (after_separator == 0)
    while (cursor.at < cursor.end && !text::is_separator(*cursor.at)) ++cursor.at;
  for (; cursor.token_on_line(); ++tokens) cursor.word();
  return tokens;
}

ElementCounts count_obj_lines(std::string_view lines) {
  ElementCounts counts;
  TextCursor cursor{lines.data(), lines.data() + lines.size()};
  while (cursor.skip_to_token()) {
    const char first = *cursor.at;
    const bool single = cursor.at + 1 < cursor.end && text::is_separator(cursor.at[1]);
    if (first == 'v' && single) ++counts.vertices;
    if (first == 'f' && single) {
      ++counts.faces;
      // The keyword is a token too; a continued line is closed by its backslash.
      counts.triangles += std::max(0.0, static_cast<double>(tokens_on_line(cursor)) - 3);
    }
    cursor.skip_line();
  }
  return counts;
}

MeshEstimate peek_obj(const MeshPeek& peek) {
  const std::optional<ElementCounts> counts = sampled(peek, count_obj_lines);
  const std::uint64_t bytes = peek.file.bytes();
  if (peek.whole && counts && (counts->vertices == 0 || peek.head.find('\\') != std::string::npos))
    return estimate_from_reader(peek);
  if (!counts || counts->vertices == 0) return estimate_from_size(bytes);
  const double margin = peek.whole ? 1 : sampling_margin;
  return {bytes, rounded_up(margin * counts->vertices), rounded_up(margin * counts->triangles)};
}

// Which the columns `group`, `material` and `object` are made of, whether or not the file names any.
std::vector<FileAttribute> obj_attributes(const ByteSource&) {
  return {{"group", 1, true, true}, {"material", 1, true, true}, {"object", 1, true, true}};
}

}  // namespace

extern const FormatRow obj_format = {
    .called = "an OBJ",
    .extensions = {".obj"},
    .read = read_obj,
    .looks_like = looks_like_obj,
    .peek = peek_obj,
    .most = most_in_text,
    .color_companions = library_paths,
    .library_images = images_of_libraries,
    .attributes = obj_attributes,
};

}  // namespace meander
