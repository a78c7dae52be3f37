#include "io/store/store_columns.h"

#include <fmt/format.h>

#include <algorithm>

#include "io/utf8.h"

namespace meander {

bool StoreColumns::applies(std::size_t column) const {
  switch (sample_columns.at(column).having) {
    case Having::all:
      return true;
    case Having::meshes:
      return rows == RowKind::meshes;
    case Having::surfaces:
      return rows == RowKind::surfaces;
    case Having::tensors:
      return tensors;
    case Having::taken:
    case Having::made:
      return asked[column];
    case Having::set:
      return points_of(sample_columns[column].set, 0) > 0;
    case Having::sides:
      return sides && points_of(PointSet::queries, 0) > 0;
    case Having::nearest:
      return nearest && points_of(PointSet::queries, 0) > 0;
  }
  return false;
}

bool StoreColumns::has(const ItemColumn& column) const {
  switch (column.having) {
    case ItemHaving::all:
      return true;
    case ItemHaving::colors:
      return asked[&Samples::rgb];
    case ItemHaving::optional_values:
      return chosen_count() > 0;
    case ItemHaving::names:
      return has_names();
    case ItemHaving::sharp:
      return points_of(PointSet::sharp, 0) > 0;
    case ItemHaving::sides:
      return sides && points_of(PointSet::queries, 0) > 0;
  }
  return false;
}

bool StoreColumns::are_chosen() const {
  ColumnSet chosen = asked;
  chosen[&Samples::rgb] = false;  // the root attribute `content` names colors
  return !chosen.empty() || !left_out.empty() || !attributes.empty() || has_sets();
}

std::size_t StoreColumns::chosen_count() const {
  return attributes.size() + asked.count([](const SampleColumn& column) { return column.is_optional(); });
}

std::optional<std::uint32_t> StoreColumns::lacks_bit(std::size_t column) const {
  if (!sample_columns.at(column).is_optional() || !applies(column)) return std::nullopt;
  auto bit = static_cast<std::uint32_t>(attributes.size());
  for (std::size_t c = 0; c < column; ++c) bit += asked[c] && sample_columns[c].is_optional();
  return bit;
}

namespace {

const SampleColumn& optional_column(const StoreColumns& columns, std::size_t bit) {
  std::size_t c = 0;
  while (columns.lacks_bit(c) != bit) ++c;
  return sample_columns[c];
}

}  // namespace

std::string StoreColumns::chosen_name(std::size_t bit) const {
  if (bit < attributes.size()) return std::string(attribute_prefix) + attributes[bit].name;
  return std::string(optional_column(*this, bit).name);
}

std::string StoreColumns::chosen_text(std::size_t bit) const {
  if (bit < attributes.size()) return fmt::format("attribute `{}`", attributes[bit].name);
  return std::string(optional_column(*this, bit).title);
}

std::string StoreColumns::why_without(std::size_t column) const {
  const SampleColumn& of = sample_columns.at(column);
  if (of.having == Having::sides && points_of(of.set, 0) > 0) return "it was made with --sign none";
  if (!of.option.empty()) return fmt::format("it was made without --{}", of.option);
  if (rows == RowKind::surfaces) return "its models are parametric surfaces";
  return of.having == Having::surfaces ? "its models are meshes" : "its samples are not anisotropic";
}

bool StoreColumns::has_names() const {
  return std::any_of(attributes.begin(), attributes.end(), [](const AttributeColumn& column) {
    return column.width == 1 && column.is_classes() &&
           std::find(numbered_attributes.begin(), numbered_attributes.end(), column.name) !=
               numbered_attributes.end();
  });
}

std::string attribute_name_problem(std::string_view name) {
  constexpr std::size_t longest = 200;
  if (name.empty()) return "has no name";
  if (name.size() > longest) return fmt::format("has a name of more than {} bytes", longest);
  if (name.find_first_not_of('.') == std::string_view::npos) return "is named by dots alone";
  for (std::string_view rest = name; !rest.empty();) {
    const std::size_t length = utf8_sequence_length(rest);
    if (length == 0) return "has a name that is not UTF-8";
    const auto byte = static_cast<unsigned char>(rest[0]);
    if (length == 1 && (byte < 0x20 || byte == 0x7F)) return "has a control character in its name";
    if (length == 1 && (byte == '/' || byte == ',' || byte == ':'))
      return fmt::format("has `{}` in its name", rest[0]);
    rest.remove_prefix(length);
  }
  return {};
}

}  // namespace meander
