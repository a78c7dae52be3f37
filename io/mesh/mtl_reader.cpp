#include "io/mesh/mtl_reader.h"

#include <fmt/format.h>

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
constexpr std::size_t most_libraries = 1000, most_images = 4096;

// Calls use(line) for each line without the blanks at its ends.
template <class Use>
void for_each_trimmed_line(std::string_view content, char line_end, Use use) {
  while (!content.empty()) {
    const std::size_t end = std::min(content.find(line_end), content.size());
    use(trimmed(content.substr(0, end)));
    content.remove_prefix(std::min(end + 1, content.size()));
  }
}

// The same of lines that LF or CR ends: libraries are small, and some have both.
template <class Use>
void for_each_library_line(std::string_view content, Use use) {
  for_each_trimmed_line(content, '\n',
                        [&](std::string_view line) { for_each_trimmed_line(line, '\r', use); });
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

// Options of map_Kd with one argument that changes no color here. -colorspace is not of the format.
constexpr std::array<std::string_view, 9> map_options_of_one = {
    "-blendu", "-blendv", "-boost", "-bm", "-cc", "-type", "-texres", "-imfchan", "-colorspace"};

// What the options of map_Kd say.
struct MapOptions {
  std::array<double, 3> scale = {1, 1, 1}, offset{}, turbulence{};
  std::array<double, 2> range = {0, 1};
  TextureWrap wrap = TextureWrap::repeat;
};

// Takes the options in front of a line, with their arguments.
MapOptions take_options(Options& line) {
  MapOptions map;
  for (;;) {
    const std::string_view option = line.next();
    const bool is_numbers = option == "-s" || option == "-o" || option == "-t" || option == "-mm";
    const bool is_word = option == "-clamp" || std::find(map_options_of_one.begin(), map_options_of_one.end(),
                                                         option) != map_options_of_one.end();
    if (!is_numbers && !is_word) return map;
    line.take();
    if (option == "-mm") {
      line.take_numbers(2, map.range.data());
    } else if (is_numbers) {
      line.take_numbers(3, option == "-s"   ? map.scale.data()
                           : option == "-o" ? map.offset.data()
                                            : map.turbulence.data());
    } else {
      const std::string_view argument = line.take();
      if (option == "-clamp")
        map.wrap = text::same_word(argument, "on") ? TextureWrap::clamp : TextureWrap::repeat;
    }
  }
}

// The number of bytes that the options in front of a line take.
std::size_t bytes_of_options(std::string_view text) {
  Options line(text);
  take_options(line);
  return line.rest().empty() ? text.size() : static_cast<std::size_t>(line.rest().data() - text.data());
}

// By the format options stand in front of the name, but some programs write them behind: moves them. A
// comment behind the extension goes. O(bytes).
std::string with_options_in_front(std::string_view line) {
  line = trimmed(line);
  for (std::size_t at = bytes_of_options(line); at + 1 < line.size(); ++at) {
    if (!text::is_separator(line[at])) continue;
    const std::string_view behind = line.substr(at + 1);
    if (behind.front() != '#' && behind.front() != '-') continue;
    const std::string_view front = trimmed(line.substr(0, at));
    const std::string_view tail = front.substr(front.size() - std::min<std::size_t>(front.size(), 5));
    const bool has_extension = tail.size() == 5 && (tail[0] == '.' || tail[1] == '.');
    if (behind.front() == '#' && has_extension) return std::string(front);
    if (behind.front() != '-') continue;
    const std::size_t options = bytes_of_options(behind);
    if (options == behind.size()) return std::string(behind) + " " + std::string(front);
    at += options;
  }
  return std::string(line);
}

// Some programs write blanks in names as `\ `.
std::string without_escapes(std::string_view name) {
  std::string plain;
  for (std::size_t at = 0; at < name.size(); ++at)
    if (name[at] != '\\' || at + 1 == name.size() || name[at + 1] != ' ') plain += name[at];
  return plain;
}

// What stands behind map_Kd.
void read_map(std::string_view folder, std::string_view line, MtlMaterial& material) {
  const std::string ordered = with_options_in_front(line);
  Options options(ordered);
  const MapOptions map = take_options(options);
  if (options.rest().empty()) return;
  Texture texture;
  texture.wrap_u = texture.wrap_v = map.wrap;
  texture.placement = {map.scale[0], 0, map.offset[0], 0, -map.scale[1], 1 - map.offset[1]};
  texture.base = map.range[0];
  texture.gain = map.range[1];
  material.has_image = true;
  material.image = meant_path(folder, options.rest());
  material.texture = texture;
}

// Names may hold blanks, and one line may name several files: a name ends at `.mtl` in front of a blank, or
// with its quotation marks.
std::vector<std::string_view> library_names(std::string_view names) {
  std::vector<std::string_view> found;
  if (names.starts_with('"')) {
    const std::size_t close = std::min(names.find('"', 1), names.size());
    found.push_back(names.substr(0, close + 1));
    names = trimmed(names.substr(std::min(close + 1, names.size())));
  }
  for (std::size_t begin = 0, at = 0; at < names.size(); ++at) {
    const bool is_end = at + 1 == names.size();
    if (!is_end && (!text::is_separator(names[at + 1]) || names[at] == '\\')) continue;
    if (!is_end && text::is_separator(names[at])) continue;  // in a run of blanks
    const std::string_view name = trimmed(names.substr(begin, at + 1 - begin));
    if (name.starts_with('#')) break;  // a comment
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

std::optional<std::string_view> behind_keyword(std::string_view line, std::string_view lower_case) {
  const std::size_t length = lower_case.size();
  if (line.size() <= length || !text::is_separator(line[length]) ||
      !text::same_word(line.substr(0, length), lower_case))
    return std::nullopt;
  return trimmed(line.substr(length));
}

std::string meant_path(std::string_view folder, std::string_view name) {
  name = trimmed(name);
  if (name.size() >= 2 && (name.front() == '"' || name.front() == '\'') && name.back() == name.front())
    name = name.substr(1, name.size() - 2);
  std::string path = without_escapes(name);
  std::replace(path.begin(), path.end(), '\\', '/');
  const bool has_drive = path.size() >= 2 && path[1] == ':';
  if (path.starts_with("file:")) path.erase(0, 5);
  if (!path.empty() && (path[0] == '/' || has_drive)) path.erase(0, path.find_last_of("/:") + 1);
  if (path.empty()) return {};
  std::string reason;
  return path_from_model(folder.empty() ? path : std::string(folder) + "/" + path, reason);
}

namespace {

std::string_view folder_of(std::string_view path) {
  const std::size_t slash = path.rfind('/');
  return path.substr(0, slash == std::string_view::npos ? 0 : slash);
}

// Why a library has no materials; nothing where it may have some.
std::optional<std::pair<Note, std::string>> lost_library(const CompanionFile& library) {
  using Loss = CompanionFile::Loss;
  const auto sentence = [&](std::string_view what) { return fmt::format("`{}` {}", library.path, what); };
  switch (library.loss) {
    case Loss::missing:
      return std::pair(Note::library_missing, sentence("is not there"));
    case Loss::outside:
      return std::pair(Note::library_outside, sentence(library.problem));
    case Loss::unreadable:
      return std::pair(Note::library_unreadable, sentence("cannot be read"));
    case Loss::none:
      break;
  }
  if (library.bytes.size() > most_library_bytes)
    return std::pair(Note::library_too_large,
                     sentence(fmt::format("has {} MiB, and {} are read", library.bytes.size() >> 20,
                                          most_library_bytes >> 20)));
  return std::nullopt;
}

void read_library(const CompanionFile& library, MtlMaterials& materials) {
  const DecodedText content(library.bytes);
  const std::string_view folder = folder_of(library.path);
  MtlMaterial* current = nullptr;
  for_each_library_line(content.text(), [&](std::string_view line) {
    if (const auto name = behind_keyword(line, "newmtl")) {
      current = nullptr;
      if (materials.by_name.size() == most_materials) return;
      const auto [at, is_new] = materials.by_name.try_emplace(std::string(*name));
      if (is_new) current = &at->second;
    } else if (current == nullptr) {
      return;
    } else if (const auto color = behind_keyword(line, "kd")) {
      current->color = diffuse_color(*color);
    } else if (const auto map = behind_keyword(line, "map_kd")) {
      read_map(folder, *map, *current);
    }
  });
}

}  // namespace

MtlMaterials read_materials(std::span<const CompanionFile> libraries) {
  MtlMaterials materials;
  for (const CompanionFile& library : libraries) {
    if (library.is_image) continue;
    if (const auto lost = lost_library(library)) {
      materials.notes.add(lost->first, lost->second);
    } else {
      materials.any_read = true;
      read_library(library, materials);
    }
  }
  return materials;
}

const MtlMaterial* MtlMaterials::find(std::string_view name) const {
  auto at = by_name.find(std::string(name));
  // A comment may stand behind the name, but names may hold a `#`, too: the first few are tried.
  std::size_t mark = name.find('#');
  for (int tries = 0; tries < 8 && at == by_name.end() && mark != std::string_view::npos; ++tries) {
    if (mark > 0 && text::is_separator(name[mark - 1]))
      at = by_name.find(std::string(trimmed(name.substr(0, mark))));
    mark = name.find('#', mark + 1);
  }
  return at == by_name.end() ? nullptr : &at->second;
}

namespace {

// Keeps each path once, however often it is named, up to a bound.
class NamedPaths {
 public:
  explicit NamedPaths(std::size_t most) : most_(most) {}
  void add(std::string path) {
    if (path.empty() || paths_.size() == most_ || !named_.insert(path).second) return;
    paths_.push_back(std::move(path));
  }
  std::vector<std::string> take() { return std::move(paths_); }

 private:
  std::size_t most_;
  std::set<std::string> named_;
  std::vector<std::string> paths_;
};

}  // namespace

std::vector<std::string> library_paths(std::span<const std::byte> obj) {
  NamedPaths paths(most_libraries);
  const DecodedText content(obj);
  for_each_trimmed_line(content.text(), '\n', [&](std::string_view line) {
    if (const auto names = behind_keyword(line, "mtllib"))
      for (const std::string_view name : library_names(*names)) paths.add(meant_path({}, name));
  });
  return paths.take();
}

std::vector<std::string> images_of_libraries(std::span<const std::byte> obj,
                                             std::span<const CompanionFile> libraries) {
  const MtlMaterials materials = read_materials(libraries);
  if (std::none_of(materials.by_name.begin(), materials.by_name.end(),
                   [](const auto& m) { return m.second.has_image; }))
    return {};
  NamedPaths paths(most_images);
  bool names_any = false;
  const DecodedText content(obj);
  for_each_trimmed_line(content.text(), '\n', [&](std::string_view line) {
    const auto name = behind_keyword(line, "usemtl");
    if (!name) return;
    names_any = true;
    if (const MtlMaterial* const material = materials.find(*name)) paths.add(material->image);
  });
  if (!names_any && materials.only() != nullptr) paths.add(materials.only()->second.image);
  return paths.take();
}

}  // namespace meander
