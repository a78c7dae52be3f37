#include "io/table/npy_header.h"

#include <fmt/format.h>

#include <charconv>

#include "kernels/core/status.h"

namespace meander {

namespace {

constexpr std::string_view npy_magic("\x93NUMPY", 6);
constexpr std::size_t max_dimensions = 32;  // that of numpy

[[noreturn]] void fail_header(const std::string& what) {
  throw ItemError(Status::unreadable, "the header of the array " + what);
}

// The dictionary of the header, a literal of Python: three keys with a string, a Boolean and a tuple of
// integers.
class NpyDictionary {
 public:
  explicit NpyDictionary(std::string_view text) : rest_(text) {}

  void read(NpyHeader& header) {
    bool has_type = false, has_order = false, has_shape = false;
    expect('{');
    while (!take('}')) {
      const std::string key = quoted_text();
      expect(':');
      if (key == "descr") {
        has_type = true;
        read_type(header.type);
      } else if (key == "fortran_order") {
        has_order = true;
        header.fortran_order = truth();
      } else if (key == "shape") {
        has_shape = true;
        read_shape(header.shape);
      } else {
        fail_header("has a key besides descr, fortran_order and shape");
      }
      if (take('}')) break;
      expect(',');
    }
    skip_blanks();
    if (!rest_.empty()) fail_header("goes on behind its dictionary");
    if (!has_type || !has_order || !has_shape) fail_header("lacks one of descr, fortran_order and shape");
  }

 private:
  void skip_blanks() {
    // Some writers pad with zeros.
    while (!rest_.empty() && static_cast<unsigned char>(rest_.front()) <= ' ') rest_.remove_prefix(1);
  }
  bool take(char c) {
    skip_blanks();
    if (!rest_.starts_with(c)) return false;
    rest_.remove_prefix(1);
    return true;
  }
  void expect(char c) {
    if (!take(c)) fail_header(fmt::format("is no dictionary that numpy writes: `{}` is missing", c));
  }
  std::string quoted_text() {
    const char quote = take('"') ? '"' : '\'';
    if (quote == '\'') expect('\'');
    const std::size_t end = rest_.find(quote);
    if (end == std::string_view::npos) fail_header("has a text without an end");
    std::string text(rest_.substr(0, end));
    rest_.remove_prefix(end + 1);
    return text;
  }
  bool truth() {
    skip_blanks();
    for (const bool value : {false, true}) {
      const std::string_view word = value ? "True" : "False";
      if (!rest_.starts_with(word)) continue;
      rest_.remove_prefix(word.size());
      return value;
    }
    fail_header("says neither True nor False for fortran_order");
  }
  // Values with fields have a list instead of a name, which is skipped.
  void read_type(std::string& type) {
    skip_blanks();
    if (!rest_.starts_with('[')) {
      type = quoted_text();
      return;
    }
    type.clear();
    std::size_t depth = 0;
    do {
      skip_blanks();
      if (rest_.starts_with('\'') || rest_.starts_with('"')) {
        quoted_text();
        continue;
      }
      if (rest_.empty()) fail_header("has a list without an end");
      depth += rest_.front() == '[' ? 1 : 0;
      depth -= rest_.front() == ']' ? 1 : 0;
      rest_.remove_prefix(1);
    } while (depth > 0);
  }
  void read_shape(std::vector<std::uint64_t>& shape) {
    shape.clear();
    expect('(');
    while (!take(')')) {
      std::uint64_t extent = 0;
      skip_blanks();
      const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), extent);
      if (error != std::errc()) fail_header("has a shape that is no tuple of sizes");
      rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
      if (rest_.starts_with('L')) rest_.remove_prefix(1);  // long integers of Python 2
      shape.push_back(extent);
      if (shape.size() > max_dimensions) fail_header("has a shape of more than 32 dimensions");
      if (take(')')) break;
      expect(',');
    }
  }

  std::string_view rest_;
};

}  // namespace

std::string npy_header(std::string_view type, std::span<const std::uint64_t> shape) {
  std::string extents;
  for (const std::uint64_t extent : shape) extents += fmt::format("{}, ", extent);
  // numpy omits the last comma, except in tuples of one.
  if (shape.size() > 1) extents.resize(extents.size() - 2);
  if (shape.size() == 1) extents.resize(extents.size() - 1);
  std::string text = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", type, extents);
  constexpr std::size_t before = 10, alignment = 64;
  text.resize((before + text.size() + alignment) / alignment * alignment - before - 1, ' ');
  text += '\n';
  std::string header("\x93NUMPY\x01\x00", 8);
  header += static_cast<char>(text.size() & 0xFF);
  header += static_cast<char>(text.size() >> 8);
  return header + text;
}

bool looks_like_npy(std::string_view content) { return content.starts_with(npy_magic); }

NpyHeader read_npy_header(std::string_view content) {
  constexpr std::size_t before_length = 8;
  if (!looks_like_npy(content))
    throw ItemError(Status::unreadable, "the file does not begin as .npy files do");
  if (content.size() < before_length + 2) fail_header("is not complete");
  const unsigned version = static_cast<unsigned char>(content[6]);
  if (version < 1 || version > 3)
    throw ItemError(Status::unsupported_format,
                    fmt::format("version {} of the .npy format is not known: 1 to 3 are", version));
  const std::size_t length_bytes = version == 1 ? 2 : 4, begin = before_length + length_bytes;
  if (content.size() < begin) fail_header("is not complete");
  std::size_t length = 0;
  for (std::size_t k = 0; k < length_bytes; ++k)
    length |= std::size_t{static_cast<unsigned char>(content[before_length + k])} << (8 * k);
  if (length > content.size() - begin)
    fail_header(fmt::format("promises {} bytes of itself, but {} follow", length, content.size() - begin));
  NpyHeader header;
  header.bytes = begin + length;
  NpyDictionary(content.substr(begin, length)).read(header);
  return header;
}

}  // namespace meander
