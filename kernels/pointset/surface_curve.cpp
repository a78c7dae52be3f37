#include "kernels/pointset/surface_curve.h"

#include "kernels/core/ordered_blocks.h"
#include "kernels/curve/curve_key.h"
#include "kernels/surface/patch_tree.h"
#include "kernels/surface/surface_leaf.h"
#include "kernels/surface/surface_measure.h"

namespace meander {

namespace {

// The key of the first finest cell of the leaf of this depth >= 1 around (s, t).
std::uint64_t first_key(CurveKind kind, double s, double t, int depth) {
  std::uint64_t cells = 1;
  for (int level = curve_key_levels(kind); level > depth; --level)
    cells *= kind == CurveKind::hilbert ? 4 : 9;
  const std::uint64_t key = curve_key(kind, s, t);
  return key - key % cells;
}

}  // namespace

SurfaceCurve build_surface_curve(const ParametricSurface& surface, const SurfaceSampleParameters& parameters,
                                 const CancelToken& cancel) {
  require_valid(parameters);
  const SurfaceMeasure measure(surface, parameters, cancel);
  const PatchTree tree(measure, parameters, cancel);
  const std::vector<std::uint64_t> counts = tree.count_leaves();
  std::vector<std::uint64_t> before(counts.size() + 1, 0);
  for (std::size_t p = 0; p < counts.size(); ++p) before[p + 1] = before[p] + counts[p];

  SurfaceCurve curve;
  curve.tree.kind = parameters.curve;
  for (std::vector<double>* array : {&curve.tree.u, &curve.tree.v, &curve.tree.side, &curve.mass})
    array->resize(before.back());
  curve.tree.key.resize(before.back());
  curve.tree.depth.resize(before.back());
  curve.tree.frame.resize(before.back());
  curve.uv.resize(2 * before.back());
  ordered_blocks(counts.size(), 64, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    std::vector<double> s, t;
    for (std::size_t p = begin; p < end; ++p) {
      std::size_t at = before[p];
      tree.visit_leaves(p, [&](const PatchNode& node) {
        const SurfaceLeaf leaf = leaf_of(tree, p, node);
        curve.tree.u[at] = leaf.s;
        curve.tree.v[at] = leaf.t;
        curve.tree.side[at] = leaf.side;
        curve.tree.depth[at] = node.depth;
        curve.tree.frame[at] = node.frame;
        curve.mass[at] = node.mass;
        ++at;
      });
    }
    for (std::size_t i = before[begin]; i < before[end]; ++i) {
      s.push_back(curve.tree.u[i] + 0.5 * curve.tree.side[i]);
      t.push_back(curve.tree.v[i] + 0.5 * curve.tree.side[i]);
    }
    MeasureBatch batch;
    measure.evaluate(s, t, batch);
    for (std::size_t i = 0; i < s.size(); ++i) {
      const std::size_t leaf = before[begin] + i;
      curve.tree.key[leaf] = first_key(parameters.curve, s[i], t[i], curve.tree.depth[leaf]);
      curve.uv[2 * leaf] = batch.u[i];
      curve.uv[2 * leaf + 1] = batch.v[i];
    }
  });
  return curve;
}

}  // namespace meander
