#include "kernels/surface/surface_strata.h"

#include <algorithm>

#include "kernels/surface/surface_leaf.h"

namespace meander {

namespace {

double unit_from(std::uint32_t word) { return word * 0x1p-32; }

// A stratum's point that is not yet accepted.
struct RedrawnDraft {
  std::size_t index;
  PhiloxBlock words;
  SurfaceLeaf leaf;
};

}  // namespace

SurfaceStrata::SurfaceStrata(const SurfaceMeasure& measure, const PatchTree& tree, std::uint32_t count,
                             RandomKey key)
    : measure_(measure),
      tree_(tree),
      count_(count),
      key_(key),
      shift_(random_pair(key, Stream::sequence_shift, 0).first) {
  const std::array<double, 6>& box = measure.box();
  center_ = {0.5 * (box[0] + box[3]), 0.5 * (box[1] + box[4]), 0.5 * (box[2] + box[5])};
  unit_ = 0.5 * std::max({box[3] - box[0], box[4] - box[1], box[5] - box[2]});
}

std::vector<double> SurfaceStrata::middles() const {
  std::vector<double> position(count_);
  for (std::uint32_t i = 0; i < count_; ++i) {
    const double at = (i + 0.5 + shift_) / count_;
    position[i] = at < 1 ? at : at - 1;
  }
  return position;
}

void SurfaceStrata::draw(std::span<const PointDraw> draws, std::span<StratumPoint> points) const {
  std::vector<RedrawnDraft> drafts(draws.size());
  for (std::size_t i = 0; i < draws.size(); ++i) {
    double at = draws[i].at + shift_;
    if (at >= count_) at -= count_;
    drafts[i] = {i, draws[i].words, leaf_at(tree_, at / count_ * tree_.total())};
  }
  std::vector<double> s, t;
  MeasureBatch batch;
  for (std::uint32_t trial = 1; !drafts.empty(); ++trial) {
    s.resize(drafts.size());
    t.resize(drafts.size());
    for (std::size_t i = 0; i < drafts.size(); ++i) {
      const RedrawnDraft& draft = drafts[i];
      s[i] = draft.leaf.s + unit_from(draft.words[1]) * draft.leaf.side;
      t[i] = draft.leaf.t + unit_from(draft.words[2]) * draft.leaf.side;
    }
    measure_.evaluate(s, t, batch);
    std::size_t left = 0;
    for (std::size_t i = 0; i < drafts.size(); ++i) {
      RedrawnDraft draft = drafts[i];
      if (unit_from(draft.words[3]) * draft.leaf.bound < batch.value[i] || trial == max_trials) {
        const Vector3 at = (1 / unit_) * (batch.position[i] - center_);
        StratumPoint& point = points[draft.index];
        for (std::size_t k = 0; k < 3; ++k)
          point.at[k] = std::clamp(static_cast<float>(k == 0 ? at.x : k == 1 ? at.y : at.z), -2.0f, 2.0f);
        point.density = std::max(static_cast<float>(batch.density[i]), 1e-30f);
        point.first = s[i];
        point.second = t[i];
      } else {
        const PointDraw& from = draws[draft.index];
        draft.words = random_words(key_, Stream::stratum_retry, from.index, from.number * max_trials + trial);
        drafts[left++] = draft;
      }
    }
    drafts.resize(left);
  }
}

}  // namespace meander
