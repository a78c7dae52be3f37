#include "kernels/remesh/remesh_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "kernels/core/parallel.h"
#include "kernels/remesh/attach_samples.h"
#include "kernels/remesh/delaunay_flips.h"
#include "kernels/remesh/edited_mesh.h"
#include "kernels/remesh/insert_samples.h"
#include "kernels/remesh/remove_vertices.h"
#include "kernels/remesh/repair_crossings.h"

namespace meander {

namespace {

constexpr double hexagonal = 1.1547005383792515;  // area of a square of the spacing over that of a sample
// How far around triangles that cross vertices are kept when a component is remeshed once more. The last time
// also around what could be parted: where two sheets are nearer to each other than their triangles bend, new
// crossings at the rim of what is kept follow the old ones for long.
constexpr std::array<CrossingSurroundings, 3> kept_around = {{{0.5, false}, {1, false}, {2, true}}};
constexpr double most_line_vertices = 4;  // added on long lines, over samples and vertices

// One component on its way, with what it needs of the whole.
struct Part {
  std::uint32_t component = 0;
  std::span<const std::uint32_t> samples;  // numbers, by triangle and rank
  std::vector<Vector3> extra;              // positions of vertices that are no samples
  std::vector<std::uint32_t> origin;       // of those
  std::vector<BetweenVertices> between;    // of those; new vertices are numbered from N on
  EditedMesh mesh;
  std::uint32_t originals = 0, inserted = 0;  // vertices of the surface, and with the samples
  std::vector<std::uint32_t> moved_to;        // of those of the surface
  std::vector<std::uint8_t> on_line;          // of those: 1 on boundaries and creases
  std::vector<std::uint8_t> kept;             // of those: 1 where they stay, or empty
  std::vector<Vector3> places;           // of the samples before they were fitted; at last, where they are
  std::vector<std::uint32_t> triangles;  // samples as their numbers, others from N on
  RemeshReport report;
};

std::vector<std::uint32_t> by_triangle(const RemeshSamples& samples) {
  std::vector<std::uint32_t> order(samples.triangle.size());
  std::iota(order.begin(), order.end(), std::uint32_t{0});
  std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    if (samples.triangle[i] != samples.triangle[j]) return samples.triangle[i] < samples.triangle[j];
    if (samples.rank[i] != samples.rank[j]) return samples.rank[i] < samples.rank[j];
    return i < j;
  });
  return order;
}

class Remesher {
 public:
  Remesher(const PreparedMesh& surface, const RemeshSamples& samples, std::span<const double> masses,
           const RemeshParameters& parameters, const CancelToken& cancel)
      : surface_(surface), samples_(samples), masses_(masses), parameters_(parameters), cancel_(cancel) {
    const std::size_t n = samples.triangle.size(), triangles = surface.triangle_count();
    if (samples.weights.size() != 2 * n || samples.position.size() != 3 * n || samples.rank.size() != n ||
        (!masses.empty() && masses.size() != triangles))
      throw std::invalid_argument("the arrays of samples and masses differ in length");
    for (const std::uint32_t t : samples.triangle)
      if (t >= triangles) throw std::invalid_argument("a sample names a triangle that is not there");
    total_ = masses.empty() ? surface.total_area : blocked_sum(masses);
  }

  RemeshedSurface run() {
    order_ = by_triangle(samples_);
    std::vector<Part> parts;
    RemeshedSurface whole;
    std::size_t at = 0;
    for (std::uint32_t c = 0; c < surface_.components.size(); ++c) {
      const std::size_t begin = at;
      while (at < order_.size() && samples_.triangle[order_[at]] < surface_.components[c].triangle_end) ++at;
      if (begin == at) {
        ++whole.report.dropped_components;
        whole.report.dropped_share += surface_.components[c].area / surface_.total_area;
        continue;
      }
      parts.emplace_back().component = c;
      parts.back().samples = std::span(order_).subspan(begin, at - begin);
    }
    parallel_tasks(parts.size(), [&](std::size_t i) {
      remesh(parts[i]);
      if (!parameters_.part_crossings) finish(parts[i]);
    });
    if (parameters_.part_crossings) {
      repair(parts, whole.report);
      parallel_tasks(parts.size(), [&](std::size_t i) { finish(parts[i]); });
    }
    join(parts, whole);
    return whole;
  }

 private:
  // The spacing of samples around the vertices of a component: that of a hexagonal grid of their density.
  std::vector<double> spacing_of(const Component& component) const {
    const std::uint32_t vertices = component.vertex_end - component.vertex_begin;
    std::vector<double> area(vertices, 0), mass(vertices, 0);
    for (std::size_t h = 3 * std::size_t{component.triangle_begin};
         h < 3 * std::size_t{component.triangle_end}; ++h) {
      const std::uint32_t v = surface_.triangles[h] - component.vertex_begin;
      area[v] += surface_.area[h / 3];
      mass[v] += masses_.empty() ? surface_.area[h / 3] : masses_[h / 3];
    }
    const double of_sample = hexagonal * total_ / static_cast<double>(samples_.triangle.size());
    constexpr double widest = 4;  // working coordinates lie in [-1, 1]
    for (std::uint32_t v = 0; v < vertices; ++v)
      area[v] = mass[v] > 0 ? std::min(widest, std::sqrt(of_sample * area[v] / mass[v])) : widest;
    return area;
  }

  Vector3 sample_position(std::uint32_t i) const {
    const std::size_t k = 3 * std::size_t{i};
    return {samples_.position[k], samples_.position[k + 1], samples_.position[k + 2]};
  }

  void insert(EditedMesh& mesh, Part& part) const {
    const Component& component = surface_.components[part.component];
    std::vector<std::uint32_t> triangle;
    std::vector<double> weights;
    std::vector<Vector3> position;
    for (const std::uint32_t i : part.samples) {
      triangle.push_back(samples_.triangle[i] - component.triangle_begin);
      weights.insert(weights.end(), {double{samples_.weights[2 * std::size_t{i}]},
                                     double{samples_.weights[2 * std::size_t{i} + 1]}});
      position.push_back(sample_position(i));
    }
    part.report.coincident_samples = insert_samples(mesh, {triangle, weights, position}, cancel_);
  }

  void remesh(Part& part) const {
    const Component& component = surface_.components[part.component];
    EditedMesh& mesh = part.mesh;
    mesh = edited_component(surface_, component);
    const std::vector<double> spacing = spacing_of(component);
    part.originals = static_cast<std::uint32_t>(spacing.size());
    mark_creases(mesh, spacing, parameters_.lines);
    part.on_line.assign(part.originals, 0);
    for (std::uint32_t h = 0; h < mesh.vertex.size(); ++h)
      if (mesh.is_line(h)) part.on_line[mesh.start(h)] = part.on_line[mesh.end(h)] = 1;
    mark_kept_edges(mesh, part.kept);
    insert(mesh, part);
    part.inserted = static_cast<std::uint32_t>(mesh.position.size());
    part.moved_to = remove_vertices(mesh, spacing, parameters_.lines, part.kept, cancel_);
    const auto most_cuts =
        static_cast<std::uint32_t>(most_line_vertices * static_cast<double>(part.inserted));
    part.report.coarse_lines = !split_lines(mesh, spacing, parameters_.lines, most_cuts);
    flip_all_to_delaunay(mesh);
    if (parameters_.fit) fit(part);
    split_double_edges(mesh);
  }

  // Components that crossings are left in are remeshed with vertices of the surface kept there.
  void repair(std::vector<Part>& parts, RemeshReport& report) const {
    for (std::size_t attempt = 0;; ++attempt) {
      std::vector<RepairedPart> repaired;
      for (Part& part : parts) repaired.push_back({&part.mesh, part.moved_to, part.on_line, part.places});
      const bool last = attempt == kept_around.size();
      const CrossingReport found =
          repair_crossings(repaired, surface_, last ? CrossingSurroundings{} : kept_around[attempt], cancel_);
      report.crossings = found.left;
      report.input_crossings = found.of_input;
      report.partial_search = found.is_partial ? 1 : 0;
      if (found.left == 0 || last) return;
      std::vector<Part*> again;
      for (std::size_t i = 0; i < parts.size(); ++i) {
        if (keep(parts[i], found.around[i])) again.push_back(&parts[i]);
      }
      parallel_tasks(again.size(), [&](std::size_t i) { remesh(*again[i]); });
    }
  }

  // False where all of them are kept already.
  static bool keep(Part& part, std::span<const std::uint32_t> vertices) {
    part.kept.resize(part.originals, 0);
    bool more = false;
    for (const std::uint32_t v : vertices) {
      more = more || part.kept[v] == 0;
      part.kept[v] = 1;
    }
    return more;
  }

  // The edges between vertices that are kept.
  static void mark_kept_edges(EditedMesh& mesh, std::span<const std::uint8_t> kept) {
    for (std::uint32_t h = 0; h < mesh.vertex.size() && !kept.empty(); ++h)
      if (kept[mesh.start(h)] != 0 && kept[mesh.end(h)] != 0) mesh.crease[h] |= mark_kept;
  }

  // To the vertices and the centroids of the surface.
  void fit(Part& part) const {
    const Component& component = surface_.components[part.component];
    EditedMesh& mesh = part.mesh;
    const std::uint32_t originals = part.originals;
    part.places.assign(mesh.position.begin() + originals, mesh.position.begin() + part.inserted);
    const double attached =
        attach_samples(mesh, originals, part.inserted, part.moved_to, parameters_.attaching);
    std::vector<std::uint32_t> moved_to = part.moved_to;
    const auto end_of = [&](std::uint32_t v) {
      while (v < originals && moved_to[v] != v) {
        const std::uint32_t next = moved_to[v];
        if (next < originals) moved_to[v] = moved_to[next];
        v = next;
      }
      return v;
    };
    std::vector<FitPoint> points;
    for (std::uint32_t v = 0; v < originals; ++v)
      points.push_back({surface_.position(component.vertex_begin + v), {}, 0, end_of(v)});
    for (std::uint32_t t = component.triangle_begin; t < component.triangle_end; ++t) {
      std::array<std::size_t, 3> corners;
      FitPoint centroid{{}, {}, 0.5 * surface_.area[t], 0};
      for (std::uint32_t k = 0; k < 3; ++k) {
        corners[k] = surface_.triangles[3 * std::size_t{t} + k] - component.vertex_begin;
        centroid.position = centroid.position + (1. / 3) * points[corners[k]].position;
      }
      const Vector3 normal = cross(points[corners[1]].position - points[corners[0]].position,
                                   points[corners[2]].position - points[corners[0]].position);
      for (const std::size_t corner : corners) {
        points[corner].weight += surface_.area[t] / 6;
        points[corner].normal = points[corner].normal + normal;
      }
      centroid.normal = normal;
      centroid.vertex = points[corners[0]].vertex;
      points.push_back(centroid);
    }
    part.report.largest_shift =
        std::max(attached, fit_samples(mesh, originals, part.inserted, points, parameters_.fitting, cancel_));
  }

  // The mesh is gone afterwards.
  void finish(Part& part) const {
    collect(part);
    check_topology(part, surface_.components[part.component]);
    if (!part.places.empty())
      part.places.assign(part.mesh.position.begin() + part.originals,
                         part.mesh.position.begin() + part.inserted);
    part.mesh = {};
  }

  void collect(Part& part) const {
    const EditedMesh& mesh = part.mesh;
    const std::uint32_t originals = part.originals, inserted = part.inserted;
    const auto count = static_cast<std::uint32_t>(samples_.triangle.size());
    const std::uint32_t first = surface_.components[part.component].vertex_begin;
    std::vector<std::uint32_t> number(mesh.position.size(), no_index);
    for (std::uint32_t v = 0; v < number.size(); ++v) {
      if (v >= originals && v < inserted) {
        number[v] = part.samples[v - originals];
      } else if (mesh.out[v] != no_index) {
        number[v] = count + static_cast<std::uint32_t>(part.extra.size());
        part.extra.push_back(mesh.position[v]);
        part.origin.push_back(v < originals ? first + v : no_index);
        bool on_line = false;
        mesh.for_neighbors(
            v, [&](std::uint32_t, std::uint32_t h) { on_line = on_line || mesh.is_crease_or_boundary(h); });
        ++(on_line ? part.report.line_vertices : part.report.kept_vertices);
      }
    }
    for (const CutVertex& cut : mesh.cuts) {
      if (number[cut.vertex] == no_index) continue;
      const auto number_of = [&](std::uint32_t v) { return v < originals ? first + v : number[v]; };
      part.between.push_back({number[cut.vertex], number_of(cut.first), number_of(cut.second),
                              cut.first < originals, cut.second < originals, cut.share});
    }
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
      if (!mesh.exists(t)) continue;
      for (std::uint32_t k = 0; k < 3; ++k) part.triangles.push_back(number[mesh.vertex[3 * t + k]]);
    }
    RemeshReport& report = part.report;
    std::uint64_t boundary = 0;
    for (std::uint32_t h = 0; h < mesh.vertex.size(); ++h)
      boundary += mesh.exists(h / 3) && mesh.opposite[h] == no_index;
    report.vertices = part.samples.size() + part.extra.size();
    report.faces = part.triangles.size() / 3;
    const std::uint64_t edges = (part.triangles.size() + boundary) / 2;
    report.euler =
        static_cast<std::int64_t>(report.vertices + report.faces) - static_cast<std::int64_t>(edges);
  }

  static void check_topology(Part& part, const Component& component) {
    part.report.components = 1;
    part.report.boundary_loops = component.boundary_loops;
    const std::int64_t wanted =
        2 - 2 * std::int64_t{component.genus} - std::int64_t{component.boundary_loops};
    if (part.report.euler != wanted)
      throw std::logic_error("a component of Euler characteristic " + std::to_string(wanted) +
                             " was remeshed to one of " + std::to_string(part.report.euler));
  }

  void join(const std::vector<Part>& parts, RemeshedSurface& whole) const {
    const std::size_t n = samples_.triangle.size();
    const auto add = [&](Vector3 at) {
      whole.x.push_back(at.x);
      whole.y.push_back(at.y);
      whole.z.push_back(at.z);
    };
    for (std::uint32_t i = 0; i < n; ++i) add(sample_position(i));
    RemeshReport& sum = whole.report;
    for (const Part& part : parts) {
      for (std::size_t i = 0; i < part.places.size(); ++i) {
        const std::uint32_t sample = part.samples[i];
        const Vector3 fitted = part.places[i];
        whole.x[sample] = fitted.x;
        whole.y[sample] = fitted.y;
        whole.z[sample] = fitted.z;
      }
      const auto offset = static_cast<std::uint32_t>(whole.origin.size());
      for (const Vector3 at : part.extra) add(at);
      whole.origin.insert(whole.origin.end(), part.origin.begin(), part.origin.end());
      const auto number_of = [&](std::uint32_t v) { return v < n ? v : v + offset; };
      for (const std::uint32_t v : part.triangles) whole.triangles.push_back(number_of(v));
      for (BetweenVertices cut : part.between) {
        cut.vertex = number_of(cut.vertex);
        if (!cut.first_of_surface) cut.first = number_of(cut.first);
        if (!cut.second_of_surface) cut.second = number_of(cut.second);
        whole.between.push_back(cut);
      }
      const RemeshReport& r = part.report;
      sum.components += r.components;
      sum.boundary_loops += r.boundary_loops;
      sum.vertices += r.vertices;
      sum.faces += r.faces;
      sum.euler += r.euler;
      sum.line_vertices += r.line_vertices;
      sum.kept_vertices += r.kept_vertices;
      sum.coincident_samples += r.coincident_samples;
      sum.coarse_lines += r.coarse_lines;
      sum.largest_shift = std::max(sum.largest_shift, r.largest_shift);
    }
  }

  const PreparedMesh& surface_;
  const RemeshSamples& samples_;
  const std::span<const double> masses_;
  const RemeshParameters& parameters_;
  const CancelToken& cancel_;
  double total_ = 0;
  std::vector<std::uint32_t> order_;
};

}  // namespace

RemeshedSurface remesh_surface(const PreparedMesh& surface, const RemeshSamples& samples,
                               std::span<const double> masses, const RemeshParameters& parameters,
                               const CancelToken& cancel) {
  return Remesher(surface, samples, masses, parameters, cancel).run();
}

}  // namespace meander
