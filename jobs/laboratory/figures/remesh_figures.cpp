// Meshes made of samples beside simplified ones: figure 10, and distances in the manner of Metro.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>

#include "io/plot/picture_sheet.h"
#include "jobs/laboratory/figures/figure_set.h"
#include "jobs/laboratory/figures/staged_model.h"
#include "kernels/analyse/mesh_distance.h"
#include "kernels/analyse/quadric_collapse.h"
#include "kernels/analyse/self_intersections.h"
#include "kernels/remesh/remesh_surface.h"
#include "kernels/render/surface_picture.h"
#include "kernels/sample/point_frames.h"

namespace meander {

namespace {

struct RemeshKind {
  const char* name;
  DensityKind density;
  bool fit;
};
constexpr std::array<RemeshKind, 3> remesh_kinds = {{{"samples", DensityKind::uniform, false},
                                                     {"fitted", DensityKind::uniform, true},
                                                     {"fitted by curvature", DensityKind::mean, true}}};

struct Size {
  const char* name;
  double share;          // of the triangles
  std::uint32_t points;  // or that many vertices
};
constexpr std::array<Size, 5> sizes = {
    {{"5 %", 0.05, 0}, {"10 %", 0.1, 0}, {"25 %", 0.25, 0}, {"50 %", 0.5, 0}, {"300 vertices", 0, 300}}};

// The least angle of every triangle, degrees, ascending.
std::vector<double> least_angles(const TriangleSpans& mesh) {
  std::vector<double> angles;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    double least = 180;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto at = [&](std::size_t i) {
        const std::uint32_t v = mesh.triangles[t + (k + i) % 3];
        return Vector3{mesh.x[v], mesh.y[v], mesh.z[v]};
      };
      const Vector3 u = at(1) - at(0), v = at(2) - at(0);
      least = std::min(least, std::atan2(norm(cross(u, v)), dot(u, v)) * 180 / std::numbers::pi);
    }
    angles.push_back(least);
  }
  std::sort(angles.begin(), angles.end());
  return angles;
}

// One mesh at one size, by every way.
class MetroRows {
 public:
  MetroRows(const FigureSet& figures, const FigureMesh& mesh, const EmbreeDevice& device, Table& table)
      : figures_(figures), mesh_(mesh), device_(device), table_(table) {}

  void add(const Size& size) {
    std::size_t vertices = 0;
    for (const RemeshKind& kind : remesh_kinds) {
      const Model& model = staged(kind);
      const auto wanted = size.points > 0
                              ? size.points
                              : static_cast<std::uint32_t>(std::max(
                                    4.0, size.share * static_cast<double>(surface().triangle_count()) / 2));
      const auto start = std::chrono::steady_clock::now();
      const RemeshedSurface made = remesh(model, kind, wanted);
      if (vertices == 0) vertices = made.x.size();
      row(size, kind.name, {made.x, made.y, made.z, made.triangles}, since(start));
    }
    const auto start = std::chrono::steady_clock::now();
    const SimplifiedMesh simple = quadric_collapse(surface(), vertices);
    row(size, "quadric edge collapse", {simple.x, simple.y, simple.z, simple.triangles}, since(start));
  }

 private:
  static double since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  const PreparedMesh& surface() const { return uniform_->surface; }

  SampleParameters parameters(const RemeshKind& kind) const {
    SampleParameters sample = parameters_for("auto");
    sample.density.kind = kind.density;
    sample.place.sequence = SequenceKind::spaced;
    return sample;
  }

  const Model& staged(const RemeshKind& kind) {
    std::optional<Model>& model = kind.density == DensityKind::uniform ? uniform_ : dense_;
    if (!model) model = staged_model(mesh_, parameters(kind));
    return *model;
  }

  RemeshedSurface remesh(const Model& model, const RemeshKind& kind, std::uint32_t count) const {
    const Row sampled = sampled_row(model, parameters(kind), count, figures_.seed, device_);
    const std::vector<double> places = working_points(sampled.report, sampled.samples.points, model.surface);
    RemeshParameters wanted;
    wanted.fit = kind.fit;
    return remesh_surface(
        model.surface,
        {sampled.samples.triangle, sampled.samples.barycentric, places, sampled.samples.curve_rank},
        model.measure.masses, wanted);
  }

  void row(const Size& size, const char* name, const TriangleSpans& made, double seconds) {
    const PreparedMesh& from = surface();
    MeshDistanceParameters measure;
    measure.seed = figures_.seed;
    if (figures_.quick) measure.samples = 10000;
    const MeshDistance d = mesh_distance(device_, {from.x, from.y, from.z, from.triangles}, made, measure);
    const std::vector<double> angles = least_angles(made);
    table_.rows.push_back({mesh_.name, size.name, name, made.x.size(), made.triangles.size() / 3,
                           d.percent(d.forward.mean), d.percent(d.backward.mean), d.percent(d.forward.rms),
                           d.percent(d.backward.rms), d.percent(d.forward.max), d.percent(d.backward.max),
                           angles[angles.size() / 2], angles[angles.size() / 100], self_intersections(made)});
    figures_.note(fmt::format("  {}, {}: {} vertices, {:.2f} s", size.name, name, made.x.size(), seconds));
  }

  const FigureSet& figures_;
  const FigureMesh& mesh_;
  const EmbreeDevice& device_;
  Table& table_;
  std::optional<Model> uniform_, dense_;
};

// Working units; edges are drawn.
RgbImage meshed_picture(const TriangleSpans& mesh, std::uint32_t size) {
  std::vector<double> positions;
  for (std::size_t v = 0; v < mesh.x.size(); ++v)
    positions.insert(positions.end(), {mesh.x[v], mesh.y[v], mesh.z[v]});
  const std::vector<std::uint32_t> faces(mesh.triangles.begin(), mesh.triangles.end());
  SurfaceScene scene{positions, faces, {}};
  const auto at = [&](std::uint32_t v) { return Vector3{mesh.x[v], mesh.y[v], mesh.z[v]}; };
  const bool fine = faces.size() > 60000;
  const double width = fine ? 0.4 : 0.7;
  const SrgbColour colour = fine ? SrgbColour{165, 170, 180} : SrgbColour{70, 80, 95};
  for (std::size_t f = 0; f < faces.size(); f += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = faces[f + k], b = faces[f + (k + 1) % 3];
      if (a < b) scene.lines.push_back({at(a), at(b), width, colour});
    }
  SurfacePictureParameters look;
  look.size = size;
  look.crease = 2;  // flat: what the triangles are
  return surface_picture(scene, look);
}

void draw_one_remeshed(FigureSet& figures, const FigureMesh& mesh, const EmbreeDevice& device) {
  const std::uint32_t size = figures.quick ? 300 : 560, count = 1000;
  SampleParameters parameters = parameters_for("auto");
  parameters.place.sequence = SequenceKind::spaced;
  MeshDistanceParameters measure;
  measure.seed = figures.seed;
  std::vector<SheetCell> cells;
  std::size_t vertices = 0;
  for (const bool by_curvature : {false, true}) {
    if (by_curvature) parameters.density.kind = DensityKind::mean;
    const Model model = staged_model(mesh, parameters);
    const PreparedMesh& from = model.surface;
    const TriangleSpans original{from.x, from.y, from.z, from.triangles};
    const auto add = [&](const TriangleSpans& made, const char* title) {
      const MeshDistance d = mesh_distance(device, original, made, measure);
      cells.push_back({meshed_picture(made, size), title,
                       fmt::format("{} vertices, mean distance {:.3f} %", made.x.size(),
                                   d.percent(0.5 * (d.forward.mean + d.backward.mean)))});
    };
    if (!by_curvature)
      cells.push_back(
          {meshed_picture(original, size), "the model", fmt::format("{} vertices", from.x.size())});
    const Row sampled = sampled_row(model, parameters, count, figures.seed, device);
    const std::vector<double> places = working_points(sampled.report, sampled.samples.points, from);
    RemeshParameters wanted;
    wanted.fit = true;
    const RemeshedSurface made = remesh_surface(
        from, {sampled.samples.triangle, sampled.samples.barycentric, places, sampled.samples.curve_rank},
        model.measure.masses, wanted);
    add({made.x, made.y, made.z, made.triangles}, by_curvature ? "samples by curvature" : "samples");
    vertices = std::max(vertices, made.x.size());
    if (!by_curvature) continue;
    const SimplifiedMesh simple = quadric_collapse(from, vertices);
    add({simple.x, simple.y, simple.z, simple.triangles}, "quadric edge collapse");
  }
  SheetLook sheet;
  sheet.cell = size;
  sheet.columns = 4;
  figures.picture("figure10_" + mesh.name, picture_sheet(cells, {}, sheet),
                  mesh.name + ": meshes of 1,000 samples, and the simplified one");
}

}  // namespace

void draw_remeshed_models(FigureSet& figures) {
  figures.begin("Figure 10: meshes made of samples");
  const EmbreeDevice device;
  for (const FigureMesh& mesh : figures.meshes)
    figures.attempt(mesh.name, [&] { draw_one_remeshed(figures, mesh, device); });
  figures.text(
      "Shown",
      "The model; meshes whose vertices are 1,000 spaced samples, uniform and by mean curvature, fitted "
      "to the surface; and quadric edge collapse to as many vertices as the larger of them. Distances in % "
      "of the diagonal, "
      "the mean of both ways; the figure `metro` has them at other sizes.");
}

void draw_remeshed(FigureSet& figures) {
  const EmbreeDevice device;
  for (const FigureMesh& mesh : figures.meshes) {
    figures.begin("Meshes made of samples, and simplified ones: " + mesh.name);
    figures.attempt(mesh.name, [&] {
      Table table;
      for (const char* name :
           {"mesh", "size", "method", "vertices", "faces", "mean", "mean back", "rms", "rms back", "largest",
            "largest back", "median angle", "1 % angle", "crossings"})
        table.columns.push_back({name, 3});
      MetroRows rows(figures, mesh, device, table);
      for (const Size& size : sizes) rows.add(size);
      figures.table("metro_" + mesh.name,
                    "Distances from the surface to the mesh and back, % of the diagonal; least angles of the "
                    "triangles, degrees; pairs of triangles that cross",
                    table);
    });
  }
}

}  // namespace meander
