#include "io/mesh/part_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "io/item_id.h"
#include "io/json_writer.h"

namespace meander {

bool asks_for(std::span<const AttributeColumn> attributes, std::string_view name) {
  return std::any_of(attributes.begin(), attributes.end(),
                     [&](const AttributeColumn& column) { return column.width == 1 && column.name == name; });
}

void NumberedAttributes::add(const std::string& attribute, NumberedFaces faces) {
  add(attribute, std::move(faces.values), faces.names.size(),
      [&](std::size_t number) -> std::string_view { return faces.names[number]; });
}

void NumberedAttributes::add(const std::string& attribute, std::vector<double> values, std::size_t count,
                             const NameOf& name_of) {
  if (count == 0) return;
  add_names(attribute, count, name_of);
  mesh_.asked_face_attributes.push_back({attribute, std::move(values), true});
}

void NumberedAttributes::add_names(std::string_view attribute, std::size_t count, const NameOf& name_of) {
  constexpr std::size_t brackets = 4;  // of the list and of the object
  const std::string key = fmt::format("{}\"{}\":", lists_.empty() ? "" : ",", attribute);
  const std::size_t room = most_name_bytes - std::min(most_name_bytes, lists_.size() + key.size() + brackets);
  std::string list;
  std::size_t kept = 0;
  for (; kept < count; ++kept) {
    const std::string_view plain = name_of(kept);
    if (plain.size() > room) break;  // escapes only lengthen it
    JsonWriter json;
    json.value(escape_id(plain));
    const std::string& name = json.text();
    if (list.size() + name.size() + (kept > 0 ? 1 : 0) > room) break;
    list += (kept > 0 ? "," : "") + name;
  }
  if (kept < count)
    mesh_.notes.add(Note::names_dropped,
                    fmt::format("of {} names of `{}` the first {} are kept: there is room for {} bytes",
                                count, attribute, kept, most_name_bytes),
                    count - kept);
  if (kept > 0) lists_ += key + "[" + list + "]";
}

void NumberedAttributes::finish() {
  if (!lists_.empty()) mesh_.names = "{" + lists_ + "}";
}

}  // namespace meander
