#include "io/mesh/mtl_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "io/mesh/format_readers.h"
#include "io/mesh/gltf_document.h"
#include "io/mesh/text_cursor.h"

namespace meander {

namespace {

constexpr std::size_t most_library_bytes = std::size_t{16} << 20, most_materials = 16384;
constexpr std::size_t most_libraries = 1000, most_images = 4096;

// The rest of the line behind this keyword, or nothing.
bool is_line_of(std::string_view line, std::string_view keyword) {
  return line.size() > keyword.size() && line.starts_with(keyword) &&
         text::is_separator(line[keyword.size()]);
}

// Programs write the keyword of the diffuse image in both cases.
bool is_map_line(std::string_view line) {
  return line.size() > 6 && text::same_word(line.substr(0, 6), "map_kd") && text::is_separator(line[6]);
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

// The rest of a line, token by token.
class Options {
 public:
  explicit Options(std::string_view line) : rest_(trimmed(line)) {}
  std::string_view rest() const { return rest_; }
  std::string_view next() const {
    std::size_t bytes = 0;
    while (bytes < rest_.size() && !text::is_separator(rest_[bytes])) ++bytes;
    return rest_.substr(0, bytes);
  }
  std::string_view take() {
    const std::string_view token = next();
    rest_ = trimmed(rest_.substr(token.size()));
    return token;
  }
  // As many of the next tokens as are numbers.
  std::size_t take_numbers(std::size_t most, double* numbers) {
    std::size_t count = 0;
    while (count < most) {
      const std::string_view token = next();
      text::TextCursor cursor{token.data(), token.data() + token.size(), false};
      double value = 0;
      if (cursor.number(value) != text::Token::ok || cursor.at != cursor.end) break;
      numbers[count++] = value;
      take();
    }
    return count;
  }

 private:
  std::string_view rest_;
};

// The image below the model's folder. People's files name those of the machine that they were made on:
// of an absolute path what is looked for is a file of this name beside the library.
std::string image_path(const std::string& library, std::string_view name) {
  if (name.size() >= 2 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
  std::string path(name);
  std::replace(path.begin(), path.end(), '\\', '/');
  const bool has_drive = path.size() >= 2 && path[1] == ':';
  if (!path.empty() && (path[0] == '/' || has_drive)) path = path.substr(path.find_last_of("/:") + 1);
  if (path.empty()) return {};
  std::string reason;
  const std::filesystem::path below =
      (std::filesystem::path(library).parent_path() / path).lexically_normal();
  return path_below_model(below.generic_string(), reason);
}

// What stands behind map_Kd.
void read_map(const std::string& library, std::string_view line, MtlMaterial& material) {
  static constexpr std::array<std::string_view, 8> of_one = {"-blendu", "-blendv", "-boost",  "-bm",
                                                             "-cc",     "-type",   "-texres", "-imfchan"};
  std::array<double, 3> scale = {1, 1, 1}, offset{}, turbulence{};
  std::array<double, 2> range = {0, 1};
  Texture texture;
  Options options(line);
  for (;;) {
    const std::string_view option = options.next();
    if (std::find(of_one.begin(), of_one.end(), option) != of_one.end()) {
      options.take();
      options.take();
    } else if (option == "-clamp") {
      options.take();
      texture.wrap_u = texture.wrap_v =
          text::same_word(options.take(), "on") ? TextureWrap::clamp : TextureWrap::repeat;
    } else if (option == "-s" || option == "-o" || option == "-t") {
      options.take();
      options.take_numbers(3, option == "-s"   ? scale.data()
                              : option == "-o" ? offset.data()
                                               : turbulence.data());
    } else if (option == "-mm") {
      options.take();
      options.take_numbers(2, range.data());
    } else {
      break;
    }
  }
  if (options.rest().empty()) return;
  texture.placement = {scale[0], 0, offset[0], 0, -scale[1], 1 - offset[1]};
  texture.base = range[0];
  texture.gain = range[1];
  material.has_image = true;
  material.image = image_path(library, options.rest());
  material.texture = texture;
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

MtlMaterials read_materials(std::span<const CompanionFile> libraries) {
  MtlMaterials materials;
  for (const CompanionFile& library : libraries) {
    if (library.is_image || !library.problem.empty() || library.bytes.size() > most_library_bytes) continue;
    MtlMaterial* current = nullptr;
    for_each_trimmed_line({reinterpret_cast<const char*>(library.bytes.data()), library.bytes.size()},
                          [&](std::string_view line) {
                            if (is_line_of(line, "newmtl")) {
                              current = nullptr;
                              if (materials.size() == most_materials) return;
                              const auto [at, is_new] = materials.try_emplace(trimmed(line.substr(6)));
                              if (is_new) current = &at->second;
                            } else if (current != nullptr && is_line_of(line, "Kd")) {
                              current->color = diffuse_color(line.substr(2));
                            } else if (current != nullptr && is_map_line(line)) {
                              read_map(library.path, line.substr(6), *current);
                            }
                          });
  }
  return materials;
}

const MtlMaterial& material_of(const MtlMaterials& materials, std::string_view name) {
  static const MtlMaterial none;
  const auto at = materials.find(name);
  return at == materials.end() ? none : at->second;
}

void scale_colors(std::vector<float>& values) {
  if (std::none_of(values.begin(), values.end(),
                   [](float value) { return std::isfinite(value) && value > 1; }))
    return;
  for (float& value : values) value /= 255;
}

std::vector<std::string> color_companion_paths(std::span<const std::byte> bytes, MeshFormat format) {
  if (format == MeshFormat::gltf)
    return gltf_image_paths({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
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

std::vector<std::string> library_image_paths(std::span<const std::byte> bytes, MeshFormat format,
                                             std::span<const CompanionFile> libraries) {
  std::vector<std::string> paths;
  if (format != MeshFormat::obj) return paths;
  const MtlMaterials materials = read_materials(libraries);
  if (std::none_of(materials.begin(), materials.end(), [](const auto& m) { return m.second.has_image; }))
    return paths;
  std::set<std::string> named;
  for_each_trimmed_line({reinterpret_cast<const char*>(bytes.data()), bytes.size()},
                        [&](std::string_view line) {
                          if (!is_line_of(line, "usemtl")) return;
                          const std::string& path = material_of(materials, trimmed(line.substr(6))).image;
                          if (path.empty() || paths.size() == most_images) return;
                          if (named.insert(path).second) paths.push_back(path);
                        });
  return paths;
}

}  // namespace meander
