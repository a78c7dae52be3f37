#include "kernels/mesh/coarsen_mesh.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <utility>

#include "kernels/core/parallel.h"

namespace meander {

namespace {

// A component with fewer fine triangles to a coarse one is copied.
constexpr double worthwhile = 1.5;
// Neighbors of a vertex that is removed.
constexpr std::uint32_t max_neighbors = 24;
// Neighbors of the vertex that it is moved to.
constexpr std::uint32_t max_star = 64;
// With fewer triangles, a closed surface may fold onto itself.
constexpr std::uint32_t min_left = 16;
// Each round removes a 32nd of the vertices or is the last.
constexpr std::uint32_t max_rounds = 64;
// The height over longest edge that new triangles keep. It is halved down to the second bound where it leaves
// a round too few vertices to remove.
constexpr double thinnest = 0.25;
constexpr double thinnest_to_halve = 0.06;
// The cosine of the largest angle between old and new normals.
constexpr double largest_turn = 0.5;
// The mean weight of the vertices that are left over the maximum weight, measured.
constexpr double filling = 0.7;
// Coarse triangles that are tried for the one under a fine triangle.
constexpr int longest_walk = 8;

using NeighborIndex = std::uint32_t;
template <class Value>
using ByNeighbor = std::array<Value, max_neighbors + 2>;

// The neighborhood of a vertex v, counter-clockwise: edge[i] is the half-edge from v to ring[i], and triangle
// i lies between ring[i] and the next. On the boundary there is one triangle less than neighbors. Inside, the
// coordinates of the ring end with those of ring[0] again.
struct Star {
  std::uint32_t vertex = no_index;
  bool inside = false;
  NeighborIndex neighbors = 0, triangles = 0;
  ByNeighbor<std::uint32_t> edge, ring;
  ByNeighbor<double> x, y, z;                       // of the ring, relative to v
  ByNeighbor<double> squared_length;                // of the edges
  ByNeighbor<double> squared_far;                   // of the side of a triangle opposite to v
  ByNeighbor<double> normal_x, normal_y, normal_z;  // of the triangles, twice as long as their area
  ByNeighbor<double> squared_normal;
  ByNeighbor<double> shape;  // (height / longest edge)^2 that a triangle must keep

  NeighborIndex after(NeighborIndex i) const { return i + 1 < neighbors ? i + 1 : 0; }
  // The triangle before neighbor k; `triangles` where there is none.
  NeighborIndex before(NeighborIndex k) const { return k > 0 ? k - 1 : inside ? triangles - 1 : triangles; }
};

double longest_of(double a, double b, double c) { return std::max({a, b, c}); }

// One component while vertices are removed from it. Triangles, half-edges and vertices have local numbers.
class Coarsener {
 public:
  Coarsener(const PreparedMesh& mesh, const Component& component, std::span<const double> weights)
      : mesh_(mesh),
        first_vertex_(component.vertex_begin),
        leaving_(component.vertex_end - component.vertex_begin, no_index),
        weight_(leaving_.size(), 0),
        mark_(leaving_.size(), 0),
        changed_(leaving_.size(), 0),
        refused_(leaving_.size(), 0),
        host_(component.triangle_end - component.triangle_begin),
        left_(component.triangle_end - component.triangle_begin) {
    const std::uint32_t first_half_edge = 3 * component.triangle_begin;
    corner_.resize(3 * host_.size());
    opposite_.resize(corner_.size());
    for (std::uint32_t h = 0; h < corner_.size(); ++h) {
      const std::uint32_t v = corner_[h] = mesh.triangles[first_half_edge + h] - first_vertex_;
      const std::uint32_t other = mesh.opposite[first_half_edge + h];
      opposite_[h] = other == no_index ? no_index : other - first_half_edge;
      // A boundary fan starts at its boundary half-edge.
      if (leaving_[v] == no_index || other == no_index) leaving_[v] = h;
      weight_[v] += (1.0 / 3) * weights[h / 3];
    }
    std::iota(host_.begin(), host_.end(), 0u);
  }

  // Removes vertices as long as none stands for more than `heaviest`.
  void run(double heaviest, const CancelToken& cancel) {
    heaviest_ = heaviest;
    const double wanted =
        2 * std::accumulate(weight_.begin(), weight_.end(), 0.0) / (filling * heaviest);  // triangles
    std::vector<std::uint32_t> candidates(leaving_.size());
    std::iota(candidates.begin(), candidates.end(), 0u);
    for (round_ = 1; round_ <= max_rounds; ++round_) {
      cancel.check();
      const std::size_t before = candidates.size();
      std::size_t removed = 0, kept = 0;
      for (const std::uint32_t v : candidates) {
        if (!(weight_[v] < heaviest_)) continue;
        // Neighbors of a vertex that was removed in this round wait for the next one. A vertex that was
        // refused is tried again once its star has changed.
        if (changed_[v] != round_ && refused_[v] <= changed_[v]) {
          if (remove(v)) {
            ++removed;
            continue;
          }
          refused_[v] = static_cast<std::uint8_t>(round_);
        }
        candidates[kept++] = v;
      }
      candidates.resize(kept);
      if (16 * removed < before && left_ > 16 * wanted && thinnest_ > thinnest_to_halve) {
        // A fine regular grid: most of its vertices can be moved only with a triangle that becomes thin.
        thinnest_ *= 0.5;
        std::fill(refused_.begin(), refused_.end(), std::uint8_t{0});
        continue;
      }
      if (32 * removed < before) break;
    }
  }

  std::uint32_t triangle_count() const { return static_cast<std::uint32_t>(host_.size()); }
  bool is_left(std::uint32_t t) const { return host_[t] == t; }
  std::uint32_t corner(std::uint32_t h) const { return corner_[h]; }
  std::uint32_t opposite(std::uint32_t h) const { return opposite_[h]; }
  // The triangle that covers about where t was.
  std::uint32_t host(std::uint32_t t) {
    std::uint32_t last = t;
    while (host_[last] != last) last = host_[last];
    while (host_[t] != last) t = std::exchange(host_[t], last);
    return last;
  }

 private:
  Vector3 position(std::uint32_t v) const { return mesh_.position(first_vertex_ + v); }

  // Moves v along the shortest of its edges that is allowed.
  bool remove(std::uint32_t v) {
    Star& star = star_;
    if (left_ < min_left || !gather(v, star)) return false;
    ByNeighbor<NeighborIndex> choice;
    NeighborIndex choices = 0;
    for (NeighborIndex i = 0; i < star.neighbors; ++i) {
      const bool along = star.inside || i == 0 || i + 1 == star.neighbors;
      if (along && weight_[v] + weight_[star.ring[i]] <= heaviest_) choice[choices++] = i;
    }
    if (choices == 0) return false;
    measure(star);
    ++stamp_;
    for (NeighborIndex i = 0; i < star.neighbors; ++i) mark_[star.ring[i]] = stamp_;
    while (choices > 0) {
      NeighborIndex* const shortest = std::min_element(
          choice.data(), choice.data() + choices,
          [&](NeighborIndex a, NeighborIndex b) { return star.squared_length[a] < star.squared_length[b]; });
      const NeighborIndex to = *shortest;
      if (keeps_shape(star, to) && keeps_topology(star, to)) {
        collapse(star, to);
        return true;
      }
      std::copy(shortest + 1, choice.data() + choices, shortest);
      --choices;
    }
    return false;
  }

  // Returns false where there are too many neighbors or too few triangles.
  bool gather(std::uint32_t v, Star& star) const {
    const std::uint32_t first = leaving_[v];
    star.vertex = v;
    star.inside = opposite_[first] != no_index;
    star.triangles = 0;
    std::uint32_t h = first;
    do {
      if (star.triangles == max_neighbors) return false;
      star.edge[star.triangles] = h;
      star.ring[star.triangles++] = corner_[next_half_edge(h)];
      h = opposite_[previous_half_edge(h)];
    } while (h != first && h != no_index);
    star.neighbors = star.triangles;
    if (!star.inside)
      star.ring[star.neighbors++] = corner_[previous_half_edge(star.edge[star.triangles - 1])];
    const Vector3 center = position(v);
    for (NeighborIndex i = 0; i < star.neighbors; ++i) {
      const Vector3 to = position(star.ring[i]) - center;
      star.x[i] = to.x;
      star.y[i] = to.y;
      star.z[i] = to.z;
      star.squared_length[i] = dot(to, to);
    }
    if (star.inside) {
      star.x[star.neighbors] = star.x[0];
      star.y[star.neighbors] = star.y[0];
      star.z[star.neighbors] = star.z[0];
      star.squared_length[star.neighbors] = star.squared_length[0];
    }
    return star.triangles >= (star.inside ? 3u : 2u);
  }

  void measure(Star& star) const {
    for (NeighborIndex i = 0; i < star.triangles; ++i) {
      const Vector3 a{star.x[i], star.y[i], star.z[i]}, b{star.x[i + 1], star.y[i + 1], star.z[i + 1]};
      const Vector3 far = b - a, normal = cross(a, b);
      star.normal_x[i] = normal.x;
      star.normal_y[i] = normal.y;
      star.normal_z[i] = normal.z;
      star.squared_normal[i] = dot(normal, normal);
      star.squared_far[i] = dot(far, far);
      const double longest =
          longest_of(star.squared_length[i], star.squared_length[i + 1], star.squared_far[i]);
      // A triangle that is thin already may stay so.
      star.shape[i] = std::min(thinnest_ * thinnest_, star.squared_normal[i] / (longest * longest));
    }
  }

  // Whether the triangles that remain are neither thin nor turned, with the vertex at neighbor k.
  static bool keeps_shape(const Star& star, NeighborIndex k) {
    const Vector3 to{star.x[k], star.y[k], star.z[k]};
    const NeighborIndex before_k = star.before(k);
    Vector3 a{star.x[0] - to.x, star.y[0] - to.y, star.z[0] - to.z};
    double squared_a = dot(a, a);
    for (NeighborIndex i = 0; i < star.triangles; ++i) {
      const Vector3 b{star.x[i + 1] - to.x, star.y[i + 1] - to.y, star.z[i + 1] - to.z};
      const double squared_b = dot(b, b);
      if (i != k && i != before_k) {
        const Vector3 normal = cross(a, b);
        const double longest = longest_of(squared_a, squared_b, star.squared_far[i]),
                     size = dot(normal, normal);
        if (!(size > 0 && size >= star.shape[i] * longest * longest)) return false;
        const double before = star.squared_normal[i], turn = normal.x * star.normal_x[i] +
                                                             normal.y * star.normal_y[i] +
                                                             normal.z * star.normal_z[i];
        if (before > 0 && !(turn > 0 && turn * turn > largest_turn * largest_turn * before * size))
          return false;
      }
      a = b;
      squared_a = squared_b;
    }
    return true;
  }

  // The link condition (Dey et al. 1999): the ends of the edge share no neighbors but the third corners of
  // the triangles beside it. `mark_` marks the ring.
  bool keeps_topology(const Star& star, NeighborIndex k) const {
    const std::uint32_t first = leaving_[star.ring[k]];
    std::uint32_t shared = 0, steps = 0, h = first;
    do {
      if (++steps > max_star) return false;
      shared += mark_[corner_[next_half_edge(h)]] == stamp_ ? 1 : 0;
      const std::uint32_t back = previous_half_edge(h);
      h = opposite_[back];
      if (h == no_index) shared += mark_[corner_[back]] == stamp_ ? 1 : 0;
    } while (h != first && h != no_index);
    return shared == (star.inside ? 2u : 1u);
  }

  void glue(std::uint32_t h, std::uint32_t other) {
    opposite_[h] = other;
    if (other != no_index) opposite_[other] = h;
  }

  // Puts the vertex v of the star at its neighbor w = ring[k]. The triangles on both sides of the edge
  // vanish, and the triangles around them are glued together.
  void collapse(const Star& star, NeighborIndex k) {
    const std::uint32_t w = star.ring[k];
    const NeighborIndex triangles = star.triangles;
    for (NeighborIndex i = 0; i < triangles; ++i) corner_[star.edge[i]] = w;
    if (k < triangles) {  // (v, w, s) after the edge; `heir` ran from v to s
      const std::uint32_t gone = star.edge[k], heir = star.edge[star.after(k)], outer = next_half_edge(gone);
      const std::uint32_t s = corner_[previous_half_edge(gone)];
      if (leaving_[w] == outer) leaving_[w] = heir;
      if (leaving_[s] == previous_half_edge(gone)) leaving_[s] = next_half_edge(heir);
      glue(heir, opposite_[outer]);
      host_[gone / 3] = heir / 3;
      --left_;
    }
    if (k > 0 || star.inside) {  // (v, s, w) before it; `heir` ran from s to v
      const NeighborIndex before = k > 0 ? k - 1 : triangles - 1;
      const std::uint32_t gone = star.edge[before], outer = next_half_edge(gone), s = corner_[outer];
      const std::uint32_t beside = star.edge[before > 0 ? before - 1 : triangles - 1];
      const std::uint32_t heir = previous_half_edge(beside);
      if (leaving_[w] == previous_half_edge(gone)) leaving_[w] = star.inside ? beside : star.edge[0];
      if (leaving_[s] == outer) leaving_[s] = heir;
      glue(heir, opposite_[outer]);
      host_[gone / 3] = heir / 3;
      --left_;
    }
    weight_[w] += weight_[star.vertex];
    for (NeighborIndex i = 0; i < star.neighbors; ++i)
      changed_[star.ring[i]] = static_cast<std::uint8_t>(round_);
  }

  const PreparedMesh& mesh_;
  std::uint32_t first_vertex_;
  std::vector<std::uint32_t> corner_, opposite_;  // by half-edge
  std::vector<std::uint32_t> leaving_;            // by vertex: a half-edge from it, at the boundary the first
  std::vector<double> weight_;                    // by vertex: the part of the surface that it stands for
  std::vector<std::uint32_t> mark_;               // by vertex
  std::vector<std::uint8_t> changed_, refused_;   // by vertex: the rounds of its last change and refusal
  std::vector<std::uint32_t> host_;               // by triangle: itself, or the one it vanished into
  // The star of the current vertex, kept because clearing a new one each time takes a tenth of the time.
  Star star_;
  double heaviest_ = 0, thinnest_ = thinnest;
  std::uint32_t left_, stamp_ = 0, round_ = 0;
};

// A component with its own numbering of triangles and vertices.
struct CoarseComponent {
  std::vector<std::uint32_t> triangles, opposite;
  std::vector<std::uint32_t> vertex;  // working vertices of the fine mesh
  std::vector<std::uint32_t> under;   // by fine triangle: a coarse one near it
};

CoarseComponent copy_component(const PreparedMesh& mesh, const Component& fine) {
  CoarseComponent copy;
  for (std::uint32_t h = 3 * fine.triangle_begin; h < 3 * fine.triangle_end; ++h) {
    const std::uint32_t other = mesh.opposite[h];
    copy.triangles.push_back(mesh.triangles[h] - fine.vertex_begin);
    copy.opposite.push_back(other == no_index ? no_index : other - 3 * fine.triangle_begin);
  }
  copy.vertex.resize(fine.vertex_end - fine.vertex_begin);
  std::iota(copy.vertex.begin(), copy.vertex.end(), fine.vertex_begin);
  copy.under.resize(fine.triangle_end - fine.triangle_begin);
  std::iota(copy.under.begin(), copy.under.end(), 0u);
  return copy;
}

CoarseComponent coarsen_component(const PreparedMesh& mesh, const Component& fine,
                                  std::span<const double> weights, double heaviest,
                                  const CancelToken& cancel) {
  Coarsener work(mesh, fine, weights);
  work.run(heaviest, cancel);
  CoarseComponent coarse;
  const std::uint32_t triangles = work.triangle_count();
  std::vector<std::uint32_t> number(triangles, no_index);
  std::vector<std::uint32_t> vertex_number(fine.vertex_end - fine.vertex_begin, no_index);
  std::uint32_t left = 0;
  for (std::uint32_t t = 0; t < triangles; ++t) {
    if (!work.is_left(t)) continue;
    number[t] = left++;
    for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) vertex_number[work.corner(h)] = 0;
  }
  for (std::uint32_t v = 0; v < vertex_number.size(); ++v) {
    if (vertex_number[v] == no_index) continue;
    vertex_number[v] = static_cast<std::uint32_t>(coarse.vertex.size());
    coarse.vertex.push_back(fine.vertex_begin + v);
  }
  for (std::uint32_t h = 0; h < 3 * triangles; ++h) {
    if (!work.is_left(h / 3)) continue;
    const std::uint32_t other = work.opposite(h);
    coarse.triangles.push_back(vertex_number[work.corner(h)]);
    coarse.opposite.push_back(other == no_index ? no_index : 3 * number[other / 3] + other % 3);
  }
  coarse.under.resize(triangles);
  for (std::uint32_t t = 0; t < triangles; ++t) coarse.under[t] = number[work.host(t)];
  return coarse;
}

// Adds the next component to the coarse mesh.
void append(const PreparedMesh& mesh, const Component& fine, const CoarseComponent& part, CoarseMesh& to) {
  PreparedMesh& coarse = to.mesh;
  Component component = fine;
  component.triangle_begin = static_cast<std::uint32_t>(coarse.area.size());
  component.vertex_begin = static_cast<std::uint32_t>(coarse.x.size());
  for (const std::uint32_t v : part.vertex) {
    coarse.x.push_back(mesh.x[v]);
    coarse.y.push_back(mesh.y[v]);
    coarse.z.push_back(mesh.z[v]);
  }
  for (const std::uint32_t v : part.triangles) coarse.triangles.push_back(component.vertex_begin + v);
  for (const std::uint32_t h : part.opposite)
    coarse.opposite.push_back(h == no_index ? no_index : 3 * component.triangle_begin + h);
  component.area = 0;
  for (std::size_t h = 3 * std::size_t{component.triangle_begin}; h < coarse.triangles.size(); h += 3) {
    coarse.area.push_back(triangle_area(coarse.position(coarse.triangles[h]),
                                        coarse.position(coarse.triangles[h + 1]),
                                        coarse.position(coarse.triangles[h + 2])));
    component.area += coarse.area.back();
  }
  component.triangle_end = static_cast<std::uint32_t>(coarse.area.size());
  component.vertex_end = static_cast<std::uint32_t>(coarse.x.size());
  coarse.components.push_back(component);
  for (const std::uint32_t t : part.under) to.triangle.push_back(component.triangle_begin + t);
}

// Walks from the triangle near each fine one to the one under its centroid: over the edge beyond which the
// centroid lies farthest, as long as it lies outside. Keeps the triangle that it lies outside of by the
// smallest share of its size.
void walk_under(const PreparedMesh& mesh, CoarseMesh& coarse, const CancelToken& cancel) {
  std::vector<PlaneWeights> weights(coarse.mesh.triangle_count());
  for (std::size_t t = 0; t < weights.size(); ++t) weights[t] = plane_weights(coarse.mesh, t);
  parallel_blocks(coarse.triangle.size(), sum_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    for (std::size_t t = begin; t < end; ++t) {
      const Vector3 centroid = mesh.centroid(t);
      std::uint32_t at = coarse.triangle[t];
      double closest = -std::numeric_limits<double>::infinity();
      for (int step = 0; step < longest_walk; ++step) {
        const PlaneWeights& plane = weights[at];
        const Vector3 p = centroid - plane.origin;
        const double b1 = dot(plane.first, p), b2 = dot(plane.second, p), b0 = 1 - b1 - b2;
        const double smallest = std::min({b0, b1, b2});
        if (smallest > closest) {
          closest = smallest;
          coarse.triangle[t] = at;
        }
        if (smallest >= 0) break;
        const std::uint32_t side = smallest == b0 ? 1 : smallest == b1 ? 2 : 0;
        const std::uint32_t other = coarse.mesh.opposite[3 * at + side];
        if (other == no_index) break;
        at = other / 3;
      }
    }
  });
}

}  // namespace

PlaneWeights plane_weights(const PreparedMesh& mesh, std::size_t triangle) {
  constexpr double smallest = 1e-200;  // squared; double does not resolve the plane of smaller triangles
  const std::uint32_t* const corner = &mesh.triangles[3 * triangle];
  const Vector3 origin = mesh.position(corner[0]);
  const Vector3 a = mesh.position(corner[1]) - origin, b = mesh.position(corner[2]) - origin;
  const Vector3 normal = cross(a, b);
  const double squared = dot(normal, normal), inverse = squared > smallest ? 1 / squared : 0;
  return {origin, inverse * cross(b, normal), inverse * cross(normal, a)};
}

CoarseMesh coarsen_mesh(const PreparedMesh& mesh, std::span<const double> masses, std::uint64_t samples,
                        const CoarsenParameters& parameters, const CancelToken& cancel) {
  CoarseMesh result;
  const double total = blocked_sum(masses);
  if (!(total > 0)) return result;
  const double in_all = std::max(parameters.triangles_per_sample * static_cast<double>(samples),
                                 static_cast<double>(parameters.min_triangles));
  const double min_of_component = parameters.min_of_component;
  const auto triangles_of = [](const Component& c) { return std::size_t{c.triangle_end} - c.triangle_begin; };
  const auto is_large = [&](const Component& c, double wanted) {
    return c.area > 0 && static_cast<double>(triangles_of(c)) > worthwhile * wanted;
  };
  if (!(static_cast<double>(mesh.triangle_count()) > worthwhile * in_all) ||
      std::none_of(mesh.components.begin(), mesh.components.end(),
                   [&](const Component& c) { return is_large(c, min_of_component); }))
    return result;

  std::vector<double> weights(mesh.triangle_count());
  for (std::size_t t = 0; t < weights.size(); ++t)
    weights[t] = 0.5 * (masses[t] / total + mesh.area[t] / mesh.total_area);
  std::vector<CoarseComponent> parts(mesh.components.size());
  parallel_tasks(parts.size(), [&](std::size_t c) {
    const Component& component = mesh.components[c];
    const auto own = std::span(weights).subspan(component.triangle_begin, triangles_of(component));
    const double weight = blocked_sum(own), wanted = std::max(in_all * weight, min_of_component);
    parts[c] = is_large(component, wanted)
                   ? coarsen_component(mesh, component, own, 2 * weight / (filling * wanted), cancel)
                   : copy_component(mesh, component);
  });
  weights = std::vector<double>();

  result.mesh.center = mesh.center;
  result.mesh.unit = mesh.unit;
  result.mesh.diagonal = mesh.diagonal;
  result.triangle.reserve(mesh.triangle_count());
  for (std::size_t c = 0; c < parts.size(); ++c) {
    append(mesh, mesh.components[c], parts[c], result);
    parts[c] = {};
  }
  result.mesh.polygon.assign(result.mesh.area.size(), 0);
  if (result.mesh.triangle_count() == mesh.triangle_count()) return {};
  result.mesh.total_area = blocked_sum(result.mesh.area);
  walk_under(mesh, result, cancel);
  result.masses.assign(result.mesh.triangle_count(), 0);
  for (std::size_t t = 0; t < masses.size(); ++t) result.masses[result.triangle[t]] += masses[t];
  return result;
}

}  // namespace meander
