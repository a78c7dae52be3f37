#include "kernels/remesh/attach_samples.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "kernels/core/portable_angles.h"
#include "kernels/remesh/delaunay_flips.h"
#include "kernels/remesh/link_condition.h"

namespace meander {

namespace {

constexpr double least_turn = 0.9;  // cosine between a normal around a sample before and after
constexpr std::uint32_t flips_around = 32;

class Attacher {
 public:
  Attacher(EditedMesh& mesh, std::uint32_t first, std::uint32_t last, std::span<std::uint32_t> moved_to,
           const AttachParameters& parameters)
      : mesh_(mesh),
        first_(first),
        last_(last),
        moved_to_(moved_to),
        parameters_(parameters),
        small_(direction_of(parameters.small_angle * std::numbers::pi / 180).cosine) {}

  double run() {
    for (std::uint32_t s = first_; s < last_; ++s) {
      look_around(s);
      if (on_line_ || worst_ <= small_) continue;
      if (take_vertex(s) || move_to_edge(s)) settle(s);
    }
    return largest_;
  }

 private:
  Vector3 at(std::uint32_t v) const { return mesh_.position[v]; }
  Vector3 corner(std::uint32_t h) const { return at(mesh_.start(h)); }

  double angle_of(std::uint32_t t) const {
    return least_angle_cosine(corner(3 * t), corner(3 * t + 1), corner(3 * t + 2));
  }

  void look_around(std::uint32_t s) {
    on_line_ = false;
    mean_edge_ = worst_ = 0;
    double count = 0;
    spokes_.clear();
    mesh_.for_neighbors(s, [&](std::uint32_t w, std::uint32_t h) {
      on_line_ = on_line_ || mesh_.is_line(h);
      mean_edge_ += distance(at(s), at(w));
      ++count;
    });
    mesh_.for_outgoing(s, [&](std::uint32_t h) {
      spokes_.push_back(h);
      worst_ = std::max(worst_, angle_of(h / 3));
    });
    mean_edge_ /= count;
  }

  // Whether the triangles around s, but those with both of these vertices, which go, stay upright with s at
  // that place, and have larger least angles than the worst one now.
  bool is_better_at(std::uint32_t s, Vector3 place, std::uint32_t without_first,
                    std::uint32_t without_second) const {
    for (const std::uint32_t h : spokes_) {
      const std::uint32_t b = mesh_.end(h), c = mesh_.apex(h);
      const bool first = b == without_first || c == without_first;
      const bool second = b == without_second || c == without_second;
      if (first && second) continue;
      const Vector3 before = cross(at(b) - at(s), at(c) - at(s)), after = cross(at(b) - place, at(c) - place);
      if (!(dot(before, after) > least_turn * norm(before) * norm(after))) return false;
      if (least_angle_cosine(place, at(b), at(c)) >= worst_) return false;
    }
    return true;
  }

  void moved(std::uint32_t s, Vector3 place) {
    largest_ = std::max(largest_, distance(at(s), place) / mean_edge_);
    mesh_.position[s] = place;
  }

  bool take_vertex(std::uint32_t s) {
    std::uint32_t nearest = no_index;
    double least = parameters_.largest_shift * mean_edge_;
    for (const std::uint32_t h : spokes_) {
      const std::uint32_t v = mesh_.end(h);
      if ((v >= first_ && v < last_) || distance(at(s), at(v)) > least) continue;
      bool is_on_line = false;
      mesh_.for_neighbors(v, [&](std::uint32_t, std::uint32_t e) {
        is_on_line = is_on_line || mesh_.is_crease_or_boundary(e);
      });
      if (!is_on_line) continue;
      nearest = h;
      least = distance(at(s), at(v));
    }
    if (nearest == no_index) return false;
    const std::uint32_t v = mesh_.end(nearest);
    const Vector3 place = at(v);
    if (!is_better_at(s, place, v, v)) return false;
    if (!link_.holds(mesh_, nearest, v)) return false;
    moved(s, place);
    mesh_.collapse(nearest, v);
    if (v < moved_to_.size()) moved_to_[v] = s;
    return true;
  }

  bool move_to_edge(std::uint32_t s) {
    std::uint32_t line = no_index;
    double least = parameters_.largest_shift * mean_edge_;
    Vector3 place;
    for (const std::uint32_t spoke : spokes_) {
      const std::uint32_t h = next_half_edge(spoke);
      if (!mesh_.is_crease_or_boundary(h)) continue;
      const Vector3 a = at(mesh_.start(h)), u = at(mesh_.end(h)) - a;
      const double squared = dot(u, u), part = squared > 0 ? dot(u, at(s) - a) / squared : 0;
      if (!(part > 0) || part >= 1) continue;
      const Vector3 foot = a + part * u;
      if (distance(foot, at(s)) > least) continue;
      line = h;
      least = distance(foot, at(s));
      place = foot;
    }
    if (line == no_index) return false;
    const std::uint32_t a = mesh_.start(line), b = mesh_.end(line), g = mesh_.opposite[line];
    if (!is_better_at(s, place, a, b)) return false;
    if (g == no_index) {
      moved(s, place);
      mesh_.remove_at_boundary(line);
      return true;
    }
    const Vector3 before = at(s);
    const std::uint32_t d = mesh_.apex(g), other = mesh_.opposite[next_half_edge(line)],
                        another = mesh_.opposite[previous_half_edge(line)];
    if (std::max(least_angle_cosine(at(d), at(b), place), least_angle_cosine(at(d), place, at(a))) >= worst_)
      return false;
    const std::uint8_t mark = mesh_.crease[line];
    mesh_.crease[line] = mesh_.crease[g] = 0;
    mesh_.position[s] = place;
    const bool possible = can_flip(mesh_, line);
    mesh_.position[s] = before;
    if (!possible) {
      mesh_.crease[line] = mesh_.crease[g] = mark;
      return false;
    }
    for (const std::uint32_t h : {next_half_edge(line), previous_half_edge(line), other, another})
      mesh_.crease[h] |= mark;
    moved(s, place);
    mesh_.flip(line);
    return true;
  }

  void settle(std::uint32_t s) {
    edges_.clear();
    mesh_.for_outgoing(s, [&](std::uint32_t h) { edges_.insert(edges_.end(), {h, next_half_edge(h)}); });
    flip_to_delaunay(mesh_, edges_, flips_around);
  }

  EditedMesh& mesh_;
  const std::uint32_t first_, last_;
  const std::span<std::uint32_t> moved_to_;
  const AttachParameters& parameters_;
  const double small_;  // cosine
  LinkCondition link_;
  std::vector<std::uint32_t> spokes_, edges_;
  double mean_edge_ = 0, worst_ = 0, largest_ = 0;
  bool on_line_ = false;
};

}  // namespace

double attach_samples(EditedMesh& mesh, std::uint32_t first, std::uint32_t last,
                      std::span<std::uint32_t> moved_to, const AttachParameters& parameters) {
  return Attacher(mesh, first, last, moved_to, parameters).run();
}

}  // namespace meander
