#include "jobs/python/query_functions.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "jobs/cli/usage_error.h"
#include "jobs/python/array_mesh.h"
#include "jobs/python/sampling_work.h"
#include "kernels/core/parallel.h"
#include "kernels/core/spelling.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/query/surface_sides.h"
#include "kernels/query/winding_number.h"

namespace meander {

namespace {

// The points in working coordinates.
std::vector<double> working_points(const LaboratoryArguments& given, const PreparedMesh& mesh) {
  const std::span<const double> points = given.reals("points", 3);
  require_finite(points, "points");
  const double center[3] = {mesh.center.x, mesh.center.y, mesh.center.z};
  std::vector<double> working(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    working[i] = (points[i] - center[i % 3]) / mesh.unit;
    if (!(std::abs(working[i]) <= farthest_point))
      throw UsageError(fmt::format("points[{}, {}] is {}: farther from the mesh than {:g} times its size",
                                   i / 3, i % 3, points[i], farthest_point));
  }
  return working;
}

TriangleTree tree_of(const PreparedMesh& mesh) {
  return build_triangle_tree(mesh.x, mesh.y, mesh.z, mesh.triangles);
}

CancelToken limit_of(const LaboratoryArguments& given) {
  const double timeout = given.real("timeout");
  return token_of(nullptr, timeout > 0 ? std::optional(timeout) : std::nullopt);
}

// The rule that was asked for, if the surface takes it.
SignRule rule_of(const std::string& word, const PreparedMesh& mesh, const TriangleTree& tree,
                 const OrientedSurface& oriented) {
  SignChoice choice{};
  if (!take_word(sign_choice_words, word, choice))
    throw UsageError("sign: " + none_of(word, all_words(sign_choice_words)));
  const std::optional<SignRule> rule = chosen_rule(choice, mesh, tree, oriented);
  if (!rule)
    throw UsageError(
        fmt::format("sign: the surface is not closed: it has {} open edges; \"auto\" chooses by the "
                    "surface",
                    oriented.open_edges));
  return *rule;
}

}  // namespace

LaboratoryResult signed_distance(const LaboratoryArguments& given) {
  PolygonMesh file = given.mesh();
  const std::string word = given.text("sign");
  const CancelToken cancel = limit_of(given);
  PreparedMesh mesh;
  LabeledPoints labels;
  std::uint32_t open_edges = 0;
  with_threads(static_cast<int>(given.whole("threads")), [&] {
    drop_doubled_faces(file);
    mesh = prepare_mesh(file, cancel);
    const std::vector<double> points = working_points(given, mesh);
    const TriangleTree tree = tree_of(mesh);
    const OrientedSurface oriented = orient_outward(mesh);
    open_edges = oriented.open_edges;
    const SignRule rule = rule_of(word, mesh, tree, oriented);
    labels = label_points(tree, oriented, rule, points, cancel);
  });
  auto& [nearest, sides] = labels;
  const std::size_t count = nearest.distance.size();
  std::vector<std::uint32_t> face(count), corners(3 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t t = nearest.triangle[i];
    face[i] = mesh.polygon[t];
    for (std::size_t k = 0; k < 3; ++k) corners[3 * i + k] = file.corners[mesh.corner_slot[3 * t + k]];
    nearest.distance[i] *= sides.inside[i] != 0 ? -mesh.unit : mesh.unit;
  }
  LaboratoryResult result;
  result.add("distance", std::move(nearest.distance));
  result.add("face", std::move(face));
  result.add("corners", std::move(corners), 3);
  result.add("weights", std::move(nearest.weights), 2);
  result.add("inside", std::move(sides.inside));
  result.add("certain", std::move(sides.certain));
  if (sides.rule == SignRule::closed || sides.rule == SignRule::winding)
    result.add("winding", std::move(sides.winding));
  const std::string_view rule = name_of(sides.rule);
  result.add("sign", std::vector<std::uint8_t>(rule.begin(), rule.end()));
  result.add("open_edges", open_edges);
  return result;
}

LaboratoryResult winding_number(const LaboratoryArguments& given) {
  const PolygonMesh file = given.mesh();
  const double error = given.real("error");
  const CancelToken cancel = limit_of(given);
  std::vector<double> winding;
  with_threads(static_cast<int>(given.whole("threads")), [&] {
    const PreparedMesh mesh = prepare_soup(file, cancel);
    const std::vector<double> points = working_points(given, mesh);
    if (error > 0) {
      const TriangleTree tree = tree_of(mesh);
      winding = winding_numbers(build_winding_tree(tree, {}, error), points, cancel);
      return;
    }
    winding.resize(points.size() / 3);
    parallel_tasks(winding.size(), [&](std::size_t i) {
      cancel.check();
      winding[i] = exact_winding_number(mesh.x, mesh.y, mesh.z, mesh.triangles,
                                        {points[3 * i], points[3 * i + 1], points[3 * i + 2]});
    });
  });
  LaboratoryResult result;
  result.add("winding", std::move(winding));
  return result;
}

}  // namespace meander
