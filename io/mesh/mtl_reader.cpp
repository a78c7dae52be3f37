#include "io/mesh/mtl_reader.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "io/mesh/format_readers.h"
#include "io/mesh/text_cursor.h"

namespace meander {

namespace {

constexpr std::size_t most_library_bytes = std::size_t{16} << 20, most_materials = 16384;
constexpr std::size_t most_libraries = 1000;

// The rest of the line behind this keyword, or nothing.
bool is_line_of(std::string_view line, std::string_view keyword) {
  return line.size() > keyword.size() && line.starts_with(keyword) &&
         text::is_separator(line[keyword.size()]);
}

// Calls use(line) for each line without the blanks at its ends.
template <class Use>
void for_each_trimmed_line(std::string_view content, Use use) {
  const char* const end = content.data() + content.size();
  for (const char* at = content.data(); at < end;) {
    const char* const line_end = text::find_line_end(at, end);
    use(trimmed({at, static_cast<std::size_t>(line_end - at)}));
    at = line_end < end ? line_end + 1 : end;
  }
}

std::array<float, 3> diffuse_color(std::string_view values) {
  text::TextCursor cursor{values.data(), values.data() + values.size()};
  std::array<double, 3> numbers{};
  std::size_t count = 0;
  while (count < 3 && cursor.token_on_line() && cursor.number(numbers[count]) == text::Token::ok) ++count;
  if (count == 0) return no_material_color;
  std::array<float, 3> color{};
  for (std::size_t k = 0; k < 3; ++k) color[k] = static_cast<float>(numbers[k < count ? k : 0]);
  return color;
}

// Names may hold blanks, and one line may name several files: a name ends at `.mtl` in front of a blank.
std::vector<std::string_view> library_names(std::string_view names) {
  std::vector<std::string_view> found;
  for (std::size_t begin = 0, at = 0; at < names.size(); ++at) {
    const bool is_end = at + 1 == names.size();
    if (!is_end && !text::is_separator(names[at + 1])) continue;
    const std::string_view name = trimmed(names.substr(begin, at + 1 - begin));
    if (!is_end && (name.size() < 5 || !text::same_word(name.substr(name.size() - 4), ".mtl"))) continue;
    if (!name.empty()) found.push_back(name);
    begin = at + 1;
  }
  return found;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text::is_separator(text.front())) text.remove_prefix(1);
  while (!text.empty() && text::is_separator(text.back())) text.remove_suffix(1);
  return text;
}

MaterialColors read_material_colors(std::span<const CompanionFile> libraries) {
  MaterialColors materials;
  for (const CompanionFile& library : libraries) {
    if (!library.problem.empty() || library.bytes.size() > most_library_bytes) continue;
    std::array<float, 3>* current = nullptr;
    for_each_trimmed_line({reinterpret_cast<const char*>(library.bytes.data()), library.bytes.size()},
                          [&](std::string_view line) {
                            if (is_line_of(line, "newmtl")) {
                              current = nullptr;
                              if (materials.size() == most_materials) return;
                              const auto [at, is_new] =
                                  materials.emplace(trimmed(line.substr(6)), no_material_color);
                              if (is_new) current = &at->second;
                            } else if (current != nullptr && is_line_of(line, "Kd")) {
                              *current = diffuse_color(line.substr(2));
                            }
                          });
  }
  return materials;
}

std::array<float, 3> color_of(const MaterialColors& materials, std::string_view name) {
  const auto at = materials.find(name);
  return at == materials.end() ? no_material_color : at->second;
}

void scale_colors(std::vector<float>& values) {
  if (std::none_of(values.begin(), values.end(),
                   [](float value) { return std::isfinite(value) && value > 1; }))
    return;
  for (float& value : values) value /= 255;
}

std::vector<std::string> color_companion_paths(std::span<const std::byte> bytes, MeshFormat format) {
  std::vector<std::string> paths;
  if (format != MeshFormat::obj) return paths;
  std::set<std::string> named;
  std::string reason;
  for_each_trimmed_line({reinterpret_cast<const char*>(bytes.data()), bytes.size()},
                        [&](std::string_view line) {
                          if (!is_line_of(line, "mtllib")) return;
                          for (const std::string_view name : library_names(line.substr(6))) {
                            std::string path(name);
                            std::replace(path.begin(), path.end(), '\\', '/');
                            path = path_below_model(path, reason);
                            if (path.empty() || paths.size() == most_libraries) continue;
                            if (named.insert(path).second) paths.push_back(path);
                          }
                        });
  return paths;
}

}  // namespace meander
