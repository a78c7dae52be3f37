#include "io/mesh/part_names.h"

#include <fmt/format.h>

#include <algorithm>

#include "io/item_id.h"
#include "io/json_writer.h"

namespace meander {

bool asks_for(std::span<const AttributeColumn> attributes, std::string_view name) {
  return std::any_of(attributes.begin(), attributes.end(),
                     [&](const AttributeColumn& column) { return column.width == 1 && column.name == name; });
}

void NumberedAttributes::add(const std::string& attribute, NumberedFaces faces) {
  if (faces.names.empty()) return;
  add_names(attribute, faces.names);
  mesh_.asked_face_attributes.push_back({attribute, std::move(faces.values), true});
}

void NumberedAttributes::add_names(std::string_view attribute, std::span<const std::string> names) {
  constexpr std::size_t brackets = 4;  // of the list and of the object
  const std::string key = fmt::format("{}\"{}\":", lists_.empty() ? "" : ",", attribute);
  const std::size_t room = most_name_bytes - std::min(most_name_bytes, lists_.size() + key.size() + brackets);
  std::string list;
  std::size_t kept = 0;
  for (; kept < names.size(); ++kept) {
    JsonWriter json;
    json.value(escape_id(names[kept]));
    const std::string& name = json.text();
    if (list.size() + name.size() + (kept > 0 ? 1 : 0) > room) break;
    list += (kept > 0 ? "," : "") + name;
  }
  if (kept < names.size())
    mesh_.notes.add(Note::names_dropped,
                    fmt::format("of {} names of `{}` the first {} are kept: there is room for {} bytes",
                                names.size(), attribute, kept, most_name_bytes),
                    names.size() - kept);
  if (kept > 0) lists_ += key + "[" + list + "]";
}

void NumberedAttributes::finish() {
  if (!lists_.empty()) mesh_.names = "{" + lists_ + "}";
}

}  // namespace meander
