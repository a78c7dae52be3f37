#include "kernels/remesh/repair_crossings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <limits>

#include "kernels/core/work_budget.h"
#include "kernels/remesh/crossing_triangles.h"
#include "kernels/remesh/delaunay_flips.h"

namespace meander {

namespace {

constexpr int most_rounds = 12;
constexpr std::size_t most_found = 16;               // pairs looked at of one triangle
constexpr std::size_t most_repaired = 4096;          // pairs in a round
constexpr std::size_t most_repaired_of_input = 256;  // of those where the surface crosses itself
constexpr std::size_t least_fresh = 32;              // triangles beside the tree before it is made again
constexpr std::uint64_t added_per_pair = 4, added_at_least = 16;
constexpr std::ptrdiff_t least_gain = -2;  // crossings fewer by a vertex that returns
constexpr double input_reach = 0.5;        // how far from a crossing of the surface, over the longest edge
constexpr double least_part = 0.15;        // of an edge, from its ends to a vertex that returns
constexpr std::uint32_t settling_flips = 12;
// Triangles that steps look at, for each one of the mesh.
constexpr std::uint64_t most_looks = 256, looks_at_least = std::uint64_t{1} << 22;
// Pairs of triangles near each other that a search looks at, for each triangle.
constexpr std::uint64_t most_near = 256, near_at_least = std::uint64_t{1} << 24,
                        near_in_block = std::uint64_t{1} << 21;
constexpr std::uint32_t fresh = no_index - 1;

// A triangle of a part.
struct Slot {
  std::uint32_t part, triangle;
  auto operator<=>(const Slot&) const = default;
};

struct CrossingPair {
  std::array<Slot, 2> slots;
  bool of_input;  // near a place where triangles of the surface cross
};

// A triangle that is there, or that a step would make.
struct Trial {
  TriangleVertices vertex;
  TriangleCorners corner;
};

class CrossingRepair {
 public:
  CrossingRepair(std::span<const RepairedPart> parts, const PreparedMesh& surface,
                 CrossingSurroundings surroundings, const CancelToken& cancel)
      : parts_(parts),
        surface_(surface),
        surroundings_(surroundings),
        cancel_(cancel),
        clusters_(parts.size()) {}

  CrossingReport run() {
    look_at_all();
    looks_ = WorkBudget(looks_at_least + most_looks * slots_.size());
    std::vector<TrianglePair> found = pairs_of_all();
    if (found.empty() && !report_.is_partial) return report_;
    report_.around.resize(parts_.size());
    if (report_.is_partial || !find_crossings_of_surface()) {
      report_.of_input = found.size() + not_listed_;
      return report_;
    }
    std::vector<CrossingPair> pairs;
    for (const TrianglePair& pair : found)
      pairs.push_back(described(slots_[pair.first], slots_[pair.second]));
    if (found.size() + not_listed_ > most_found * slots_.size()) {
      // Long needles that all cross each other: to part them takes the square of their number, in vain.
      for (const CrossingPair& pair : pairs) ++(pair.of_input ? report_.of_input : report_.left);
      report_.of_input += not_listed_;
      return report_;
    }
    if (surroundings_.around_parted)
      for (const CrossingPair& pair : pairs)
        if (!pair.of_input) find_around(pair.slots);
    const std::uint64_t most_added = added_at_least + added_per_pair * pairs.size();
    bool changed = false;
    for (int round = 0; round < most_rounds && !pairs.empty(); ++round) {
      changed_.clear();
      std::size_t tried = 0, tried_of_input = 0;
      for (std::size_t i = 0; i < pairs.size() && tried < most_repaired; ++i) {
        if (looks_.exhausted()) break;
        if (pairs[i].of_input && ++tried_of_input > most_repaired_of_input) continue;
        ++tried;
        cancel_.check();
        if (fresh_.size() > most_fresh_) look_at_all();
        repair(pairs[i], report_.added < most_added);
      }
      if (changed_.empty()) break;
      changed = true;
      if (looks_.exhausted()) break;
      pairs = pairs_of_changed();
    }
    if (changed) {
      look_at_all();
      found = pairs_of_all();
    }
    for (const TrianglePair& pair : found) {
      const CrossingPair left = described(slots_[pair.first], slots_[pair.second]);
      const bool of_input = left.of_input || report_.is_partial;
      ++(of_input ? report_.of_input : report_.left);
      if (!of_input) find_around(left.slots);
    }
    for (std::vector<std::uint32_t>& around : report_.around) {
      if (report_.left == 0) around.clear();
      std::sort(around.begin(), around.end());
      around.erase(std::unique(around.begin(), around.end()), around.end());
    }
    report_.of_input += not_listed_;
    return report_;
  }

 private:
  EditedMesh& mesh_of(Slot slot) const { return *parts_[slot.part].mesh; }
  bool exists(Slot slot) const { return mesh_of(slot).exists(slot.triangle); }

  static Trial trial_of(const EditedMesh& mesh, const TriangleVertices& v) {
    return {v, {mesh.position[v[0]], mesh.position[v[1]], mesh.position[v[2]]}};
  }
  Trial trial(Slot slot) const {
    const EditedMesh& mesh = mesh_of(slot);
    const std::size_t h = 3 * std::size_t{slot.triangle};
    return trial_of(mesh, {mesh.vertex[h], mesh.vertex[h + 1], mesh.vertex[h + 2]});
  }

  void look_at_all() {
    slots_.clear();
    fresh_.clear();
    item_.assign(parts_.size(), {});
    for (std::uint32_t p = 0; p < parts_.size(); ++p) {
      const EditedMesh& mesh = *parts_[p].mesh;
      item_[p].assign(mesh.triangle_count(), no_index);
      for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        if (!mesh.exists(t)) continue;
        item_[p][t] = static_cast<std::uint32_t>(slots_.size());
        slots_.push_back({p, t});
      }
    }
    stale_.assign(slots_.size(), 0);
    // Every look goes through the triangles beside the tree, of which a change takes some dozens; the tree
    // takes a time of T.
    most_fresh_ =
        std::max(least_fresh, static_cast<std::size_t>(std::sqrt(static_cast<double>(slots_.size()))));
    boxes_ = BoxSearch(slots_.size(), [&](std::size_t i) { return box_of(trial(slots_[i]).corner); });
  }

  bool cross(const Slot& a, const Slot& b) const {
    const Trial first = trial(a), second = trial(b);
    if (a.part == b.part && share_a_vertex(first.vertex, second.vertex)) return false;
    return triangles_cross(first.corner, second.corner);
  }

  static CrossingSearchBound bound_of(std::size_t triangles) {
    return {near_in_block, near_at_least + most_near * triangles};
  }

  std::vector<TrianglePair> pairs_of_all() {
    CrossingPairs found = crossing_pairs(
        boxes_, slots_.size(), most_found, bound_of(slots_.size()),
        [&](std::size_t i) { return box_of(trial(slots_[i]).corner); },
        [&](std::size_t i, std::size_t j) { return cross(slots_[i], slots_[j]); }, [&] { cancel_.check(); });
    report_.is_partial = report_.is_partial || !found.is_whole;
    not_listed_ = found.count - found.pairs.size();
    return std::move(found.pairs);
  }

  // False where there are more than triangles, or the search ended at its bound: what crosses everywhere
  // cannot be parted.
  bool find_crossings_of_surface() {
    const auto vertices = [&](std::size_t t) {
      return TriangleVertices{surface_.triangles[3 * t], surface_.triangles[3 * t + 1],
                              surface_.triangles[3 * t + 2]};
    };
    const auto corners = [&](std::size_t t) {
      const TriangleVertices v = vertices(t);
      return TriangleCorners{surface_.position(v[0]), surface_.position(v[1]), surface_.position(v[2])};
    };
    const std::size_t count = surface_.triangle_count();
    const auto box = [&](std::size_t t) { return box_of(corners(t)); };
    // Samples cut triangles with common vertices into some without.
    const auto overlap = [&](std::size_t t, std::size_t u) {
      return triangles_overlap(vertices(t), corners(t), vertices(u), corners(u));
    };
    const CrossingPairs found = crossing_pairs(BoxSearch(count, box), count, most_found, bound_of(count), box,
                                               overlap, [&] { cancel_.check(); });
    report_.is_partial = report_.is_partial || !found.is_whole;
    if (!found.is_whole || found.count > count) return false;
    input_ = BoxSearch(found.pairs.size(), [&](std::size_t i) {
      return common_box(box_of(corners(found.pairs[i].first)), box_of(corners(found.pairs[i].second)));
    });
    return true;
  }

  // Around the place where they cross, within their longest edge times `reach`.
  static SpaceBox place_of(const Trial& a, const Trial& b, double reach) {
    double longest = 0;
    for (const Trial* of : {&a, &b})
      for (std::size_t k = 0; k < 3; ++k)
        longest = std::max(longest, distance(of->corner[k], of->corner[(k + 1) % 3]));
    SpaceBox box = common_box(box_of(a.corner), box_of(b.corner));
    for (std::size_t k = 0; k < 3; ++k) {
      box.low[k] -= reach * longest;
      box.high[k] += reach * longest;
    }
    return box;
  }

  // Near a place where triangles of the surface cross.
  bool is_of_input(const Trial& a, const Trial& b) const {
    return input_.meets_any(place_of(a, b, input_reach));
  }

  void touch(Slot slot) {
    changed_.push_back(slot);
    std::vector<std::uint32_t>& items = item_[slot.part];
    if (slot.triangle >= items.size()) items.resize(slot.triangle + 1, no_index);
    std::uint32_t& item = items[slot.triangle];
    if (item == fresh) return;
    if (item != no_index) stale_[item] = 1;
    item = fresh;
    fresh_.push_back(slot);
  }

  // Calls visit(slot, trial) for the triangles that cross one of this part.
  template <class Visit>
  void visit_crossing(std::uint32_t part, const Trial& of, const Visit& visit) const {
    const SpaceBox box = box_of(of.corner);
    looks_.spend(fresh_.size());
    const auto look = [&](Slot slot) {
      looks_.spend(1);
      const Trial other = trial(slot);
      if (slot.part == part && share_a_vertex(of.vertex, other.vertex)) return;
      if (triangles_cross(of.corner, other.corner)) visit(slot, other);
    };
    boxes_.visit_meeting(box, [&](std::uint32_t item) {
      if (!stale_[item]) look(slots_[item]);
    });
    for (const Slot slot : fresh_)
      if (exists(slot) && box_of(trial(slot).corner).meets(box)) look(slot);
  }

  // The crossings of these triangles with each other and with all but those that they replace.
  std::size_t crossings_of(std::uint32_t part, std::span<const Trial> trials,
                           std::span<const std::uint32_t> replaced) const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < trials.size(); ++i) {
      visit_crossing(part, trials[i], [&](Slot slot, const Trial&) {
        count +=
            slot.part != part || std::find(replaced.begin(), replaced.end(), slot.triangle) == replaced.end();
      });
      for (std::size_t j = 0; j < i; ++j)
        count += !share_a_vertex(trials[i].vertex, trials[j].vertex) &&
                 triangles_cross(trials[i].corner, trials[j].corner);
    }
    return count;
  }

  std::size_t crossings_now(std::uint32_t part, std::span<const std::uint32_t> triangles) const {
    std::vector<Trial> trials;
    for (const std::uint32_t t : triangles) trials.push_back(trial({part, t}));
    return crossings_of(part, trials, triangles);
  }

  bool still_cross(const std::array<Slot, 2>& pair) const {
    return exists(pair[0]) && exists(pair[1]) && cross(pair[0], pair[1]);
  }

  void repair(const CrossingPair& pair, bool may_add) {
    if (!still_cross(pair.slots)) return;
    for (const Slot slot : pair.slots)
      if (unfit(slot)) return;
    for (const Slot slot : pair.slots)
      if (flip_one(slot)) return;
    if (may_add) bring_back(pair.slots, pair.of_input ? 1 : least_gain);
  }

  CrossingPair described(Slot a, Slot b) const { return {{a, b}, is_of_input(trial(a), trial(b))}; }

  // The vertices of the triangle return to where they were before the fit, if that helps.
  bool unfit(Slot slot) {
    const RepairedPart& part = parts_[slot.part];
    if (part.places.empty()) return false;
    EditedMesh& mesh = *part.mesh;
    const std::size_t first = part.moved_to.size();
    const TriangleVertices vertices = trial(slot).vertex;
    std::vector<std::uint32_t> around;
    bool moved = false;
    for (const std::uint32_t v : vertices) {
      if (v < first || v - first >= part.places.size()) continue;
      const Vector3 place = part.places[v - first], now = mesh.position[v];
      if (place.x == now.x && place.y == now.y && place.z == now.z) continue;
      moved = true;
      mesh.for_outgoing(v, [&](std::uint32_t h) {
        if (std::find(around.begin(), around.end(), h / 3) == around.end()) around.push_back(h / 3);
      });
    }
    if (!moved) return false;
    const std::size_t before = crossings_now(slot.part, around);
    std::vector<Trial> trials;
    for (const std::uint32_t t : around) {
      Trial after = trial({slot.part, t});
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = after.vertex[k];
        if (v >= first && v - first < part.places.size() &&
            std::find(vertices.begin(), vertices.end(), v) != vertices.end())
          after.corner[k] = part.places[v - first];
      }
      trials.push_back(after);
    }
    if (crossings_of(slot.part, trials, around) >= before) return false;
    for (const std::uint32_t v : vertices)
      if (v >= first && v - first < part.places.size()) mesh.position[v] = part.places[v - first];
    for (const std::uint32_t t : around) touch({slot.part, t});
    return true;
  }

  // Whether that edge, flipped, crosses less than before; or at most as much.
  bool flip_helps(std::uint32_t part, std::uint32_t h, bool strictly) const {
    const EditedMesh& mesh = *parts_[part].mesh;
    if (mesh.is_line(h) || !can_flip(mesh, h)) return false;
    const std::uint32_t g = mesh.opposite[h];
    const std::array<std::uint32_t, 2> replaced = {h / 3, g / 3};
    const std::uint32_t a = mesh.start(h), b = mesh.end(h), c = mesh.apex(h), d = mesh.apex(g);
    const std::array<Trial, 2> trials = {trial_of(mesh, {d, b, c}), trial_of(mesh, {c, a, d})};
    const std::size_t before = crossings_now(part, replaced), after = crossings_of(part, trials, replaced);
    return strictly ? after < before : after <= before;
  }

  bool flip_one(Slot slot) {
    EditedMesh& mesh = mesh_of(slot);
    for (std::uint32_t h = 3 * slot.triangle; h < 3 * slot.triangle + 3; ++h) {
      if (!flip_helps(slot.part, h, true)) continue;
      flip(slot.part, mesh, h);
      return true;
    }
    return false;
  }

  void flip(std::uint32_t part, EditedMesh& mesh, std::uint32_t h) {
    const std::uint32_t other = mesh.opposite[h] / 3;
    mesh.flip(h);
    touch({part, h / 3});
    touch({part, other});
  }

  // For each vertex of a part the vertices of the surface that went to it.
  struct Clusters {
    std::vector<std::uint32_t> end;          // W
    std::vector<std::uint32_t> begin, list;  // by vertex
    bool made = false;
  };

  Clusters& clusters_of(std::uint32_t p) {
    Clusters& clusters = clusters_[p];
    if (clusters.made) return clusters;
    clusters.made = true;
    const RepairedPart& part = parts_[p];
    const auto originals = static_cast<std::uint32_t>(part.moved_to.size());
    clusters.end.assign(part.moved_to.begin(), part.moved_to.end());
    const auto vertices = part.mesh->position.size();
    clusters.begin.assign(vertices + 2, 0);
    for (std::uint32_t v = 0; v < originals; ++v) {
      std::uint32_t at = v;
      while (at < originals && clusters.end[at] != at) {
        const std::uint32_t next = clusters.end[at];
        if (next < originals) clusters.end[at] = clusters.end[next];
        at = next;
      }
      clusters.end[v] = at;
      if (at != v) ++clusters.begin[at + 2];
    }
    for (std::size_t v = 2; v < clusters.begin.size(); ++v) clusters.begin[v] += clusters.begin[v - 1];
    clusters.list.resize(clusters.begin.back());
    for (std::uint32_t v = 0; v < originals; ++v)
      if (clusters.end[v] != v) clusters.list[clusters.begin[clusters.end[v] + 1]++] = v;
    return clusters;
  }

  // The one of those that went to these vertices, or to what came back of theirs, that is nearest to a place.
  std::uint32_t nearest_gone(std::uint32_t p, std::span<const std::uint32_t> vertices, Vector3 place,
                             bool on_line) {
    const RepairedPart& part = parts_[p];
    const EditedMesh& mesh = *part.mesh;
    const Clusters& clusters = clusters_of(p);
    std::uint32_t best = no_index;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::uint32_t v : vertices) {
      if (v < part.moved_to.size()) v = clusters.end[v];
      if (std::size_t{v} + 1 >= clusters.begin.size()) continue;
      for (std::uint32_t i = clusters.begin[v]; i < clusters.begin[v + 1]; ++i) {
        const std::uint32_t gone = clusters.list[i];
        if (mesh.out[gone] != no_index || (part.on_line[gone] != 0) != on_line) continue;
        const Vector3 d = mesh.position[gone] - place;
        const double squared = dot(d, d);
        if (squared > nearest || (squared == nearest && gone > best)) continue;
        nearest = squared;
        best = gone;
      }
    }
    return best;
  }

  // The vertices of the surface, there or gone, that lie around the place and belong to the two or to their
  // neighbors.
  void find_around(const std::array<Slot, 2>& pair) {
    const SpaceBox place = place_of(trial(pair[0]), trial(pair[1]), surroundings_.reach);
    for (const Slot slot : pair) {
      const EditedMesh& mesh = mesh_of(slot);
      const auto originals = static_cast<std::uint32_t>(parts_[slot.part].moved_to.size());
      const Clusters& clusters = clusters_of(slot.part);
      std::vector<std::uint32_t>& around = report_.around[slot.part];
      const auto add = [&](std::uint32_t v) {
        const Vector3 at = mesh.position[v];
        if (SpaceBox{{at.x, at.y, at.z}, {at.x, at.y, at.z}}.meets(place)) around.push_back(v);
      };
      const auto add_all = [&](std::uint32_t v) {
        if (v < originals) {
          add(v);
          v = clusters.end[v];
        }
        if (std::size_t{v} + 1 >= clusters.begin.size()) return;
        for (std::uint32_t i = clusters.begin[v]; i < clusters.begin[v + 1]; ++i) add(clusters.list[i]);
      };
      for (const std::uint32_t corner : trial(slot).vertex) {
        add_all(corner);
        mesh.for_neighbors(corner, [&](std::uint32_t w, std::uint32_t) { add_all(w); });
      }
    }
  }

  // A vertex of the surface that cuts an edge, or a triangle, in two, or in three.
  struct Return {
    std::uint32_t part = 0, vertex = no_index;
    std::uint32_t edge = no_index, triangle = no_index;
    std::ptrdiff_t gain = 0;
    double length = 0;
  };

  void bring_back(const std::array<Slot, 2>& pair, std::ptrdiff_t least) {
    Return best;
    const auto offer = [&](const Return& found) {
      if (best.vertex == no_index || found.gain > best.gain ||
          (found.gain == best.gain && found.length > best.length))
        best = found;
    };
    for (const Slot slot : pair) {
      for (std::uint32_t h = 3 * slot.triangle; h < 3 * slot.triangle + 3; ++h) offer_edge(slot, h, offer);
      offer_center(slot, offer);
    }
    if (best.vertex == no_index || best.gain < least) return;
    EditedMesh& mesh = *parts_[best.part].mesh;
    const auto added = static_cast<std::uint32_t>(mesh.triangle_count());
    if (best.edge != no_index) {
      const std::uint32_t g = mesh.opposite[best.edge];
      mesh.split_edge(best.edge, best.vertex);
      touch({best.part, best.edge / 3});
      if (g != no_index) touch({best.part, g / 3});
    } else {
      mesh.split_triangle(best.triangle, best.vertex);
      touch({best.part, best.triangle});
    }
    for (std::uint32_t t = added; t < mesh.triangle_count(); ++t) touch({best.part, t});
    ++report_.added;
    settle(best.part, best.vertex);
  }

  template <class Offer>
  void offer_edge(Slot slot, std::uint32_t h, const Offer& offer) {
    const EditedMesh& mesh = mesh_of(slot);
    const std::uint32_t g = mesh.opposite[h], a = mesh.start(h), b = mesh.end(h), c = mesh.apex(h);
    const Vector3 middle = 0.5 * (mesh.position[a] + mesh.position[b]);
    const std::uint32_t p = nearest_gone(slot.part, std::array{a, b, c, g == no_index ? c : mesh.apex(g)},
                                         middle, mesh.is_line(h));
    if (p == no_index) return;
    const double length = distance(mesh.position[a], mesh.position[b]);
    const Vector3 at = mesh.position[p];
    if (std::min(distance(at, mesh.position[a]), distance(at, mesh.position[b])) < least_part * length)
      return;
    std::vector<Trial> trials = {trial_of(mesh, {a, p, c}), trial_of(mesh, {p, b, c})};
    std::vector<std::uint32_t> replaced = {h / 3};
    if (g != no_index) {
      const std::uint32_t d = mesh.apex(g);
      trials.push_back(trial_of(mesh, {b, p, d}));
      trials.push_back(trial_of(mesh, {p, a, d}));
      replaced.push_back(g / 3);
    }
    Return found{slot.part, p, h, no_index, 0, length};
    found.gain = static_cast<std::ptrdiff_t>(crossings_now(slot.part, replaced)) -
                 static_cast<std::ptrdiff_t>(crossings_of(slot.part, trials, replaced));
    offer(found);
  }

  template <class Offer>
  void offer_center(Slot slot, const Offer& offer) {
    const EditedMesh& mesh = mesh_of(slot);
    const Trial now = trial(slot);
    const auto& [a, b, c] = now.vertex;
    const Vector3 center = (1. / 3) * (now.corner[0] + now.corner[1] + now.corner[2]);
    const std::uint32_t p = nearest_gone(slot.part, now.vertex, center, false);
    if (p == no_index) return;
    const std::array<Trial, 3> trials = {trial_of(mesh, {a, b, p}), trial_of(mesh, {b, c, p}),
                                         trial_of(mesh, {c, a, p})};
    const std::array<std::uint32_t, 1> replaced = {slot.triangle};
    Return found{slot.part, p, no_index, slot.triangle, 0, 0};
    found.gain = static_cast<std::ptrdiff_t>(crossings_now(slot.part, replaced)) -
                 static_cast<std::ptrdiff_t>(crossings_of(slot.part, trials, replaced));
    offer(found);
  }

  // Flips around a vertex that came back, to Delaunay triangles, where that makes no crossing.
  void settle(std::uint32_t part, std::uint32_t v) {
    EditedMesh& mesh = *parts_[part].mesh;
    for (std::uint32_t flips = 0; flips < settling_flips; ++flips) {
      std::uint32_t longer = no_index;
      mesh.for_outgoing(v, [&](std::uint32_t out) {
        for (const std::uint32_t h : {out, next_half_edge(out)})
          if (longer == no_index && !mesh.is_line(h) && is_longer_diagonal(mesh, h) &&
              flip_helps(part, h, false))
            longer = h;
      });
      if (longer == no_index) return;
      flip(part, mesh, longer);
    }
  }

  std::vector<CrossingPair> pairs_of_changed() {
    std::vector<CrossingPair> pairs;
    std::sort(changed_.begin(), changed_.end());
    changed_.erase(std::unique(changed_.begin(), changed_.end()), changed_.end());
    for (std::size_t i = 0; i < changed_.size(); ++i) {
      if (i % 256 == 0) cancel_.check();
      if (!exists(changed_[i])) continue;
      const Trial of = trial(changed_[i]);
      std::vector<Slot> others;
      visit_crossing(changed_[i].part, of, [&](Slot slot, const Trial&) { others.push_back(slot); });
      std::sort(others.begin(), others.end());  // whichever of them are in the tree
      for (const Slot other : others) pairs.push_back(described(changed_[i], other));
    }
    return pairs;
  }

  const std::span<const RepairedPart> parts_;
  const PreparedMesh& surface_;
  const CrossingSurroundings surroundings_;
  const CancelToken& cancel_;
  std::vector<Clusters> clusters_;
  std::vector<Slot> slots_, fresh_, changed_;     // in boxes_, changed since, changed in this round
  std::vector<std::vector<std::uint32_t>> item_;  // of each triangle in boxes_, `fresh`, or no_index
  std::vector<std::uint8_t> stale_;               // items of triangles that are fresh now
  std::size_t most_fresh_ = least_fresh;
  BoxSearch boxes_, input_;
  CrossingReport report_;
  std::uint64_t not_listed_ = 0;
  mutable WorkBudget looks_{0};  // steps are judged by const functions
};

}  // namespace

CrossingReport repair_crossings(std::span<const RepairedPart> parts, const PreparedMesh& surface,
                                CrossingSurroundings surroundings, const CancelToken& cancel) {
  return CrossingRepair(parts, surface, surroundings, cancel).run();
}

}  // namespace meander
