#include "kernels/surface/sample_surface.h"

#include <cmath>
#include <numeric>
#include <stdexcept>

#include "kernels/core/check_range.h"
#include "kernels/core/expression.h"
#include "kernels/core/ordered_blocks.h"
#include "kernels/core/random.h"
#include "kernels/sample/redraw_limit.h"
#include "kernels/sample/seen_points.h"
#include "kernels/sample/sequence.h"
#include "kernels/surface/patch_tree.h"
#include "kernels/surface/relax_on_surface.h"
#include "kernels/surface/surface_leaf.h"
#include "kernels/surface/surface_measure.h"
#include "kernels/surface/surface_settings.h"
#include "kernels/surface/surface_strata.h"

namespace meander {

namespace {

constexpr std::size_t sample_block = 1024;
constexpr int max_redraws = 64;

// A sample without a point yet: its leaf, and the number of random numbers it has used.
struct Draft {
  std::uint32_t rank = 0;
  std::uint32_t counter = 0;
  SurfaceLeaf leaf;
};

// Draws points and writes them to their place in the file.
class SurfacePlacer {
 public:
  SurfacePlacer(const SurfaceMeasure& measure, const PatchTree& tree, RandomKey key, PlaceKind place,
                const std::vector<double>& position, const std::vector<std::uint32_t>& place_of_rank,
                SurfaceSamples& samples)
      : measure_(measure),
        tree_(tree),
        key_(key),
        place_(place),
        position_(position),
        place_of_rank_(place_of_rank),
        samples_(samples),
        counter_(position.size(), 0) {}

  // Places the samples of ranks begin .. end - 1.
  void place(std::size_t begin, std::size_t end, std::uint64_t& violations) {
    std::vector<Draft> drafts(end - begin);
    for (std::size_t r = begin; r < end; ++r)
      drafts[r - begin] = {static_cast<std::uint32_t>(r), 0, leaf_at(tree_, position_[r] * tree_.total())};
    if (place_ == PlaceKind::vertex)
      put_centers(drafts);
    else
      draw(drafts, violations);
  }

  // Places the samples of ranks begin .. end - 1 at points of the curve's square: chosen(r).
  template <class Chosen>
  void place_at(const Chosen& chosen, std::size_t begin, std::size_t end) {
    std::vector<double> s(end - begin), t(end - begin);
    for (std::size_t r = begin; r < end; ++r) {
      const UnitPair point = chosen(r);
      s[r - begin] = point.first;
      t[r - begin] = point.second;
    }
    MeasureBatch batch;
    measure_.evaluate(s, t, batch);
    for (std::size_t r = begin; r < end; ++r)
      put({static_cast<std::uint32_t>(r), counter_[r], {}}, {s[r - begin], t[r - begin]}, batch, r - begin);
  }

  // Where the samples have been placed in the curve's square, by rank, from now on.
  void keep_places() { in_square_.resize(position_.size()); }
  std::vector<UnitPair>& in_square() { return in_square_; }

  // Draws the sample of a rank anew, from the next random numbers of its stream.
  void redraw(std::uint32_t rank, std::uint64_t& violations) {
    std::vector<Draft> draft = {{rank, counter_[rank], leaf_at(tree_, position_[rank] * tree_.total())}};
    draw(draft, violations);
  }

 private:
  // Draws mu-uniform points of the leaves: uniform ones, accepted with probability measure / bound. All
  // drafts without a point are evaluated in one batch.
  void draw(std::vector<Draft>& drafts, std::uint64_t& violations) {
    std::vector<double> s(drafts.size()), t(drafts.size());
    MeasureBatch batch;
    for (std::uint32_t trial = 1; !drafts.empty(); ++trial) {
      s.resize(drafts.size());
      t.resize(drafts.size());
      for (std::size_t i = 0; i < drafts.size(); ++i) {
        Draft& draft = drafts[i];
        const UnitPair uniform = random_pair(key_, Stream::element_point, draft.rank, draft.counter++);
        s[i] = draft.leaf.s + uniform.first * draft.leaf.side;
        t[i] = draft.leaf.t + uniform.second * draft.leaf.side;
      }
      measure_.evaluate(s, t, batch);
      std::size_t left = 0;
      for (std::size_t i = 0; i < drafts.size(); ++i) {
        Draft& draft = drafts[i];
        const double accept = random_pair(key_, Stream::element_point, draft.rank, draft.counter++).first;
        const bool above = batch.value[i] > draft.leaf.bound;
        if (accept * draft.leaf.bound < batch.value[i] || trial == max_trials) {
          violations += above || trial == max_trials;
          put(draft, {s[i], t[i]}, batch, i);
        } else {
          drafts[left++] = draft;
        }
      }
      drafts.resize(left);
    }
  }

  // Places samples as Quinn et al. do: at the vertex of the curve, which is the center of the leaf.
  void put_centers(const std::vector<Draft>& drafts) {
    std::vector<double> s(drafts.size()), t(drafts.size());
    for (std::size_t i = 0; i < drafts.size(); ++i) {
      s[i] = drafts[i].leaf.s + 0.5 * drafts[i].leaf.side;
      t[i] = drafts[i].leaf.t + 0.5 * drafts[i].leaf.side;
    }
    MeasureBatch batch;
    measure_.evaluate(s, t, batch);
    for (std::size_t i = 0; i < drafts.size(); ++i) put(drafts[i], {s[i], t[i]}, batch, i);
  }

  void put(const Draft& draft, const UnitPair& in_square, const MeasureBatch& batch, std::size_t i) {
    counter_[draft.rank] = draft.counter;
    if (!in_square_.empty()) in_square_[draft.rank] = in_square;
    const std::size_t at = place_of_rank_[draft.rank];
    const Vector3 p = batch.position[i];
    Vector3 n = batch.du_cross_dv[i];
    const double length = norm(n);
    n = length > 0 && std::isfinite(length) ? (1 / length) * n : Vector3{0, 0, 1};
    float* point = &samples_.points[3 * at];
    float* normal = &samples_.normals[3 * at];
    const OutputFrame& frame = samples_.frame;
    point[0] = static_cast<float>((p.x - frame.loc.x) / frame.scale) + 0.0f;  // no negative zero
    point[1] = static_cast<float>((p.y - frame.loc.y) / frame.scale) + 0.0f;
    point[2] = static_cast<float>((p.z - frame.loc.z) / frame.scale) + 0.0f;
    normal[0] = static_cast<float>(n.x);
    normal[1] = static_cast<float>(n.y);
    normal[2] = static_cast<float>(n.z);
    samples_.uv[2 * at] = batch.u[i];
    samples_.uv[2 * at + 1] = batch.v[i];
    samples_.density[at] = static_cast<float>(batch.density[i]);
  }

  const SurfaceMeasure& measure_;
  const PatchTree& tree_;
  RandomKey key_;
  PlaceKind place_;
  const std::vector<double>& position_;
  const std::vector<std::uint32_t>& place_of_rank_;
  SurfaceSamples& samples_;
  std::vector<std::uint32_t> counter_;  // by rank
  std::vector<UnitPair> in_square_;     // by rank, if they are kept
};

// order[i] = rank of the i-th sample of the file.
std::vector<std::uint32_t> file_order(SampleSequence& sequence, OrderKind order, RandomKey key) {
  const auto count = static_cast<std::uint32_t>(sequence.position.size());
  if (order == OrderKind::progressive)
    return sequence.rank_of_index.empty() ? progressive_order(count, key) : std::move(sequence.rank_of_index);
  std::vector<std::uint32_t> along(count);
  std::iota(along.begin(), along.end(), 0u);
  return along;
}

}  // namespace

std::vector<std::string> validate(const SurfaceSampleParameters& p) {
  std::vector<std::string> problems;
  check_ranges(surface_settings(), p, problems);
  check_range(problems, "jitter", p.jitter, 0.0, 1.0);
  if (p.sequence == SequenceKind::spaced && p.place == PlaceKind::vertex)
    problems.push_back("the sequence spaced chooses points in elements: place at elements, not vertices");
  if (p.finish == FinishKind::relax && p.place == PlaceKind::vertex)
    problems.push_back("the finish `relax` moves samples off the vertices of the curve: place at elements");
  if (p.leaves_per_sample > 0 && p.leaves_per_sample < 1)
    check_range(problems, "leaves per sample", p.leaves_per_sample, 1.0, 1024.0);
  check_range(problems, "least curve depth", p.min_depth, 5, 12);
  if (p.max_depth < p.min_depth) check_range(problems, "max depth", p.max_depth, p.min_depth, 31);
  check_range(problems, "density quantile", p.density.quantile, 0.01, 1.0);
  if (p.density.kind == SurfaceDensityKind::expression) {
    try {
      const Expression compiled(p.density.expression);
    } catch (const std::invalid_argument& error) {
      problems.push_back(error.what());
    }
  } else if (!p.density.expression.empty()) {
    problems.push_back("an expression is given but the density is of another kind");
  }
  return problems;
}

void require_valid(const SurfaceSampleParameters& parameters) {
  std::string all;
  for (const std::string& problem : validate(parameters)) all += (all.empty() ? "" : "; ") + problem;
  if (!all.empty()) throw std::invalid_argument(all);
}

SurfaceSamples sample_surface(const ParametricSurface& surface, const SurfaceSampleParameters& parameters,
                              const CancelToken& cancel) {
  require_valid(parameters);
  const SurfaceMeasure measure(surface, parameters, cancel);
  const PatchTree tree(measure, parameters, cancel);
  const RandomKey key = make_random_key(parameters.seed, surface.content());
  const std::uint32_t count = parameters.samples;

  SurfaceSamples samples;
  samples.area = tree.area();
  samples.measure = tree.total();
  samples.frame = float_frame(measure.box(), box_frame(measure.box()));
  samples.patches = tree.patches().leaf_count();
  samples.unresolved_patches = tree.unresolved();
  for (const std::uint64_t leaves : tree.count_leaves()) samples.leaves += leaves;
  cancel.check();

  const bool is_spaced = parameters.sequence == SequenceKind::spaced;
  SpacedSamples spaced;
  SampleSequence sequence;
  if (is_spaced) {
    const SurfaceStrata strata(measure, tree, count, key);
    spaced = space_samples(strata, parameters.order == OrderKind::progressive, key,
                           spacing_parameters(parameters.spacing), cancel);
    // Samples that coincide are drawn anew from here.
    sequence.position = strata.middles();
    samples.curve_rank = std::move(spaced.rank_of_index);
  } else {
    sequence = make_sequence(parameters.sequence, count, parameters.jitter, key);
    samples.curve_rank = file_order(sequence, parameters.order, key);
  }
  std::vector<std::uint32_t> place_of_rank(count);
  for (std::uint32_t i = 0; i < count; ++i) place_of_rank[samples.curve_rank[i]] = i;
  samples.points.resize(3 * std::size_t{count});
  samples.normals.resize(3 * std::size_t{count});
  samples.density.resize(count);
  samples.uv.resize(2 * std::size_t{count});

  SurfacePlacer placer(measure, tree, key, parameters.place, sequence.position, place_of_rank, samples);
  const bool relaxes = parameters.finish == FinishKind::relax;
  if (relaxes) placer.keep_places();
  std::vector<std::uint64_t> violations((count + sample_block - 1) / sample_block, 0);
  ordered_blocks(count, sample_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    if (is_spaced)
      placer.place_at(
          [&](std::size_t r) {
            return UnitPair{spaced.point[r].first, spaced.point[r].second};
          },
          begin, end);
    else
      placer.place(begin, end, violations[begin / sample_block]);
  });
  samples.bound_violations = std::accumulate(violations.begin(), violations.end(), std::uint64_t{0});
  if (relaxes) {
    std::vector<UnitPair>& places = placer.in_square();
    const bool uniform = parameters.density.kind == SurfaceDensityKind::uniform;
    note_unrelaxed(relax_on_surface(measure, uniform, samples.area, places, cancel), count, samples.notes);
    ordered_blocks(count, sample_block, [&](std::size_t begin, std::size_t end) {
      cancel.check();
      placer.place_at([&](std::size_t r) { return places[r]; }, begin, end);
    });
  }

  SeenPoints seen(count);
  RedrawLimit limit(max_redraws);
  for (std::uint32_t rank = 0; rank < count; ++rank) {
    if (rank % sample_block == 0) cancel.check();
    bool distinct = seen.insert(samples.points, place_of_rank[rank]);
    if (distinct) continue;
    for (int redraw = 0; redraw < limit.now() && !distinct; ++redraw) {
      placer.redraw(rank, samples.bound_violations);
      distinct = seen.insert(samples.points, place_of_rank[rank]);
    }
    distinct ? limit.found() : limit.exhausted();
    samples.coincident_points += !distinct;
  }
  return samples;
}

}  // namespace meander
