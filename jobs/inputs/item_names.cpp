#include "jobs/inputs/item_names.h"

#include <algorithm>
#include <array>
#include <utility>

#include "io/item_id.h"
#include "io/mesh/mesh_reader.h"
#include "jobs/inputs/folder_layout.h"

namespace meander {

namespace {

namespace fs = std::filesystem;

// The extensions of files of points, which lists may name for the model.
constexpr std::array<std::string_view, 7> point_extensions = {".txt", ".npy", ".npz", ".pts",
                                                              ".xyz", ".pcd", ".h5"};

std::string_view last_part(std::string_view path) { return path.substr(path.rfind('/') + 1); }

std::string_view without_last_part(std::string_view path) {
  const std::size_t slash = path.rfind('/');
  return path.substr(0, slash == std::string_view::npos ? 0 : slash + 1);
}

bool is_mesh_name(std::string_view name) {
  MeshFormat format;
  return mesh_format_of(fs::path(name), format);
}

std::string_view stem_of_name(std::string_view name) {
  const std::size_t dot = name.rfind('.');
  return dot == std::string_view::npos || dot == 0 ? name : name.substr(0, dot);
}

// The number that ABC or ScanNet puts in front of a stem; empty: none.
std::string_view number_of_stem(std::string_view stem) {
  constexpr std::string_view abc = "00000000_", scannet = "scene0000_00_";
  for (const std::string_view form : {abc, scannet}) {
    const auto fits = [](char wanted, char c) { return wanted == '0' ? c >= '0' && c <= '9' : c == wanted; };
    if (stem.size() > form.size() && std::equal(form.begin(), form.end(), stem.begin(), fits))
      return stem.substr(0, form.size() - 1);
  }
  return {};
}

// The path with single slashes, and without parts that are dots.
std::string plain_path(std::string_view name) {
  std::string plain;
  while (!name.empty()) {
    const std::size_t end = std::min(name.find('/'), name.size());
    const std::string_view part = name.substr(0, end);
    name.remove_prefix(std::min(end + 1, name.size()));
    if (part.empty() || part == ".") continue;
    if (!plain.empty()) plain += '/';
    plain += part;
  }
  return plain;
}

}  // namespace

void ItemNames::add(std::string_view id, const fs::path& path) {
  ids_.push_back(id);
  std::string whole = escape_id(fs::absolute(path).lexically_normal().generic_string());
  const bool has_id =
      whole.size() > id.size() && whole.ends_with(id) && whole[whole.size() - id.size() - 1] == '/';
  above_.push_back(has_id ? whole.size() - id.size() : 0);
  whole_.push_back(has_id ? std::string_view(owned_.emplace_back(std::move(whole))) : id);
}

// Adds the folders of an item that the item before does not have.
void ItemNames::add_folders(std::size_t item) {
  const std::string_view id = ids_[item], before = item > 0 ? ids_[item - 1] : std::string_view();
  for (std::size_t slash = id.find('/'); slash != std::string_view::npos; slash = id.find('/', slash + 1)) {
    if (before.starts_with(id.substr(0, slash + 1))) continue;
    const auto below = [&](std::string_view other) { return other.starts_with(id.substr(0, slash + 1)); };
    const auto begin = ids_.begin() + static_cast<std::ptrdiff_t>(item);
    const auto end = std::partition_point(begin, ids_.end(), below);
    const std::string_view path = id.substr(0, slash);
    places_.push_back({last_part(path), without_last_part(path), item,
                       static_cast<std::size_t>(end - ids_.begin()), Kind::folder});
  }
}

void ItemNames::finish() {
  for (std::size_t item = 0; item < ids_.size(); ++item) {
    add_folders(item);
    const std::string_view path = ids_[item], stem = stem_of_name(last_part(path)),
                           number = number_of_stem(stem);
    places_.push_back({stem, without_last_part(path), item, item + 1, Kind::stem});
    if (!number.empty()) places_.push_back({number, without_last_part(path), item, item + 1, Kind::number});
  }
  std::sort(places_.begin(), places_.end(), [](const Place& a, const Place& b) {
    const int order = compare(a, {b.last, b.folder, ~std::size_t{0}, b.kind == Kind::number});
    return order != 0 ? order < 0 : std::pair(a.begin, a.kind) < std::pair(b.begin, b.kind);
  });
}

// Orders by the last part, then by the folders from the last one up; a path that ends sooner comes first.
int ItemNames::compare(const Place& place, const Wanted& wanted) {
  if (const int order = place.last.compare(wanted.last); order != 0) return order;
  const bool is_number = place.kind == Kind::number;
  if (is_number != wanted.is_number) return is_number ? 1 : -1;
  std::string_view a = place.folder, b = wanted.folder;
  for (std::size_t k = 0; k < wanted.parts; ++k) {
    if (a.empty() || b.empty()) return a.empty() ? (b.empty() ? 0 : -1) : 1;
    a.remove_suffix(1);
    b.remove_suffix(1);
    if (const int order = last_part(a).compare(last_part(b)); order != 0) return order;
    a = without_last_part(a);
    b = without_last_part(b);
  }
  return 0;
}

namespace {

// Adds a place of a name: the one that holds all others is meant. False when neither holds the other.
bool take_place(std::size_t begin, std::size_t end, ItemNames::Items& found) {
  if (begin >= found.begin && end <= found.end) return true;
  const bool is_first = found.begin == found.end;
  if (!is_first && (begin > found.begin || end < found.end)) {
    found.is_ambiguous = true;
    return false;
  }
  found = {begin, end, false};
  return true;
}

}  // namespace

template <class IsRight>
ItemNames::Items ItemNames::find_places(const Wanted& wanted, const IsRight& is_right) const {
  auto at = std::lower_bound(places_.begin(), places_.end(), wanted,
                             [](const Place& place, const Wanted& w) { return compare(place, w) < 0; });
  Items found;
  for (; at != places_.end() && compare(*at, wanted) == 0; ++at)
    if (is_right(*at) && !take_place(at->begin, at->end, found)) break;
  return found;
}

bool ItemNames::is_below_other_synset(std::size_t item, const std::string& synset) const {
  for (std::string_view path = without_last_part(whole_[item]); !path.empty();
       path = without_last_part(path)) {
    path.remove_suffix(1);
    // The numbers of synsets begin with 0; dates, which folders above the input may have as names, do not.
    if (is_synset(last_part(path)) && last_part(path).starts_with('0') && last_part(path) != synset)
      return true;
  }
  return false;
}

// Whether the folders that a name has in front of an id may be those above the item: at least two parts
// agree, and those that differ are not two synsets.
bool ItemNames::may_be_above(const Place& place, const Wanted& wanted) const {
  std::string_view here = above(place.begin), there = wanted.folder;
  std::size_t right = wanted.parts;
  for (std::size_t k = 0; k < wanted.parts; ++k) there = without_last_part(there.substr(0, there.size() - 1));
  for (; !here.empty() && !there.empty(); ++right) {
    const std::string_view a = last_part(here.substr(0, here.size() - 1)),
                           b = last_part(there.substr(0, there.size() - 1));
    if (a != b) return right > 0 && (!is_synset(a) || !is_synset(b));
    here.remove_suffix(std::min(a.size() + 1, here.size()));
    there.remove_suffix(std::min(b.size() + 1, there.size()));
  }
  return right > 0;
}

// Finds places at the top of the input whose name has further folders above the ids.
template <class IsRight>
ItemNames::Items ItemNames::find_from_top(Wanted wanted, const IsRight& is_right) const {
  const std::size_t folders = wanted.parts;
  for (wanted.parts = folders; wanted.parts-- > 0;) {
    const auto depth = [](const Place& place) {
      return static_cast<std::size_t>(std::count(place.folder.begin(), place.folder.end(), '/'));
    };
    auto at = std::lower_bound(places_.begin(), places_.end(), wanted,
                               [](const Place& place, const Wanted& w) { return compare(place, w) < 0; });
    Items found;
    for (; at != places_.end() && compare(*at, wanted) == 0 && depth(*at) == wanted.parts; ++at) {
      if (!is_right(*at) || !may_be_above(*at, wanted)) continue;
      if (!take_place(at->begin, at->end, found)) return found;
    }
    if (found.begin != found.end) return found;
  }
  return {};
}

ItemNames::Items ItemNames::find_end(const std::string& name, const std::string& synset) const {
  const std::string_view last = last_part(name), folder = without_last_part(name);
  const auto folders = static_cast<std::size_t>(std::count(folder.begin(), folder.end(), '/'));
  const std::string_view stem = stem_of_name(last);
  const bool is_points = std::find(point_extensions.begin(), point_extensions.end(),
                                   last.substr(stem.size())) != point_extensions.end();
  Items found;
  const auto take = [&](std::string_view wanted, bool is_number, const auto& is_right) {
    const auto is_known = [&](const Place& place) {
      return is_right(place) && (synset.empty() || !is_below_other_synset(place.begin, synset));
    };
    const Wanted all{wanted, folder, folders, is_number};
    if (found.begin == found.end) found = find_places(all, is_known);
    if (found.begin == found.end) found = find_from_top(all, is_known);
  };
  const auto is_any = [](const Place&) { return true; };
  if (is_mesh_name(last))
    take(stem, false, [&](const Place& place) {
      return place.kind == Kind::stem && last_part(ids_[place.begin]) == last;
    });
  take(last, false, is_any);
  if (is_points) take(stem, false, is_any);
  take(is_points ? stem : last, true, is_any);
  return found;
}

ItemNames::Items ItemNames::find_exactly(const std::string& id) const {
  const auto at = std::lower_bound(ids_.begin(), ids_.end(), id);
  const auto item = static_cast<std::size_t>(at - ids_.begin());
  return at != ids_.end() && *at == id ? Items{item, item + 1, false} : Items();
}

ItemNames::Items ItemNames::find_id(const LabelLine& line) const {
  for (const std::string& name : line.names)
    for (const std::string& text : {name, escape_id(name)})
      if (const Items found = find_exactly(text); found.begin != found.end) return found;
  return {};
}

ItemNames::Items ItemNames::find(const LabelLine& line) const {
  for (const std::string& name : line.names) {
    const bool is_first = &name == line.names.data();
    for (const std::string& text : {name, escape_id(name)}) {
      const std::string plain = plain_path(text);
      Items found = find_exactly(text);  // an id may be any path, but the ends of paths are plain
      if (found.begin == found.end) found = find_exactly(plain);
      if (found.begin == found.end && !plain.empty())
        found = find_end(plain, is_first ? std::string() : line.synset);
      if (found.begin != found.end) return found;
    }
  }
  return {};
}

}  // namespace meander
