#include "jobs/describe/describe_stages.h"

#include <fmt/format.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

#include "io/archive/model_bytes.h"
#include "io/store/crc32c.h"
#include "io/store/row_codec.h"
#include "jobs/cli/usage_error.h"
#include "jobs/rows/descriptor_choice.h"
#include "kernels/core/joined_texts.h"
#include "kernels/mesh/prepare_mesh.h"
#include "pipeline/memory_estimate.h"

namespace meander {

namespace {

void read_row_to_describe(const Describer& describer, const StoreReader& store, GraphItem& item) {
  Row& row = item.model.row;
  row = store.read_row(item.plan->row);
  if (row.report.status == Status::ok &&
      crc32c(std::span<const float>(row.samples.points)) != row.report.points_crc32c)
    throw RunError(RunError::Kind::unusable,
                   fmt::format("the points of row {} are not those that were written: see meander verify",
                               item.plan->row));
  item.file_bytes = std::uint64_t{12} * describer.header->samples;
  item.model.key = make_random_key(describer.header->seed, row.report.content_sha256);
  // Descriptors of this job replace those of the store, even if they cannot be made.
  std::erase_if(row.descriptors, [&](const DescriptorRow& d) { return describer.makes(d.name); });
}

// The mesh must be the file that was sampled.
void read_mesh_of_row(const Describer& describer, GraphItem& item) {
  const PlanItem& plan = *item.plan;
  if (!plan.known_format)
    throw ItemError(Status::unsupported_format, "`" + plan.path.string() + "` is no mesh file");
  MeshEstimate actual;
  const auto admit = [&](MeshEstimate needs) {
    needs.file_bytes = actual.file_bytes;
    needs.packed_bytes = actual.packed_bytes;
    const std::uint64_t needed =
        estimate_bytes(needs, describer.meshes, oneapi::tbb::this_task_arena::max_concurrency());
    if (needed > describer.memory_bytes && !describer.allow_oversize)
      throw ItemError(
          Status::too_large,
          fmt::format("needs about {} MiB, --memory leaves {} MiB for models (raise it, or --allow-oversize)",
                      needed >> 20, describer.memory_bytes >> 20));
    if (needed > item.reserved_bytes) throw NeedsMoreMemory(needed);
  };
  PolygonMesh& mesh = item.model.file;
  {
    const ModelBytes file(plan, describer.allow_oversize ? ~std::uint64_t{0} : describer.memory_bytes);
    if (file.content_sha256() != item.model.row.report.content_sha256)
      throw ItemError(Status::unreadable,
                      "`" + plan.path.string() + "` is not the file that was sampled: its SHA-256 differs");
    item.file_bytes = actual.file_bytes = file.file_bytes();
    actual.packed_bytes = file.packed_bytes();
    mesh = file.mesh(item.model.cancel, admit);
  }
  actual.vertices = mesh.vertex_count();
  const std::size_t corners = mesh.corners.size(), polygons = mesh.polygon_count();
  actual.triangles = corners > 2 * polygons ? corners - 2 * polygons : 0;
  actual.decoding_bytes = mesh.attribute_bytes();
  admit(actual);
}

void prepare(GraphItem& item) {
  Model& model = item.model;
  model.surface = prepare_mesh(model.file, model.cancel);
  locate_on_mesh(model.file, model.surface, model.row.samples, model.cancel);
}

// Adds the new descriptors after those of the row.
void describe(const DescribeParameters& parameters, GraphItem& item) {
  Model& model = item.model;
  for (DescriptorRow& made :
       describe_samples(model.surface, model.row.samples, model.key, parameters, model.cancel))
    model.row.descriptors.push_back(std::move(made));
}

// Arranges the columns of the header in order: the newest of each name, or NaN for one that could not be
// made, which is reported to `failed`.
void arrange_descriptors(const Describer& describer, const DescribeFailed& failed, GraphItem& item) {
  std::vector<DescriptorRow>& present = item.model.row.descriptors;
  std::vector<DescriptorRow> arranged;
  std::vector<std::string> lacking;
  for (const DescriptorSchema& schema : describer.header->descriptors) {
    const auto newest = std::find_if(present.rbegin(), present.rend(),
                                     [&](const DescriptorRow& d) { return d.name == schema.name; });
    if (newest == present.rend())
      arranged.push_back(
          {schema.name, std::vector<float>(schema.width, std::numeric_limits<float>::quiet_NaN())});
    else
      arranged.push_back(std::move(*newest));
    if (schema.group == "descriptors" && describer.makes(schema.name) &&
        !is_described(schema, arranged.back().values))
      lacking.push_back("`" + schema.name + "`");
  }
  if (!lacking.empty())
    failed(item,
           {Status::ok, fmt::format("{} could not be made of this model", joined_texts(lacking, " and "))});
  present = std::move(arranged);
}

}  // namespace

Describer make_describer(const StoreHeader& header, const DescribeParameters& describe) {
  SampleParameters parameters = parameters_for("direct");  // it makes no charts and casts no rays
  parameters.samples = header.samples;
  parameters.describe = describe;
  const std::vector<std::string> problems = validate(parameters);
  if (!problems.empty()) throw UsageError(joined_texts(problems, "\n"));
  Describer describer;
  describer.header = &header;
  describer.points = describer.meshes = parameters;
  describer.points.describe.descriptors.clear();
  describer.meshes.describe.descriptors.clear();
  for (const Descriptor descriptor : describe.descriptors)
    (needs_mesh(descriptor) ? describer.meshes : describer.points).describe.descriptors.push_back(descriptor);
  return describer;
}

SampleParameters Describer::all() const {
  SampleParameters both = points;
  const std::vector<Descriptor>& more = meshes.describe.descriptors;
  both.describe.descriptors.insert(both.describe.descriptors.end(), more.begin(), more.end());
  return both;
}

void DescribedRowSink::write(EncodedRow row) {
  const auto record = store::read_record_header(row.bytes);
  if (record && record->status == Status::ok) return directory_.end_item(std::move(row));
  if (last_round_)
    throw RunError(RunError::Kind::stopped,
                   "row " + std::to_string(row.row) + " could not be read and written again");
}

bool Describer::makes(std::string_view name) const {
  const auto named = [&](Descriptor descriptor) { return makes_row(descriptor, name); };
  const auto &of_points = points.describe.descriptors, &of_meshes = meshes.describe.descriptors;
  return std::any_of(of_points.begin(), of_points.end(), named) ||
         std::any_of(of_meshes.begin(), of_meshes.end(), named);
}

GraphStages stages_with_meshes(const Describer& describer, const StoreReader& store, DescribeFailed failed) {
  return {{"read_row", [&](GraphItem& item) { read_row_to_describe(describer, store, item); }},
          {"read_mesh", [&](GraphItem& item) { read_mesh_of_row(describer, item); }},
          {"prepare_mesh", prepare},
          {"describe_shape", [&describer, failed = std::move(failed)](GraphItem& item) {
             describe(describer.meshes.describe, item);
             describe(describer.points.describe, item);
             arrange_descriptors(describer, failed, item);
           }}};
}

// One stage with its own time limit: a row must get through it, however long its descriptors take.
GraphStages stages_with_points(const Describer& describer, const StoreReader& store, DescribeFailed failed) {
  return {{"describe_shape", [&describer, &store, failed = std::move(failed)](GraphItem& item) {
             read_row_to_describe(describer, store, item);
             if (describer.timeout_seconds > 0)
               item.model.cancel.deadline = std::chrono::steady_clock::now() +
                                            std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                                std::chrono::duration<double>(describer.timeout_seconds));
             try {
               describe(describer.points.describe, item);
             } catch (const RunCanceled&) {
               throw;
             } catch (...) {
               failed(item, current_failure("describe_shape"));
             }
             arrange_descriptors(describer, failed, item);
           }}};
}

}  // namespace meander
