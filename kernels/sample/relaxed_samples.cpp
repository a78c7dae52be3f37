#include "kernels/sample/relaxed_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "kernels/core/parallel.h"
#include "kernels/density/pieces.h"
#include "kernels/sample/kernel_sums.h"
#include "kernels/sample/median_place.h"
#include "kernels/sample/offered_places.h"
#include "kernels/sample/spaced_samples.h"
#include "kernels/sample/stratum_grid.h"
#include "kernels/sample/surface_points.h"

namespace meander {

namespace {

// Lengths are in spacings, sqrt(area of a sample), unless they are in working units.

// Where the kernel of sum_pull ends, and its integral in the plane.
constexpr float kernel_end = 2, kernel_integral = static_cast<float>(4 * std::numbers::pi / 9);
// The step that would bring a single sample to the middle of a hole: 1 / (density x 2 pi sigma^4), with
// sigma = 1/2 in the units of Pull::way.
constexpr float step_per_pull = static_cast<float>(4 / std::numbers::pi);
constexpr int passes = 8;
constexpr float longest_step = 0.25f;
// How far a sample may go from where the attraction was found: beyond, its slope says nothing.
constexpr float longest_way = 0.75f;
// Samples may come nearer by so much before their neighbors are looked for again.
constexpr float neighbor_margin = 0.5f;
// Then pairs that are nearer than this are pushed apart: a little more than half of what is missing, by each.
constexpr int pushes = 16;
constexpr float too_near = 0.78f * static_cast<float>(hexagonal_distance), push_share = 0.55f,
                push_margin = 0.35f;
// In the first passes, those that are not pushed are drawn into holes around which they lie: circles without
// samples, their corners on surface that faces one way within this cosine, that are larger by so much than
// those of the hexagonal lattice, which have .62 spacings; larger ones than the largest are no holes of the
// surface. By a share of what is too much, by each corner. All are looked at in each fourth pass, the corners
// of holes in the others.
constexpr int draws = 8, look_again = 4;
constexpr float hole =
                    1.15f * static_cast<float>(hexagonal_distance) / static_cast<float>(std::numbers::sqrt3),
                largest_hole = 1, draw_share = 0.2f, same_side = 0.2f, around_hole = 1.75f;
constexpr std::size_t max_around_hole = 24;
// The surface within the kernel, over that of a plane: where it is this much on sheets that face one way,
// samples stay; where it is more than this in all, they cannot be so far apart; below the first of these they
// move along the border only, above the second freely.
constexpr float stacked = 1.6f, room_for_one = 1.6f, at_border = 0.9f, inside = 0.97f;
// Samples of a task; within it each sees where those before it have gone.
constexpr std::size_t task_samples = 1024;
// So many samples along the path look together for what is around them, unless the run is longer than this,
// in what they look across, or has more around it.
constexpr std::size_t run_samples = 8, max_around_run = 8192, max_around_sample = 512;
constexpr float longest_search = 4;
// The nearest of a sample that it keeps: those of six sheets. Where sheets face both ways there may be more.
constexpr std::size_t neighbors_kept = 128;
// Cells of the grid of points.
constexpr double point_cell = 0.7;
// In working units: below this, squares would leave the range of float.
constexpr float min_spacing = 1e-15f;

using Float3 = std::array<float, 3>;
float dot(const Float3& a, const Float3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Float3 difference(const Float3& a, const Float3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Float3 to_float3(const Vector3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

// Points in a grid, to be found around samples.
class PointsAround {
 public:
  // cell: of the grid, in working units. at(j): where point j is. around(j): the distance at which samples
  // look around there.
  template <class At, class Around>
  PointsAround(std::size_t count, double cell, const At& at, const Around& around) : grid_(cell) {
    for (std::size_t j = 0; j < count; ++j) {
      const Float3 p = at(j);
      grid_.add({p, p}, around(j));
    }
    grid_.build();
  }

  // Calls visit(first, last, found) for the runs of samples in [begin, end): `found` are the points within
  // distance(i) of the samples i of the run, and others near them; of one sample at most the limit above.
  template <class At, class Distance, class Visit>
  void visit_runs(std::size_t begin, std::size_t end, const std::vector<Float3>& sample,
                  const Distance& distance, const At& at, const Visit& visit) const {
    StratumGrid::Scratch scratch;
    std::vector<std::uint32_t> found;
    for (std::size_t first = begin; first < end; first += run_samples) {
      const std::size_t last = std::min(end, first + run_samples);
      PointBox run{sample[first], sample[first]};
      float within = 0;
      for (std::size_t i = first; i < last; ++i) {
        within = std::max(within, distance(i));
        for (std::size_t k = 0; k < 3; ++k) {
          run.low[k] = std::min(run.low[k], sample[i][k]);
          run.high[k] = std::max(run.high[k], sample[i][k]);
        }
      }
      bool together = true;
      for (std::size_t k = 0; k < 3; ++k) together &= run.high[k] - run.low[k] < longest_search * within;
      const auto is_near = [&](std::uint32_t j) {
        return spaced::squared_gap({at(j), at(j)}, run) < within * within;
      };
      if (together && grid_.find_around(run, within, max_around_run, is_near, found)) {
        visit(first, last, found);
        continue;
      }
      for (std::size_t i = first; i < last; ++i) {
        const Float3& p = sample[i];
        const float d = distance(i);
        grid_.find(
            std::span(&p[0], 1), std::span(&p[1], 1), std::span(&p[2], 1), {p, p}, false, d,
            max_around_sample,
            [&](std::uint32_t j, const PointBox& place) {
              return spaced::squared_gap({at(j), at(j)}, place) < d * d;
            },
            scratch, found);
        visit(i, i + 1, found);
      }
    }
  }

 private:
  StratumGrid grid_;
};

class Relaxation {
 public:
  Relaxation(const PreparedMesh& mesh, const MeshMeasure& measure, std::span<SurfacePlace> places,
             const CancelToken& cancel)
      : mesh_(mesh),
        density_(measure.density),
        places_(places),
        cancel_(cancel),
        count_(places.size()),
        sample_mass_(measure.total() / static_cast<double>(count_)),
        origin_(median_place(count_, [&](std::size_t i) { return position_of(mesh_, places_[i]); })),
        at_(count_),
        normal_(count_),
        spacing_(count_) {
    parallel_blocks(count_, task_samples, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        at_[i] = place_of(i);
        normal_[i] = normal_of(i);
      }
    });
    find_spacings();
  }

  void relax() {
    find_pulls();
    find_room();
    find_neighbors(kernel_end + neighbor_margin);
    for (int pass = 0; pass < passes; ++pass)
      move_all([&](std::size_t i, const Moving& at, PointRows& near) { return pulled(i, at, near); });
    find_spacings();
    find_neighbors(around_hole);
    std::vector<std::uint8_t> at_hole(count_);
    for (int pass = 0; pass < pushes; ++pass)
      move_all([&](std::size_t i, const Moving& at, PointRows&) {
        const Float3 apart = pushed(i, at);
        if (apart != Float3{} || pass >= draws || (pass > 0 && at_hole[i] == 0)) return apart;
        const Float3 together = drawn(i, at);
        at_hole[i] = together != Float3{} ? 1 : 0;
        return together;
      });
  }

  std::uint32_t held() const {
    return static_cast<std::uint32_t>(std::count(stays_.begin(), stays_.end(), std::uint8_t{1}));
  }

 private:
  // Where samples are in a pass: those of the own task have moved already.
  struct Moving {
    const std::vector<Float3>&before, &now;
    std::size_t begin, end;
    const Float3& operator[](std::size_t j) const { return j >= begin && j < end ? now[j] : before[j]; }
  };

  Float3 place_of(std::size_t i) const { return to_float3(position_of(mesh_, places_[i]) - origin_); }
  Float3 normal_of(std::size_t i) const { return to_float3(triangle_normal(mesh_, places_[i].triangle)); }

  void find_spacings() {
    for (std::size_t i = 0; i < count_; ++i) {
      const SurfacePlace& place = places_[i];
      const double density =
          density_.uniform()
              ? 1.0
              : std::max(source_of(mesh_, density_, place.triangle).density_at(place.b1, place.b2),
                         min_density);
      spacing_[i] = std::max(static_cast<float>(std::sqrt(sample_mass_ / density)), min_spacing);
    }
    smallest_ = *std::min_element(spacing_.begin(), spacing_.end());
  }

  // Lists the samples within so many spacings of each that moves, the nearest if there are too many.
  void find_neighbors(float within) {
    const auto distance = [&](std::size_t i) { return within * spacing_[i]; };
    const auto at = [&](std::size_t j) { return at_[j]; };
    const PointsAround samples(count_, within * smallest_ / 1.5, at, distance);
    near_begin_.assign(count_ + 1, 0);
    pushing_.assign(count_, 0);
    std::vector<std::vector<std::uint32_t>> lists(tasks());
    parallel_tasks(tasks(), [&](std::size_t task) {
      cancel_.check();
      std::vector<std::uint32_t>& list = lists[task];
      std::vector<std::pair<float, std::uint32_t>> near;
      const auto pick = [&](std::size_t first, std::size_t last, const std::vector<std::uint32_t>& found) {
        for (std::size_t i = first; i < last; ++i) {
          if (stays_[i] != 0) continue;
          const std::size_t before = list.size();
          near.clear();
          for (const std::uint32_t j : found) {
            const Float3 way = difference(at_[j], at_[i]);
            const float squared = dot(way, way);
            if (squared < distance(i) * distance(i) && j != i) near.emplace_back(squared, j);
          }
          if (near.size() > neighbors_kept) {
            std::partial_sort(near.begin(), near.begin() + neighbors_kept, near.end());
            near.resize(neighbors_kept);
          }
          // Those that may push come first.
          const float push = (too_near + push_margin) * spacing_[i];
          for (const auto& [squared, j] : near)
            if (squared < push * push) list.push_back(j);
          pushing_[i] = static_cast<std::uint32_t>(list.size() - before);
          for (const auto& [squared, j] : near)
            if (!(squared < push * push)) list.push_back(j);
          near_begin_[i + 1] = near.size();
        }
      };
      samples.visit_runs(task * task_samples, std::min(count_, (task + 1) * task_samples), at_, distance, at,
                         pick);
    });
    for (std::size_t i = 0; i < count_; ++i) near_begin_[i + 1] += near_begin_[i];
    near_.clear();
    near_.reserve(near_begin_[count_]);
    for (std::vector<std::uint32_t>& list : lists) {
      near_.insert(near_.end(), list.begin(), list.end());
      list = {};
    }
  }

  // What the surface attracts each sample with.
  void find_pulls() {
    const SurfaceRows points = surface_points(mesh_, density_, sample_mass_, origin_, cancel_);
    const auto at = [&](std::size_t j) { return Float3{points.x[j], points.y[j], points.z[j]}; };
    const PointsAround surface(points.size(), point_cell * smallest_, at, [](std::size_t) { return 0.0f; });
    start_ = at_;
    pull_.resize(count_);
    parallel_tasks(tasks(), [&](std::size_t task) {
      cancel_.check();
      SurfaceRows around;
      const auto add_up = [&](std::size_t first, std::size_t last, const std::vector<std::uint32_t>& found) {
        around.resize(found.size());
        for (const auto row : {&SurfaceRows::x, &SurfaceRows::y, &SurfaceRows::z, &SurfaceRows::mass,
                               &SurfaceRows::normal_x, &SurfaceRows::normal_y, &SurfaceRows::normal_z}) {
          const float* const from = (points.*row).data();
          float* const to = (around.*row).data();
          for (std::size_t k = 0; k < found.size(); ++k) to[k] = from[found[k]];
        }
        for (std::size_t i = first; i < last; ++i)
          pull_[i] = sum_pull(around, at_[i], normal_[i], 1 / spacing_[i]);
      };
      surface.visit_runs(
          task * task_samples, std::min(count_, (task + 1) * task_samples), at_,
          [&](std::size_t i) { return kernel_end * spacing_[i]; }, at, add_up);
    });
  }

  // What samples may do follows from how much surface there is around them.
  void find_room() {
    stays_.resize(count_);
    room_.resize(count_);
    for (std::size_t i = 0; i < count_; ++i) {
      stays_[i] = pull_[i].facing > stacked * kernel_integral ? 1 : 0;
      room_[i] = 1 / std::sqrt(std::max(1.0f, pull_[i].all / kernel_integral - (room_for_one - 1)));
    }
  }

  Float3 tangential(const Float3& way, std::size_t i) const {
    const float up = dot(way, normal_[i]);
    return {way[0] - up * normal_[i][0], way[1] - up * normal_[i][1], way[2] - up * normal_[i][2]};
  }

  // The step of sample i by what pulls at it, in working units. near: scratch.
  Float3 pulled(std::size_t i, const Moving& at, PointRows& near) const {
    const Float3 p = at[i];
    const float per_spacing = 1 / spacing_[i];
    const std::size_t count = near_begin_[i + 1] - near_begin_[i];
    near.resize((count + 7) / 8 * 8);
    for (std::size_t k = 0; k < near.size(); ++k) {
      const Float3& q = k < count ? at[near_[near_begin_[i] + k]] : p;
      near.x[k] = q[0];
      near.y[k] = q[1];
      near.z[k] = q[2];
    }
    Float3 force = sum_ways(near, p, per_spacing);
    for (float& c : force) c = -c;
    const Pull& pull = pull_[i];
    const Float3 gone = {per_spacing * (p[0] - start_[i][0]), per_spacing * (p[1] - start_[i][1]),
                         per_spacing * (p[2] - start_[i][2])};
    if (dot(gone, gone) > longest_way * longest_way) return {};
    const auto& [xx, xy, xz, yy, yz, zz] = pull.slope;
    force[0] += pull.way[0] + xx * gone[0] + xy * gone[1] + xz * gone[2];
    force[1] += pull.way[1] + xy * gone[0] + yy * gone[1] + yz * gone[2];
    force[2] += pull.way[2] + xz * gone[0] + yz * gone[1] + zz * gone[2];
    Float3 step = along_border(tangential(force, i), i);
    const float length = step_per_pull * std::sqrt(dot(step, step));
    const float scale = step_per_pull * std::min(1.0f, longest_step / std::max(length, longest_step));
    for (float& c : step) c *= scale * spacing_[i];
    return step;
  }

  // Without its part away from the border, as far as there is one: where surface is missing, it is on the
  // side that less pulls to.
  Float3 along_border(Float3 way, std::size_t i) const {
    const float missing = inside - pull_[i].all / kernel_integral;
    if (missing <= 0) return way;
    const Float3 inward = tangential(pull_[i].way, i);
    const float squared = dot(inward, inward);
    if (!(squared > 0)) return way;
    const float share = std::min(missing / (inside - at_border), 1.0f) * dot(way, inward) / squared;
    for (std::size_t c = 0; c < 3; ++c) way[c] -= share * inward[c];
    return way;
  }

  // The step of sample i away from those that are too near.
  Float3 pushed(std::size_t i, const Moving& at) const {
    const Float3 p = at[i];
    const float near = too_near * room_[i] * spacing_[i];
    Float3 step{};
    for (std::size_t k = near_begin_[i]; k < near_begin_[i] + pushing_[i]; ++k) {
      const Float3 way = difference(at[near_[k]], p);
      const float squared = dot(way, way);
      if (!(squared > 0) || squared >= near * near) continue;
      const float length = std::sqrt(squared);
      for (std::size_t c = 0; c < 3; ++c) step[c] -= push_share * (near - length) / length * way[c];
    }
    return tangential(step, i);
  }

  // A neighbor in the tangential plane of a sample, as far away as in space, in spacings.
  struct Around {
    float u, v, squared;
    bool same_side;
  };

  // Those of sample i, or none where there are too many.
  std::size_t find_around(std::size_t i, const Moving& at, const Float3& first, const Float3& second,
                          std::array<Around, max_around_hole>& around) const {
    std::size_t count = 0;
    for (std::size_t k = near_begin_[i]; k < near_begin_[i + 1]; ++k) {
      const std::size_t j = near_[k];
      const Float3 way = difference(at[j], at[i]);
      const float u = dot(way, first), v = dot(way, second), in_plane = u * u + v * v,
                  squared = dot(way, way);
      if (!(in_plane > 0)) continue;
      if (count == max_around_hole) return 0;
      const float scale = std::sqrt(squared / in_plane) / spacing_[i];
      around[count++] = {scale * u, scale * v, scale * scale * in_plane,
                         dot(normal_[j], normal_[i]) > same_side};
    }
    return count;
  }

  // The step of sample i towards the middles of the holes that it is a corner of: circles through it and two
  // of its neighbors, without others inside.
  Float3 drawn(std::size_t i, const Moving& at) const {
    const Float3 up = normal_[i];
    std::size_t flat = 0;
    for (std::size_t c = 1; c < 3; ++c)
      if (std::abs(up[c]) < std::abs(up[flat])) flat = c;
    Float3 first{};
    first[flat] = 1;
    first = tangential(first, i);
    const float length = std::sqrt(dot(first, first));
    for (float& c : first) c /= length;
    const Float3 second{up[1] * first[2] - up[2] * first[1], up[2] * first[0] - up[0] * first[2],
                        up[0] * first[1] - up[1] * first[0]};
    std::array<Around, max_around_hole> around;
    const std::size_t count = find_around(i, at, first, second, around);
    float u = 0, v = 0;
    for (std::size_t j = 0; j < count; ++j)
      for (std::size_t k = j + 1; k < count; ++k) {
        const Around &a = around[j], &b = around[k];
        if (!a.same_side || !b.same_side) continue;
        const float twice = 2 * (a.u * b.v - a.v * b.u);
        const float middle_u = (b.v * a.squared - a.v * b.squared) / twice,
                    middle_v = (a.u * b.squared - b.u * a.squared) / twice;
        const float squared = middle_u * middle_u + middle_v * middle_v;
        if (!(squared > hole * hole && squared < largest_hole * largest_hole)) continue;
        bool empty = true;
        for (std::size_t l = 0; l < count && empty; ++l) {
          const float du = around[l].u - middle_u, dv = around[l].v - middle_v;
          empty = l == j || l == k || du * du + dv * dv >= squared;
        }
        if (!empty) continue;
        const float share = draw_share * (1 - hole / std::sqrt(squared));
        u += share * middle_u;
        v += share * middle_v;
      }
    if (u == 0 && v == 0) return {};
    Float3 step;
    for (std::size_t c = 0; c < 3; ++c) step[c] = spacing_[i] * (u * first[c] + v * second[c]);
    return along_border(step, i);
  }

  // Moves all samples by step(i, at, scratch).
  template <class Step>
  void move_all(const Step& step) {
    std::vector<Float3> now = at_, normal = normal_;
    parallel_tasks(tasks(), [&](std::size_t task) {
      cancel_.check();
      const std::size_t begin = task * task_samples, end = std::min(count_, begin + task_samples);
      const Moving at{at_, now, begin, end};
      PointRows scratch;
      for (std::size_t i = begin; i < end; ++i) {
        if (stays_[i] != 0) continue;
        const Float3 way = step(i, at, scratch);
        if (way == Float3{}) continue;
        places_[i] = walk_on_surface(mesh_, places_[i], {way[0], way[1], way[2]});
        now[i] = place_of(i);
        normal[i] = normal_of(i);
      }
    });
    at_ = std::move(now);
    normal_ = std::move(normal);
  }

  std::size_t tasks() const { return (count_ + task_samples - 1) / task_samples; }

  const PreparedMesh& mesh_;
  const Density& density_;
  std::span<SurfacePlace> places_;
  const CancelToken& cancel_;
  std::size_t count_;
  double sample_mass_;
  Vector3 origin_;
  std::vector<Float3> at_, normal_;      // of the samples, from the origin
  std::vector<float> spacing_;           // in working units
  float smallest_ = 0;                   // of them
  std::vector<Float3> start_;            // where samples were
  std::vector<Pull> pull_;               // there
  std::vector<std::uint8_t> stays_;      // 1: the sample does not move
  std::vector<float> room_;              // for how much of too_near there is room, 0..1
  std::vector<std::uint32_t> near_;      // the neighbors of all samples,
  std::vector<std::size_t> near_begin_;  // where those of each begin,
  std::vector<std::uint32_t> pushing_;   // and how many of them, the first ones, may push it
};

}  // namespace

double relaxation_bytes(double samples, double triangles) {
  // Places, positions and normals twice, pulls and the grid of samples; lists of neighbors twice; points of
  // the surface with their grid, twice while they are made; bins of light triangles, twice while they grow.
  constexpr double bytes_per_sample = 350, bytes_per_point = 100, points_per_sample = 16, bytes_per_bin = 400;
  const double neighbors = std::min(samples, static_cast<double>(neighbors_kept));
  return samples * (bytes_per_sample + 2 * sizeof(std::uint32_t) * neighbors +
                    bytes_per_point * points_per_sample) +
         bytes_per_bin * std::min(triangles, 16 * samples);
}

std::uint32_t relax_samples(const PreparedMesh& mesh, const MeshMeasure& measure,
                            std::span<SurfacePlace> places, const CancelToken& cancel) {
  if (places.empty()) return 0;
  Relaxation relaxation(mesh, measure, places, cancel);
  relaxation.relax();
  return relaxation.held();
}

}  // namespace meander
