#include "kernels/remesh/remove_vertices.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>
#include <vector>

#include "kernels/remesh/delaunay_flips.h"
#include "kernels/remesh/link_condition.h"

namespace meander {

namespace {

// What a removal must keep to, in the order in which it is tried.
struct Level {
  double least_turn;           // cosine between the old and the new normal of a triangle
  double least_shape;          // 4 sqrt(3) area / sum of squared edges
  std::uint32_t most_valence;  // of the vertex that goes
  int rounds;
};
constexpr std::array<Level, 4> levels = {
    {{0.8, 0.1, 10, 48}, {0.5, 0.02, 16, 24}, {0.1, 0.001, 64, 12}, {-2, -1.5, 1u << 20, 12}}};
constexpr double worthwhile_round = 0.01;  // of the vertices left: with fewer removed, the next level
constexpr double least_straight = 0.7;     // cosine of the largest turn of a line that is no corner
constexpr std::size_t most_targets = 24;   // neighbors looked at, the nearest first
constexpr std::uint32_t flips_per_neighbor = 4, vertices_between_checks = 512;
constexpr std::uint32_t most_freed = 64;     // neighbors of a vertex that flips are to free
constexpr std::uint32_t most_flipped = 256;  // neighbors of one that takes another: all may flip

class Remover {
 public:
  Remover(EditedMesh& mesh, std::span<const double> spacing, const LineParameters& lines,
          const CancelToken& cancel)
      : mesh_(mesh),
        spacing_(spacing),
        lines_(lines),
        cancel_(cancel),
        drift_(spacing.size(), 0),
        moved_to_(spacing.size()),
        locked_(mesh.position.size(), 0) {
    std::iota(moved_to_.begin(), moved_to_.end(), std::uint32_t{0});
  }

  std::vector<std::uint32_t> run(std::span<const std::uint8_t> kept) {
    std::vector<std::uint32_t> waiting;
    for (std::uint32_t v = 0; v < spacing_.size(); ++v)
      if (kept.empty() || kept[v] == 0) waiting.push_back(v);
    for (const Level& level : levels) {
      level_ = level;
      for (int round = 0; round < level.rounds && !waiting.empty(); ++round) {
        const std::size_t before = waiting.size();
        remove_round(waiting);
        if (static_cast<double>(before - waiting.size()) < worthwhile_round * static_cast<double>(before))
          break;
      }
    }
    for (const auto may_flip : {can_flip, can_flip_in_topology})
      for (const std::uint32_t v : waiting) free_by_flips(v, may_flip);
    return std::move(moved_to_);
  }

 private:
  struct Target {
    std::uint32_t edge = no_index;  // of the edge to it
    std::uint32_t vertex = no_index;
    double length = 0, shape = 0, drift = 0;
    std::uint32_t other_end = no_index;  // the other neighbor on the line
  };

  void remove_round(std::vector<std::uint32_t>& waiting) {
    ++round_;
    std::size_t left = 0;
    for (std::size_t i = 0; i < waiting.size(); ++i) {
      if (i % vertices_between_checks == 0) cancel_.check();
      const std::uint32_t v = waiting[i];
      if (locked_[v] == round_ || !try_remove(v)) waiting[left++] = v;
    }
    waiting.resize(left);
  }

  Vector3 at(std::uint32_t v) const { return mesh_.position[v]; }

  // The triangles around v: edges that start there, neighbors, and those among them that lines lead to.
  void look_around(std::uint32_t v) {
    corners_.clear();
    targets_.clear();
    line_ends_.clear();
    mesh_.for_outgoing(v, [&](std::uint32_t h) { corners_.push_back(h); });
    mesh_.for_neighbors(v, [&](std::uint32_t w, std::uint32_t h) {
      Target target;
      target.edge = h;
      target.vertex = w;
      target.length = distance(at(v), at(w));
      targets_.push_back(target);
      if (mesh_.is_line(h)) line_ends_.push_back(target);
    });
    boundary_ = mesh_.is_boundary_vertex(v);
  }

  bool try_remove(std::uint32_t v) {
    look_around(v);
    if (targets_.size() > level_.most_valence) return false;
    // A vertex of a line may stay: rather that than triangles that turn over.
    if (!line_ends_.empty() && (level_.least_turn < 0 || !choose_line_targets(v))) return false;
    std::stable_sort(targets_.begin(), targets_.end(),
                     [](const Target& a, const Target& b) { return a.length < b.length; });
    if (targets_.size() > most_targets) targets_.resize(most_targets);
    for (Target& target : targets_) target.shape = shape_after(v, target);
    std::stable_sort(targets_.begin(), targets_.end(),
                     [](const Target& a, const Target& b) { return a.shape > b.shape; });
    for (const Target& target : targets_) {
      if (target.shape < level_.least_shape) return false;
      if (!link_.holds(mesh_, target.edge, v)) continue;
      remove(v, target);
      return true;
    }
    return false;
  }

  // Chooses targets for a vertex on lines among its neighbors on them: along a smooth line as far as it stays
  // where it is, and from corner to corner within a small part of the spacing. False where there is none.
  bool choose_line_targets(std::uint32_t v) {
    const double spacing = spacing_[v];
    const bool corner = is_corner(v);
    std::vector<Target> chosen;
    for (Target target : line_ends_) {
      // A line of the boundary is left for no crease.
      if (boundary_ && !mesh_.is_boundary_edge(target.edge)) continue;
      if (!corner) {
        const Target& other = line_ends_[target.vertex == line_ends_[0].vertex ? 1 : 0];
        target.other_end = other.vertex;
        target.drift = drift_[v] + distance_to_segment(at(v), at(target.vertex), at(other.vertex));
        if (target.drift <= lines_.deviation * spacing &&
            distance(at(target.vertex), at(other.vertex)) <= lines_.spacing * spacing)
          chosen.push_back(target);
        continue;
      }
      target.drift = drift_[v] + target.length;
      if (target.drift <= lines_.merging * spacing && is_corner(target.vertex)) chosen.push_back(target);
    }
    targets_ = std::move(chosen);
    return !targets_.empty();
  }

  // Whether lines end, meet or turn there.
  bool is_corner(std::uint32_t v) const {
    std::array<std::uint32_t, 2> ends = {no_index, no_index};
    std::size_t count = 0;
    mesh_.for_neighbors(v, [&](std::uint32_t w, std::uint32_t h) {
      if (!mesh_.is_line(h)) return;
      if (count < 2) ends[count] = w;
      ++count;
    });
    if (count != 2) return true;
    const Vector3 in = at(v) - at(ends[0]), out = at(ends[1]) - at(v);
    return dot(in, out) < least_straight * norm(in) * norm(out);
  }

  static double distance_to_segment(Vector3 p, Vector3 a, Vector3 b) {
    const Vector3 d = b - a;
    const double squared = dot(d, d);
    const double s = squared > 0 ? std::clamp(dot(p - a, d) / squared, 0.0, 1.0) : 0.0;
    return distance(p, a + s * d);
  }

  // The worst shape of the triangles that stay, negative for one that turns over, -2 where one turns too far.
  double shape_after(std::uint32_t v, const Target& target) const {
    double worst = 2;
    const Vector3 p = at(v), q = at(target.vertex);
    for (const std::uint32_t h : corners_) {
      const std::uint32_t b = mesh_.end(h), c = mesh_.apex(h);
      if (b == target.vertex || c == target.vertex) continue;
      const Vector3 pb = at(b), pc = at(c);
      const Vector3 after = cross(pb - q, pc - q), before = cross(pb - p, pc - p);
      const double area = norm(after), old_area = norm(before);
      const double squares = dot(pb - q, pb - q) + dot(pc - q, pc - q) + dot(pb - pc, pb - pc);
      // 2 sqrt(3) for twice the area.
      const double shape = squares > 0 ? 3.4641016151377544 * area / squares : 0;
      const double turn = dot(before, after);
      if (turn < level_.least_turn * old_area * area) return -2;
      worst = std::min(worst, turn < 0 ? -shape : shape);
    }
    return worst;
  }

  void remove(std::uint32_t v, const Target& target) {
    const std::uint32_t w = target.vertex;
    mesh_.for_neighbors(v, [&](std::uint32_t u, std::uint32_t) { locked_[u] = round_; });
    for (const std::uint32_t end : {w, target.other_end})
      if (end < drift_.size()) drift_[end] = std::max(drift_[end], target.drift);
    moved_to_[v] = w;
    mesh_.collapse(target.edge, v);
    edges_.clear();
    const auto add = [&](std::uint32_t h) { edges_.insert(edges_.end(), {h, next_half_edge(h)}); };
    if (mesh_.has_more_outgoing(w, most_flipped)) {  // those that it has from v alone
      for (const std::uint32_t h : corners_)
        if (mesh_.exists(h / 3)) add(h);
    } else {
      mesh_.for_outgoing(w, add);
    }
    const auto most = flips_per_neighbor * static_cast<std::uint32_t>(corners_.size());
    flip_to_delaunay(mesh_, edges_, most);
  }

  // A vertex inside that no neighbor takes: with three neighbors left it can go, unless they and it are the
  // whole surface.
  void free_by_flips(std::uint32_t v, bool (*may_flip)(const EditedMesh&, std::uint32_t)) {
    if (mesh_.out[v] == no_index) return;
    cancel_.check();
    level_ = levels.back();
    look_around(v);
    if (!line_ends_.empty() || corners_.size() > most_freed) return;
    if (try_remove(v)) return;
    for (std::size_t tries = corners_.size(); tries > 0; --tries) {
      look_around(v);
      std::uint32_t flipped = no_index;
      for (const std::uint32_t h : corners_)
        if (corners_.size() > 3 && may_flip(mesh_, h)) {
          flipped = h;
          break;
        }
      if (flipped == no_index) return;
      mesh_.flip(flipped);
      if (try_remove(v)) return;
    }
  }

  EditedMesh& mesh_;
  const std::span<const double> spacing_;
  const LineParameters& lines_;
  const CancelToken& cancel_;
  std::vector<double> drift_;  // W: how far lines may have moved around each vertex
  std::vector<std::uint32_t> moved_to_, locked_;
  LinkCondition link_;
  std::vector<std::uint32_t> corners_, edges_;
  std::vector<Target> targets_, line_ends_;
  Level level_ = levels.front();
  std::uint32_t round_ = 0;
  bool boundary_ = false;
};

}  // namespace

std::vector<std::uint32_t> remove_vertices(EditedMesh& mesh, std::span<const double> spacing,
                                           const LineParameters& lines, std::span<const std::uint8_t> kept,
                                           const CancelToken& cancel) {
  return Remover(mesh, spacing, lines, cancel).run(kept);
}

}  // namespace meander
