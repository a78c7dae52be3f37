// The vertices of PLY files as points: nothing missing, nothing left over.
#include <algorithm>
#include <bit>
#include <cmath>
#include <string>
#include <vector>

#include "io/mesh/format_readers.h"
#include "io/mesh/line_blocks.h"
#include "io/mesh/ply_rows.h"

namespace meander {

namespace {

using text::TextCursor;
using text::Token;

class PlyPointReader {
 public:
  PlyPointReader(std::string_view content, const CancelToken& cancel, const BlockRule& rule)
      : content_(content), cancel_(cancel), rule_(rule), header_(parse_ply_header(content)) {}

  PointCloud read() {
    check_header();
    const std::string_view body = content_.substr(header_.body);
    if (header_.encoding != PlyEncoding::ascii)
      read_binary(body);
    else
      read_ascii(body);
    return std::move(cloud_);
  }

 private:
  void check_header() {
    vertices_ = header_.find("vertex");
    if (vertices_ == nullptr) throw ItemError(Status::unreadable, "the header has no element vertex");
    if (vertices_->count == 0) throw ItemError(Status::empty, "the header promises no vertex");
    check_positions(*vertices_);
    last_ = std::all_of(header_.elements.data() + (vertices_ - header_.elements.data()) + 1,
                        header_.elements.data() + header_.elements.size(),
                        [](const PlyElement& element) { return element.count == 0; });
  }

  // Takes the memory, when `bytes` can hold the vertices at `bytes_per_row` and more.
  void make_columns(std::size_t bytes, std::size_t bytes_per_row) {
    const std::uint64_t rows = vertices_->count;
    if (rows > bytes / bytes_per_row)
      throw ItemError(Status::unreadable, "the header promises " + std::to_string(rows) +
                                              " vertices, but only " + std::to_string(bytes) +
                                              " bytes follow it");
    check_count(rows, "vertices");
    columns_.columns.resize(vertices_->properties.size());
    place_vertices(*vertices_, rows, {&cloud_.x, &cloud_.y, &cloud_.z}, cloud_.normals, columns_);
    if (const int density = vertices_->scalar_named("density"); density >= 0) {
      cloud_.density.resize(rows);
      columns_.columns[static_cast<std::size_t>(density)].values = cloud_.density.data();
    }
  }

  bool finite(std::size_t row) const {
    return std::isfinite(cloud_.x[row]) && std::isfinite(cloud_.y[row]) && std::isfinite(cloud_.z[row]);
  }

  static std::string row_of(std::uint64_t row, const PlyElement& element) {
    return "row " + std::to_string(row) + " of " + std::to_string(element.count) + " of the element " +
           text::quoted(element.name, element.name.data());
  }

  std::string leftover() const {
    return " the " + std::to_string(vertices_->count) + " vertices that the header promises";
  }

  void read_binary(std::string_view body) {
    for (const PlyElement& element : header_.elements) {
      const bool wanted = &element == vertices_;
      if (wanted) make_columns(body.size(), element.fixed_bytes());
      PlyColumns skipped;
      skipped.columns.resize(element.properties.size());
      PolygonPart unused;
      const PlyProgress progress = read_binary_rows(body, element, header_.swaps_bytes(),
                                                    wanted ? columns_ : skipped, unused, cancel_, rule_);
      body.remove_prefix(progress.bytes);
      if (progress.rows < element.count)
        throw ItemError(Status::unreadable, "byte " + std::to_string(body.data() - content_.data()) + ": " +
                                                row_of(progress.rows, element) + " is not complete");
      if (wanted) break;
    }
    for (std::size_t row = 0; row < cloud_.count(); ++row)
      if (!finite(row)) throw ItemError(Status::non_finite, not_finite(row, cloud_.count()));
    if (last_ && !std::all_of(body.begin(), body.end(), text::is_separator))
      throw ItemError(Status::unreadable,
                      "byte " + std::to_string(body.data() - content_.data()) + ": data follow" + leftover());
  }

  // One vertex; a bad token is at the cursor.
  Token read_row(TextCursor& line, std::uint64_t row) const {
    Token token = Token::ok;
    for (std::size_t p = 0; p < columns_.columns.size() && token == Token::ok; ++p) {
      const PlyColumns::Column& column = columns_.columns[p];
      if (vertices_->properties[p].is_list) {
        std::int64_t length = 0;
        line.skip_to_token();
        const char* const start = line.at;
        token = line.length(length);
        if (token == Token::bad) line.at = start;
        for (std::int64_t k = 0; k < length && token == Token::ok; ++k)
          if (line.word().empty()) token = Token::ended;
      } else if (column.values == nullptr && column.normals == nullptr) {
        if (line.word().empty()) token = Token::ended;
      } else {
        double value = 0;
        token = line.number(value);
        if (token == Token::ok && column.values != nullptr) column.values[row] = value;
        if (token == Token::ok && column.normals != nullptr)
          column.normals[3 * row] = static_cast<float>(value);
      }
    }
    return token;
  }

  void read_ascii(std::string_view body) {
    // A number and a separator take two bytes; the file may end without the last one.
    make_columns(body.size() + 1, 2 * vertices_->properties.size());
    std::uint64_t before = 0, lines = 0;  // of other elements, and in all
    for (const PlyElement& element : header_.elements) {
      if (&element == vertices_) before = lines;
      if (!element.properties.empty()) lines += std::min<std::uint64_t>(element.count, content_.size());
    }
    if (body.size() >= rule_.parallel_from && read_lines(body, before, lines)) return;
    TextCursor cursor{body.data(), body.data() + body.size(), false};
    for (std::uint64_t ordinal = 0; ordinal < before + vertices_->count; ++ordinal) {
      if (ordinal % rows_between_checks == 0) cancel_.check();
      if (!cursor.skip_to_token())
        text::fail_at(content_, cursor.end,
                      ordinal < before ? "the file ends before the vertices"
                                       : "the file ends before " + row_of(ordinal - before, *vertices_));
      const char* const start = cursor.at;
      TextCursor line{start, text::find_line_end(start, cursor.end), false};
      cursor.at = line.end;
      if (ordinal < before) continue;
      const std::uint64_t row = ordinal - before;
      const Token token = read_row(line, row);
      if (token == Token::ended)
        text::fail_at(content_, start, row_of(row, *vertices_) + " is not complete on its line");
      if (token == Token::bad)
        text::fail_at(
            content_, line.at,
            row_of(row, *vertices_) + ": " + text::quoted(content_, line.at) +
                (vertices_->has_lists() ? " is not a number, or no length of a list" : " is not a number"));
      if (!finite(row))
        throw ItemError(Status::non_finite, "line " + std::to_string(text::line_of(content_, start)) + ": " +
                                                not_finite(row, vertices_->count));
    }
    if (last_ && cursor.skip_to_token())
      text::fail_at(content_, cursor.at, text::quoted(content_, cursor.at) + " follows" + leftover());
  }

  // A large file without anything wrong. False: read in order, to say what is wrong.
  bool read_lines(std::string_view body, std::uint64_t before, std::uint64_t lines) {
    return text::for_each_line(
        body, lines, false, rule_.block_bytes, cancel_, [](std::size_t) {},
        [&](std::size_t, std::uint64_t ordinal, TextCursor line) {
          if (ordinal < before || ordinal >= before + vertices_->count) return true;
          return read_row(line, ordinal - before) == Token::ok && finite(ordinal - before);
        });
  }

  std::string_view content_;
  const CancelToken& cancel_;
  const BlockRule& rule_;
  PlyHeader header_;
  const PlyElement* vertices_ = nullptr;
  bool last_ = false;  // no rows follow the vertices
  PlyColumns columns_;
  PointCloud cloud_;
};

}  // namespace

PointCloud read_ply_points(std::string_view content, const CancelToken& cancel, const BlockRule& rule) {
  return PlyPointReader(content, cancel, rule).read();
}

}  // namespace meander
