#include "kernels/locate/elements.h"

#include <algorithm>
#include <array>
#include <bit>
#include <string>

#include "kernels/core/parallel.h"
#include "kernels/core/radix_sort.h"
#include "kernels/locate/pieces.h"
#include "kernels/order/balanced_order.h"

namespace meander {

namespace {

// Parts that pieces of the balanced order are split into.
constexpr double split_parts = 4;

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
  void reserve(std::size_t pieces) { elements.reserve(pieces); }
  void append(const KeyedPieces& next) {
    elements.insert(elements.end(), next.elements.begin(), next.elements.end());
  }

  void operator()(std::size_t t, const TriangleSource& source, const WorkPiece& piece, double mass) {
    std::array<double, 3> u, v;
    const bool in_chart = places_->find(t, u, v);
    // In 3-D order no sample is ever placed at the point of the key, and the centroid is the steadier one.
    const auto [b1, b2] = in_chart || parameters_->keep_vertices
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

// From a piece's centroid to that of the half that bisect_edge makes first.
Vector3 way_to_first_half(const PlainPiece& piece, std::size_t edge) {
  return (1.0 / 6) * (piece.corner[edge] - piece.corner[(edge + 1) % 3]);
}

// How a piece is split into parts of at most `limit`.
ElementSplit split_of(const PlainPiece& piece, double mass, double limit) {
  ElementSplit split;
  const int bisections = std::bit_width(piece.path) - 1;
  while (split.levels < 2 && mass > limit && bisections + split.levels < most_bisections) {
    ++split.levels;
    mass *= 0.5;
  }
  if (split.levels == 0) return split;
  const auto store = [](const Vector3& way, float(&to)[3]) {
    to[0] = static_cast<float>(way.x);
    to[1] = static_cast<float>(way.y);
    to[2] = static_cast<float>(way.z);
  };
  const std::size_t edge = longest_edge(piece);
  store(way_to_first_half(piece, edge), split.half);
  if (split.levels == 1) return split;
  std::array<PlainPiece, 2> half;
  bisect_edge(piece, edge, half[0], half[1]);
  for (std::size_t h = 0; h < 2; ++h)
    store(way_to_first_half(half[h], longest_edge(half[h])), split.quarter[h]);
  return split;
}

// Pieces with their centroids (see cut_all), and with the splits of plain ones, unless the limit is 0.
class PlacedPieces {
 public:
  PlacedPieces(const ChartPlaces& places, RandomKey key, bool keep_vertices, double split_limit)
      : places_(&places), key_(key), keep_vertices_(keep_vertices), split_limit_(split_limit) {}

  static constexpr bool takes_plain_pieces = true;
  bool wants_weights() const { return keep_vertices_ || places_->any(); }

  void reserve(std::size_t pieces) {
    point.reserve(pieces);
    triangle.reserve(pieces);
    path.reserve(pieces);
    if (split_limit_ > 0) split.reserve(pieces);
  }
  void append(const PlacedPieces& next) {
    point.insert(point.end(), next.point.begin(), next.point.end());
    triangle.insert(triangle.end(), next.triangle.begin(), next.triangle.end());
    path.insert(path.end(), next.path.begin(), next.path.end());
    vertex.insert(vertex.end(), next.vertex.begin(), next.vertex.end());
    split.insert(split.end(), next.split.begin(), next.split.end());
  }

  void operator()(std::size_t t, const TriangleSource& source, const WorkPiece& piece, double mass) {
    const auto [b1, b2] = centroid(piece.weights);
    Vector3 at = source.at(b1, b2);
    std::array<double, 3> u, v;
    if (places_->find(t, u, v)) {
      const double b0 = 1 - b1 - b2;
      at = {b0 * u[0] + b1 * u[1] + b2 * u[2], b0 * v[0] + b1 * v[1] + b2 * v[2], 0};
    }
    add(t, at, piece.path, mass);
    if (!keep_vertices_) return;
    const auto [v1, v2] = random_point(piece.weights, t, piece.path, key_);
    vertex.push_back(static_cast<float>(v1));
    vertex.push_back(static_cast<float>(v2));
  }

  void operator()(std::size_t t, const PlainPiece& piece, double mass) {
    add(t, centroid(piece), piece.path, mass);
    if (split_limit_ > 0) split.push_back(split_of(piece, mass, split_limit_));
  }

  std::vector<MassPoint> point;
  std::vector<std::uint32_t> triangle, path;
  std::vector<float> vertex;
  std::vector<ElementSplit> split;

 private:
  void add(std::size_t t, const Vector3& at, std::uint32_t piece_path, double mass) {
    point.push_back({{static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)}, mass});
    triangle.push_back(static_cast<std::uint32_t>(t));
    path.push_back(piece_path);
  }

  const ChartPlaces* places_;
  RandomKey key_;
  bool keep_vertices_;
  double split_limit_;
};

void check_count(std::size_t elements, bool balanced) {
  const std::size_t most = balanced ? most_balanced_elements : std::size_t{1} << 31;
  if (elements > most)
    throw ItemError(Status::too_large, std::to_string(elements) + " curve elements are more than the 2^" +
                                           std::to_string(std::countr_zero(most)) + " that can be numbered");
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

// Words of equal coarse keys in the order of their whole keys. A small part of a large box may share one
// cell.
void sort_ties(const std::vector<MassPoint>& points, std::span<std::uint64_t> words, int number_bits) {
  std::vector<KeyIndex> tied;
  for (std::size_t begin = 0, end; begin < words.size(); begin = end) {
    for (end = begin + 1; end < words.size() && words[end] >> number_bits == words[begin] >> number_bits;)
      ++end;
    if (end - begin == 1) continue;
    tied.clear();
    for (std::size_t i = begin; i < end; ++i) {
      const auto number = static_cast<std::uint32_t>(words[i] & ((std::uint64_t{1} << number_bits) - 1));
      const float* p = points[number].at;
      tied.push_back(
          {hilbert_key_3d({static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])}),
           number});
    }
    std::stable_sort(tied.begin(), tied.end(),
                     [](const KeyIndex& a, const KeyIndex& b) { return a.key < b.key; });
    const std::uint64_t key = words[begin] >> number_bits << number_bits;
    for (std::size_t i = begin; i < end; ++i) words[i] = key | tied[i - begin].index;
  }
}

// Places along the 3-D Hilbert curve: first by coarse keys, which fit into one word with the numbers.
std::vector<std::uint32_t> space_order(const std::vector<MassPoint>& points) {
  constexpr std::size_t most_coarse = std::size_t{1} << 20;  // beyond, many keys would be equal
  constexpr int number_bits = 64 - coarse_key_bits;
  const std::size_t count = points.size();
  std::vector<std::uint32_t> order(count);
  if (count <= most_coarse) {
    std::vector<std::uint64_t> words(count), scratch;
    if (count > 0)
      coarse_hilbert_keys_3d(count, points[0].at, sizeof(MassPoint) / sizeof(float), words.data());
    for (std::size_t i = 0; i < count; ++i) words[i] = words[i] << number_bits | i;
    radix_sort_words(words, scratch, number_bits);
    sort_ties(points, words, number_bits);
    for (std::size_t i = 0; i < count; ++i)
      order[i] = static_cast<std::uint32_t>(words[i] & ((std::uint64_t{1} << number_bits) - 1));
    return order;
  }
  std::vector<KeyIndex> keys(count), scratch;
  parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const float* p = points[i].at;
      keys[i] = {
          hilbert_key_3d({static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])}),
          static_cast<std::uint32_t>(i)};
    }
  });
  radix_sort(keys, scratch);
  for (std::size_t i = 0; i < count; ++i) order[i] = keys[i].index;
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

// A piece as it stands in the order, or the part of it that further bisections lead to.
struct PieceEntry {
  std::size_t piece;
  std::uint32_t part = 1;  // 1 followed by one bit a bisection
};

// Everything but the masses of `count` elements, of which entry(i) tells the i-th.
template <class Entry>
CurveElements gathered(const PlacedPieces& pieces, std::size_t count, const Entry& entry) {
  CurveElements result;
  result.triangle.resize(count);
  result.path.resize(count);
  if (!pieces.vertex.empty()) result.vertex.resize(2 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const PieceEntry e = entry(i);
    result.triangle[i] = pieces.triangle[e.piece];
    const int bisections = std::bit_width(e.part) - 1;
    result.path[i] = pieces.path[e.piece] << bisections | (e.part - (1u << bisections));
    if (pieces.vertex.empty()) continue;
    result.vertex[2 * i] = pieces.vertex[2 * e.piece];
    result.vertex[2 * i + 1] = pieces.vertex[2 * e.piece + 1];
  }
  return result;
}

CurveElements along_space_curve(const PlacedPieces& pieces) {
  const std::vector<std::uint32_t> order = space_order(pieces.point);
  CurveElements result = gathered(pieces, order.size(), [&](std::size_t i) { return PieceEntry{order[i]}; });
  result.cumulative.resize(order.size() + 1);
  MassSum sum;
  for (std::size_t i = 0; i < order.size(); ++i)
    result.cumulative[i + 1] = sum.add(pieces.point[order[i]].mass);
  return result;
}

// Unit normals in space, (0, 0, 0) for triangles of no area.
std::vector<float> triangle_normals(const PreparedMesh& mesh) {
  std::vector<float> normal(3 * mesh.triangle_count());
  parallel_blocks(mesh.triangle_count(), sum_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const Vector3 a = mesh.position(mesh.triangles[3 * t]);
      const Vector3 n =
          cross(mesh.position(mesh.triangles[3 * t + 1]) - a, mesh.position(mesh.triangles[3 * t + 2]) - a);
      const double length = norm(n), scale = length > 0 ? 1 / length : 0;
      normal[3 * t] = static_cast<float>(scale * n.x);
      normal[3 * t + 1] = static_cast<float>(scale * n.y);
      normal[3 * t + 2] = static_cast<float>(scale * n.z);
    }
  });
  return normal;
}

CurveElements by_bisection(const PreparedMesh& mesh, const PlacedPieces& pieces,
                           std::span<const FlatChart> charts, std::span<const std::uint32_t> group,
                           std::uint32_t samples, const CancelToken& cancel) {
  const std::vector<float> normal = charts.empty() ? triangle_normals(mesh) : std::vector<float>();
  BalancedOrder order =
      balanced_order(pieces.point, samples, {pieces.triangle, pieces.split, normal, group}, cancel);
  cancel.check();
  CurveElements result = gathered(pieces, order.element.size(), [&](std::size_t i) {
    return PieceEntry{order.element[i], order.part[i]};
  });
  result.cumulative = std::move(order.cumulative);
  return result;
}

}  // namespace

CurveElements build_elements(const MeasuredMesh& surface, const MeshMeasure& measure,
                             std::span<const FlatChart> charts, const TriangleHints& hints, RandomKey key,
                             const ElementParameters& parameters, const CancelToken& cancel) {
  const double total = blocked_sum(measure.masses);
  if (!(total > 0)) throw ItemError(Status::zero_density, "the density is zero everywhere on the surface");
  const double limit = total / (parameters.elements_per_sample * static_cast<double>(parameters.samples));
  const ChartPlaces places(surface.mesh(), charts);
  const std::vector<std::uint32_t> group = sheet_groups(surface.mesh(), charts, hints.sheet);
  const bool balanced = parameters.order == ElementOrder::balanced;
  if (charts.empty() || balanced) {
    // Pieces in space of one density are cut to four times the limit, and split in the order alone; coarse
    // ones are not made coarser.
    const bool is_split = balanced && charts.empty() && parameters.elements_per_sample >= 8 &&
                          measure.density.uniform() && surface.in_space() && hints.hits.empty() &&
                          !parameters.keep_vertices;
    const PlacedPieces pieces = cut_all(
        surface, measure.density, hints.hits, is_split ? limit * split_parts : limit,
        [&] { return PlacedPieces(places, key, parameters.keep_vertices, is_split ? limit : 0); }, cancel);
    check_count(pieces.point.size(), balanced);
    cancel.check();
    if (!balanced) return along_space_curve(pieces);
    return by_bisection(surface.mesh(), pieces, charts, group, static_cast<std::uint32_t>(parameters.samples),
                        cancel);
  }
  const KeyedPieces pieces = cut_all(
      surface, measure.density, hints.hits, limit,
      [&] { return KeyedPieces(places, group, key, parameters); }, cancel);
  check_count(pieces.elements.size(), false);
  cancel.check();
  return along_curve(surface.mesh(), pieces.elements, parameters.keep_vertices);
}

}  // namespace meander
