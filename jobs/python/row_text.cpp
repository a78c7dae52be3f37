#include "jobs/python/row_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <utility>

#include "io/digest.h"
#include "io/json_writer.h"

namespace meander {

namespace {

template <class Value>
constexpr const char* type_text = nullptr;
template <>
constexpr const char* type_text<float> = "<f4";
template <>
constexpr const char* type_text<double> = "<f8";
template <>
constexpr const char* type_text<std::uint32_t> = "<u4";
template <>
constexpr const char* type_text<std::uint8_t> = "|u1";

// n x columns (n where columns is 0) values.
template <class Values>
void add_values(JsonWriter& json, std::string_view name, Values& values, std::uint64_t columns) {
  json.key(name);
  json.begin_array();
  json.value(std::uint64_t{reinterpret_cast<std::uintptr_t>(values.data())});
  json.value(type_text<typename Values::value_type>);
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
void add_number(JsonWriter& json, std::string_view name, double number) {
  json.member(name, fmt::format("{:a}", number));
}

void add_report(JsonWriter& json, const ItemReport& report) {
  add_number(json, "area", report.area);
  add_number(json, "measure", report.measure);
  add_number(json, "scale", report.scale);
  json.member("method", name_of(report.method));
  json.member("components", report.components);
  json.member("genus", report.genus);
  json.member("boundaries", report.boundaries);
  json.key("repairs");
  json.begin_object();
  for (std::size_t i = 0; i < repair_count; ++i)
    if (report.repairs.counts[i] > 0) json.member(repair_names[i], report.repairs.counts[i]);
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
  add_array(json, "points", samples.points, 3);
  add_array(json, "normals", samples.normals, 3);
  add_array(json, "face_index", samples.face, 0);
  add_array(json, "corners", samples.corners, 3);
  add_array(json, "barycentric", samples.barycentric, 2);
  add_array(json, "uv", samples.uv, 2);
  add_array(json, "curve_rank", samples.curve_rank, 0);
  add_array(json, "density", samples.density, 0);
  add_array(json, "weights", weighted.weights, 0);
  add_array(json, "tensor_direction", samples.tensor_direction, 3);
  add_array(json, "tensor_spacing", samples.tensor_spacing, 2);
  add_array(json, "bbox", row.report.bbox, 3);
  add_array(json, "loc", row.report.loc, 0);
  json.end_object();
  json.key("descriptors");
  json.begin_object();
  for (DescriptorRow& descriptor : row.descriptors) add_array(json, descriptor.name, descriptor.values, 0);
  json.end_object();
  add_report(json, row.report);
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
  for (const auto& [name, number] : result.numbers) add_number(json, name, number);
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
