#include "kernels/sample/place_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "kernels/core/exact_division.h"
#include "kernels/core/parallel.h"
#include "kernels/locate/element_cells.h"
#include "kernels/locate/surface_regions.h"
#include "kernels/sample/cell_net.h"
#include "kernels/sample/mesh_strata.h"
#include "kernels/sample/point_set.h"
#include "kernels/sample/sequence.h"

namespace meander {

namespace {

constexpr int max_redraws = 64;
// Acceptance of a linear density is at least 1/3 a trial: 64 misses in a row happen once in 10^11 draws.
constexpr int max_draws = 64;
// float32 keeps 2^-14 of the diagonal up to this many diagonals from 0.
constexpr double float_headroom = 1024;
// Within these float32 has its full precision, and 2^8 times a coordinate (the spacing of few samples on a
// folded surface) is still finite.
constexpr double least_unit = 0x1p-126, largest_coordinate = 0x1p120;

struct Draw {
  double b1, b2;
  std::uint32_t next_counter;
};

// The elements that samples lie in, by curve rank.
struct RankElements {
  std::vector<std::uint32_t> triangle, path;
  std::vector<float> vertex;  // 2 weights of the curve vertex, where samples are placed there,
  std::vector<double> mass;   // and the element's mass
  RankElements(std::size_t count, bool vertices)
      : triangle(count), path(count), vertex(vertices ? 2 * count : 0), mass(vertices ? count : 0) {}
  void set(std::size_t rank, std::uint32_t in_triangle, std::uint32_t at_path) {
    triangle[rank] = in_triangle;
    path[rank] = at_path;
  }
  void set_vertex(std::size_t rank, const float* weights, double own_mass) {
    vertex[2 * rank] = weights[0];
    vertex[2 * rank + 1] = weights[1];
    mass[rank] = own_mass;
  }
  // From rank `first` on, those of a part.
  void set_all(std::size_t first, const RankElements& part) {
    const auto copy = [](const auto& from, auto& to, std::size_t at) {
      std::copy(from.begin(), from.end(), to.begin() + static_cast<std::ptrdiff_t>(at));
    };
    copy(part.triangle, triangle, first);
    copy(part.path, path, first);
    copy(part.vertex, vertex, 2 * first);
    copy(part.mass, mass, first);
  }
};

// Everything that placing one sample needs; const, shared by all threads.
struct Placer {
  const PolygonMesh& file;
  const MeasuredMesh& surface;
  const Density& density;
  const RankElements& elements;
  RandomKey key;
  const PlaceParameters& parameters;
  const OutputFrame& frame;
  const PreparedMesh& mesh = surface.mesh();
  ExactDivision in_units{mesh.unit};
  double scale_in_units = frame.scale / mesh.unit;

  double density_at(std::uint32_t triangle, double b1, double b2) const {
    if (density.uniform()) return 1.0;
    if (density.in_pieces()) return source_of(mesh, density, triangle).density_at(b1, b2);
    const double* corner = &density.corner[3 * std::size_t{triangle}];
    return (1 - b1 - b2) * corner[0] + b1 * corner[1] + b2 * corner[2];
  }

  Piece piece(std::size_t rank) const {
    return piece_of(bisection_corners(surface, elements.triangle[rank]), elements.path[rank]);
  }

  // A mu-uniform point of the piece: uniform, accepted with probability density / largest corner density.
  Draw draw(std::uint32_t triangle, const Piece& p, std::uint32_t rank, std::uint32_t counter) const {
    double largest = 0, smallest = INFINITY;
    for (std::size_t k = 0; k < 3; ++k) {
      const double d = density_at(triangle, p.b1[k], p.b2[k]);
      largest = std::max(largest, d);
      smallest = std::min(smallest, d);
    }
    if (density.in_pieces()) {  // near a curve vertex: its corners say nothing about what is between them
      largest = 1;
      smallest = 0;
    }
    Draw result{p.b1[0], p.b2[0], counter};
    for (int trial = 0; trial < max_draws; ++trial) {
      const UnitPair uniform = random_pair(key, Stream::element_point, rank, result.next_counter++);
      const auto weights = uniform_point(p, uniform.first, uniform.second);
      result.b1 = weights[0];
      result.b2 = weights[1];
      if (smallest == largest) break;
      const double accept = random_pair(key, Stream::element_point, rank, result.next_counter++).first;
      if (accept * largest <= density_at(triangle, result.b1, result.b2)) break;
    }
    return result;
  }

  // A mu-uniform point of the element.
  Draw draw_in_element(std::uint32_t rank, const Piece& p, std::uint32_t counter) const {
    return density.in_pieces() ? draw_in_parts(rank, counter)
                               : draw(elements.triangle[rank], p, rank, counter);
  }
  // The same where the density is one in pieces: in one of them, chosen by mass.
  Draw draw_in_parts(std::uint32_t rank, std::uint32_t counter) const {
    const double choice = random_pair(key, Stream::element_point, rank, counter).first;
    const UnitPair uniform = random_pair(key, Stream::element_point, rank, counter + 1);
    const WorkPiece part =
        part_by_mass(source_of(mesh, density, elements.triangle[rank]), elements.path[rank], choice);
    const auto weights = uniform_point(part.weights, uniform.first, uniform.second);
    return {weights[0], weights[1], counter + 2};
  }

  // The piece to redraw a duplicate in: the element itself, or, for a curve vertex that stands for less than
  // the whole triangle, the triangle shrunk towards the vertex until it weighs what the vertex does.
  Piece redraw_piece(std::size_t rank) const {
    Piece p = piece(rank);
    if (parameters.place == PlaceKind::element || elements.path[rank] != 1) return p;
    const std::uint32_t t = elements.triangle[rank];
    const double whole =
        density.in_pieces()
            ? piece_mass(source_of(mesh, density, t), {}, 1)
            : mesh.area[t] * (density_at(t, 0, 0) + density_at(t, 1, 0) + density_at(t, 0, 1)) / 3;
    const double shrink = whole > 0 ? std::sqrt(std::clamp(elements.mass[rank] / whole, 0.0, 1.0)) : 1.0;
    for (std::size_t k = 0; k < 3; ++k) {
      p.b1[k] = elements.vertex[2 * rank] + shrink * (p.b1[k] - elements.vertex[2 * rank]);
      p.b2[k] = elements.vertex[2 * rank + 1] + shrink * (p.b2[k] - elements.vertex[2 * rank + 1]);
    }
    return p;
  }

  // The point that float32 weights name, in stored coordinates: what a reader recomputes from corners and
  // weights. In units of the mesh, where nothing leaves the range of double.
  std::array<float, 3> stored_point(std::uint32_t triangle, float b1, float b2) const {
    const auto vertex = [&](std::size_t k) {
      return file.corners[mesh.corner_slot[3 * std::size_t{triangle} + k]];
    };
    const std::uint32_t v0 = vertex(0), v1 = vertex(1), v2 = vertex(2);
    const auto along = [&](const std::vector<double>& c, double loc) {
      const double at = in_units(c[v0] - loc) + b1 * in_units(c[v1] - c[v0]) + b2 * in_units(c[v2] - c[v0]);
      return static_cast<float>(at / scale_in_units) + 0.0f;  // no negative zero
    };
    return {along(file.x, frame.loc.x), along(file.y, frame.loc.y), along(file.z, frame.loc.z)};
  }

  Vector3 geometric_normal(std::uint32_t triangle) const {
    const std::size_t t = 3 * std::size_t{triangle};
    const Vector3 a = mesh.position(mesh.triangles[t]), b = mesh.position(mesh.triangles[t + 1]),
                  c = mesh.position(mesh.triangles[t + 2]);
    const Vector3 n = cross(b - a, c - a);
    const double length = norm(n);
    return length > 0 ? (1 / length) * n : Vector3{0, 0, 1};
  }

  // The file's normals interpolated, where all three corners have a usable one and they do not cancel.
  Vector3 normal(std::uint32_t triangle, float b1, float b2) const {
    if (file.normals.empty()) return geometric_normal(triangle);
    const double weight[3] = {1.0 - b1 - b2, b1, b2};
    Vector3 sum;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t slot = mesh.corner_slot[3 * std::size_t{triangle} + k];
      const std::size_t number = file.corner_normals.empty() ? file.corners[slot] : file.corner_normals[slot];
      if (3 * number + 2 >= file.normals.size()) return geometric_normal(triangle);
      const Vector3 n = {file.normals[3 * number], file.normals[3 * number + 1],
                         file.normals[3 * number + 2]};
      const double length = norm(n);
      if (!(length > 0) || !std::isfinite(length)) return geometric_normal(triangle);
      sum = sum + (weight[k] / length) * n;
    }
    const double length = norm(sum);
    return length > 1e-6 ? (1 / length) * sum : geometric_normal(triangle);
  }
};

// The element that holds each position: half-open, never one without mass. Positions ascend: one linear
// merge.
RankElements elements_at(const CurveElements& elements, std::span<const double> position, bool vertices,
                         const CancelToken& cancel) {
  RankElements found(position.size(), vertices);
  const double total = elements.total();
  std::size_t at = 0;
  std::size_t last =
      elements.count() -
      1;  // positions that rounding pushes past the end belong to the last element of positive mass
  while (last > 0 && !(elements.cumulative[last + 1] > elements.cumulative[last])) --last;
  for (std::size_t r = 0; r < position.size(); ++r) {
    if (r % sum_block == 0) cancel.check();
    const double target = position[r] * total;
    while (at < last && elements.cumulative[at + 1] <= target) ++at;
    found.set(r, elements.triangle[at], elements.path[at]);
    if (vertices)
      found.set_vertex(r, &elements.vertex[2 * at], elements.cumulative[at + 1] - elements.cumulative[at]);
  }
  return found;
}

RankElements elements_at(const ElementCells& cells, std::span<const double> position, bool vertices,
                         const CancelToken& cancel) {
  RankElements found(position.size(), vertices);
  const auto count = static_cast<double>(cells.count());
  parallel_blocks(position.size(), sum_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    std::vector<std::uint64_t> scratch;
    for (std::size_t r = begin; r < end; ++r) {
      const double at = position[r] * count;
      const std::size_t c = std::min(static_cast<std::size_t>(at), cells.count() - 1);
      const CellEntry& entry =
          entry_at(cells.cells, cells.cells.cell[c], std::min(at - static_cast<double>(c), 1.0), scratch);
      found.set(r, cells.triangle[entry.element()], cells.path_of(entry));
      if (vertices)
        found.set_vertex(r, &cells.vertex[2 * std::size_t{entry.element()}], cells.cells.mass(entry));
    }
  });
  return found;
}

// The same where the samples of cells form a net: the cells from rank `first` on.
void elements_in_net(const ElementCells& cells, std::size_t first, RandomKey key, bool vertices,
                     RankElements& found, const CancelToken& cancel) {
  const DigitalShift shift = digital_shift(key);
  parallel_blocks(cells.count(), sum_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    CellNetScratch scratch;
    for (std::size_t c = begin; c < end; ++c) {
      const double choice = random_pair(key, Stream::sequence, first + c).first;
      const CellEntry& entry = entry_in_net(cells.cells, cells.cells.cell[c], shift, choice, scratch);
      found.set(first + c, cells.triangle[entry.element()], cells.path_of(entry));
      if (vertices)
        found.set_vertex(first + c, &cells.vertex[2 * std::size_t{entry.element()}], cells.cells.mass(entry));
    }
  });
}

RankElements elements_in_net(const SurfaceRegions& regions, const ElementSource& source, RandomKey key,
                             bool vertices, const CancelToken& cancel) {
  RankElements found(regions.parameters.samples, vertices);
  parallel_tasks(regions.count(), [&](std::size_t region) {
    elements_in_net(region_cells(regions, source, region, cancel), regions.first_stratum[region], key,
                    vertices, found, cancel);
  });
  return found;
}

// Regions have whole strata: positions in strata, less those before, are those in the region.
RankElements elements_at(const SurfaceRegions& regions, const ElementSource& source,
                         std::span<const double> position, bool vertices, const CancelToken& cancel) {
  RankElements found(position.size(), vertices);
  const auto samples = static_cast<double>(regions.parameters.samples);
  const auto rank_at = [&](std::size_t region) {
    if (region == regions.count()) return position.size();
    const auto first = static_cast<double>(regions.first_stratum[region]);
    const auto at =
        std::partition_point(position.begin(), position.end(), [&](double p) { return p * samples < first; });
    return static_cast<std::size_t>(at - position.begin());
  };
  parallel_tasks(regions.count(), [&](std::size_t region) {
    const std::size_t begin = rank_at(region), end = rank_at(region + 1);
    if (begin == end) return;
    const auto first = static_cast<double>(regions.first_stratum[region]);
    const auto strata = static_cast<double>(regions.strata(region));
    std::vector<double> local(end - begin);
    for (std::size_t i = 0; i < local.size(); ++i)
      local[i] = std::min((position[begin + i] * samples - first) / strata, below_one);
    const RankElements part =
        regions.parameters.order == ElementOrder::balanced
            ? elements_at(region_cells(regions, source, region, cancel), local, vertices, cancel)
            : elements_at(region_elements(regions, source, region, cancel), local, vertices, cancel);
    found.set_all(begin, part);
  });
  return found;
}

std::uint32_t count_bad_normals(const PolygonMesh& file) {
  std::uint32_t bad = 0;
  for (std::size_t i = 0; i + 2 < file.normals.size(); i += 3) {
    const double length = norm({file.normals[i], file.normals[i + 1], file.normals[i + 2]});
    bad += !(length > 0) || !std::isfinite(length);
  }
  return bad;
}

}  // namespace

OutputFrame float_frame(const std::array<double, 6>& bbox, const BoxFrame& box) {
  OutputFrame frame;
  double largest = 0;
  for (const double c : bbox) largest = std::max(largest, std::abs(c));
  if (largest > float_headroom * box.diagonal) {
    frame.loc = box.centre;
    largest = box.unit;
  }
  if (largest > largest_coordinate || box.unit < least_unit) frame.scale = box.unit;
  return frame;
}

OutputFrame output_frame(const PreparedMesh& mesh, NormalizeKind kind) {
  if (kind == NormalizeKind::none) return float_frame(mesh.bbox, {mesh.centre, mesh.unit, mesh.diagonal});
  OutputFrame frame;
  frame.loc = mesh.centre;
  if (kind == NormalizeKind::unit_box) {
    frame.scale =
        std::max({mesh.bbox[3] - mesh.bbox[0], mesh.bbox[4] - mesh.bbox[1], mesh.bbox[5] - mesh.bbox[2]});
  } else {
    double radius = 0;
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
      radius = std::max(radius, norm({mesh.x[v], mesh.y[v], mesh.z[v]}));
    frame.scale = radius * mesh.unit;
  }
  return frame;
}

namespace {

// Points by curve rank: duplicates must be found in one fixed order.
struct RankPoints {
  std::vector<float> point, weight;  // 3 and 2 a sample
  explicit RankPoints(std::size_t count) : point(3 * count), weight(2 * count) {}
  void set(const Placer& placer, std::size_t rank, double b1, double b2) {
    weight[2 * rank] = static_cast<float>(b1);
    weight[2 * rank + 1] = static_cast<float>(b2);
    const auto p =
        placer.stored_point(placer.elements.triangle[rank], weight[2 * rank], weight[2 * rank + 1]);
    std::copy(p.begin(), p.end(), point.begin() + 3 * static_cast<std::ptrdiff_t>(rank));
  }
};

// chosen: points by rank, if they are not to be drawn.
RankPoints place_by_rank(const Placer& placer, std::span<const StratumPoint> chosen, RepairCounts& repairs,
                         const CancelToken& cancel) {
  const RankElements& elements = placer.elements;
  const std::uint32_t count = placer.parameters.samples;
  const bool at_vertices = placer.parameters.place == PlaceKind::vertex;
  RankPoints points(count);
  std::vector<std::uint8_t> counter(count, 0);  // of the next draw: at most 2 max_draws
  parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    for (std::size_t r = begin; r < end; ++r) {
      if (!chosen.empty()) {
        points.set(placer, r, chosen[r].first, chosen[r].second);
        continue;
      }
      if (at_vertices) {
        points.set(placer, r, elements.vertex[2 * r], elements.vertex[2 * r + 1]);
        continue;
      }
      const Draw draw = placer.draw_in_element(static_cast<std::uint32_t>(r), placer.piece(r), 0);
      counter[r] = static_cast<std::uint8_t>(draw.next_counter);
      points.set(placer, r, draw.b1, draw.b2);
    }
  });
  PointSet seen(count);
  for (std::uint32_t rank = 0; rank < count; ++rank) {
    if (rank % sum_block == 0) cancel.check();
    if (seen.insert(points.point, rank)) continue;
    const Piece piece = placer.redraw_piece(rank);
    bool distinct = false;
    std::uint32_t next_counter = counter[rank];
    for (int redraw = 0; redraw < max_redraws && !distinct; ++redraw) {
      const Draw draw = at_vertices ? placer.draw(elements.triangle[rank], piece, rank, next_counter)
                                    : placer.draw_in_element(rank, piece, next_counter);
      next_counter = draw.next_counter;
      points.set(placer, rank, draw.b1, draw.b2);
      distinct = seen.insert(points.point, rank);
    }
    if (!distinct) ++repairs[Repair::coincident_points];
  }
  return points;
}

// rank_of_index: order in the file, if the sequence has one of its own.
Samples place(const Placer& placer, std::vector<std::uint32_t> rank_of_index,
              std::span<const StratumPoint> chosen, RepairCounts& repairs, const CancelToken& cancel) {
  const PlaceParameters& parameters = placer.parameters;
  const RankElements& elements = placer.elements;
  const PolygonMesh& file = placer.file;
  const PreparedMesh& mesh = placer.mesh;
  const std::uint32_t count = parameters.samples;
  cancel.check();
  const RankPoints by_rank = place_by_rank(placer, chosen, repairs, cancel);
  cancel.check();

  std::vector<std::uint32_t> order;
  if (parameters.order == OrderKind::curve) {
    order.resize(count);
    std::iota(order.begin(), order.end(), 0u);
  } else {
    order = rank_of_index.empty() ? progressive_order(count, placer.key) : std::move(rank_of_index);
  }
  repairs[Repair::bad_normals] += count_bad_normals(file);
  Samples samples;
  samples.points.resize(3 * std::size_t{count});
  samples.normals.resize(3 * std::size_t{count});
  samples.face.resize(count);
  samples.triangle.resize(count);
  samples.corners.resize(3 * std::size_t{count});
  samples.barycentric.resize(2 * std::size_t{count});
  samples.density.resize(count);
  parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t rank = order[i];
      const std::uint32_t t = elements.triangle[rank];
      const float b1 = by_rank.weight[2 * rank], b2 = by_rank.weight[2 * rank + 1];
      const Vector3 n = placer.normal(t, b1, b2);
      const float normal[3] = {static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)};
      for (std::size_t k = 0; k < 3; ++k) {
        samples.points[3 * i + k] = by_rank.point[3 * rank + k];
        samples.normals[3 * i + k] = normal[k];
        samples.corners[3 * i + k] = file.corners[mesh.corner_slot[3 * std::size_t{t} + k]];
      }
      samples.face[i] = mesh.polygon[t];
      samples.triangle[i] = t;
      samples.barycentric[2 * i] = b1;
      samples.barycentric[2 * i + 1] = b2;
      samples.density[i] = static_cast<float>(placer.density_at(t, b1, b2));
    }
  });
  samples.curve_rank = std::move(order);
  return samples;
}

CurveStrata strata_of(const CurveElements& elements, const MeasuredMesh& surface, const Density& density,
                      RandomKey key, const PlaceParameters& parameters, const MetricAt& metric) {
  return {elements, parameters.samples, surface, density, key, metric};
}
CellStrata strata_of(const ElementCells& cells, const MeasuredMesh& surface, const Density& density,
                     RandomKey key, const PlaceParameters&, const MetricAt& metric) {
  return {cells, surface, density, key, metric};
}

// Samples of cells form a net in place of a shifted set along the path.
bool forms_net(const PlaceParameters& parameters) { return parameters.sequence == SequenceKind::shifted; }

template <class Order>
Samples place_in_order(const PolygonMesh& file, const MeasuredMesh& surface, const Density& density,
                       const Order& order, RandomKey key, const PlaceParameters& parameters,
                       const OutputFrame& frame, RepairCounts& repairs, const CancelToken& cancel,
                       const MetricAt& metric) {
  if (order.count() == 0) throw ItemError(Status::zero_density, "no curve element has any mass");
  if (parameters.sequence == SequenceKind::spaced) {
    SpacedSamples spaced = space_samples(strata_of(order, surface, density, key, parameters, metric),
                                         parameters.order == OrderKind::progressive, key,
                                         spacing_parameters(parameters.spacing), cancel);
    RankElements elements(parameters.samples, false);
    for (std::size_t r = 0; r < parameters.samples; ++r)
      elements.set(r, spaced.point[r].triangle, spaced.point[r].path);
    return place(Placer{file, surface, density, elements, key, parameters, frame},
                 std::move(spaced.rank_of_index), spaced.point, repairs, cancel);
  }
  SampleSequence sequence = make_sequence(parameters.sequence, parameters.samples, parameters.jitter, key);
  const RankElements elements =
      elements_at(order, sequence.position, parameters.place == PlaceKind::vertex, cancel);
  sequence.position = std::vector<double>();
  return place(Placer{file, surface, density, elements, key, parameters, frame},
               std::move(sequence.rank_of_index), {}, repairs, cancel);
}

}  // namespace

Samples place_samples(const PolygonMesh& file, const MeasuredMesh& surface, const Density& density,
                      const CurveElements& elements, RandomKey key, const PlaceParameters& parameters,
                      const OutputFrame& frame, RepairCounts& repairs, const CancelToken& cancel,
                      const MetricAt& metric) {
  return place_in_order(file, surface, density, elements, key, parameters, frame, repairs, cancel, metric);
}

Samples place_samples(const PolygonMesh& file, const MeasuredMesh& surface, const Density& density,
                      const ElementCells& cells, RandomKey key, const PlaceParameters& parameters,
                      const OutputFrame& frame, RepairCounts& repairs, const CancelToken& cancel,
                      const MetricAt& metric) {
  if (forms_net(parameters) && cells.count() > 0) {
    RankElements elements(parameters.samples, parameters.place == PlaceKind::vertex);
    elements_in_net(cells, 0, key, parameters.place == PlaceKind::vertex, elements, cancel);
    std::vector<std::uint32_t> order;
    if (parameters.order == OrderKind::progressive)
      order = cell_net_order(cells.cells.cell, digital_shift(key));
    return place(Placer{file, surface, density, elements, key, parameters, frame}, std::move(order), {},
                 repairs, cancel);
  }
  return place_in_order(file, surface, density, cells, key, parameters, frame, repairs, cancel, metric);
}

Samples place_samples(const PolygonMesh& file, const MeasuredMesh& surface, const Density& density,
                      const ChartSet& charts, const SurfaceRegions& regions, RandomKey key,
                      const PlaceParameters& parameters, const OutputFrame& frame, RepairCounts& repairs,
                      const CancelToken& cancel) {
  if (regions.count() == 0) throw ItemError(Status::zero_density, "no curve element has any mass");
  const ElementSource source(surface, density, charts, {}, regions.group, regions.parameters.order, key);
  const bool vertices = parameters.place == PlaceKind::vertex;
  if (forms_net(parameters) && regions.parameters.order == ElementOrder::balanced) {
    const RankElements elements = elements_in_net(regions, source, key, vertices, cancel);
    return place(Placer{file, surface, density, elements, key, parameters, frame}, {}, {}, repairs, cancel);
  }
  SampleSequence sequence = make_sequence(parameters.sequence, parameters.samples, parameters.jitter, key);
  const RankElements elements = elements_at(regions, source, sequence.position, vertices, cancel);
  sequence.position = std::vector<double>();
  return place(Placer{file, surface, density, elements, key, parameters, frame},
               std::move(sequence.rank_of_index), {}, repairs, cancel);
}

}  // namespace meander
