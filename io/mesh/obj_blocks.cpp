#include "io/mesh/obj_blocks.h"

#include <array>
#include <charconv>
#include <limits>

#include "io/mesh/mtl_reader.h"
#include "io/mesh/text_cursor.h"

namespace meander {

bool is_continued(const char* line_end, const char* text_begin) {
  const char* p = line_end;
  while (p > text_begin && text::is_blank(p[-1])) --p;
  return p > text_begin && p[-1] == '\\';
}

namespace {

// In lower case, to be compared with letters alone: no other byte becomes one of them.
constexpr char folded(char c) { return static_cast<char>(c | 0x20); }

class ObjBlockReader {
 public:
  ObjBlockReader(const char* begin, const char* end, ObjExtras extras, ObjPart& part)
      : at_(begin), end_(end), begin_(begin), extras_(extras), part_(part) {}

  void read() {
    while (at_ < end_ && part_.bad_vertex == nullptr) {
      while (at_ < end_ && text::is_separator(*at_)) ++at_;
      if (at_ == end_) return;
      const char after = at_ + 1 < end_ ? at_[1] : '\n';
      const char first = folded(*at_), second = folded(after);
      if (first == 'v' && text::is_separator(after)) {
        ++at_;
        read_vertex();
      } else if (first == 'f' && text::is_separator(after)) {
        ++at_;
        read_face();
        skip_logical_line();
      } else if (first == 'f' && second == 'o' && at_ + 2 < end_ && text::is_separator(at_[2])) {
        at_ += 2;  // a face before version 3.0 of the format
        read_face();
        skip_logical_line();
      } else if (first == 'v' && second == 'n' && at_ + 2 < end_ && text::is_blank(at_[2])) {
        at_ += 2;
        read_normal();
        skip_logical_line();
      } else if (extras_.coordinates() && first == 'v' && second == 't' && at_ + 2 < end_ &&
                 text::is_blank(at_[2])) {
        part_.keywords = true;
        at_ += 2;
        read_coordinate();
        skip_logical_line();
      } else {
        if (!part_.keywords) part_.keywords = is_keyword();
        part_.free_forms += is_free_form() ? 1 : 0;
        if ((extras_.colors || extras_.materials) && first == 'u') read_material();
        if (extras_.colors && *at_ == '#') read_painted();
        if ((extras_.objects || extras_.groups) && text::is_separator(after)) {
          if (extras_.objects && first == 'o') read_name(part_.objects);
          if (extras_.groups && first == 'g') read_name(part_.groups);
        }
        // Never continued: a comment or a material path may well end in a backslash.
        at_ = text::find_line_end(at_, end_);
      }
    }
  }

 private:
  // Moves to the next token of the logical line; false at its end.
  bool next_on_line() {
    for (; at_ < end_; ++at_) {
      if (*at_ == '\\') {
        const char* p = at_ + 1;
        while (p < end_ && text::is_blank(*p)) ++p;
        if (p == end_ || *p != '\n') return true;
        at_ = p;
      } else if (*at_ == '\n' || !text::is_separator(*at_)) {
        return *at_ != '\n' && *at_ != '#';
      }
    }
    return false;
  }

  void skip_logical_line() {
    // After most vertices and faces the line ends here: cheaper than a search that finds it at once.
    if (at_ == end_ || *at_ != '\n') at_ = text::find_line_end(at_, end_);
    while (at_ < end_ && is_continued(at_, begin_)) at_ = text::find_line_end(at_ + 1, end_);
  }

  bool read_number(double& value) {
    if (!next_on_line()) return false;
    const char* const next = text::parse_number(at_, end_, value);
    if (next == nullptr) return false;
    at_ = next;
    return true;
  }

  void read_vertex() {
    double x = 0, y = 0, z = 0;
    if (!read_number(x) || !read_number(y) || !read_number(z)) {
      // Only the last line of the file has no line end.
      part_.cut_vertex = text::find_line_end(at_, end_) == end_;
      if (part_.cut_vertex)
        at_ = end_;
      else
        part_.bad_vertex = at_;
      return;
    }
    part_.x.push_back(x);
    part_.y.push_back(y);
    part_.z.push_back(z);
    if (extras_.colors) read_color();
    skip_logical_line();
  }

  // Three numbers behind the position, or four with an opacity; a single one is a weight.
  void read_color() {
    std::array<double, 4> values{};
    std::size_t count = 0;
    while (count < values.size() && read_number(values[count])) ++count;
    for (std::size_t k = 0; k < 3; ++k)
      part_.colors.push_back(count >= 3 ? static_cast<float>(values[k])
                                        : std::numeric_limits<float>::quiet_NaN());
  }

  std::string_view rest_of_line() const {
    return {at_, static_cast<std::size_t>(text::find_line_end(at_, end_) - at_)};
  }

  void read_material() {
    const std::string_view line = rest_of_line();
    if (text::same_word(line.substr(0, 6), "usemtl") && (line.size() == 6 || text::is_separator(line[6])))
      part_.materials.push_back({part_.polygons.count(), trimmed(line.substr(6))});
  }

  // ZBrush keeps colors of vertices in comments: `#MRGB` and up to 64 times eight digits, mask, red, green
  // and blue.
  void read_painted() {
    const std::string_view line = rest_of_line();
    if (!line.starts_with("#MRGB ")) return;
    const std::string_view digits = trimmed(line.substr(6));
    for (std::size_t at = 0; at + 8 <= digits.size(); at += 8) {
      std::uint32_t value = 0;
      const auto [stop, error] = std::from_chars(digits.data() + at, digits.data() + at + 8, value, 16);
      if (error != std::errc{} || stop != digits.data() + at + 8) return;
      for (const int shift : {16, 8, 0})
        part_.painted.push_back(static_cast<float>(value >> shift & 255u) / 255.0f);
    }
  }

  // Reads the name behind a keyword of one letter.
  void read_name(std::vector<NameUse>& uses) {
    uses.push_back({part_.polygons.count(), trimmed(rest_of_line().substr(1))});
  }

  // A normal that cannot be read stays in its place as zero: what uses it falls back to the geometric one.
  void read_normal() {
    double n[3] = {0, 0, 0};
    if (!read_number(n[0]) || !read_number(n[1]) || !read_number(n[2])) n[0] = n[1] = n[2] = 0;
    for (const double value : n) part_.normals.push_back(static_cast<float>(value));
  }

  // Reads one to three numbers; the second is 0 where it is missing.
  void read_coordinate() {
    double u = 0, v = 0;
    if (!read_number(u)) u = std::numeric_limits<double>::quiet_NaN();
    if (!read_number(v)) v = 0;
    part_.coordinates.push_back(static_cast<float>(u));
    part_.coordinates.push_back(static_cast<float>(v));
  }

  static std::uint32_t resolve(std::int64_t number, std::size_t count, std::size_t position,
                               std::vector<RelativeIndex>& relative) {
    if (number > 0) return text::to_index(number - 1);
    if (number < 0) relative.push_back({position, static_cast<std::int64_t>(count) + number});
    return no_index;
  }

  // a, a/b, a//c or a/b/c, where b may be missing.
  bool read_corner() {
    std::int64_t vertex = 0, texture = 0, normal = 0;
    const char* p = text::parse_digits(at_, end_, vertex);
    if (p == nullptr) return false;
    if (p < end_ && *p == '/') {
      ++p;
      const bool is_given = p < end_ && *p != '/';
      if (const char* const q = is_given ? text::parse_digits(p, end_, texture) : nullptr) p = q;
      if (p < end_ && *p == '/') {
        ++p;
        if (const char* const q = text::parse_digits(p, end_, normal)) p = q;
      }
    }
    if (p < end_ && !text::is_separator(*p)) {
      if (*p == '.' || text::lower(*p) == 'e') p = text::parse_whole_number(at_, end_, vertex);
      if (p == nullptr) return false;
      if (p < end_ && !text::is_separator(*p) && *p != '#' && *p != '\\') return false;
    }
    at_ = p;
    std::vector<std::uint32_t>& corners = part_.polygons.corners;
    if (normal != 0) {
      part_.corner_normals.resize(corners.size(), no_index);
      part_.corner_normals.push_back(
          resolve(normal, part_.normals.size() / 3, corners.size(), part_.relative_normals));
    }
    if (texture != 0 && extras_.coordinates()) {
      part_.corner_coordinates.resize(corners.size(), no_index);
      part_.corner_coordinates.push_back(
          resolve(texture, part_.coordinates.size() / 2, corners.size(), part_.relative_coordinates));
    }
    corners.push_back(resolve(vertex, part_.x.size(), corners.size(), part_.relative_corners));
    return true;
  }

  void read_face() {
    const char* const start = at_;
    const std::size_t normals = part_.corner_normals.size();
    const std::size_t coordinates = part_.corner_coordinates.size();
    while (next_on_line()) {
      if (read_corner()) continue;
      part_.polygons.give_up_polygon();
      const std::size_t kept = part_.polygons.corners.size();
      part_.corner_normals.resize(normals);  // a face that cannot be read names none
      part_.corner_coordinates.resize(coordinates);
      for (std::vector<RelativeIndex>* const list :
           {&part_.relative_corners, &part_.relative_normals, &part_.relative_coordinates})
        while (!list->empty() && list->back().position >= kept) list->pop_back();
      if (part_.bad_faces++ == 0) part_.first_bad_face = start;
      return;
    }
    part_.polygons.close_polygon();
  }

  std::string_view word() const {
    const char* p = at_;
    while (p < end_ && !text::is_separator(*p)) ++p;
    return {at_, static_cast<std::size_t>(p - at_)};
  }

  // A surface that is no polygon: of version 3.0 of the format, or a patch of those before.
  bool is_free_form() const {
    if (*at_ != 's' && *at_ != 'b' && *at_ != 'c') return false;
    const std::string_view word = this->word();
    for (const std::string_view known : {"surf", "bzp", "bsp", "cdc", "cdp"})
      if (word == known) return true;
    return false;
  }

  bool is_keyword() const {
    if (*at_ == '#') return true;
    const std::string_view word = this->word();
    for (const std::string_view known : {"vt", "vp", "l", "p", "o", "g", "s", "mtllib", "usemtl", "v", "vn"})
      if (text::same_word(word, known)) return true;
    return false;
  }

  const char* at_;
  const char* end_;
  const char* begin_;
  ObjExtras extras_;
  ObjPart& part_;
};

}  // namespace

void read_obj_block(const char* begin, const char* end, ObjExtras extras, ObjPart& part) {
  ObjBlockReader(begin, end, extras, part).read();
}

}  // namespace meander
