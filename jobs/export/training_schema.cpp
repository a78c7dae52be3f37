#include "jobs/export/training_schema.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <stdexcept>

#include "io/parameters_text.h"
#include "io/run_error.h"
#include "io/table/npy_header.h"
#include "jobs/cli/usage_error.h"
#include "kernels/core/half.h"
#include "kernels/sample/query_points.h"

namespace meander {

namespace {

bool is_query(SchemaPoints points) {
  return points != SchemaPoints::samples && points != SchemaPoints::sharp;
}

std::vector<SchemaArray> arrays_of(SchemaKind schema) {
  std::vector<SchemaArray> arrays;
  for (const SchemaArray& array : schema_arrays)
    if (array.schema == schema) arrays.push_back(array);
  return arrays;
}

// The names of files, each once.
std::vector<std::string_view> templates_of(SchemaKind schema) {
  std::vector<std::string_view> names;
  for (const SchemaArray& array : arrays_of(schema))
    if (names.empty() || names.back() != array.file) names.push_back(array.file);
  return names;
}

std::string file_name(std::string_view name, const std::string& id) {
  const std::size_t begin = name.find('{'), end = name.find('}');
  const std::string_view folder = name.substr(begin + 1, end - begin - 1);  // "/FOLDER/", or nothing
  std::string inner = id;
  if (!folder.empty()) {
    const std::size_t slash = id.rfind('/');
    inner = slash == id.npos ? std::string(folder.substr(1)) + id
                             : id.substr(0, slash) + std::string(folder) + id.substr(slash + 1);
  }
  return std::string(name.substr(0, begin)) + inner + std::string(name.substr(end + 1));
}

// The kinds of queries in the order in which an array has them.
std::vector<QueryKind> kinds_of(SchemaPoints points) {
  using enum QueryKind;
  switch (points) {
    case SchemaPoints::near:
      return {near};
    case SchemaPoints::near_sharp:
      return {near_sharp};
    case SchemaPoints::volume:
      return {volume};
    case SchemaPoints::near_then_volume:
      return {near, volume};
    case SchemaPoints::all:
    case SchemaPoints::samples:
    case SchemaPoints::sharp:
      break;
  }
  return {};
}

// By the name of a group, KIND@SIZE.
bool is_of_kind(std::string_view group, QueryKind kind) {
  return group.substr(0, group.find('@')) == text_of(query_kind_words, kind);
}

// The numbers of an array of one model.
class ModelArrays {
 public:
  ModelArrays(const StoreColumns& columns, SchemaChoice schema, const Row& row)
      : columns_(columns),
        facts_(row_of(schema_facts, schema.kind)),
        keeps_(schema.uncertain == UncertainChoice::keep),
        row_(row),
        place_(schema_place(row.report, schema.kind)) {}

  std::string npy(const SchemaArray& array) const {
    std::vector<double> values;
    std::uint64_t width = 1;
    std::vector<std::uint64_t> shape;
    switch (array.part) {
      case SchemaPart::loc:
        values = {place_.center.x, place_.center.y, place_.center.z};
        return file(array, values, {3});
      case SchemaPart::scale:
        values = {place_.size};
        return file(array, values, {});
      case SchemaPart::one:
        values = {1};
        return file(array, values, {});
      case SchemaPart::packed_occupancies:
        return packed(array);
      case SchemaPart::points:
      case SchemaPart::normals:
        width = 3;
        break;
      case SchemaPart::with_normals:
        width = 6;
        break;
      case SchemaPart::with_distance:
      case SchemaPart::outside_with_distance:
      case SchemaPart::inside_with_distance:
        width = 4;
        break;
      case SchemaPart::distances:
      case SchemaPart::occupancies:
        break;
    }
    for (const std::size_t i : chosen(array)) append(array, i, values);
    shape = {values.size() / width};
    if (array.middle_axis) shape.push_back(1);
    if (width > 1) shape.push_back(width);
    return file(array, values, shape);
  }

 private:
  const std::vector<float>& points_of(SchemaPoints points) const {
    const Samples& s = row_.samples;
    return points == SchemaPoints::samples ? s.points
           : points == SchemaPoints::sharp ? s.sharp_points
                                           : s.query_points;
  }

  // The points of an array, in its order.
  std::vector<std::size_t> chosen(const SchemaArray& array) const {
    const Samples& s = row_.samples;
    std::vector<std::size_t> all;
    if (!is_query(array.points)) {
      for (std::size_t i = 0; i < points_of(array.points).size() / 3; ++i) all.push_back(i);
      return all;
    }
    const auto take = [&](std::optional<QueryKind> kind) {
      for (std::size_t i = 0; i < s.query_kind.size(); ++i) {
        if (kind && !is_of_kind(columns_.query_groups.at(s.query_kind[i]), *kind)) continue;
        if (!keeps_ && s.query_certain[i] == 0) continue;
        if (array.part == SchemaPart::outside_with_distance && s.query_inside[i] != 0) continue;
        if (array.part == SchemaPart::inside_with_distance && s.query_inside[i] == 0) continue;
        all.push_back(i);
      }
    };
    if (array.points == SchemaPoints::all) take(std::nullopt);
    for (const QueryKind kind : kinds_of(array.points)) take(kind);
    return all;
  }

  void append_point(const std::vector<float>& points, std::size_t i, std::vector<double>& values) const {
    const double center[3] = {place_.center.x, place_.center.y, place_.center.z};
    // The shift first: nothing is lost where both are far from the origin.
    for (std::size_t k = 0; k < 3; ++k)
      values.push_back(((row_.report.loc[k] - center[k]) + row_.report.scale * double{points[3 * i + k]}) /
                       place_.size);
  }
  void append_vector(const std::vector<float>& vectors, std::size_t i, std::vector<double>& values) const {
    for (std::size_t k = 0; k < 3; ++k) values.push_back(double{vectors[3 * i + k]});
  }
  double distance(std::size_t i) const {
    const double stored = double{row_.samples.query_distance[i]} * row_.report.scale / place_.size;
    return facts_.positive_inside ? -stored : stored;
  }

  void append(const SchemaArray& array, std::size_t i, std::vector<double>& values) const {
    const Samples& s = row_.samples;
    const bool is_sharp = array.points == SchemaPoints::sharp;
    switch (array.part) {
      case SchemaPart::points:
        return append_point(points_of(array.points), i, values);
      case SchemaPart::normals:
        return append_vector(is_sharp ? s.sharp_normals : s.normals, i, values);
      case SchemaPart::with_normals:
        append_point(points_of(array.points), i, values);
        return append_vector(is_sharp ? s.sharp_normals : s.normals, i, values);
      case SchemaPart::distances:
        values.push_back(distance(i));
        return;
      case SchemaPart::with_distance:
      case SchemaPart::outside_with_distance:
      case SchemaPart::inside_with_distance:
        append_point(points_of(array.points), i, values);
        values.push_back(distance(i));
        return;
      case SchemaPart::occupancies:
        values.push_back(s.query_inside[i]);
        return;
      case SchemaPart::packed_occupancies:
      case SchemaPart::loc:
      case SchemaPart::scale:
      case SchemaPart::one:
        return;
    }
  }

  std::string packed(const SchemaArray& array) const {
    const std::vector<std::size_t> all = chosen(array);
    std::vector<double> bytes((all.size() + 7) / 8, 0);
    for (std::size_t i = 0; i < all.size(); ++i)
      if (row_.samples.query_inside[all[i]] != 0) bytes[i / 8] += 128 >> i % 8;
    return file(array, bytes, {bytes.size()});
  }

  template <class Value, class Of>
  static void put(std::string& file, const std::vector<double>& values, const Of& of) {
    for (const double value : values) {
      const Value as = of(value);
      file.append(reinterpret_cast<const char*>(&as), sizeof as);
    }
  }

  static std::string file(const SchemaArray& array, const std::vector<double>& values,
                          const std::vector<std::uint64_t>& shape) {
    constexpr std::array<std::string_view, 5> types = {"<f2", "<f4", "<f8", "|u1", "|b1"};
    std::string file = npy_header(types[static_cast<std::size_t>(array.type)], shape);
    switch (array.type) {
      case SchemaType::f16:
        put<std::uint16_t>(file, values, [](double v) { return half_of(static_cast<float>(v)); });
        break;
      case SchemaType::f32:
        put<float>(file, values, [](double v) { return static_cast<float>(v); });
        break;
      case SchemaType::f64:
        put<double>(file, values, [](double v) { return v; });
        break;
      case SchemaType::u8:
      case SchemaType::truth:
        put<std::uint8_t>(file, values, [](double v) { return static_cast<std::uint8_t>(v); });
        break;
    }
    return file;
  }

  const StoreColumns& columns_;
  const SchemaFacts& facts_;
  bool keeps_;
  const Row& row_;
  SchemaPlace place_;
};

}  // namespace

std::vector<std::string> schema_files(SchemaKind schema, const std::string& id) {
  std::vector<std::string> files;
  for (const std::string_view name : templates_of(schema)) files.push_back(file_name(name, id));
  return files;
}

std::vector<std::string> schema_members(SchemaKind schema) {
  std::vector<std::string> members;
  for (const std::string_view name : templates_of(schema)) {
    std::string member;
    for (const char c : name.substr(name.find('{') + 1))
      if (c != '}' && c != '/') member += c;
    members.push_back(member.substr(member.find_first_not_of("_.")));
  }
  return members;
}

SchemaPlace schema_place(const ItemReport& report, SchemaKind schema) {
  const SchemaFrame frame = row_of(schema_facts, schema).frame;
  if (frame == SchemaFrame::sphere) return {{report.loc[0], report.loc[1], report.loc[2]}, report.scale};
  const std::array<double, 6>& box = report.bbox;
  const double longest = std::max({box[3] - box[0], box[4] - box[1], box[5] - box[2]});
  return {{box[0] / 2 + box[3] / 2, box[1] / 2 + box[4] / 2, box[2] / 2 + box[5] / 2},
          frame == SchemaFrame::box ? longest : longest / 2};
}

void require_schema(const StoreReader& store, SchemaKind schema) {
  const std::string user = fmt::format("--schema {}", text_of(schema_words, schema));
  for (const SchemaArray& array : arrays_of(schema)) {
    if (array.points == SchemaPoints::samples)
      store.require(&Samples::normals, user);
    else if (array.points == SchemaPoints::sharp)
      store.require(&Samples::sharp_points, user);
    else
      store.require(&Samples::query_inside, user);
    for (const QueryKind kind : kinds_of(array.points)) {
      const std::vector<std::string>& groups = store.columns().query_groups;
      if (std::none_of(groups.begin(), groups.end(), [&](const auto& g) { return is_of_kind(g, kind); }))
        throw UsageError(
            fmt::format("{} needs points `{}=COUNT@SIZE` of run --queries, which the store has none of", user,
                        text_of(query_kind_words, kind)));
    }
  }
  if (row_of(schema_facts, schema).frame != SchemaFrame::sphere) return;
  const auto members = split_members(store.parameters_json());
  const auto at = members.find("normalize");
  if (at == members.end() || at->second != "\"unit-sphere\"")
    throw UsageError(
        fmt::format("{} has models in a sphere: it needs a store of run --normalize unit-sphere", user));
}

bool has_sides(const ItemReport& report, std::uint32_t queries, UncertainChoice uncertain) {
  return uncertain == UncertainChoice::keep || report.uncertain < queries;
}

void write_schema_file(const PutBytes& put, const StoreColumns& columns, SchemaChoice schema,
                       std::size_t number, const Row& row, const std::string& id) {
  const std::string_view name = templates_of(schema.kind).at(number);
  const ModelArrays arrays(columns, schema, row);
  try {
    StoredZipWriter zip(put);
    for (const SchemaArray& array : arrays_of(schema.kind)) {
      if (array.file != name) continue;
      if (array.key.empty()) return put(arrays.npy(array));
      zip.add(std::string(array.key) + ".npy", {arrays.npy(array)});
    }
    zip.finish();
  } catch (const std::length_error&) {
    throw RunError(RunError::Kind::unusable,
                   "the arrays of `" + id + "` exceed the 4 GiB that an .npz file holds");
  }
}

std::string schema_markdown() {
  constexpr std::array<std::string_view, 5> types = {"float16", "float32", "float64", "uint8", "bool"};
  constexpr std::array<std::string_view, 7> counts = {"N", "S", "Q", "Q", "Q", "Q", "Q"};
  constexpr std::array<std::string_view, 7> whose = {
      "samples",  "points on sharp edges", "`near`",     "`near-sharp`",
      "`volume`", "`near`, then `volume`", "all queries"};
  struct Text {
    std::string_view shape, what;
  };
  constexpr std::array<Text, 12> parts = {{{", 3)", "points"},
                                           {", 3)", "normals"},
                                           {", 6)", "points, normals"},
                                           {")", "distances"},
                                           {", 4)", "points, distance"},
                                           {", 4)", "points, distance: those outside"},
                                           {", 4)", "points, distance: those inside"},
                                           {")", "1 inside, 0 outside"},
                                           {" / 8)", "1 inside, 0 outside, packed (numpy.unpackbits)"},
                                           {"(3)", "center of the box"},
                                           {"()", "longest side"},
                                           {"()", "1"}}};
  std::string table = "| schema | file | key | shape | type | content |\n|---|---|---|---|---|---|\n";
  for (const SchemaArray& array : schema_arrays) {
    const Text& part = parts[static_cast<std::size_t>(array.part)];
    const auto points = static_cast<std::size_t>(array.points);
    const bool is_fixed = part.shape.front() == '(';
    const std::string shape =
        is_fixed ? std::string(part.shape)
                 : fmt::format("({}{}{}", counts[points], array.middle_axis ? ", 1" : "", part.shape);
    table += fmt::format("| {} | `{}` | {} | {} | {} | {} |\n", text_of(schema_words, array.schema),
                         file_name(array.file, "ID"), array.key.empty() ? "" : fmt::format("`{}`", array.key),
                         shape, types[static_cast<std::size_t>(array.type)],
                         is_fixed ? std::string(part.what) : fmt::format("{}: {}", whose[points], part.what));
  }
  return table;
}

}  // namespace meander
