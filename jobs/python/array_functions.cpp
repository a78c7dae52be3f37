#include "jobs/python/array_functions.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "io/file/atomic_file.h"
#include "io/mesh/point_writer.h"
#include "io/word_list.h"
#include "jobs/cli/option_words.h"
#include "jobs/cli/usage_error.h"
#include "jobs/python/query_functions.h"
#include "jobs/python/sample_options.h"
#include "jobs/python/sampling_work.h"
#include "kernels/model/model.h"
#include "kernels/model/remesh_model.h"
#include "kernels/rays/embree_locator.h"
#include "kernels/retrieve/nearest_rows.h"

namespace meander {

namespace {

// ---- the nearest rows of a base

DistanceKind distance_of(const LaboratoryArguments& given) {
  const std::string word = given.text("distance");
  DistanceKind kind{};
  if (!take_word(distance_words, word, kind))
    throw UsageError("distance: " + none_of(word, all_words(distance_words)));
  return kind;
}

// rows and distances (queries, k).
LaboratoryResult neighbors(const std::vector<std::vector<NearRow>>& found) {
  const std::size_t k = found.empty() ? 0 : found.front().size();  // of all: they search one base
  if (k == 0 && !found.empty()) throw UsageError("there is no other row to be near");
  std::vector<std::uint32_t> rows;
  std::vector<float> distances;
  for (const std::vector<NearRow>& near : found)
    for (const NearRow& row : near) {
      rows.push_back(row.row);
      distances.push_back(row.distance);
    }
  LaboratoryResult result;
  const std::uint64_t columns = std::max<std::size_t>(k, 1);
  result.add("rows", std::move(rows), columns);
  result.add("distances", std::move(distances), columns);
  return result;
}

// Takes base (M, B), k, distance, and either queries (Q, B) or rows (Q,), rows of the base that are not among
// their own neighbors; all in float32. Returns rows and distances (Q, k), ascending by (distance, row).
LaboratoryResult nearest_rows(const LaboratoryArguments& given) {
  const std::uint64_t width = given.columns("base");
  const std::span<const float> values = given.floats("base", width);
  const DescriptorBlock block{values, static_cast<std::uint32_t>(width)};
  const DescriptorBase base = make_descriptor_base({&block, 1}, distance_of(given));
  NearestSearch search(given.whole("k"));
  std::size_t count = 0;
  if (given.has("queries")) {
    const std::span<const float> queries = given.floats("queries", width);
    count = queries.size() / width;
    for (std::size_t q = 0; q < count; ++q)
      search.add_query(make_descriptor_query(base, queries.subspan(q * width, width)));
  } else {
    const std::span<const std::uint32_t> rows = given.numbers("rows");
    count = rows.size();
    for (const std::uint32_t row : rows) {
      if (row >= base.rows)
        throw UsageError(fmt::format("queries: there is no row {} of {}", row, base.rows));
      search.add_query(make_descriptor_query(base, values.subspan(row * width, width)), row);
    }
  }
  std::vector<std::uint32_t> numbers(base.rows);
  std::iota(numbers.begin(), numbers.end(), 0u);
  search.search(base, numbers);
  std::vector<std::vector<NearRow>> found(count);
  for (std::size_t q = 0; q < count; ++q) found[q] = search.found(q);
  return neighbors(found);
}

// ---- meshes

// Takes a mesh, content (32,), sample and mesh: settings as JSON in a text, threads, and timeout (seconds, 0:
// none). Returns vertices (V, 3), faces (F, 3), and the numbers of remesh_counts and the fractions of the
// report.
LaboratoryResult remesh(const LaboratoryArguments& given) {
  const SampleParameters sample = sample_parameters(given.text("sample"), false);
  const RemeshParameters parameters = remesh_parameters(given.text("mesh"));
  const std::span<const std::uint8_t> content = given.bytes("content");
  const double timeout = given.real("timeout");
  RemeshedSurface made;
  with_threads(static_cast<int>(given.whole("threads")), [&] {
    std::optional<EmbreeDevice> device;
    if (casts_rays(sample)) device.emplace();
    Model model;
    model.cancel = token_of(nullptr, timeout > 0 ? std::optional(timeout) : std::nullopt);
    model.key = make_random_key(sample.seed, content);
    model.file = given.mesh();
    run_stages(stages_of(sample, device ? &*device : nullptr), model);
    made = remesh_model(model, parameters);
  });
  std::vector<double> vertices;
  vertices.reserve(3 * made.x.size());
  for (std::size_t v = 0; v < made.x.size(); ++v)
    vertices.insert(vertices.end(), {made.x[v], made.y[v], made.z[v]});
  LaboratoryResult result;
  result.add("vertices", std::move(vertices), 3);
  result.add("faces", std::move(made.triangles), 3);
  for (const RemeshCount& count : remesh_counts)
    result.add(std::string("report_") + count.name, static_cast<double>(count.of(made.report)));
  result.add("report_dropped_share", made.report.dropped_share);
  result.add("report_largest_shift", made.report.largest_shift);
  return result;
}

// ---- files

// The format of a file of this name.
PointFormat point_format_of(const std::filesystem::path& path) {
  const std::string ending = lower_ascii(path.extension().string());
  std::vector<std::string_view> endings;
  for (const PointFormat format : point_formats) {
    endings.push_back(ending_of(kind_of(format)));
    if (endings.back() == ending) return format;
  }
  throw UsageError(fmt::format("`{}` ends in none of {}", path.string(), word_list(endings)));
}

// Takes path (a text in bytes), frame (4,), loc and scale, and the columns of samples by the names of their
// arrays, `points` among them. Writes the file.
LaboratoryResult write_point_file(const LaboratoryArguments& given) {
  const std::span<const std::uint8_t> name = given.bytes("path");
  const std::filesystem::path path(std::string(name.begin(), name.end()));
  const PointFormat format = point_format_of(path);
  Samples samples;
  for (const SampleColumn& column : sample_columns)
    with_array(column, samples, [&]<class Value>(std::vector<Value>& values) {
      const std::string array = column.array_name();
      if (!given.has(array) || !column.is_of_samples()) return;
      std::span<const Value> all;
      if constexpr (std::is_same_v<Value, float>)
        all = given.floats(array, column.values_each());
      else if constexpr (std::is_same_v<Value, std::uint8_t>)
        all = given.bytes(array, column.values_each());
      else
        all = given.numbers(array, column.values_each());
      values.assign(all.begin(), all.end());
      if (values.size() != samples.count() * column.values_each())
        throw UsageError(fmt::format("{} has {} rows for {} points", array,
                                     values.size() / column.values_each(), samples.count()));
    });
  if (format == PointFormat::xyz && samples.normals.empty())
    throw UsageError("an .xyz file has a normal at each point: give normals, or write .ply or .off");
  const std::span<const double> frame = given.reals("frame");
  ItemReport report;
  report.loc = {frame[0], frame[1], frame[2]};
  report.scale = frame[3];
  AtomicFile file(path);
  write_points([&](std::string_view data) { file.append(data); }, format, samples, report);
  file.commit();
  return {};
}

struct ArrayFunction {
  std::string_view name;
  LaboratoryResult (*call)(const LaboratoryArguments&);
};
constexpr ArrayFunction functions[] = {{"nearest_rows", nearest_rows},
                                       {"remesh", remesh},
                                       {"signed_distance", signed_distance},
                                       {"winding_number", winding_number},
                                       {"write_points", write_point_file}};

}  // namespace

std::optional<LaboratoryResult> call_array_function(std::string_view name, const LaboratoryArguments& given) {
  const auto* const found =
      std::find_if(std::begin(functions), std::end(functions),
                   [&](const ArrayFunction& function) { return function.name == name; });
  if (found == std::end(functions)) return std::nullopt;
  return found->call(given);
}

}  // namespace meander
