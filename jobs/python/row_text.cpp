#include "jobs/python/row_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <utility>

#include "io/digest.h"
#include "io/item_json.h"
#include "io/json_writer.h"
#include "io/table/npy_header.h"

namespace meander {

namespace {

// n x columns (n where columns is 0) values.
template <class Values>
void add_values(JsonWriter& json, std::string_view name, Values& values, std::uint64_t columns) {
  json.key(name);
  json.begin_array();
  json.value(std::uint64_t{reinterpret_cast<std::uintptr_t>(values.data())});
  json.value(numpy_type<typename Values::value_type>);
  json.value(std::uint64_t{values.size() / std::max<std::uint64_t>(columns, 1)});
  if (columns > 0) json.value(columns);
  json.end_array();
}

// The same; null for none.
template <class Values>
void add_array(JsonWriter& json, std::string_view name, Values& values, std::uint64_t columns) {
  if (!values.empty()) return add_values(json, name, values, columns);
  json.key(name);
  json.null();
}

// As C writes it in hexadecimal: with every bit, and a number of this type to every reader.
std::string exact_text(double number) { return fmt::format("{:a}", number); }

// Whether the value of a column is an array.
bool is_array(const ItemColumn& column) {
  const ColumnType type = type_of(column);
  return type.width > 0 && type.names.empty() && type.element != ElementType::text;
}

void add_item_array(JsonWriter& json, const ItemColumn& column, ItemReport& report) {
  std::visit(
      [&]<class Member>(Member member) {
        if constexpr (std::is_same_v<Member, std::array<double, 3> ItemReport::*>)
          add_values(json, column.short_name(), report.*member, 0);
        if constexpr (std::is_same_v<Member, std::array<double, 6> ItemReport::*>)
          add_values(json, column.short_name(), report.*member, 3);
      },
      column.member);
}

// As many as were asked for: those of classes are in a list of their own.
void add_attributes(JsonWriter& json, SampledRow& sampled) {
  Samples& samples = sampled.row.samples;
  json.key("attributes");
  json.begin_object();
  for (std::size_t c = 0; c < sampled.attributes.size(); ++c) {
    const AttributeColumn& column = sampled.attributes[c];
    const std::uint64_t width = column.width > 1 ? column.width : 0;
    if (column.is_classes())
      add_values(json, column.name, samples.classes.at(c), width);
    else
      add_values(json, column.name, samples.attributes.at(c), width);
  }
  json.end_object();
}

}  // namespace

WeightedRow::WeightedRow(SampledRow row) : sampled(std::move(row)), weights(sampled.row.samples.count()) {
  const Samples& samples = sampled.row.samples;
  const double share = sampled.row.report.measure / static_cast<double>(weights.size());
  for (std::size_t i = 0; i < weights.size(); ++i)
    weights[i] = samples.density.empty() ? share : share / static_cast<double>(samples.density[i]);
}

std::string text_of(WeightedRow& weighted) {
  Row& row = weighted.sampled.row;
  Samples& samples = row.samples;
  JsonWriter json;
  json.begin_object();
  if (row.report.status != Status::ok) {
    json.member("status", name_of(row.report.status));
    json.member("reason", row.report.reason);
    json.end_object();
    return json.text();
  }
  json.key("arrays");
  json.begin_object();
  for (const SampleColumn& column : sample_columns)
    with_array(column, samples,
               [&](auto& values) { add_array(json, column.array_name(), values, column.width); });
  add_array(json, "weights", weighted.weights, 0);
  for (const ItemColumn& column : item_columns)
    if (column.is_in_python() && is_array(column)) add_item_array(json, column, row.report);
  json.end_object();
  add_attributes(json, weighted.sampled);
  json.member("names", row.names);
  json.key("descriptors");
  json.begin_object();
  for (DescriptorRow& descriptor : row.descriptors) add_array(json, descriptor.name, descriptor.values, 0);
  json.end_object();
  for (const ItemColumn& column : item_columns)
    if (column.is_in_python() && !is_array(column))
      write_item(json, column, row.report, [&](double number) { json.value(exact_text(number)); });
  json.member("content", hex_text(weighted.sampled.content));
  json.end_object();
  return json.text();
}

std::string text_of(ContentMesh& content_mesh) {
  PolygonMesh& mesh = content_mesh.mesh;
  const std::size_t faces = mesh.polygon_count();
  const std::size_t width = faces > 0 ? mesh.polygon_begin[1] - mesh.polygon_begin[0] : 3;
  bool equal = true;
  for (std::size_t f = 0; f < faces && equal; ++f)
    equal = mesh.polygon_begin[f + 1] - mesh.polygon_begin[f] == width;
  JsonWriter json;
  json.begin_object();
  json.member("vertex_count", std::uint64_t{mesh.vertex_count()});
  json.member("face_count", std::uint64_t{faces});
  json.member("width", std::uint64_t{equal ? width : 0});
  json.key("arrays");
  json.begin_object();
  add_array(json, "x", mesh.x, 0);
  add_array(json, "y", mesh.y, 0);
  add_array(json, "z", mesh.z, 0);
  add_array(json, "corners", mesh.corners, 0);
  json.end_object();
  json.member("content", hex_text(content_mesh.content));
  json.end_object();
  return json.text();
}

std::string text_of(LaboratoryResult& result) {
  JsonWriter json;
  json.begin_object();
  json.key("numbers");
  json.begin_object();
  for (const auto& [name, number] : result.numbers) json.member(name, exact_text(number));
  json.end_object();
  json.key("arrays");
  json.begin_object();
  for (LaboratoryResult::Array& array : result.arrays)
    std::visit([&](auto& values) { add_values(json, array.name, values, array.columns); }, array.values);
  json.end_object();
  json.end_object();
  return json.text();
}

}  // namespace meander
