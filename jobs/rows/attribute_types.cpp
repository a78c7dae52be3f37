#include "jobs/rows/attribute_types.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "io/archive/archive.h"
#include "io/file/input_file.h"
#include "io/mesh/peek_attributes.h"
#include "kernels/core/spelling.h"

namespace meander {

namespace {

constexpr std::size_t most_models = 64, most_near = 5;
constexpr std::size_t most_names = 1024;  // that are compared in spelling

std::vector<FileAttribute> attributes_of(const PlanItem& item) {
  if (!item.known_format || item.path.empty()) return {};
  std::vector<FileAttribute> attributes;
  try {
    if (item.packed)
      item.packed.archive->look_at(item.packed.member, [&](const ByteSource& content) {
        attributes = peek_attributes(content, item.format);
      });
    else
      attributes = peek_attributes(InputFile(item.path), item.format);
  } catch (const ItemError&) {  // its row will say so
  }
  return attributes;
}

// The numbers that readers give to faces.
bool is_numbered(std::string_view name) {
  return std::find(numbered_attributes.begin(), numbered_attributes.end(), name) != numbered_attributes.end();
}

std::optional<AttributeKind> kind_in(const StoreColumns& known, const AttributeColumn& column) {
  for (const AttributeColumn& stored : known.attributes)
    if (stored.name == column.name && stored.width == column.width) return stored.kind;
  return std::nullopt;
}

}  // namespace

bool has_open_kinds(std::span<const AttributeColumn> columns) {
  return std::any_of(columns.begin(), columns.end(),
                     [](const AttributeColumn& column) { return column.kind == AttributeKind::plain; });
}

void choose_kinds(std::vector<AttributeColumn>& columns, const StoreColumns* known,
                  std::span<const PlanItem> items) {
  std::vector<AttributeColumn*> open;
  for (AttributeColumn& column : columns) {
    if (column.kind != AttributeKind::plain) continue;
    std::optional<AttributeKind> kind;
    if (known != nullptr) kind = kind_in(*known, column);
    column.kind = kind.value_or(AttributeKind::plain);
    if (!kind) open.push_back(&column);
  }
  for (std::size_t i = 0; i < std::min(items.size(), most_models) && !open.empty(); ++i) {
    const std::vector<FileAttribute> attributes = attributes_of(items[i]);
    std::erase_if(open, [&](AttributeColumn* column) {
      const std::optional<bool> integers = takes_integers(attributes, *column);
      if (integers.value_or(false)) column->kind = AttributeKind::classes;
      return integers.has_value();
    });
  }
  for (AttributeColumn* const column : open)
    if (column->width == 1 && is_numbered(column->name)) column->kind = AttributeKind::classes;
}

std::vector<std::string> near_attributes(const std::string& name, std::span<const PlanItem> items) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < std::min(items.size(), most_models); ++i) {
    for (const FileAttribute& attribute : attributes_of(items[i])) {
      if (names.size() == most_names) break;
      if (!attribute_name_problem(attribute.name).empty() || attribute.name == name) continue;
      names.insert(attribute.width == 1 ? attribute.name
                                        : fmt::format("{}:{}", attribute.name, attribute.width));
    }
  }
  std::vector<std::pair<std::size_t, std::string>> by_distance;
  for (const std::string& known : names) by_distance.emplace_back(edit_distance(name, known), known);
  std::sort(by_distance.begin(), by_distance.end());
  std::vector<std::string> near;
  for (std::size_t i = 0; i < std::min(by_distance.size(), most_near); ++i)
    near.push_back(std::move(by_distance[i].second));
  return near;
}

}  // namespace meander
