#include "kernels/remesh/insert_samples.h"

#include <algorithm>
#include <array>
#include <vector>

#include "kernels/flatten/orient2d.h"

namespace meander {

namespace {

// The least distance of a sample from the edges of its triangle, as a weight: half of what float32 resolves.
constexpr double least_weight = 0x1p-25;
constexpr int most_moves = 8;         // of a sample that stands where another one is
constexpr double one_move = 0x1p-22;  // of the way to the centroid
constexpr int flips_per_sample = 64;  // Delaunay flips after one sample, at most
constexpr std::uint32_t samples_between_checks = 1024;

struct Planar {
  double u = 0, v = 0;
};

// The samples of one triangle after the other. Vertices have barycentric coordinates of the triangle that is
// worked on.
class Inserter {
 public:
  Inserter(EditedMesh& mesh, const InsertedSamples& samples)
      : mesh_(mesh),
        samples_(samples),
        originals_(static_cast<std::uint32_t>(mesh.position.size())),
        place_(mesh.position.size() + samples.triangle.size()) {}

  std::uint32_t run(const CancelToken& cancel) {
    const std::size_t count = samples_.triangle.size();
    mesh_.position.reserve(originals_ + count);
    mesh_.out.reserve(originals_ + count);
    for (std::size_t begin = 0; begin < count;) {
      std::size_t end = begin;
      while (end < count && samples_.triangle[end] == samples_.triangle[begin]) ++end;
      insert_all(begin, end, cancel);
      begin = end;
    }
    return coincident_;
  }

 private:
  void insert_all(std::size_t begin, std::size_t end, const CancelToken& cancel) {
    const std::uint32_t t = samples_.triangle[begin];
    const std::size_t h = 3 * std::size_t{t};
    place_[mesh_.vertex[h]] = {0, 0};
    place_[mesh_.vertex[h + 1]] = {1, 0};
    place_[mesh_.vertex[h + 2]] = {0, 1};
    const Vector3 a = mesh_.position[mesh_.vertex[h]];
    first_edge_ = mesh_.position[mesh_.vertex[h + 1]] - a;
    second_edge_ = mesh_.position[mesh_.vertex[h + 2]] - a;
    parts_.assign(1, t);
    std::uint32_t near = t;
    for (std::size_t i = begin; i < end; ++i) {
      if (i % samples_between_checks == 0) cancel.check();
      const std::uint32_t p = mesh_.add_vertex(samples_.position[i]);
      near = find_place(p, {samples_.weights[2 * i], samples_.weights[2 * i + 1]}, near);
      const auto added = static_cast<std::uint32_t>(mesh_.triangle_count());
      mesh_.split_triangle(near, p);
      parts_.insert(parts_.end(), {added, added + 1});
      make_delaunay(p);
      near = mesh_.out[p] / 3;
    }
  }

  double turn(std::uint32_t a, std::uint32_t b, Planar c) const {
    return orient2d(place_[a].u, place_[a].v, place_[b].u, place_[b].v, c.u, c.v);
  }

  static Planar inside(Planar at) {
    at.u = std::clamp(at.u, least_weight, 1 - 2 * least_weight);
    at.v = std::clamp(at.v, least_weight, 1 - 2 * least_weight);
    const double rest = 1 - at.u - at.v;
    if (rest >= least_weight) return at;
    const double scale = (1 - least_weight) / (at.u + at.v);
    return {std::max(least_weight, at.u * scale - least_weight),
            std::max(least_weight, at.v * scale - least_weight)};
  }

  bool is_taken(std::uint32_t t, Planar at) const {
    for (std::size_t k = 0; k < 3; ++k) {
      const Planar corner = place_[mesh_.vertex[3 * std::size_t{t} + k]];
      if (corner.u == at.u && corner.v == at.v) return true;
    }
    return false;
  }

  // The triangle around `at`, which becomes the place of p.
  std::uint32_t find_place(std::uint32_t p, Planar at, std::uint32_t near) {
    at = inside(at);
    std::uint32_t t = locate(at, near);
    for (int move = 0; move < most_moves && is_taken(t, at); ++move) {
      at = inside(
          {at.u + (1. / 3 - at.u) * one_move * (move + 1), at.v + (0.25 - at.v) * one_move * (move + 1)});
      t = locate(at, t);
    }
    coincident_ += is_taken(t, at);
    place_[p] = at;
    return t;
  }

  bool contains(std::uint32_t t, Planar at) const {
    const std::size_t h = 3 * std::size_t{t};
    for (std::size_t k = 0; k < 3; ++k)
      if (turn(mesh_.vertex[h + k], mesh_.vertex[h + (k + 1) % 3], at) < 0) return false;
    return true;
  }

  // Walks through edges that have the place on their other side; if that takes long, looks at all triangles.
  std::uint32_t locate(Planar at, std::uint32_t near) const {
    std::uint32_t t = near;
    for (std::size_t step = 0; step < 16 + parts_.size(); ++step) {
      const std::uint32_t h = 3 * t;
      std::uint32_t next = no_index;
      for (std::uint32_t k = 0; k < 3 && next == no_index; ++k) {
        const std::uint32_t edge = h + (k + static_cast<std::uint32_t>(step)) % 3;
        if (turn(mesh_.start(edge), mesh_.end(edge), at) < 0) next = edge;
      }
      if (next == no_index) return t;
      if (is_outer(next)) break;
      t = mesh_.opposite[next] / 3;
    }
    for (const std::uint32_t part : parts_)
      if (contains(part, at)) return part;
    return near;
  }

  // An edge between two corners of the original triangle is one of its edges.
  bool is_outer(std::uint32_t h) const { return mesh_.start(h) < originals_ && mesh_.end(h) < originals_; }

  Vector3 in_space(Planar at) const { return at.u * first_edge_ + at.v * second_edge_; }

  // Whether the edge of h lies inside the circle of the two angles: their sum is more than pi.
  bool is_illegal(std::uint32_t h) const {
    const auto cotangent = [&](std::uint32_t side) {
      const Vector3 c = in_space(place_[mesh_.apex(side)]);
      const Vector3 a = in_space(place_[mesh_.start(side)]) - c, b = in_space(place_[mesh_.end(side)]) - c;
      return std::array<double, 2>{dot(a, b), norm(cross(a, b))};
    };
    const auto [cos1, sin1] = cotangent(h);
    const auto [cos2, sin2] = cotangent(mesh_.opposite[h]);
    const double sum = cos1 * sin2 + cos2 * sin1;
    return sum < -1e-12 * (std::abs(cos1) + sin1) * (std::abs(cos2) + sin2) || (sin1 == 0 && cos1 < 0);
  }

  bool is_convex(std::uint32_t h) const {
    const std::uint32_t c = mesh_.apex(h), d = mesh_.apex(mesh_.opposite[h]);
    return turn(d, c, place_[mesh_.start(h)]) > 0 && turn(c, d, place_[mesh_.end(h)]) > 0;
  }

  void make_delaunay(std::uint32_t p) {
    stack_.clear();
    mesh_.for_outgoing(p, [&](std::uint32_t h) { stack_.push_back(next_half_edge(h)); });
    for (int flips = 0; !stack_.empty() && flips < flips_per_sample;) {
      const std::uint32_t h = stack_.back();
      stack_.pop_back();
      if (is_outer(h) || !is_illegal(h) || !is_convex(h)) continue;
      mesh_.flip(h);
      ++flips;
      // Both triangles have p now; the edges opposite to it may be wrong.
      for (const std::uint32_t t : {h / 3, mesh_.opposite[previous_half_edge(h)] / 3})
        for (std::uint32_t k = 0; k < 3; ++k)
          if (mesh_.apex(3 * t + k) == p) stack_.push_back(3 * t + k);
    }
  }

  EditedMesh& mesh_;
  const InsertedSamples& samples_;
  const std::uint32_t originals_;
  std::vector<Planar> place_;
  std::vector<std::uint32_t> parts_, stack_;
  Vector3 first_edge_, second_edge_;
  std::uint32_t coincident_ = 0;
};

}  // namespace

std::uint32_t insert_samples(EditedMesh& mesh, const InsertedSamples& samples, const CancelToken& cancel) {
  return Inserter(mesh, samples).run(cancel);
}

}  // namespace meander
