#include "kernels/locate/elements.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string>

#include "kernels/core/parallel.h"
#include "kernels/core/radix_sort.h"

namespace meander {

namespace {

// A path is 1 followed by one bit a bisection: 31 bisections fit. No run needs more than 2^30 pieces of one
// triangle.
constexpr std::uint32_t deepest_path = 1u << 30;

// A piece while it is being bisected: barycentric weights of its corners, and where they lie in the triangle
// whose longest edge decides.
struct WorkPiece {
  Piece weights;
  std::array<Vector3, 3> corner;
  std::uint32_t path;
};

// Bisects the longest edge (the lowest one of equals); child 0 keeps the edge's first end, child 1 its
// second.
std::array<WorkPiece, 2> bisect(const WorkPiece& piece) {
  std::size_t longest = 0;
  double best = -1;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3 edge = piece.corner[(k + 1) % 3] - piece.corner[k];
    const double length = dot(edge, edge);
    if (length > best) {
      best = length;
      longest = k;
    }
  }
  const std::size_t a = longest, b = (longest + 1) % 3;
  std::array<WorkPiece, 2> children = {piece, piece};
  const double b1 = 0.5 * (piece.weights.b1[a] + piece.weights.b1[b]),
               b2 = 0.5 * (piece.weights.b2[a] + piece.weights.b2[b]);
  const Vector3 middle = 0.5 * (piece.corner[a] + piece.corner[b]);
  for (std::size_t child = 0; child < 2; ++child) {
    const std::size_t replaced = child == 0 ? b : a;
    children[child].weights.b1[replaced] = b1;
    children[child].weights.b2[replaced] = b2;
    children[child].corner[replaced] = middle;
    children[child].path = piece.path << 1 | static_cast<std::uint32_t>(child);
  }
  return children;
}

WorkPiece whole_triangle(const std::array<Vector3, 3>& corners) {
  return {{{0, 1, 0}, {0, 0, 1}}, corners, 1};
}

// Geometry and density of one triangle, from which masses and keys of its pieces follow.
struct TriangleSource {
  std::array<Vector3, 3> corner;  // in space
  double density[3];
  double area;
  bool uniform;  // density 1 everywhere
};

struct Element {
  std::uint64_t key;  // along the curve of the chart
  double mass;
  std::uint32_t triangle, path;
  std::uint32_t group;  // component and sheet
  float b1, b2;         // the curve vertex
};

// Mass of a piece: area x mean of the linear density at its corners (exact for a linear density).
double piece_mass(const TriangleSource& source, const Piece& piece, int bisections) {
  // 2^-bisections, exact; a call of ldexp costs more than the rest.
  const double share = std::bit_cast<double>(static_cast<std::uint64_t>(1023 - bisections) << 52);
  if (source.uniform) return source.area * share;
  double mean = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double b1 = piece.b1[k], b2 = piece.b2[k];
    mean += (1 - b1 - b2) * source.density[0] + b1 * source.density[1] + b2 * source.density[2];
  }
  return source.area * share * mean / 3;
}

// The point that keys a piece in 3-D order, where no sample is ever placed at the point of the key.
std::array<double, 2> centroid(const Piece& piece) {
  return {(piece.b1[0] + piece.b1[1] + piece.b1[2]) / 3, (piece.b2[0] + piece.b2[1] + piece.b2[2]) / 3};
}

// The uniformly random point of a piece that keys it along a chart's curve; a pure function of (key,
// triangle, path).
std::array<double, 2> random_point(const Piece& piece, std::size_t triangle, std::uint32_t path,
                                   RandomKey key) {
  const UnitPair uniform =
      random_pair(key, Stream::element_key, static_cast<std::uint64_t>(triangle) << 32 | path);
  const double root = std::sqrt(uniform.first);
  const double w1 = root * (1 - uniform.second), w2 = root * uniform.second, w0 = 1 - root;
  return {w0 * piece.b1[0] + w1 * piece.b1[1] + w2 * piece.b1[2],
          w0 * piece.b2[0] + w1 * piece.b2[1] + w2 * piece.b2[2]};
}

// Whether a piece is much longer, where lengths are measured, than a well-shaped one of mass `limit` would be
// there: samples would be spread along it. Never for pieces of less than limit / 8, so that their number is
// bounded.
bool is_needle(const WorkPiece& piece, double mass, double limit) {
  if (!(8 * mass > limit)) return false;
  double longest = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3 edge = piece.corner[(k + 1) % 3] - piece.corner[k];
    longest = std::max(longest, dot(edge, edge));
  }
  // 2.3 for an equilateral triangle of this mass, 4 for half a square.
  return longest * mass > 4.1 * triangle_area(piece.corner[0], piece.corner[1], piece.corner[2]) * limit;
}

// Depth-first bisection of one triangle until every piece weighs at most `limit` (and, where asked for, none
// is a needle) and there are at least `wanted` of them; `emit` is called in path order.
template <class Emit>
void cut_triangle(const TriangleSource& source, const std::array<Vector3, 3>& shape, double limit,
                  std::uint32_t wanted, bool no_needles, std::vector<WorkPiece>& stack, const Emit& emit) {
  const int least = wanted > 1 ? std::bit_width(wanted - 1) : 0;
  const WorkPiece whole = whole_triangle(shape);
  const double whole_mass = piece_mass(source, whole.weights, 0);
  if (!(whole_mass > 0)) return;
  const auto too_large = [&](const WorkPiece& piece, double mass) {
    return mass > limit || (no_needles && is_needle(piece, mass, limit));
  };
  if (!too_large(whole, whole_mass) && least == 0) {  // most triangles of a fine mesh
    emit(whole, whole_mass);
    return;
  }
  stack.push_back(whole);
  while (!stack.empty()) {
    const WorkPiece piece = stack.back();
    stack.pop_back();
    const int bisections = std::bit_width(piece.path) - 1;
    const double mass = piece_mass(source, piece.weights, bisections);
    if ((too_large(piece, mass) || bisections < least) && mass > 0 && piece.path < deepest_path) {
      const auto children = bisect(piece);
      stack.push_back(children[1]);
      stack.push_back(children[0]);
    } else if (mass > 0) {
      emit(piece, mass);
    }
  }
}

TriangleSource source_of(const PreparedMesh& mesh, const Density& density, std::size_t t) {
  TriangleSource source;
  for (std::size_t k = 0; k < 3; ++k) {
    source.corner[k] = mesh.position(mesh.triangles[3 * t + k]);
    source.density[k] = density.uniform() ? 1.0 : density.corner[3 * t + k];
  }
  source.area = mesh.area[t];
  source.uniform = density.uniform();
  return source;
}

// Elements of all triangles, before sorting, in triangle order. Blocks are cut by triangle, so the order is
// fixed.
std::vector<Element> cut_all(const MeasuredMesh& surface, const Density& density,
                             std::span<const FlatChart> charts, const TriangleHints& hints, RandomKey key,
                             const ElementParameters& parameters, double limit, const CancelToken& cancel) {
  const PreparedMesh& mesh = surface.mesh();
  const std::size_t triangles = mesh.triangle_count();
  std::vector<std::uint32_t> chart_of(triangles, no_index);
  for (std::size_t c = 0; c < charts.size(); ++c)
    if (charts[c].report.method != Method::none)
      std::fill(chart_of.begin() + mesh.components[c].triangle_begin,
                chart_of.begin() + mesh.components[c].triangle_end, static_cast<std::uint32_t>(c));
  std::vector<std::uint32_t> component_of(charts.empty() ? 0 : triangles);
  if (!charts.empty())
    for (std::size_t c = 0; c < mesh.components.size(); ++c)
      std::fill(component_of.begin() + mesh.components[c].triangle_begin,
                component_of.begin() + mesh.components[c].triangle_end, static_cast<std::uint32_t>(c));

  // Large, so that a model of usual size is one block, whose elements need no copying.
  constexpr std::size_t block = 16384;
  std::vector<std::vector<Element>> parts((triangles + block - 1) / block);
  parallel_blocks(triangles, block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    std::vector<Element>& part = parts[begin / block];
    part.reserve(end - begin);
    std::vector<WorkPiece> stack;
    for (std::size_t t = begin; t < end; ++t) {
      if (!(mesh.area[t] > 0)) continue;
      const TriangleSource source = source_of(mesh, density, t);
      const std::uint32_t wanted = hints.hits.empty() ? 0 : hints.hits[t];
      const std::uint32_t chart = chart_of[t];
      std::array<double, 3> u{}, v{};
      if (chart != no_index) {
        const std::size_t local = 3 * (t - mesh.components[chart].triangle_begin);
        for (std::size_t k = 0; k < 3; ++k) {
          u[k] = charts[chart].u[charts[chart].cut.triangles[local + k]];
          v[k] = charts[chart].v[charts[chart].cut.triangles[local + k]];
        }
      }
      const std::uint32_t sheet = hints.sheet.empty() ? 0 : hints.sheet[t];
      const std::uint32_t group = charts.empty() ? 0 : component_of[t] * 16 + sheet;
      const std::array<Vector3, 3> shape = bisection_corners(surface, static_cast<std::uint32_t>(t));
      cut_triangle(
          source, shape, limit, wanted, !surface.in_space(), stack, [&](const WorkPiece& piece, double mass) {
            const auto [b1, b2] = chart == no_index && !parameters.keep_vertices
                                      ? centroid(piece.weights)
                                      : random_point(piece.weights, t, piece.path, key);
            const double b0 = 1 - b1 - b2;
            Element e;
            e.key =
                chart == no_index
                    ? hilbert_key_3d(b0 * source.corner[0] + b1 * source.corner[1] + b2 * source.corner[2])
                    : curve_key(parameters.curve, b0 * u[0] + b1 * u[1] + b2 * u[2],
                                b0 * v[0] + b1 * v[1] + b2 * v[2]);
            e.mass = mass;
            e.triangle = static_cast<std::uint32_t>(t);
            e.path = piece.path;
            e.group = group;
            e.b1 = static_cast<float>(b1);
            e.b2 = static_cast<float>(b2);
            part.push_back(e);
          });
    }
  });
  if (parts.size() == 1) return std::move(parts.front());
  std::size_t count = 0;
  for (const auto& part : parts) count += part.size();
  std::vector<Element> elements;
  elements.reserve(count);
  for (auto& part : parts) {
    elements.insert(elements.end(), part.begin(), part.end());
    std::vector<Element>().swap(part);
  }
  return elements;
}

// The 3-D Hilbert key of an element's curve vertex.
std::uint64_t space_key(const PreparedMesh& mesh, const Element& e) {
  const auto corner = [&](std::size_t k) {
    return mesh.position(mesh.triangles[3 * std::size_t{e.triangle} + k]);
  };
  return hilbert_key_3d((1.0 - e.b1 - e.b2) * corner(0) + static_cast<double>(e.b1) * corner(1) +
                        static_cast<double>(e.b2) * corner(2));
}

// Elements of one cell of the finest level, along the 3-D curve instead; then in the order they are in.
void sort_run(const PreparedMesh& mesh, const std::vector<Element>& elements, std::span<KeyIndex> run) {
  for (KeyIndex& entry : run) entry.key = space_key(mesh, elements[entry.index]);
  std::sort(run.begin(), run.end(), [](const KeyIndex& a, const KeyIndex& b) {
    return a.key != b.key ? a.key < b.key : a.index < b.index;
  });
}

// Order of the elements: group, key, 3-D Hilbert key, then triangle and path (the order they are in).
std::vector<KeyIndex> curve_order(const PreparedMesh& mesh, const std::vector<Element>& elements) {
  std::vector<KeyIndex> order(elements.size()), scratch;
  for (std::size_t i = 0; i < elements.size(); ++i)
    order[i] = {elements[i].key, static_cast<std::uint32_t>(i)};
  radix_sort(order, scratch);
  const bool grouped = std::any_of(elements.begin(), elements.end(),
                                   [&](const Element& e) { return e.group != elements[0].group; });
  if (grouped) {
    for (KeyIndex& entry : order) entry.key = elements[entry.index].group;
    radix_sort(order, scratch);
  }
  // Runs of equal group and key are rare: a part of the chart that shrank below the finest cell.
  for (std::size_t begin = 0; begin < order.size();) {
    const Element& first = elements[order[begin].index];
    std::size_t end = begin + 1;
    while (end < order.size() && elements[order[end].index].key == first.key &&
           elements[order[end].index].group == first.group)
      ++end;
    if (end - begin > 1) sort_run(mesh, elements, std::span(order).subspan(begin, end - begin));
    begin = end;
  }
  return order;
}

}  // namespace

std::array<Vector3, 3> bisection_corners(const MeasuredMesh& surface, std::uint32_t triangle) {
  const PreparedMesh& mesh = surface.mesh();
  const std::uint32_t h = 3 * triangle;
  if (surface.in_space())
    return {mesh.position(mesh.triangles[h]), mesh.position(mesh.triangles[h + 1]),
            mesh.position(mesh.triangles[h + 2])};
  const double a = surface.length(h), b = surface.length(h + 1), c = surface.length(h + 2);
  if (!(a > 0)) return {Vector3{}, Vector3{}, Vector3{b, 0, 0}};
  const double x = 0.5 * (a + (c - b) * (c + b) / a), y = 2 * area_from_lengths(a, b, c) / a;
  return {Vector3{}, Vector3{a, 0, 0}, Vector3{x, y, 0}};
}

Piece piece_of(const std::array<Vector3, 3>& corners, std::uint32_t path) {
  WorkPiece piece = whole_triangle(corners);
  for (int bit = std::bit_width(path) - 2; bit >= 0; --bit) piece = bisect(piece)[path >> bit & 1u];
  return piece.weights;
}

CurveElements build_elements(const MeasuredMesh& surface, const MeshMeasure& measure,
                             std::span<const FlatChart> charts, const TriangleHints& hints, RandomKey key,
                             const ElementParameters& parameters, const CancelToken& cancel) {
  const double total = blocked_sum(measure.masses);
  if (!(total > 0)) throw ItemError(Status::zero_density, "the density is zero everywhere on the surface");
  const double limit = total / (parameters.elements_per_sample * static_cast<double>(parameters.samples));
  const std::vector<Element> elements =
      cut_all(surface, measure.density, charts, hints, key, parameters, limit, cancel);
  if (elements.size() >= no_index)
    throw ItemError(Status::too_large,
                    std::to_string(elements.size()) + " curve elements are more than 32 bits can number");
  cancel.check();
  const std::vector<KeyIndex> order = curve_order(surface.mesh(), elements);

  CurveElements result;
  const std::size_t count = elements.size();
  result.triangle.resize(count);
  result.path.resize(count);
  result.cumulative.resize(count + 1);
  if (parameters.keep_vertices) result.vertex.resize(2 * count);
  // Kahan's compensated sum: monotone, and exact to a few units in the last place for any number of elements.
  double sum = 0, lost = 0;
  result.cumulative[0] = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Element& e = elements[order[i].index];
    result.triangle[i] = e.triangle;
    result.path[i] = e.path;
    const double add = e.mass - lost, next = sum + add;
    lost = (next - sum) - add;
    sum = next;
    result.cumulative[i + 1] = std::max(sum, result.cumulative[i]);
    if (parameters.keep_vertices) {
      result.vertex[2 * i] = e.b1;
      result.vertex[2 * i + 1] = e.b2;
    }
  }
  return result;
}

}  // namespace meander
