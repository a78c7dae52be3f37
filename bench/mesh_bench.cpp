// Reading files, preparing meshes, and adjacency beside OpenMesh's.
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <cstdio>
#include <cstring>
#include <string>

#include "bench/bench_shapes.h"
#include "io/mesh/mesh_reader.h"
#include "kernels/mesh/half_edges.h"
#include "kernels/mesh/prepare_mesh.h"

namespace meander::bench {

namespace {

void append(std::string& text, const char* format, auto... values) {
  char line[128];
  std::snprintf(line, sizeof line, format, values...);
  text += line;
}

template <class T>
void append_raw(std::string& text, T value) {
  char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  text.append(bytes, sizeof bytes);
}

std::string text_file(const PolygonMesh& mesh, MeshFormat format) {
  std::string text;
  const bool off = format == MeshFormat::off;
  if (off) append(text, "OFF\n%zu %zu 0\n", mesh.vertex_count(), mesh.polygon_count());
  for (std::size_t i = 0; i < mesh.x.size(); ++i)
    append(text, off ? "%.9g %.9g %.9g\n" : "v %.9g %.9g %.9g\n", mesh.x[i], mesh.y[i], mesh.z[i]);
  for (std::size_t c = 0; c < mesh.corners.size(); c += 3) {
    const std::uint32_t* v = mesh.corners.data() + c;
    if (off)
      append(text, "3 %u %u %u\n", v[0], v[1], v[2]);
    else
      append(text, "f %u %u %u\n", v[0] + 1, v[1] + 1, v[2] + 1);
  }
  return text;
}

std::string binary_ply(const PolygonMesh& mesh) {
  std::string text = "ply\nformat binary_little_endian 1.0\n";
  append(text, "element vertex %zu\nproperty float x\nproperty float y\nproperty float z\n",
         mesh.vertex_count());
  append(text, "element face %zu\nproperty list uchar int vertex_indices\nend_header\n",
         mesh.polygon_count());
  for (std::size_t i = 0; i < mesh.x.size(); ++i)
    for (const double value : {mesh.x[i], mesh.y[i], mesh.z[i]}) append_raw(text, static_cast<float>(value));
  for (std::size_t c = 0; c < mesh.corners.size(); c += 3) {
    append_raw(text, std::uint8_t{3});
    for (std::size_t k = 0; k < 3; ++k) append_raw(text, mesh.corners[c + k]);
  }
  return text;
}

std::string binary_stl(const PolygonMesh& mesh) {
  std::string text(80, ' ');
  append_raw(text, static_cast<std::uint32_t>(mesh.polygon_count()));
  for (std::size_t c = 0; c < mesh.corners.size(); c += 3) {
    for (int k = 0; k < 3; ++k) append_raw(text, 0.0f);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = mesh.corners[c + k];
      for (const double value : {mesh.x[v], mesh.y[v], mesh.z[v]})
        append_raw(text, static_cast<float>(value));
    }
    append_raw(text, std::uint16_t{0});
  }
  return text;
}

void read_format(benchmark::State& state) {
  static constexpr const char* names[] = {"OFF", "OBJ", "binary PLY", "binary STL"};
  const auto format = static_cast<MeshFormat>(state.range(0));
  const PolygonMesh& mesh = shape(1);
  const std::string text = format == MeshFormat::ply   ? binary_ply(mesh)
                           : format == MeshFormat::stl ? binary_stl(mesh)
                                                       : text_file(mesh, format);
  PolygonMesh result;
  for ([[maybe_unused]] auto _ : state) {
    result = read_mesh(std::as_bytes(std::span(text)), format);
    benchmark::DoNotOptimize(result.x.data());
  }
  count_items(state, "face", static_cast<double>(mesh.polygon_count()));
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(text.size()));
  check_sum(state, names[state.range(0)], result.x);
}
BENCHMARK(read_format)->DenseRange(0, 3)->Unit(benchmark::kMillisecond);

void prepare(benchmark::State& state) {
  const PolygonMesh& mesh = shape(state.range(0));
  PreparedMesh result;
  for ([[maybe_unused]] auto _ : state) {
    result = prepare_mesh(mesh);
    benchmark::DoNotOptimize(result.x.data());
  }
  count_items(state, "face", static_cast<double>(mesh.polygon_count()));
  check_sum(state, shape_name(state.range(0)), result.triangles);
}
BENCHMARK(prepare)->Apply(every_shape);

// Half-edges of a triangle list as flat arrays: partners and vertex fans.
void half_edges(benchmark::State& state) {
  const PolygonMesh& mesh = shape(state.range(0));
  std::vector<std::uint32_t> opposite, fans;
  for ([[maybe_unused]] auto _ : state) {
    pair_half_edges(mesh.corners, mesh.vertex_count(), opposite);
    number_fans(opposite, fans);
    benchmark::DoNotOptimize(fans.data());
  }
  count_items(state, "face", static_cast<double>(mesh.polygon_count()));
  check_sum(state, shape_name(state.range(0)), opposite);
}
BENCHMARK(half_edges)->Apply(every_shape);

// The same by OpenMesh, with float points and nothing else attached. The checksum is of the partners.
void half_edges_openmesh(benchmark::State& state) {
  using Mesh = OpenMesh::TriMesh_ArrayKernelT<>;
  const PolygonMesh& mesh = shape(state.range(0));
  std::vector<int> partners;
  for ([[maybe_unused]] auto _ : state) {
    Mesh open_mesh;
    open_mesh.reserve(mesh.vertex_count(), 3 * mesh.polygon_count() / 2, mesh.polygon_count());
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
      open_mesh.add_vertex(Mesh::Point(static_cast<float>(mesh.x[v]), static_cast<float>(mesh.y[v]),
                                       static_cast<float>(mesh.z[v])));
    for (std::size_t c = 0; c < mesh.corners.size(); c += 3)
      open_mesh.add_face(Mesh::VertexHandle(static_cast<int>(mesh.corners[c])),
                         Mesh::VertexHandle(static_cast<int>(mesh.corners[c + 1])),
                         Mesh::VertexHandle(static_cast<int>(mesh.corners[c + 2])));
    state.PauseTiming();
    partners.clear();
    for (const auto h : open_mesh.halfedges()) partners.push_back(open_mesh.face_handle(h).idx());
    state.ResumeTiming();
  }
  count_items(state, "face", static_cast<double>(mesh.polygon_count()));
  check_sum(state, shape_name(state.range(0)), partners);
}
BENCHMARK(half_edges_openmesh)->Apply(every_shape);

}  // namespace

}  // namespace meander::bench
