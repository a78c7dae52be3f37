#include "kernels/locate/elements.h"

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
#include "kernels/locate/element_source.h"
#include "kernels/locate/pieces.h"
#include "kernels/locate/placed_pieces.h"

namespace meander {

namespace {

constexpr std::size_t most_curve_elements = std::size_t{1} << 31;
constexpr std::size_t tie_block = 65536;

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

// Stable; nearly all ties are of two or three.
void sort_by_key(std::vector<KeyIndex>& items) {
  constexpr std::size_t few = 16;
  const auto precedes = [](const KeyIndex& a, const KeyIndex& b) { return a.key < b.key; };
  if (items.size() > few) {
    std::stable_sort(items.begin(), items.end(), precedes);
    return;
  }
  for (std::size_t i = 1; i < items.size(); ++i)
    for (std::size_t k = i; k > 0 && precedes(items[k], items[k - 1]); --k) std::swap(items[k], items[k - 1]);
}

// Words of equal coarse keys in the order of their whole keys, which key_of(number) gives. A small part of a
// large box may share one cell.
template <class KeyOf>
void sort_ties(std::span<std::uint64_t> words, int number_bits, const KeyOf& key_of) {
  const auto tie = [&](std::size_t a, std::size_t b) {
    return words[a] >> number_bits == words[b] >> number_bits;
  };
  // Ties belong to the block that they begin in, and may be longer than it.
  std::vector<std::size_t> block_begin((words.size() + tie_block - 1) / tie_block + 1, words.size());
  block_begin[0] = 0;
  for (std::size_t b = 1; b + 1 < block_begin.size(); ++b) {
    std::size_t at = std::max(b * tie_block, block_begin[b - 1]);
    if (at > block_begin[b - 1])
      while (at < words.size() && tie(at - 1, at)) ++at;
    block_begin[b] = at;
  }
  parallel_blocks(words.size(), tie_block, [&](std::size_t first, std::size_t) {
    const std::size_t past = block_begin[first / tie_block + 1];
    std::vector<KeyIndex> tied;
    for (std::size_t begin = block_begin[first / tie_block], end; begin < past; begin = end) {
      for (end = begin + 1; end < past && tie(begin, end);) ++end;
      if (end - begin == 1) continue;
      tied.clear();
      for (std::size_t i = begin; i < end; ++i) {
        const auto number = static_cast<std::uint32_t>(words[i] & ((std::uint64_t{1} << number_bits) - 1));
        tied.push_back({key_of(number), number});
      }
      sort_by_key(tied);
      const std::uint64_t key = words[begin] >> number_bits << number_bits;
      for (std::size_t i = begin; i < end; ++i) words[i] = key | tied[i - begin].index;
    }
  });
}

// Numbers of points along the 3-D Hilbert curve, in words whose other bits are to be masked.
struct SpaceOrder {
  std::vector<std::uint64_t> words;
  std::uint64_t mask = ~std::uint64_t{0};
  std::size_t operator[](std::size_t i) const { return static_cast<std::size_t>(words[i] & mask); }
};

StridedPoints points_from(const std::vector<MassPoint>& points, std::size_t begin) {
  return {points[begin].at, sizeof(MassPoint) / sizeof(float)};
}

std::vector<std::uint64_t> whole_keys(const std::vector<MassPoint>& points) {
  std::vector<std::uint64_t> keys(points.size());
  parallel_blocks(keys.size(), sum_block, [&](std::size_t begin, std::size_t end) {
    hilbert_keys_3d(points_from(points, begin), std::span(keys).subspan(begin, end - begin));
  });
  return keys;
}

// A coarse key and the number fit into one word. `dense`: most points may share a cell of the coarse grid, as
// those of a region of the surface. They are not so many, so that their words have room for longer keys; and
// a region is a stretch of the curve, so that keys less the least of them are shorter than whole ones.
SpaceOrder space_order(const std::vector<MassPoint>& points, bool dense) {
  constexpr int most_number_bits = 64 - coarse_key_bits;
  constexpr std::size_t most_numbered = std::size_t{1} << most_number_bits;
  const std::size_t count = points.size();
  const int number_bits = dense ? std::max(static_cast<int>(std::bit_width(count)), 1) : most_number_bits;
  SpaceOrder order;
  std::vector<std::uint64_t>& words = order.words;
  resize_large(words, count);
  if (count == 0) return order;
  std::vector<std::uint64_t> keys;  // whole ones, where they are needed
  if (dense || count > most_numbered) keys = whole_keys(points);
  if (count > most_numbered) {
    std::vector<KeyIndex> numbered(count), scratch;
    for (std::size_t i = 0; i < count; ++i) numbered[i] = {keys[i], static_cast<std::uint32_t>(i)};
    radix_sort(numbered, scratch);
    for (std::size_t i = 0; i < count; ++i) words[i] = numbered[i].index;
    return order;
  }
  if (dense) {
    const auto [least, most] = std::minmax_element(keys.begin(), keys.end());
    const std::uint64_t first = *least, range = *most - first;
    const int unused = 64 - std::max(static_cast<int>(std::bit_width(range)), 1);
    for (std::size_t i = 0; i < count; ++i)
      words[i] = (keys[i] - first) << unused >> number_bits << number_bits | i;
  } else {
    parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
      coarse_hilbert_keys_3d(points_from(points, begin), std::span(words).subspan(begin, end - begin));
      for (std::size_t i = begin; i < end; ++i) words[i] = words[i] << number_bits | i;
    });
  }
  {
    std::vector<std::uint64_t> scratch;
    radix_sort_words(words, scratch, number_bits);
  }
  sort_ties(words, number_bits, [&](std::uint32_t number) {
    if (!keys.empty()) return keys[number];
    const float* p = points[number].at;
    return hilbert_key_3d({static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])});
  });
  order.mask = (std::uint64_t{1} << number_bits) - 1;
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

// Column by column, each of which is freed once it has been put in order.
CurveElements along_space_curve(PlacedPieces pieces, bool dense) {
  const SpaceOrder order = space_order(pieces.point, dense);
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

}  // namespace

double element_limit(const MeshMeasure& measure, const ElementParameters& parameters) {
  const double total = measure.total();
  if (!(total > 0)) throw ItemError(Status::zero_density, "the density is zero everywhere on the surface");
  return total / (parameters.elements_per_sample * static_cast<double>(parameters.samples));
}

void check_count(std::size_t elements, std::size_t most) {
  if (elements > most)
    throw ItemError(Status::too_large, std::to_string(elements) + " curve elements are more than the 2^" +
                                           std::to_string(std::countr_zero(most)) + " that can be numbered");
}

CurveElements elements_from(const ElementSource& source, const SurfaceRegion* region, double limit,
                            const ElementParameters& parameters, const CancelToken& cancel) {
  if (!source.places.any()) {
    PlacedPieces pieces = cut_source(
        source, region, limit,
        [&] {
          return PlacedPieces(source.places, source.key, KeptOfPieces{.vertices = parameters.keep_vertices});
        },
        cancel);
    check_count(pieces.point.size(), most_curve_elements);
    cancel.check();
    return along_space_curve(std::move(pieces), region != nullptr);
  }
  const KeyedPieces pieces = cut_source(
      source, region, limit, [&] { return KeyedPieces(source.places, source.group, source.key, parameters); },
      cancel);
  check_count(pieces.elements.size(), most_curve_elements);
  cancel.check();
  return along_curve(source.surface.mesh(), pieces.elements, parameters.keep_vertices);
}

CurveElements build_elements(const MeasuredMesh& surface, const MeshMeasure& measure, const ChartSet& charts,
                             const TriangleHints& hints, RandomKey key, const ElementParameters& parameters,
                             const CancelToken& cancel) {
  const ElementSource source(surface, measure.density, charts, hints.hits,
                             sheet_groups(surface.mesh(), charts.charts, hints.sheet), parameters.order, key);
  return elements_from(source, nullptr, element_limit(measure, parameters), parameters, cancel);
}

}  // namespace meander
