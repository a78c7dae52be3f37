#include "kernels/partition/elements.h"

#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "kernels/core/large_vector.h"
#include "kernels/core/parallel.h"
#include "kernels/core/radix_sort.h"
#include "kernels/density/pieces.h"
#include "kernels/partition/element_source.h"
#include "kernels/partition/placed_pieces.h"
#include "kernels/partition/space_order.h"

namespace meander {

namespace {

constexpr std::size_t most_curve_elements = std::size_t{1} << 31;

struct Element {
  std::uint64_t key;  // along the curve of the chart
  double mass;
  std::uint32_t triangle, path;
  std::uint32_t group;  // component and sheet
  float b1, b2;         // the curve vertex
};

// Pieces with the curve keys of their vertices (see cut_all).
class KeyedPieces {
 public:
  KeyedPieces(const ChartPlaces& places, std::span<const std::uint32_t> group, RandomKey key,
              const ElementParameters& parameters)
      : places_(&places), group_(group), key_(key), parameters_(&parameters) {}

  static constexpr bool takes_plain_pieces = false;
  std::size_t size() const { return elements.size(); }
  void reserve(std::size_t pieces, double) { elements.reserve(pieces); }
  void append(const KeyedPieces& next) {
    elements.insert(elements.end(), next.elements.begin(), next.elements.end());
  }

  void operator()(std::size_t t, const TriangleSource& source, const WorkPiece& piece, double mass) {
    std::array<double, 3> u, v;
    const bool in_chart = places_->find(t, u, v);
    // In 3-D order no sample is ever placed at the point of the key, and the centroid is the steadier one.
    const auto [b1, b2] = in_chart || parameters_->use == ElementUse::vertices
                              ? random_point(piece.weights, t, piece.path, key_)
                              : centroid(piece.weights);
    const double b0 = 1 - b1 - b2;
    Element e;
    e.key = in_chart ? curve_key(curve_of(parameters_->order), b0 * u[0] + b1 * u[1] + b2 * u[2],
                                 b0 * v[0] + b1 * v[1] + b2 * v[2])
                     : hilbert_key_3d(source.at(b1, b2));
    e.mass = mass;
    e.triangle = static_cast<std::uint32_t>(t);
    e.path = piece.path;
    e.group = group_.empty() ? 0 : group_[t];
    e.b1 = static_cast<float>(b1);
    e.b2 = static_cast<float>(b2);
    elements.push_back(e);
  }

  std::vector<Element> elements;

 private:
  const ChartPlaces* places_;
  std::span<const std::uint32_t> group_;
  RandomKey key_;
  const ElementParameters* parameters_;
};

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

// A sum of masses in their order, compensated (Kahan 1965): monotone, and exact to a few units in the last
// place for any number of elements.
class MassSum {
 public:
  double add(double mass) {
    const double part = mass - lost_, next = sum_ + part;
    lost_ = (next - sum_) - part;
    sum_ = next;
    return reached_ = std::max(sum_, reached_);
  }

 private:
  double sum_ = 0, lost_ = 0, reached_ = 0;
};

CurveElements along_curve(const PreparedMesh& mesh, const std::vector<Element>& elements,
                          bool keep_vertices) {
  const std::vector<KeyIndex> order = curve_order(mesh, elements);
  CurveElements result;
  const std::size_t count = elements.size();
  result.triangle.resize(count);
  result.path.resize(count);
  result.cumulative.resize(count + 1);
  if (keep_vertices) result.vertex.resize(2 * count);
  MassSum sum;
  result.cumulative[0] = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Element& e = elements[order[i].index];
    result.triangle[i] = e.triangle;
    result.path[i] = e.path;
    result.cumulative[i + 1] = sum.add(e.mass);
    if (keep_vertices) {
      result.vertex[2 * i] = e.b1;
      result.vertex[2 * i + 1] = e.b2;
    }
  }
  return result;
}

// Pieces as they are, wide ones included. Column by column, each of which is freed once it has been put in
// order.
CurveElements in_space_order(PlacedPieces pieces, const SpaceOrder& order) {
  const std::size_t count = pieces.size();
  CurveElements result;
  const auto put_in_order = [&](std::vector<std::uint32_t>& from, std::vector<std::uint32_t>& to) {
    resize_large(to, count);
    parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) to[i] = from[order[i]];
    });
    from = std::vector<std::uint32_t>();
  };
  const auto sum_masses = [&] {
    resize_large(result.cumulative, count + 1);
    parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) result.cumulative[i + 1] = pieces.point[order[i]].mass;
    });
    MassSum sum;  // one after the other
    for (std::size_t i = 0; i < count; ++i) result.cumulative[i + 1] = sum.add(result.cumulative[i + 1]);
  };
  put_in_order(pieces.triangle, result.triangle);
  parallel_both(count, sum_masses, [&] { put_in_order(pieces.path, result.path); });
  if (pieces.vertex.empty()) return result;
  result.vertex.resize(2 * count);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = 0; k < 2; ++k) result.vertex[2 * i + k] = pieces.vertex[2 * order[i] + k];
  return result;
}

// Pieces along the 3-D Hilbert curve.
CurveElements along_space_curve(const ElementSource& source, const SurfacePart& part,
                                const ElementParameters& parameters) {
  PlacedPieces pieces = cut_source(source, part, part.limit, [&] {
    return PlacedPieces(source.places, source.key,
                        KeptOfPieces{.vertices = parameters.use == ElementUse::vertices});
  });
  check_elements(pieces.size(), most_curve_elements);
  source.cancel.check();
  const SpaceOrder order = space_order(pieces.point, false);
  return in_space_order(std::move(pieces), order);
}

// Whether many of the pieces that follow each other lie on each other, as those of two sheets that coincide:
// their centroids are nearer to each other than those of neighbors in one sheet are.
bool lie_on_each_other(const std::vector<MassPoint>& points, const SpaceOrder& order) {
  // Between the centroids of two halves of a square it is, squared, 4/9 of the mass of each.
  constexpr double near = 0.1;
  constexpr std::size_t one_in = 16;
  std::size_t found = 0;
  for (std::size_t i = 1; i < order.count(); ++i) {
    const MassPoint &a = points[order[i - 1]], &b = points[order[i]];
    double squared = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double way = static_cast<double>(b.at[k]) - static_cast<double>(a.at[k]);
      squared += way * way;
    }
    if (squared < near * std::min(a.mass, b.mass)) ++found;
  }
  return found * one_in > order.count();
}

// The same for a region. Wide pieces are elements as wholes, unless they lie on each other: there the curve
// passes through all sheets at once.
CurveElements along_region(const ElementSource& source, const SurfacePart& part,
                           const ElementParameters& parameters) {
  const auto cut = [&](double stratum) {
    const KeptOfPieces kept{.vertices = parameters.use == ElementUse::vertices, .stratum = stratum};
    PlacedPieces pieces =
        cut_source(source, part, part.limit, [&] { return PlacedPieces(source.places, source.key, kept); });
    source.cancel.check();
    return pieces;
  };
  PlacedPieces pieces = cut(part.limit * parameters.elements_per_sample);
  SpaceOrder order = space_order(pieces.point, true);
  if (pieces.wide > 0 && lie_on_each_other(pieces.point, order)) {
    pieces = cut(0);
    order = space_order(pieces.point, true);
  }
  std::vector<float> place;
  if (pieces.wide > 0) {
    place.reserve(3 * order.count());
    for (std::size_t i = 0; i < order.count(); ++i)
      place.insert(place.end(), pieces.point[order[i]].at, pieces.point[order[i]].at + 3);
  }
  CurveElements elements = in_space_order(std::move(pieces), order);
  elements.place = std::move(place);
  elements.limit = part.limit;
  return elements;
}

}  // namespace

double element_limit(const MeshMeasure& measure, const ElementParameters& parameters) {
  const double total = measure.total();
  if (!(total > 0)) throw ItemError(Status::zero_density, "the density is zero everywhere on the surface");
  return total / (parameters.elements_per_sample * static_cast<double>(parameters.samples));
}

void check_elements(std::size_t elements, std::size_t most) {
  if (elements > most)
    throw ItemError(Status::too_large, std::to_string(elements) + " curve elements are more than the 2^" +
                                           std::to_string(std::countr_zero(most)) + " that can be numbered");
}

CurveElements elements_from(const ElementSource& source, const SurfacePart& part,
                            const ElementParameters& parameters) {
  if (!source.places.any())
    return part.region == nullptr ? along_space_curve(source, part, parameters)
                                  : along_region(source, part, parameters);
  const KeyedPieces pieces = cut_source(source, part, part.limit, [&] {
    return KeyedPieces(source.places, source.group, source.key, parameters);
  });
  check_elements(pieces.elements.size(), most_curve_elements);
  source.cancel.check();
  return along_curve(source.surface.mesh(), pieces.elements, parameters.use == ElementUse::vertices);
}

CurveElements build_elements(const SurfaceContext& context, const ElementParameters& parameters) {
  return elements_from(ElementSource(context, parameters.order),
                       {.limit = element_limit(context.measure, parameters)}, parameters);
}

}  // namespace meander
