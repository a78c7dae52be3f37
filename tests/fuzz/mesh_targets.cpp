// Meshes, their materials, point sets and tables of tensors.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <optional>

#include "io/json/json_tree.h"
#include "io/mesh/format_readers.h"
#include "io/mesh/tensor_table.h"
#include "scratch_file.h"
#include "targets.h"

namespace meander::fuzz {

namespace {

// What a small budget refuses before memory is taken, as a run does.
constexpr std::uint64_t most_memory = std::uint64_t{64} << 20;

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

// Calls `read`; its error in words if it is one of the documented kinds.
std::string outcome_of(const std::function<void()>& read, std::initializer_list<Status> documented) {
  try {
    read();
    return {};
  } catch (const ItemError& error) {
    demand(std::count(documented.begin(), documented.end(), error.status()) == 1,
           "status " + std::string(name_of(error.status())) + " is not documented: " + error.what());
    demand(std::string_view(error.what()).size() > 10, "an error is a sentence");
    return std::string(name_of(error.status())) + ": " + error.what();
  }
}

template <class T>
bool same_values(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

bool same_attributes(const std::vector<ScalarAttribute>& a, const std::vector<ScalarAttribute>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const ScalarAttribute& one, const ScalarAttribute& other) {
                      return one.name == other.name && same_values(one.values, other.values);
                    });
}

bool same_mesh(const PolygonMesh& a, const PolygonMesh& b) {
  return same_values(a.x, b.x) && same_values(a.y, b.y) && same_values(a.z, b.z) &&
         a.polygon_begin == b.polygon_begin && a.corners == b.corners && same_values(a.normals, b.normals) &&
         a.corner_normals == b.corner_normals && same_attributes(a.vertex_attributes, b.vertex_attributes) &&
         same_attributes(a.face_attributes, b.face_attributes) &&
         same_values(a.colors.vertex, b.colors.vertex) && same_values(a.colors.face, b.colors.face) &&
         a.repairs.counts == b.repairs.counts;
}

void demand_colors(const std::vector<float>& values, std::size_t elements, const std::string& what) {
  demand(values.empty() || values.size() == 3 * elements, "three components for each " + what);
  for (const float value : values)
    demand(std::isnan(value) || (value >= 0 && value <= 1),
           "components of colors of a " + what + " are in [0, 1]");
}

void demand_consistent(const PolygonMesh& mesh, MeshFormat format) {
  const std::size_t vertices = mesh.vertex_count(), polygons = mesh.polygon_count();
  demand(mesh.y.size() == vertices && mesh.z.size() == vertices, "three coordinates for each vertex");
  demand(polygons > 0, "a mesh has faces");
  demand(mesh.polygon_begin.front() == 0 && mesh.polygon_begin.back() == mesh.corners.size(),
         "the faces have all corners");
  demand(std::is_sorted(mesh.polygon_begin.begin(), mesh.polygon_begin.end()), "offsets of faces ascend");
  if (format == MeshFormat::obj || format == MeshFormat::gltf || format == MeshFormat::stl)
    for (const std::uint32_t corner : mesh.corners)
      demand(corner < vertices || (corner == no_index && format != MeshFormat::stl),
             "a corner names a vertex that is there");
  demand(mesh.normals.size() % 3 == 0, "three components for each normal");
  if (mesh.corner_normals.empty()) {
    demand(mesh.normals.empty() || mesh.normals.size() == 3 * vertices, "a normal for each vertex");
  } else {
    demand(mesh.corner_normals.size() == mesh.corners.size(), "a normal for each corner");
    for (const std::uint32_t normal : mesh.corner_normals)
      demand(normal == no_index || normal < mesh.normals.size() / 3, "a corner names a normal that is there");
  }
  for (const ScalarAttribute& attribute : mesh.vertex_attributes)
    demand(attribute.values.size() == vertices, "a value of an attribute for each vertex");
  for (const ScalarAttribute& attribute : mesh.face_attributes)
    demand(attribute.values.size() == polygons, "a value of an attribute for each face");
  demand_colors(mesh.colors.vertex, vertices, "vertex");
  for (const ScalarAttribute& attribute : mesh.asked_attributes) {
    demand(attribute.name.starts_with('_'), "what is asked for has such a name");
    demand(attribute.values.size() == mesh.vertex_count(), "an attribute that is asked for has all vertices");
  }
  for (const ScalarAttribute& attribute : mesh.asked_face_attributes) {
    demand(attribute.integers && attribute.values.size() == polygons, "a number for each face");
    for (const double value : attribute.values)
      demand(std::isnan(value) || (value >= 0 && value < static_cast<double>(polygons)),
             "what faces belong to is numbered by faces");
  }
  demand(mesh.names.size() <= most_name_bytes, "names are bounded");
  demand(mesh.names.empty() || JsonTree(mesh.names).root().is_object(), "names are a JSON object");
  const CornerCoordinates& coordinates = mesh.coordinates;
  demand(coordinates.values.size() % 2 == 0, "coordinates are pairs");
  demand(coordinates.corner.empty() == coordinates.values.empty(), "coordinates come with their corners");
  demand(coordinates.corner.empty() || coordinates.corner.size() == mesh.corners.size(),
         "all corners have a coordinate or none");
  demand_colors(mesh.colors.face, polygons, "face");
}

void demand_inside(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) {
    const std::filesystem::path named(path);
    demand(!path.empty() && !named.is_absolute(), "companions are named from the model's folder");
    demand(named.lexically_normal() == named, "companions lead up at their beginning alone");
    demand(named.filename() != "..", "companions are files");
    demand(std::count(paths.begin(), paths.end(), path) == 1, "companions are named once");
  }
}

// The mesh is the same whether it is read in one block or in small ones, and so is the error.
void run_mesh(std::string_view bytes, MeshFormat format, std::span<const CompanionFile> companions = {}) {
  MeshSurroundings around;
  around.companions = companions;
  around.colors = true;
  static const std::vector<AttributeColumn> asked = {
      {"_A", 2},    {"_A_0", 1},     {"_BATCHID", 1}, {"_FEATURE_ID_0", 1}, {"POSITION", 3},
      {"group", 1}, {"material", 1}, {"object", 1},   {"part", 1}};
  around.extras = {true, asked};
  around.admit = [](const MeshEstimate& stated) {
    if (stated.vertices > most_memory / 100 || stated.triangles > most_memory / 100 ||
        stated.decoding_bytes > most_memory)
      throw ItemError(Status::too_large, "more than the budget of this target");
  };
  demand(peek_mesh(MemorySource(bytes), format).file_bytes == bytes.size(), "a peek knows the size");
  const std::initializer_list<Status> documented = {Status::unreadable, Status::unsupported_format,
                                                    Status::empty, Status::too_large};
  std::optional<PolygonMesh> whole, parts;
  const std::string outcome =
      outcome_of([&] { whole = read_mesh(bytes_of(bytes), format, {}, around); }, documented);
  if (whole) demand_consistent(*whole, format);
  for (const auto paths : {row_of(format).companions, row_of(format).color_companions})
    if (paths != nullptr) demand_inside(paths(bytes_of(bytes)));
  if (format == MeshFormat::gltf) return;  // is not read in blocks
  const std::string outcome_of_parts = outcome_of(
      [&] {
        parts = read_mesh_in_blocks(bytes_of(bytes), format, {}, BlockRule{1, 64}, around);
      },
      documented);
  demand(outcome == outcome_of_parts,
         "read in blocks: \"" + outcome_of_parts + "\", else: \"" + outcome + "\"");
  demand(!whole || same_mesh(*whole, *parts), "a mesh read in blocks is the same");
}

void run_point_file(std::string_view bytes, const char* name) {
  const std::initializer_list<Status> documented = {Status::unreadable, Status::empty, Status::non_finite,
                                                    Status::unsupported_format};
  std::optional<PointCloud> whole, parts;
  const std::string outcome =
      outcome_of([&] { whole = read_points_in_blocks(bytes, name, {}, {}); }, documented);
  const std::string outcome_of_parts = outcome_of(
      [&] {
        parts = read_points_in_blocks(bytes, name, {}, BlockRule{1, 64});
      },
      documented);
  demand(outcome == outcome_of_parts,
         "read in blocks: \"" + outcome_of_parts + "\", else: \"" + outcome + "\"");
  if (!whole) return;
  const std::size_t count = whole->count();
  demand(count > 0 && whole->y.size() == count && whole->z.size() == count,
         "three coordinates for each point");
  for (const std::vector<double>* axis : {&whole->x, &whole->y, &whole->z})
    demand(std::all_of(axis->begin(), axis->end(), [](double v) { return std::isfinite(v); }),
           "coordinates of points are finite");
  demand(whole->normals.empty() || whole->normals.size() == 3 * count, "a normal for each point");
  demand(whole->density.empty() || whole->density.size() == count, "a density for each point");
  demand(same_values(whole->x, parts->x) && same_values(whole->y, parts->y) &&
             same_values(whole->z, parts->z) && same_values(whole->normals, parts->normals) &&
             same_values(whole->density, parts->density),
         "points read in blocks are the same");
}

}  // namespace

void run_off(std::string_view bytes) {
  run_mesh(bytes, MeshFormat::off);
  run_point_file(bytes, "a.off");
}

void run_obj(std::string_view bytes) { run_mesh(bytes, MeshFormat::obj); }

void run_ply(std::string_view bytes) {
  run_mesh(bytes, MeshFormat::ply);
  run_point_file(bytes, "a.ply");
}

void run_stl(std::string_view bytes) { run_mesh(bytes, MeshFormat::stl); }

// A buffer beside the model, as test_seeds names it.
void run_gltf(std::string_view bytes) {
  static const std::string buffer(96 + 72, '\1');
  const CompanionFile beside[] = {{"cube.bin", bytes_of(buffer), {}},
                                  {"missing.bin", {}, "the file cannot be opened"}};
  run_mesh(bytes, MeshFormat::gltf, beside);
}

void run_mtl(std::string_view bytes) {
  const CompanionFile libraries[] = {{"a.mtl", bytes_of(bytes), {}}};
  run_mesh(
      "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\nusemtl blue\nf 1 3 2\nusemtl\nf 2 3 1\n",
      MeshFormat::obj, libraries);
}

void run_points(std::string_view bytes) { run_point_file(bytes, "a.xyz"); }

void run_npy(std::string_view bytes) { run_point_file(bytes, "a.npy"); }
void run_npz(std::string_view bytes) { run_point_file(bytes, "a.npz"); }

void run_tensor(std::string_view bytes) {
  const std::filesystem::path path = scratch_file("tensors.txt", bytes);
  TensorTable table;
  const std::string outcome =
      outcome_of([&] { table = read_tensor_table(path); }, {Status::unreadable, Status::empty});
  if (!outcome.empty()) return;
  demand(table.columns == 3 || table.columns == 6, "a row has three numbers or six");
  demand(!table.values.empty() && table.values.size() % table.columns == 0, "rows are complete");
}

}  // namespace meander::fuzz
