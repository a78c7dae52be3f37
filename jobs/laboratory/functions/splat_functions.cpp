// Samples as splats, those chosen for a view, and as brush strokes.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "jobs/laboratory/functions/laboratory_functions.h"
#include "jobs/laboratory/painted_model.h"
#include "jobs/laboratory/viewed_model.h"
#include "kernels/render/shading.h"
#include "kernels/sample/point_frames.h"

namespace meander {

namespace {

std::vector<Vector3> directions_in(const LaboratoryArguments& given, const char* name) {
  const std::span<const double> values = given.reals(name, 3);
  std::vector<Vector3> result;
  for (std::size_t i = 0; i < values.size(); i += 3)
    result.push_back({values[i], values[i + 1], values[i + 2]});
  if (result.empty()) throw std::invalid_argument(std::string(name) + " must have a direction");
  return result;
}

SplatSizes sizes_of(const LaboratoryArguments& given) {
  return {given.real("cover", SplatSizes{}.cover), given.flag("round")};
}

// A sampled model from one direction. Its mesh, in the units of the samples, fills the picture as in
// surface_picture.
struct SplattedView {
  SplatView view;
  std::vector<float> depth;  // surface_depth of the mesh

  SplattedView(const Model& model, Vector3 towards, const LaboratoryArguments& given) {
    const ItemReport& report = model.row.report;
    const PreparedMesh& mesh = model.surface;
    std::vector<float> corners;
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
      const Vector3 file = to_file(mesh, {mesh.x[v], mesh.y[v], mesh.z[v]});
      for (std::size_t k = 0; k < 3; ++k)
        corners.push_back(static_cast<float>(((k == 0   ? file.x
                                               : k == 1 ? file.y
                                                        : file.z) -
                                              report.loc[k]) /
                                             report.scale));
    }
    const auto size = static_cast<std::uint32_t>(given.whole("size"));
    view = fitted_view(corners, towards, directions_in(given, "up").front(), size, size,
                       given.real("margin", 0.03));
    depth = mesh_depth(model.row, mesh, view);
  }

  // Whether the mesh hides a splat with this longer half-axis, which must then not show through between those
  // in front. A splat behind the surface by less than its own size may reach beyond it, unless it faces away:
  // that one is visible through an opening only.
  bool hides(Vector3 center, Vector3 normal, double half_axis) const {
    const Vector3 at = view.point(center);
    const bool away = view.direction(normal).z < 0;
    double nearest = away ? -1e300 : 1e300;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const double x = std::floor(at.x) + dx, y = std::floor(at.y) + dy;
        const bool inside = x >= 0 && y >= 0 && x < view.width && y < view.height;
        const double there =
            inside ? double{depth[static_cast<std::size_t>(y) * view.width + static_cast<std::size_t>(x)]}
                   : -1e300;
        nearest = away ? std::max(nearest, there) : std::min(nearest, there);
      }
    return at.z + 1 + (away ? 0.25 : 1) * view.scale * half_axis < nearest;
  }

  // The numbers of those that are not hidden.
  std::vector<std::uint32_t> seen(const Row& row, std::span<const float> half_axes) const {
    const auto vector = [](const std::vector<float>& of, std::size_t i) {
      return Vector3{of[3 * i], of[3 * i + 1], of[3 * i + 2]};
    };
    std::vector<std::uint32_t> result;
    for (std::size_t i = 0; i < row.samples.count(); ++i)
      if (!hides(vector(row.samples.points, i), vector(row.samples.normals, i), half_axes[2 * i]))
        result.push_back(static_cast<std::uint32_t>(i));
    return result;
  }
};

// The values of these samples, `each` per sample.
std::vector<float> of_samples(std::span<const float> values, std::size_t each,
                              std::span<const std::uint32_t> numbers) {
  std::vector<float> result;
  if (values.empty()) return result;
  for (const std::uint32_t i : numbers)
    for (std::size_t k = 0; k < each; ++k) result.push_back(values[each * i + k]);
  return result;
}

// Takes vertices and faces, or staged=; run, n, seed; views (K, 3) towards the eye, up (1, 3), size and
// margin of the pictures; cover, the area of a splat over that which its sample represents; round, for discs
// even with tensors; measured, for no pictures. Returns images (K x size x size x 3) and white (K,), the
// share of the visible surface that no splat covers.
LaboratoryResult splats(const LaboratoryArguments& given) {
  const Model model = sampled_model(given);
  const Row& row = model.row;
  const bool closed = is_closed(row);
  const std::vector<float> areas = sample_areas(row, row.samples.count());
  std::vector<std::uint8_t> images;
  std::vector<double> white;
  for (const Vector3& towards : directions_in(given, "views")) {
    const SplattedView from(model, towards, given);
    std::vector<float> half_axes = splat_half_axes(row, areas, sizes_of(given));
    const OrientedSplats all = splats_of(row, half_axes, {&splat_color, 1}, from.view);
    white.push_back(white_space(all, from.view, from.depth).share());
    if (given.flag("measured")) continue;
    const std::vector<std::uint32_t> seen = from.seen(row, half_axes);
    const std::vector<float> centers = of_samples(all.centers, 3, seen),
                             normals = of_samples(all.normals, 3, seen),
                             directions = of_samples(all.directions, 3, seen),
                             axes = of_samples(half_axes, 2, seen);
    const RgbImage image =
        draw_splats({centers, normals, directions, axes, all.colors}, from.view, {.backs = !closed}).image;
    images.insert(images.end(), image.pixels.begin(), image.pixels.end());
  }
  LaboratoryResult result;
  if (!given.flag("measured")) result.add("images", std::move(images));
  result.add("white", std::move(white));
  return result;
}

// Takes vertices and faces, or staged=; run, n, seed; views (K, 3). Returns, for the samples of a progressive
// set that each view keeps, counts (K,); behind (K,), the share that faces away; stays (K - 1,), the share
// that the next view keeps; and kept, the numbers of the samples of the first view. With size, up (1, 3) and
// cover it also returns the image of the splats of the first view (size x size x 3).
LaboratoryResult view_detail_of(const LaboratoryArguments& given) {
  const Model model = sampled_model(given);
  const ViewedModel viewed(model.row, {.both_sides = !is_closed(model.row)}, 0);
  const std::vector<Vector3> views = directions_in(given, "views");
  std::vector<double> counts, behind, stays;
  std::vector<std::uint32_t> first, before;
  for (const Vector3& towards : views) {
    ViewDetail detail = viewed.detail(towards);
    behind.push_back(viewed.behind(detail, towards));
    if (counts.empty())
      first = detail.kept;
    else
      stays.push_back(static_cast<double>(samples_that_stay(before, detail.kept)) /
                      static_cast<double>(std::max<std::size_t>(1, before.size())));
    counts.push_back(static_cast<double>(detail.kept.size()));
    before = std::move(detail.kept);
  }
  LaboratoryResult result;
  if (given.has("size")) {
    const SplattedView from(model, views.front(), given);
    ViewDetail detail = viewed.detail(views.front());
    const std::vector<std::uint32_t> seen = from.seen(
        model.row,
        splat_half_axes(model.row, sample_areas(model.row, model.row.samples.count()), sizes_of(given)));
    std::erase_if(detail.kept,
                  [&](std::uint32_t i) { return !std::binary_search(seen.begin(), seen.end(), i); });
    result.add("image", viewed.draw(detail, from.view, sizes_of(given)).pixels);
  }
  result.add("counts", std::move(counts));
  result.add("behind", std::move(behind));
  result.add("stays", std::move(stays));
  result.add("kept", std::move(first));
  return result;
}

// The share of the model's picture that no stroke of the body reaches, and the standard deviation over the
// mean of the number of strokes on a pixel: all strokes are opaque and leave a mark each.
void add_coverage(const StrokePlan& plan, LaboratoryResult& result) {
  StrokeStyle style = plan.style;
  style.glaze = true;
  style.grain = style.granulation = style.edge = style.impasto = 0;
  style.paper = PaperKind::smooth;
  style.paper_color = {1, 1, 1};
  const float mark = std::exp(-0.25f);
  std::vector<Stroke> body;
  for (Stroke stroke : plan.strokes) {
    if (stroke.layer >= plan.style.layers.size() ||
        plan.style.layers[stroke.layer].purpose != LayerPurpose::body)
      continue;
    stroke.opacity = 1;
    stroke.color = {mark, mark, mark};
    body.push_back(stroke);
  }
  const RgbImage image = paint_strokes(body, plan.brushes, style, plan.canvas, LatticeNoise(picture_key(1)));
  double pixels = 0, bare = 0, sum = 0, squares = 0;
  for (std::uint32_t y = 0; y < image.height; ++y)
    for (std::uint32_t x = 0; x < image.width; ++x) {
      if (!plan.depth.covered(x, y)) continue;
      // 1/4 for every stroke; paper has a little relief.
      const double marks = -4 * std::log(std::max(1e-4, double{linear_light(image.pixel(x, y)[1])}));
      ++pixels;
      bare += marks < 0.25;
      sum += marks;
      squares += marks * marks;
    }
  const double mean = sum / std::max(1.0, pixels);
  result.add("bare", bare / std::max(1.0, pixels));
  result.add("spread", std::sqrt(std::max(0.0, squares / std::max(1.0, pixels) - mean * mean)) / mean);
}

// Takes vertices and faces, or staged=; run (of anisotropic samples), n, seed; medium, as in `meander render
// strokes`; tones, for three tones instead of one; views (1, 3), up (1, 3), size. Returns image (size x size
// x 3) and, with `coverage`, bare and spread of the strokes of the body (see above).
LaboratoryResult strokes(const LaboratoryArguments& given) {
  const Model model = sampled_model(given);
  PaintedModel painted = painted_model(model.surface, model.row);
  const auto medium = std::find(stroke_medium_names.begin(), stroke_medium_names.end(), given.text("medium"));
  if (medium == stroke_medium_names.end()) throw std::invalid_argument("there is no such medium");
  StrokePictureParameters look;
  look.medium = static_cast<StrokeMedium>(medium - stroke_medium_names.begin());
  look.many_tones = given.flag("tones");
  look.width = look.height = static_cast<std::uint32_t>(given.whole("size"));
  look.view = directions_in(given, "views").front();
  look.up = directions_in(given, "up").front();
  look.seed = given.whole("seed", 1);
  // A sample of a closed model that faces away is not visible: without a normal it has no stroke.
  if (is_closed(model.row))
    for (std::size_t i = 0; i < painted.normals.size(); i += 3)
      if (dot({painted.normals[i], painted.normals[i + 1], painted.normals[i + 2]}, look.view) <= 0)
        std::fill_n(painted.normals.begin() + static_cast<std::ptrdiff_t>(i), 3, 0.0f);
  const StrokePlan plan = plan_strokes(painted.spans(), look);
  LaboratoryResult result;
  if (given.flag("coverage")) add_coverage(plan, result);
  result.add("image", paint_strokes(plan.strokes, plan.brushes, plan.style, plan.canvas,
                                    LatticeNoise(picture_key(look.seed)))
                          .pixels);
  return result;
}

constexpr LaboratoryFunction splat_table[] = {
    {"splats", splats}, {"view_detail", view_detail_of}, {"strokes", strokes}};

}  // namespace

const std::span<const LaboratoryFunction> splat_functions = splat_table;

}  // namespace meander
