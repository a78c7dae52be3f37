#include "io/file_kind.h"

#include <fcntl.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/file/file_descriptor.h"
#include "io/utf8.h"
#include "io/word_list.h"
#include "kernels/core/status.h"

namespace meander {

namespace {

using std::string_view_literals::operator""sv;

constexpr std::size_t head_bytes = std::size_t{1} << 16;

struct Head {
  std::string bytes;  // of the beginning
  std::uint64_t size = 0;
  bool whole() const { return bytes.size() == size; }
};

Head read_head(const std::filesystem::path& path) {
  const FileDescriptor file = open_file(path, O_RDONLY | O_NONBLOCK);
  Head head;
  head.size = file_size(file, path);
  head.bytes.resize(std::min<std::uint64_t>(head.size, head_bytes));
  head.bytes.resize(
      read_at(file, std::as_writable_bytes(std::span(head.bytes.data(), head.bytes.size())), 0, path));
  return head;
}

bool is_hdf5(std::string_view bytes) {
  constexpr auto signature = "\x89HDF\r\n\x1a\n"sv;
  for (std::size_t at = 0; at < bytes.size(); at = at == 0 ? 512 : 2 * at)
    if (bytes.substr(at).starts_with(signature)) return true;
  return false;
}

// UTF-8 without control characters other than those of lines. The last character of a head may be cut.
bool is_text(const Head& head) {
  std::string_view rest = head.bytes;
  while (!rest.empty()) {
    const auto c = static_cast<unsigned char>(rest.front());
    if (c < 0x20 && c != '\t' && c != '\n' && c != '\r' && c != '\f') return false;
    const std::size_t length = utf8_sequence_length(rest);
    if (length == 0) return !head.whole() && rest.size() < 4;
    rest.remove_prefix(length);
  }
  return true;
}

std::string_view after_blanks(std::string_view text) {
  text = without_byte_order_mark(text);
  const std::size_t at = text.find_first_not_of(" \t\r\n\f");
  return at == std::string_view::npos ? std::string_view{} : text.substr(at);
}

// Lines that are not blank; of a head that is not the whole file the last, which may be cut, is left out.
std::vector<std::string_view> lines_of(const Head& head) {
  std::vector<std::string_view> lines;
  std::string_view rest = head.bytes;
  while (!rest.empty()) {
    const std::size_t end = rest.find_first_of("\r\n");
    if (end == std::string_view::npos && !head.whole()) break;
    const std::string_view line = rest.substr(0, end);
    if (!after_blanks(line).empty()) lines.push_back(after_blanks(line));
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  }
  return lines;
}

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  for (line = after_blanks(line); !line.empty(); line = after_blanks(line)) {
    const std::size_t end = std::min(line.find_first_of(" \t\r\n\f"), line.size());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
  return words;
}

bool is_number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error != std::errc::invalid_argument && end == word.data() + word.size();
}

// Every row has as many cells as the first, two or more (RFC 4180). A row that the end of the head cuts does
// not count.
bool is_csv(const Head& head) {
  std::size_t cells = 1, first = 0;
  bool quoted = false, blank = true;
  const auto row_fits = [&] {
    if (first == 0) first = cells;
    const bool fits = cells == first && first >= 2;
    cells = 1;
    blank = true;
    return fits;
  };
  for (const char c : head.bytes) {
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    if (c == ',') ++cells;
    if (c == '\n' && !blank && !row_fits()) return false;
    if (c != '\n' && c != '\r') blank = false;
  }
  if (head.whole() && !blank && !row_fits()) return false;
  return first >= 2 && !(quoted && head.whole());
}

// "# ID: STATUS: SENTENCE" to begin with. Ids and sentences may have commas, as many on each line as on the
// others.
bool is_failed_list(const std::vector<std::string_view>& lines) {
  if (lines.empty() || !lines.front().starts_with("# ")) return false;
  return std::any_of(status_names.begin(), status_names.end(), [&](std::string_view name) {
    return lines.front().find(": " + std::string(name) + ": ") != std::string_view::npos;
  });
}

bool is_xyz(const std::vector<std::string_view>& lines) {
  const auto is_comment = [](std::string_view line) { return line.starts_with('#'); };
  return !std::all_of(lines.begin(), lines.end(), is_comment) &&
         std::all_of(lines.begin(), lines.end(), [&](std::string_view line) {
           if (is_comment(line)) return true;
           const auto words = words_of(line);
           return words.size() >= 3 && std::all_of(words.begin(), words.end(), is_number);
         });
}

// An object, or an array that an .ini file's [section] is not.
bool is_json(std::string_view text) {
  if (!text.starts_with('{') && !text.starts_with('[')) return false;
  const std::string_view inside = after_blanks(text.substr(1));
  return text.starts_with('{') ? inside.starts_with('"') || inside.starts_with('}')
                               : inside.find_first_of("\"{[]-0123456789") == 0;
}

FileKind text_kind(const Head& head) {
  const std::string_view text = after_blanks(head.bytes);
  if (text.starts_with('<')) {
    const std::string start = lower_ascii(text.substr(0, 4096));
    if (start.starts_with("<!doctype html") || start.starts_with("<html")) return FileKind::html;
    return start.find("<svg") != std::string::npos ? FileKind::svg : FileKind::text;
  }
  if (is_json(text)) return FileKind::json;
  const auto lines = lines_of(head);
  if (is_failed_list(lines)) return FileKind::item_list;
  if (is_csv(head)) return FileKind::csv;
  if (text.starts_with("# ")) return FileKind::item_list;
  return is_xyz(lines) ? FileKind::xyz : FileKind::text;
}

std::uint32_t number_at(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

bool is_distance_matrix(const Head& head) {
  if (head.size < 4 || head.size % 4 != 0) return false;
  const std::uint64_t values = head.size / 4;
  const auto side = static_cast<std::uint64_t>(std::llround(std::sqrt(static_cast<double>(values))));
  if (side * side != values) return false;
  constexpr float rounding = 1e-3f;
  for (std::size_t i = 0; i < std::min<std::uint64_t>(side, head.bytes.size() / 4); ++i) {
    float value = 0;
    std::memcpy(&value, head.bytes.data() + 4 * i, sizeof value);
    if (!std::isfinite(value) || value < -rounding || (i == 0 && value > rounding)) return false;
  }
  return true;
}

FileKind binary_kind(const Head& head) {
  const std::string_view bytes = head.bytes;
  if (is_exact_binary_stl(bytes, head.size)) return mesh_kind(MeshFormat::stl);
  if (bytes.size() >= 8 &&
      head.size == 8 + std::uint64_t{4} * number_at(bytes, 0) * std::uint64_t{number_at(bytes, 4)})
    return FileKind::fbin;
  return is_distance_matrix(head) ? FileKind::distance_matrix : FileKind::unknown;
}

}  // namespace

std::string describe(FileKind kind) {
  if (is_mesh(kind))
    return std::string(
               mesh_formats()[static_cast<std::size_t>(kind) - static_cast<std::size_t>(FileKind::mesh)]
                   ->called) +
           " mesh";
  constexpr std::array names = {"an empty file"sv,
                                "a Meander store"sv,
                                "an HDF5 file"sv,
                                "a PNG picture"sv,
                                "an SVG drawing"sv,
                                "an HTML page"sv,
                                "a JSON file"sv,
                                "a CSV table"sv,
                                "a list of failed items"sv,
                                "a text file of coordinates"sv,
                                "a PLY file of points"sv,
                                "an OFF file of points"sv,
                                "an fbin file"sv,
                                "a numpy array"sv,
                                "a tar archive"sv,
                                "a zip archive"sv,
                                "a file of scores"sv,
                                "a file of words"sv,
                                "a graph of neighbors"sv,
                                "a matrix of distances"sv,
                                "a text file"sv,
                                "a file of unknown content"sv};
  static_assert(names.size() == static_cast<std::size_t>(FileKind::unknown) + 1);
  return std::string(names[static_cast<std::size_t>(kind)]);
}

FileKind kind_of_file(const std::filesystem::path& path) {
  const Head head = read_head(path);
  const std::string_view bytes = head.bytes;
  if (bytes.empty()) return FileKind::empty;
  if (bytes.starts_with("meander store\n")) return FileKind::store;
  if (bytes.starts_with(scores_magic)) return FileKind::scores;
  if (bytes.starts_with(words_magic)) return FileKind::words;
  if (bytes.starts_with(graph_magic)) return FileKind::graph;
  if (is_hdf5(bytes)) return FileKind::hdf5;
  if (bytes.starts_with("\x89PNG\r\n\x1a\n"sv)) return FileKind::png;
  if (bytes.starts_with("\x93NUMPY"sv)) return FileKind::npy;
  if (bytes.starts_with("PK\3\4"sv) || bytes.starts_with("PK\5\6"sv)) return FileKind::zip;
  if (bytes.substr(std::min<std::size_t>(257, bytes.size())).starts_with("ustar"sv)) return FileKind::tar;
  if (const auto found = recognize_mesh(bytes)) {
    if (found->content == LooksLike::mesh) return mesh_kind(found->format);
    return found->format == MeshFormat::ply ? FileKind::ply_points : FileKind::off_points;
  }
  return is_text(head) ? text_kind(head) : binary_kind(head);
}

}  // namespace meander
