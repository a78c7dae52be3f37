#include "pipeline/memory_estimate.h"

#include <algorithm>

#include "io/store/journal_store.h"
#include "kernels/sample/column_makers.h"

namespace meander {

namespace {

constexpr double fixed_bytes = 1.0 * 1024 * 1024;  // arrays of a tiny model, one scene
constexpr double bytes_per_file_vertex = 40;       // three doubles, weld table
constexpr double bytes_per_file_triangle = 24;     // corners, offsets
// Texture coordinates for their own sake: of every corner one of its own, while parts are joined; of every
// vertex while an accessor is read.
constexpr double bytes_per_coordinate_triangle = 120, bytes_per_coordinate_vertex = 40;
// The bytes of each number of an attribute that only a column asks for.
constexpr double bytes_per_asked_vertex = 32, bytes_per_attribute_sample = 12;

constexpr std::uint64_t program_bytes = 30 << 20;      // measured: 25 MiB, with Embree 27
constexpr std::uint64_t bytes_per_thread = 512 << 10;  // stack, buffers, tables of the compressor
constexpr std::uint64_t bytes_per_item = 1 << 10;      // of the plan, the header and a block of item columns
constexpr std::uint64_t allocator_share =
    16;  // 1/16 of the budget may be free blocks that are not given back

}  // namespace

MemoryEstimate::MemoryEstimate(const SampleParameters& parameters, int threads)
    : parameters_(parameters), threads_(threads), stages_(stage_bytes(parameters)) {}

std::uint64_t MemoryEstimate::operator()(const MeshEstimate& mesh) const {
  const auto triangles = static_cast<double>(mesh.triangles), vertices = static_cast<double>(mesh.vertices);
  const auto samples = static_cast<double>(parameters_.samples);
  double file = static_cast<double>(mesh.file_bytes + mesh.packed_bytes + mesh.decoding_bytes) +
                vertices * bytes_per_file_vertex + triangles * bytes_per_file_triangle;
  for (const ColumnMaker& maker : column_makers)
    if (parameters_.columns[maker.column])
      file += maker.bytes.fixed + vertices * maker.bytes.per_vertex + triangles * maker.bytes.per_triangle +
              samples * maker.bytes.per_sample;
  if (reads_coordinates(parameters_))
    file += vertices * bytes_per_coordinate_vertex + triangles * bytes_per_coordinate_triangle;
  for (const AttributeColumn& column : parameters_.attributes)
    file += column.width * (vertices * bytes_per_asked_vertex + samples * bytes_per_attribute_sample);
  file += density_bytes(parameters_.density, triangles);
  const ModelSizes sizes = {triangles, vertices, samples, threads_};
  double most = 0;
  for (const StageBytes bytes : stages_) most = std::max(most, bytes(parameters_, sizes));
  return static_cast<std::uint64_t>(fixed_bytes + file + most);
}

std::uint64_t estimate_bytes(const MeshEstimate& mesh, const SampleParameters& parameters, int threads) {
  return MemoryEstimate(parameters, threads)(mesh);
}

std::uint64_t process_bytes(std::uint64_t budget, const StoreHeader& header, int threads) {
  const std::uint64_t items = header.ids.size();
  return program_bytes + static_cast<std::uint64_t>(threads) * bytes_per_thread + items * bytes_per_item +
         store_writing_bytes(header) + budget / allocator_share;
}

}  // namespace meander
