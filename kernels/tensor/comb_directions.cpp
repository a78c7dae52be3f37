#include "kernels/tensor/comb_directions.h"

#include <algorithm>
#include <cmath>

#include "kernels/solve/intrinsic_disk.h"

namespace meander {

namespace {

constexpr std::uint32_t check_every = 1 << 16;  // triangles between checks of the deadline

struct Direction2 {
  double x = 0, y = 0;
};
double dot(Direction2 a, Direction2 b) { return a.x * b.x + a.y * b.y; }

class Comber {
 public:
  Comber(const CutChart& chart, const ChartGeometry& geometry, const UnfoldedTriangles& unfolded,
         const CombParameters& parameters, CombedDirections& result)
      : chart_(chart), geometry_(geometry), unfolded_(unfolded), parameters_(parameters), result_(result) {}

  void read(const TensorField& field) {
    const std::size_t count = chart_.triangle_count();
    result_.x.assign(count, 1);
    result_.y.assign(count, 0);
    result_.first.assign(count, 1);
    result_.second.assign(count, 1);
    result_.inherited.assign(count, 1);
    for (std::uint32_t t = 0; t < count; ++t) {
      if (!geometry_.counts[t]) continue;
      const TensorAxes axes = spacings_of(field.mean(chart_.triangle_begin + t));
      result_.first[t] = axes.first;
      result_.second[t] = axes.second;
      if (axes.first < parameters_.isotropic_ratio * axes.second) continue;
      result_.x[t] = axes.x;
      result_.y[t] = axes.y;
      result_.inherited[t] = 0;
    }
  }

  void comb(const CancelToken& cancel) {
    const std::size_t count = chart_.triangle_count();
    if (count == 0) return;
    // Triangles with a direction of their own come first, in a queue of their own, so that no sign travels
    // through an isotropic region as long as there is a way around it.
    std::vector<std::uint32_t> own, rest;
    std::size_t own_head = 0, rest_head = 0;
    std::vector<std::uint32_t> from(count, no_index);  // half-edge of the triangle that queued it
    std::vector<std::uint8_t> queued(count, 0);
    done_.assign(count, 0);
    order_.clear();
    const auto enqueue = [&](std::uint32_t t, std::uint32_t by) {
      if (queued[t]) return;
      queued[t] = 1;
      from[t] = by;
      (result_.inherited[t] ? rest : own).push_back(t);
    };
    const auto first = std::find(result_.inherited.begin(), result_.inherited.end(), std::uint8_t{0});
    enqueue(
        first == result_.inherited.end() ? 0 : static_cast<std::uint32_t>(first - result_.inherited.begin()),
        no_index);
    for (std::uint32_t steps = 0; own_head < own.size() || rest_head < rest.size(); ++steps) {
      if (steps % check_every == 0) cancel.check();
      const std::uint32_t t = own_head < own.size() ? own[own_head++] : rest[rest_head++];
      if (from[t] != no_index) {
        if (result_.inherited[t])
          inherit(t, from[t]);
        else if (dot(carried(from[t]), direction(t)) < 0)
          set_direction(t, {-result_.x[t], -result_.y[t]});
      }
      done_[t] = 1;
      if (result_.inherited[t]) order_.push_back(t);
      for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h)
        if (chart_.opposite[h] != no_index) enqueue(chart_.opposite[h] / 3, h);
    }
  }

  // Gauss-Seidel on the mean of the neighbors: directions inherited from several sides meet smoothly.
  void smooth(const CancelToken& cancel) {
    for (std::uint32_t sweep = 0; sweep < parameters_.smoothing_sweeps && !order_.empty(); ++sweep) {
      cancel.check();
      for (const std::uint32_t t : order_) take_mean(t);
    }
  }

  void count_faults() {
    std::vector<std::uint8_t> on_boundary(chart_.vertex_count(), 0), odd(chart_.vertex_count(), 0);
    for (std::uint32_t h = 0; h < chart_.opposite.size(); ++h) {
      const std::uint32_t other = chart_.opposite[h];
      const std::uint32_t a = chart_.triangles[h], b = chart_.triangles[next_half_edge(h)];
      if (other == no_index) on_boundary[a] = on_boundary[b] = 1;
      if (other == no_index || other < h || !(dot(carried(h), direction(other / 3)) < 0)) continue;
      ++result_.inconsistent_edges;
      // An edge that ends where it began meets its vertex twice.
      odd[a] ^= 1;
      odd[b] ^= 1;
    }
    for (std::uint32_t w = 0; w < odd.size(); ++w)
      if (odd[w] && !on_boundary[w]) result_.odd_vertices.push_back(w);
  }

 private:
  Direction2 direction(std::uint32_t t) const { return {result_.x[t], result_.y[t]}; }
  void set_direction(std::uint32_t t, Direction2 e) {
    result_.x[t] = e.x;
    result_.y[t] = e.y;
  }

  // Carries e1 of the triangle of half-edge h into the frame of the triangle on the other side, the two
  // unfolded: angles to the common edge stay, and the edge runs the other way there.
  Direction2 carried(std::uint32_t h) const {
    const std::uint32_t o = chart_.opposite[h];
    const double ax = unfolded_.x[h], ay = unfolded_.y[h], bx = -unfolded_.x[o], by = -unfolded_.y[o];
    const double cosine = ax * bx + ay * by, sine = ax * by - ay * bx;
    const double length = std::sqrt(cosine * cosine + sine * sine);
    const Direction2 e = direction(h / 3);
    if (!(length > 0)) return e;
    return {(cosine * e.x - sine * e.y) / length, (sine * e.x + cosine * e.y) / length};
  }

  // Takes the mean direction of the neighbors that have one, weighted by edge length. False where it
  // vanishes.
  bool take_mean(std::uint32_t t) {
    Direction2 sum;
    double total = 0;
    for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
      const std::uint32_t o = chart_.opposite[h];
      if (o == no_index || !done_[o / 3]) continue;
      const Direction2 e = carried(o);
      const double length = geometry_.length[h];
      sum = {sum.x + length * e.x, sum.y + length * e.y};
      total += length;
    }
    const double size = std::sqrt(dot(sum, sum));
    if (!(size > 1e-3 * total)) return false;
    set_direction(t, {sum.x / size, sum.y / size});
    return true;
  }

  void inherit(std::uint32_t t, std::uint32_t by) {
    if (!take_mean(t)) set_direction(t, carried(by));
    if (geometry_.counts[t]) return;
    result_.first[t] = result_.first[by / 3];
    result_.second[t] = result_.second[by / 3];
  }

  const CutChart& chart_;
  const ChartGeometry& geometry_;
  const UnfoldedTriangles& unfolded_;
  const CombParameters& parameters_;
  CombedDirections& result_;
  std::vector<std::uint8_t> done_;
  std::vector<std::uint32_t> order_;  // inherited triangles in the order of the search
};

}  // namespace

UnfoldedTriangles unfold_triangles(const ChartGeometry& geometry) {
  UnfoldedTriangles unfolded;
  const std::size_t count = geometry.counts.size();
  unfolded.x.assign(3 * count, 0);
  unfolded.y.assign(3 * count, 0);
  for (std::size_t t = 0; t < count; ++t) {
    const double* l = &geometry.length[3 * t];
    std::size_t base = 0;
    if (!geometry.counts[t]) base = static_cast<std::size_t>(std::max_element(l, l + 3) - l);
    const std::size_t second = (base + 1) % 3, third = (base + 2) % 3;
    const double a = l[base], b = l[second], c = l[third];
    if (!(a > 0)) continue;  // a point
    // The corner off the base, seen from the start of the base.
    const double x = 0.5 * (a + (c - b) * (c + b) / a);
    const double y = 2 * area_from_lengths(a, b, c) / a;
    double* ex = &unfolded.x[3 * t];
    double* ey = &unfolded.y[3 * t];
    ex[base] = a;
    ex[second] = x - a;
    ey[second] = y;
    ex[third] = -x;
    ey[third] = -y;
  }
  return unfolded;
}

CombedDirections comb_directions(const CutChart& chart, const ChartGeometry& geometry,
                                 const UnfoldedTriangles& unfolded, const TensorField& field,
                                 const CombParameters& parameters, const CancelToken& cancel) {
  CombedDirections result;
  Comber comber(chart, geometry, unfolded, parameters, result);
  comber.read(field);
  comber.comb(cancel);
  comber.smooth(cancel);
  comber.count_faults();
  return result;
}

CombedDirections comb_directions(const PreparedMesh& mesh, const CutChart& chart, const TensorField& field,
                                 const CombParameters& parameters, const CancelToken& cancel) {
  const ChartGeometry geometry = chart_geometry(mesh, chart);
  return comb_directions(chart, geometry, unfold_triangles(geometry), field, parameters, cancel);
}

}  // namespace meander
