// Points as text, one a line.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "io/mesh/format_readers.h"
#include "io/mesh/text_cursor.h"
#include "kernels/core/portable_functions.h"

namespace meander {

namespace {

using text::TextCursor;

constexpr std::size_t most_columns = 6;  // further columns are ignored

std::string numbers(std::size_t count) {
  return std::to_string(count) + (count == 1 ? " number" : " numbers");
}

class TextPointReader {
 public:
  TextPointReader(std::string_view content, const CancelToken& cancel) : content_(content), cancel_(cancel) {}

  PointCloud read() {
    TextCursor cursor{content_.data(), content_.data() + content_.size()};
    for (std::size_t row = 0; cursor.skip_to_token(); ++row) {
      if (row % rows_between_checks == 0) cancel_.check();
      const TextCursor line{cursor.at, text::find_line_end(cursor.at, cursor.end)};
      cursor.at = line.end;
      if (row > 0 || !read_header(line)) read_line(line, row == 0);
    }
    if (promised_ && *promised_ != static_cast<double>(cloud_.count()))
      throw ItemError(Status::unreadable,
                      "the first line promises " + std::to_string(static_cast<std::int64_t>(*promised_)) +
                          " points, but the file holds " + std::to_string(cloud_.count()));
    if (cloud_.count() == 0) throw ItemError(Status::empty, "the file holds no point");
    normals_.finish(cloud_.normals);
    return std::move(cloud_);
  }

 private:
  // Whether the line is a header: words of which none begins like a number: a damaged first point is no
  // header.
  bool read_header(TextCursor line) {
    std::vector<std::string> words;
    const char* const start = line.at;
    while (line.token_on_line()) {
      const char* p = line.at;
      while (p < line.end && !text::is_separator(*p) && *p != ',' && *p != '#') ++p;
      double value = 0;
      const bool like_a_number =
          text::is_digit(*line.at) || *line.at == '+' || *line.at == '-' || *line.at == '.';
      if (like_a_number || text::parse_number(line.at, p, value) != nullptr) return false;
      std::string word;
      for (const char c : std::string_view(line.at, static_cast<std::size_t>(p - line.at)))
        if (c != '"' && c != '\'' && c != '/') word += text::lower(c);
      words.push_back(word);
      line.at = p < line.end && *p == ',' ? p + 1 : p;
    }
    // Binary data are not words.
    const auto is_control = [](char c) {
      return (static_cast<unsigned char>(c) < ' ' || c == '\x7F') && c != '\t' && c != '\r';
    };
    if (std::any_of(start, line.end, is_control)) return false;
    normals_.kind = TrailingNormals::Kind::none;
    if (std::find(words.begin(), words.end(), "x") == words.end()) return true;
    const auto has = [&](std::size_t column, const char* name) {
      return column < words.size() && words[column] == name;
    };
    if (!has(0, "x") || !has(1, "y") || (words.size() > 2 && !has(2, "z")))
      throw ItemError(Status::unsupported_format,
                      place(start) + "the columns do not begin with x y or x y z, as they must");
    if (has(3, "nx") && has(4, "ny") && has(5, "nz")) normals_.kind = TrailingNormals::Kind::named;
    return true;
  }

  void read_line(TextCursor line, bool is_first) {
    const char* const start = line.at;
    std::array<double, most_columns> values{};
    const std::size_t count = parse(line, values);
    if (is_first && count == 1 && values[0] >= 0 && values[0] <= 1e15 && values[0] == std::floor(values[0])) {
      promised_ = values[0];
      return;
    }
    if (columns_ == 0) {
      if (count != 2 && count != 3 && count != most_columns)
        throw ItemError(Status::unsupported_format,
                        place(start) + numbers(count) + ", but a point has 2, 3 or 6 and more");
      columns_ = count;
    }
    if (count != columns_)
      text::fail_at(content_, start,
                    numbers(count) + ", but the first point has " + std::to_string(columns_));
    if (!std::isfinite(values[0]) || !std::isfinite(values[1]) || !std::isfinite(values[2]))
      throw ItemError(Status::non_finite,
                      place(start) + "point " + std::to_string(cloud_.count()) + " is not finite");
    cloud_.x.push_back(values[0]);
    cloud_.y.push_back(values[1]);
    cloud_.z.push_back(values[2]);
    check_count(cloud_.count(), "points");
    if (columns_ == most_columns) normals_.add(values[3], values[4], values[5], cloud_.normals);
  }

  // The numbers of a line, at most six; returns how many.
  std::size_t parse(TextCursor line, std::array<double, most_columns>& values) const {
    bool commas = false, blanks = false, behind_comma = false;
    for (std::size_t count = 0;;) {
      if (!line.token_on_line()) {
        if (behind_comma) text::fail_at(content_, line.at - 1, "nothing follows the last comma");
        return count;
      }
      const char* stop = line.at;
      while (stop < line.end && !text::is_separator(*stop) && *stop != ',') ++stop;
      if (stop == line.at) text::fail_at(content_, line.at, "nothing precedes a comma");
      // The comma ends the number; else the whole text can be parsed, which is faster than its last bytes.
      const char* const end = stop < line.end && *stop == ',' ? stop : content_.data() + content_.size();
      const char* const next = text::parse_number(line.at, end, values[count]);
      if (next == nullptr)
        text::fail_at(
            content_, line.at,
            text::quoted({line.at, static_cast<std::size_t>(stop - line.at)}, line.at) + " is not a number");
      line.at = next;
      if (++count == most_columns) return count;
      behind_comma = false;
      if (!line.token_on_line()) continue;
      behind_comma = *line.at == ',';
      (behind_comma ? commas : blanks) = true;
      if (commas && blanks)
        text::fail_at(content_, line.at,
                      "commas and blanks both separate numbers; a decimal mark is a point");
      if (behind_comma) ++line.at;
    }
  }

  std::string place(const char* at) const {
    return "line " + std::to_string(text::line_of(content_, at)) + ": ";
  }

  std::string_view content_;
  const CancelToken& cancel_;
  PointCloud cloud_;
  std::size_t columns_ = 0;         // of the first point
  std::optional<double> promised_;  // points, by a count in the first line
  TrailingNormals normals_;
};

}  // namespace

void TrailingNormals::add(double x, double y, double z, std::vector<float>& normals) {
  if (kind == Kind::none) return;
  const double length = portable::hypot(x, y, z);
  const bool unit = std::abs(length - 1) <= 0.01;
  any_unit = any_unit || unit;
  if (kind == Kind::unnamed && !unit && std::isfinite(length) && length != 0) {
    kind = Kind::none;  // other data, for example colors
    normals = {};
    return;
  }
  for (const double value : {x, y, z}) normals.push_back(static_cast<float>(value));
}

PointCloud read_text_points(std::string_view content, const CancelToken& cancel, const BlockRule&) {
  return TextPointReader(content, cancel).read();
}

}  // namespace meander
