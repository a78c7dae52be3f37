// Strokes: where they lie, what they follow, and how they are painted.
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <vector>

#include "kernels/render/stroke_picture.h"
#include "support/catch.h"

using namespace meander;

namespace {

struct TestModel {
  std::vector<double> positions, points;
  std::vector<std::uint32_t> faces;
  std::vector<float> normals, directions, spacings;

  StrokeModel spans() const { return {positions, faces, points, normals, directions, spacings}; }
  StrokeModel first(std::size_t n) const {
    return {positions,
            faces,
            std::span(points).first(3 * n),
            std::span(normals).first(3 * n),
            std::span(directions).first(3 * n),
            std::span(spacings).first(2 * n)};
  }
  void vertex(Vector3 p) { positions.insert(positions.end(), {p.x, p.y, p.z}); }
  void sample(Vector3 p, Vector3 n, Vector3 d, double s1, double s2) {
    points.insert(points.end(), {p.x, p.y, p.z});
    for (const double v : {n.x, n.y, n.z}) normals.push_back(static_cast<float>(v));
    for (const double v : {d.x, d.y, d.z}) directions.push_back(static_cast<float>(v));
    for (const double v : {s1, s2}) spacings.push_back(static_cast<float>(v));
  }
  // A grid of vertices at(i, j), i < columns, j < rows.
  template <class At>
  void grid(std::uint32_t columns, std::uint32_t rows, const At& at) {
    const auto base = static_cast<std::uint32_t>(positions.size() / 3);
    for (std::uint32_t j = 0; j < rows; ++j)
      for (std::uint32_t i = 0; i < columns; ++i) vertex(at(i, j));
    for (std::uint32_t j = 0; j + 1 < rows; ++j)
      for (std::uint32_t i = 0; i + 1 < columns; ++i) {
        const std::uint32_t a = base + j * columns + i, b = a + 1, c = a + columns, d = c + 1;
        faces.insert(faces.end(), {a, b, d, a, d, c});
      }
  }
};

// Well spread in the unit square, in progressive order.
struct UnitPoint {
  double u, v;
};
UnitPoint spread(std::size_t i) {
  const double a = 0.5 + 0.7548776662466927 * static_cast<double>(i),
               b = 0.5 + 0.5698402909980532 * static_cast<double>(i);
  return {a - std::floor(a), b - std::floor(b)};
}

constexpr double two_pi = 2 * std::numbers::pi;

// Radius 1, height 4 along y; spacings along the axis grow with the height.
TestModel cylinder(std::size_t samples) {
  TestModel model;
  const auto at = [](double u, double y) { return Vector3{std::cos(two_pi * u), y, std::sin(two_pi * u)}; };
  model.grid(97, 33, [&](std::uint32_t i, std::uint32_t j) { return at(i / 96.0, 4 * (j / 32.0)); });
  for (std::size_t i = 0; i < samples; ++i) {
    const UnitPoint p = spread(i);
    const Vector3 n = at(p.u, 0);
    model.sample(at(p.u, 4 * p.v), n, {0, 1, 0}, std::exp(2 * p.v), 1);
  }
  return model;
}

UnitPoint independent(std::size_t i) {
  const UnitPair pair = random_pair(picture_key(99), Stream::test_shapes, i);
  return {pair.first, pair.second};
}

// Radii 1 and 0.4 around y; the primary direction goes around the axis.
TestModel torus(std::size_t samples, UnitPoint (*place)(std::size_t) = spread) {
  TestModel model;
  const auto normal = [](double u, double v) {
    return Vector3{std::cos(two_pi * u) * std::cos(two_pi * v), std::sin(two_pi * v),
                   std::sin(two_pi * u) * std::cos(two_pi * v)};
  };
  const auto at = [&](double u, double v) {
    return Vector3{std::cos(two_pi * u), 0, std::sin(two_pi * u)} + 0.4 * normal(u, v);
  };
  model.grid(129, 65, [&](std::uint32_t i, std::uint32_t j) { return at(i / 128.0, j / 64.0); });
  for (std::size_t i = 0; i < samples; ++i) {
    const UnitPoint p = place(i);
    model.sample(at(p.u, p.v), normal(p.u, p.v), {-std::sin(two_pi * p.u), 0, std::cos(two_pi * p.u)},
                 1 + 0.4 * std::cos(two_pi * p.v), 0.4);
  }
  return model;
}

// A square that faces the eye of look().
TestModel plate(std::size_t samples) {
  TestModel model;
  model.grid(2, 2, [](std::uint32_t i, std::uint32_t j) { return Vector3{double(i), double(j), 0}; });
  for (std::size_t i = 0; i < samples; ++i) {
    const UnitPoint p = spread(i);
    model.sample({p.u, p.v, 0}, {0, 0, 1}, {1, 0, 0}, 1, 1);
  }
  return model;
}

StrokePictureParameters look(StrokeMedium medium, std::uint32_t size = 240) {
  StrokePictureParameters parameters;
  parameters.medium = medium;
  parameters.width = parameters.height = size;
  parameters.view = {0.3, 0.4, 1};
  return parameters;
}

bool along_primary(const StrokePlan& plan, const Stroke& stroke) {
  if (stroke.layer >= plan.style.layers.size()) return false;
  const LayerPurpose purpose = plan.style.layers[stroke.layer].purpose;
  return purpose != LayerPurpose::cross && purpose != LayerPurpose::contour;
}

Vector3 at(const std::vector<float>& values, std::size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

// Axes of the picture, from the definition of a view.
struct Axes {
  Vector3 right, down, back;
};
Axes axes_of(const StrokePictureParameters& parameters) {
  const auto unit = [](Vector3 v) { return (1 / norm(v)) * v; };
  const Vector3 back = unit(parameters.view), right = unit(cross(parameters.up, back));
  return {right, cross(right, back), back};
}

std::vector<std::uint8_t> paper_alone(StrokePictureParameters parameters) {
  return stroke_picture({}, parameters).pixels;
}

double mean_value(const RgbImage& image) {
  double sum = 0;
  for (const std::uint8_t value : image.pixels) sum += value;
  return sum / static_cast<double>(image.pixels.size());
}

}  // namespace

TEST_CASE("strokes: run along the primary direction as the picture shows it") {
  for (const TestModel& model : {cylinder(3000), torus(3000)})
    for (const StrokeMedium medium : {StrokeMedium::oil, StrokeMedium::ink, StrokeMedium::watercolor}) {
      const StrokePictureParameters parameters = look(medium);
      const StrokePlan plan = plan_strokes(model.spans(), parameters);
      const Axes axes = axes_of(parameters);
      REQUIRE(std::abs(dot(axes.down, axes.right)) < 1e-12);
      std::size_t checked = 0;
      for (const Stroke& stroke : plan.strokes) {
        if (!along_primary(plan, stroke)) continue;
        const Vector3 d = at(model.directions, stroke.sample);
        const double x = dot(axes.right, d), y = dot(axes.down, d), seen = std::hypot(x, y);
        if (seen < 0.05) continue;
        const double jitter = plan.style.layers[stroke.layer].angle_jitter;
        // The sine of the angle between two lines without a sign.
        const double sine = std::abs(x * double{stroke.sine} - y * double{stroke.cosine}) / seen;
        CHECK(sine <= std::sin(jitter) + 1e-5);
        ++checked;
      }
      CHECK(checked > 200);
    }
}

TEST_CASE("hatching: runs across in shadows, and along the silhouette as contours") {
  const TestModel model = cylinder(4000);
  const StrokePictureParameters parameters = look(StrokeMedium::ink);
  const StrokePlan plan = plan_strokes(model.spans(), parameters);
  const Axes axes = axes_of(parameters);
  std::size_t across = 0, contours = 0;
  for (const Stroke& stroke : plan.strokes) {
    if (stroke.layer >= plan.style.layers.size()) continue;
    const StrokeLayer& layer = plan.style.layers[stroke.layer];
    const Vector3 n = at(model.normals, stroke.sample), d = at(model.directions, stroke.sample);
    Vector3 line = cross(n, d);
    if (layer.purpose == LayerPurpose::contour) line = cross(n, axes.back);
    if (layer.purpose != LayerPurpose::contour && layer.purpose != LayerPurpose::cross) continue;
    const double x = dot(axes.right, line), y = dot(axes.down, line), seen = std::hypot(x, y);
    if (seen < 0.05) continue;
    CHECK(std::abs(x * double{stroke.sine} - y * double{stroke.cosine}) / seen <=
          std::sin(layer.angle_jitter) + 1e-5);
    ++(layer.purpose == LayerPurpose::cross ? across : contours);
    if (layer.purpose == LayerPurpose::contour) CHECK(std::abs(dot(n, axes.back)) < 0.35);
  }
  CHECK(across > 100);
  CHECK(contours > 50);
}

TEST_CASE("strokes: are as long as the primary spacing requires") {
  const TestModel model = cylinder(4000);
  const StrokePictureParameters parameters = look(StrokeMedium::pastel);
  const StrokePlan plan = plan_strokes(model.spans(), parameters);
  // The logarithm is 2 v with v even in [0, 1]: bin k between the quantiles holds v = 0.05 + 0.9 (k .. k + 1)
  // / 10.
  const Axes axes = axes_of(parameters);
  const double seen = std::hypot(dot(axes.right, {0, 1, 0}), dot(axes.down, {0, 1, 0}));
  std::set<int> bins;
  std::vector<float> length_of_bin(brush_lengths, 0);
  for (const Stroke& stroke : plan.strokes) {
    if (!along_primary(plan, stroke) || plan.style.layers[stroke.layer].purpose != LayerPurpose::body)
      continue;
    const double v = 0.5 * std::log(double{model.spacings[2 * stroke.sample]});
    const double bin = std::clamp((v - 0.05) / 0.9 * 10, 0.0, 9.0);
    CHECK(std::abs(bin - 0.5 - stroke.brush_length) <= 0.65);
    bins.insert(stroke.brush_length);
    float& length = length_of_bin[stroke.brush_length];
    if (length > 0) CHECK(stroke.length == Approx(length));
    length = stroke.length;
  }
  REQUIRE(bins.size() == brush_lengths);
  // Equal ratios from the shortest to the longest, shortened as the axis is.
  const StrokeLayer& layer = plan.style.layers[1];
  REQUIRE(layer.purpose == LayerPurpose::body);
  CHECK(length_of_bin[9] / length_of_bin[0] == Approx(layer.longest / layer.shortest).epsilon(1e-4));
  for (std::size_t k = 1; k < brush_lengths; ++k)
    CHECK(length_of_bin[k] / length_of_bin[k - 1] ==
          Approx(std::pow(layer.longest / layer.shortest, 1 / 9.0)).epsilon(1e-4));
  CHECK(seen > 0.9);
  // One spacing everywhere: the middle length.
  const TestModel flat = plate(500);
  for (const Stroke& stroke : plan_strokes(flat.spans(), parameters).strokes)
    if (stroke.layer < plan.style.layers.size()) CHECK(stroke.brush_length == brush_lengths / 2);
}

TEST_CASE("strokes: only visible samples have them, and they reach beyond the silhouette") {
  const TestModel ring = torus(4000);
  const StrokePictureParameters parameters = look(StrokeMedium::acrylic);
  const StrokePlan plan = plan_strokes(ring.spans(), parameters);
  const Axes axes = axes_of(parameters);
  CHECK(plan.visible > 1000);
  CHECK(plan.visible < 2000);
  for (const Stroke& stroke : plan.strokes)
    if (stroke.layer < plan.style.layers.size())
      // Within a pixel of the silhouette.
      CHECK(dot(at(ring.normals, stroke.sample), axes.back) > -0.2);
  // A plate in front of another one hides its samples, all but those that look out around it.
  TestModel both = plate(1000);
  const std::size_t behind = both.points.size() / 3;
  both.grid(2, 2, [](std::uint32_t i, std::uint32_t j) { return Vector3{double(i), double(j), -0.5}; });
  for (std::size_t i = 0; i < 1000; ++i) {
    const UnitPoint p = spread(i);
    both.sample({p.u, p.v, -0.5}, {0, 0, 1}, {1, 0, 0}, 1, 1);
  }
  StrokePictureParameters straight = look(StrokeMedium::acrylic);
  straight.view = {0, 0, 1};
  const StrokePlan stacked = plan_strokes(both.spans(), straight);
  CHECK(stacked.visible == 1000);
  float least = 1e9f, left_most = 1e9f;
  for (const Stroke& stroke : stacked.strokes) {
    if (stroke.layer >= stacked.style.layers.size()) continue;
    CHECK(stroke.sample < behind);
    least = std::min(least, stroke.x);
    left_most = std::min(left_most, stroke.x - 0.5f * stroke.length);
  }
  CHECK(left_most < least - 4);
}

TEST_CASE("strokes: surfaces just behind the silhouette are not painted, so lit rims stay free of shadow") {
  const TestModel ring = torus(60000);
  const StrokePictureParameters parameters = look(StrokeMedium::watercolor, 480);
  const StrokePlan plan = plan_strokes(ring.spans(), parameters);
  const Axes axes = axes_of(parameters);
  std::size_t rim = 0;
  for (const Stroke& stroke : plan.strokes) {
    if (stroke.layer >= plan.style.layers.size()) continue;
    const double facing = dot(at(ring.normals, stroke.sample), axes.back);
    CHECK((facing >= 0 || facing <= -0.1));
    rim += facing >= 0 && facing < 0.1;
  }
  CHECK(rim > 100);
}

TEST_CASE("strokes: a shadow on bare paper ends before the margin, one on a painted ground need not") {
  const TestModel model = cylinder(1500);
  for (const StrokeMedium medium : {StrokeMedium::crayon, StrokeMedium::ink, StrokeMedium::watercolor}) {
    StrokePictureParameters parameters = look(medium, 400);
    parameters.light = {-1, 0.5, 0.3};  // low: the shadow is longer than the picture
    const StrokePlan plan = plan_strokes(model.spans(), parameters);
    std::size_t cast = 0;
    double farthest = 0;
    for (const Stroke& stroke : plan.strokes) {
      if (stroke.layer != plan.style.layers.size() + 2) continue;
      ++cast;
      farthest =
          std::max(farthest, static_cast<double>(stroke.x + 0.5f * stroke.length * std::abs(stroke.cosine)));
    }
    CHECK(cast > 3);
    CHECK(farthest <= 400 - plan.canvas.margin);
  }
}

TEST_CASE("strokes: layers are prefixes of one set, and so are the strokes of fewer samples") {
  const TestModel model = torus(3000);
  for (std::size_t m = 0; m < stroke_medium_names.size(); ++m) {
    const auto parameters = look(static_cast<StrokeMedium>(m));
    const StrokePlan all = plan_strokes(model.spans(), parameters);
    for (const Stroke& stroke : all.strokes) {
      if (stroke.layer >= all.style.layers.size()) continue;
      CHECK(stroke.sample <= std::ceil(all.style.layers[stroke.layer].share * 3000));
    }
  }
  // Every sample of the body has one stroke: those of a prefix are the same but for their size.
  const auto parameters = look(StrokeMedium::crayon);
  const StrokePlan all = plan_strokes(model.spans(), parameters),
                   half = plan_strokes(model.first(1500), parameters);
  std::vector<const Stroke*> of_all(3000), of_half(3000);
  for (const Stroke& stroke : all.strokes)
    if (stroke.layer == 1) of_all[stroke.sample] = &stroke;
  for (const Stroke& stroke : half.strokes)
    if (stroke.layer == 1) of_half[stroke.sample] = &stroke;
  std::size_t shared = 0;
  for (std::size_t i = 0; i < 900; ++i) {
    REQUIRE((of_all[i] == nullptr) == (of_half[i] == nullptr));
    if (of_all[i] == nullptr) continue;
    ++shared;
    CHECK(of_all[i]->x == of_half[i]->x);
    CHECK(of_all[i]->y == of_half[i]->y);
    CHECK(of_all[i]->cosine == of_half[i]->cosine);
    CHECK(of_all[i]->color == of_half[i]->color);
  }
  CHECK(shared > 200);
}

TEST_CASE("hatching: strokes drawn in the light are drawn in the shadow too, and the tone is preserved") {
  const TestModel model = plate(6000);
  std::set<std::uint32_t> fewer;
  double brighter = 256;
  for (const double near : {1.0, 0.6, 0.35, 0.1}) {
    StrokePictureParameters parameters = look(StrokeMedium::ink, 300);
    parameters.view = {0, 0, 1};
    parameters.light = {-std::sqrt(1 - near * near), 0, near};
    const StrokePlan plan = plan_strokes(model.spans(), parameters);
    std::set<std::uint32_t> drawn;
    for (const Stroke& stroke : plan.strokes)
      if (stroke.layer == 0) drawn.insert(stroke.sample);
    CHECK(std::includes(drawn.begin(), drawn.end(), fewer.begin(), fewer.end()));
    // One tone everywhere: the first so many samples.
    if (!drawn.empty()) CHECK(*drawn.rbegin() + 1 == drawn.size());
    fewer = drawn;
    const double value = mean_value(stroke_picture(model.spans(), parameters));
    CHECK(value < brighter);
    brighter = value;
  }
  CHECK(fewer.size() > 500);
}

TEST_CASE("strokes: well-spread samples leave less of the model bare than independent ones") {
  const auto bare = [](const TestModel& model) {
    StrokePlan plan = plan_strokes(model.spans(), look(StrokeMedium::acrylic, 300));
    std::erase_if(plan.strokes, [&](const Stroke& stroke) {
      return stroke.layer >= plan.style.layers.size() ||
             plan.style.layers[stroke.layer].purpose != LayerPurpose::body;
    });
    for (Stroke& stroke : plan.strokes) stroke.color = {0, 0, 0};
    plan.style.impasto = plan.style.gloss = 0;
    plan.style.paper_color = {1, 1, 1};
    const RgbImage image =
        paint_strokes(plan.strokes, plan.brushes, plan.style, plan.canvas, LatticeNoise(picture_key(1)));
    std::size_t count = 0;
    for (std::uint32_t y = 0; y < image.height; ++y)
      for (std::uint32_t x = 0; x < image.width; ++x)
        count += plan.depth.covered(x, y) && image.pixel(x, y)[1] > 128;
    return count;
  };
  const std::size_t even = bare(torus(8000)), uneven = bare(torus(8000, independent));
  CHECK(uneven > 200);
  CHECK(2 * even < uneven);
}

TEST_CASE("strokes: one seed gives one picture for any number of threads, another seed another") {
  const TestModel model = torus(1500);
  for (std::size_t m = 0; m < stroke_medium_names.size(); ++m) {
    StrokePictureParameters parameters = look(static_cast<StrokeMedium>(m), 160);
    std::vector<std::uint8_t> one, four;
    {
      const oneapi::tbb::global_control control(oneapi::tbb::global_control::max_allowed_parallelism, 1);
      one = stroke_picture(model.spans(), parameters).pixels;
    }
    {
      const oneapi::tbb::global_control control(oneapi::tbb::global_control::max_allowed_parallelism, 4);
      four = stroke_picture(model.spans(), parameters).pixels;
    }
    CHECK(one == four);
    parameters.seed = 2;
    CHECK(one != stroke_picture(model.spans(), parameters).pixels);
  }
}

TEST_CASE("strokes: the margin stays paper") {
  const TestModel model = cylinder(1500);
  for (std::size_t m = 0; m < stroke_medium_names.size(); ++m) {
    StrokePictureParameters parameters = look(static_cast<StrokeMedium>(m), 160);
    parameters.margin = 0.1;
    const RgbImage picture = stroke_picture(model.spans(), parameters);
    parameters.medium = static_cast<StrokeMedium>(m);
    const RgbImage paper =
        paint_strokes({}, {}, stroke_style(parameters.medium), {160, 160, 16, 160 / 1080.0},
                      LatticeNoise(picture_key(parameters.seed)));
    std::size_t painted = 0;
    for (std::uint32_t y = 0; y < 160; ++y)
      for (std::uint32_t x = 0; x < 160; ++x) {
        const bool same = std::equal(picture.pixel(x, y), picture.pixel(x, y) + 3, paper.pixel(x, y));
        const bool inside = x >= 16 && y >= 16 && x < 144 && y < 144;
        if (!inside) CHECK(same);
        painted += !same;
      }
    CHECK(painted > 500);
  }
}

TEST_CASE("strokes: models without samples and non-finite numbers") {
  constexpr double infinite = std::numeric_limits<double>::infinity(),
                   nan = std::numeric_limits<double>::quiet_NaN();
  TestModel bad = plate(50);
  bad.vertex({nan, 0, 0});
  bad.vertex({infinite, 1, 0});
  bad.faces.insert(bad.faces.end(), {0, 1, 4, 1, 2, 5, 0, 0, 0});
  bad.sample({nan, 0, 0}, {0, 0, 1}, {1, 0, 0}, 1, 1);
  bad.sample({0.5, infinite, 0}, {0, 0, 1}, {1, 0, 0}, 1, 1);
  bad.sample({0.5, 0.5, 0}, {nan, 0, 1}, {1, 0, 0}, 1, 1);
  bad.sample({0.5, 0.5, 0}, {0, 0, 0}, {1, 0, 0}, 1, 1);
  bad.sample({0.5, 0.5, 0}, {0, 0, 1}, {0, 0, 0}, 1, 1);
  bad.sample({0.5, 0.5, 0}, {0, 0, 1}, {0, 0, 1}, 0, nan);
  bad.sample({0.2, 0.5, 0}, {0, 0, 1}, {1, 0, 0}, infinite, -1);
  bad.sample({1e300, 0.5, 0}, {0, 0, 1}, {1, 0, 0}, 1, 1);
  TestModel point;
  point.grid(2, 2, [](std::uint32_t, std::uint32_t) { return Vector3{3, 3, 3}; });
  for (int i = 0; i < 20; ++i) point.sample({3, 3, 3}, {0, 0, 1}, {1, 0, 0}, 1, 1);
  TestModel huge = plate(100);
  for (double& v : huge.positions) v *= 1e300;
  for (double& v : huge.points) v *= 1e300;
  for (std::size_t m = 0; m < stroke_medium_names.size(); ++m) {
    const auto parameters = look(static_cast<StrokeMedium>(m), 96);
    const std::size_t pixels = std::size_t{3} * 96 * 96;
    const StrokePlan plan = plan_strokes(bad.spans(), parameters);
    CHECK(plan.visible <= 52);
    for (const Stroke& stroke : plan.strokes) {
      CHECK(std::isfinite(stroke.x + stroke.y + stroke.length + stroke.width + stroke.bend));
      CHECK(std::abs(stroke.cosine * stroke.cosine + stroke.sine * stroke.sine - 1) < 1e-4f);
    }
    CHECK(stroke_picture(bad.spans(), parameters).pixels.size() == pixels);
    CHECK(stroke_picture(point.spans(), parameters).pixels.size() == pixels);
    CHECK(stroke_picture(huge.spans(), parameters).pixels.size() == pixels);
    CHECK(plan_strokes({}, parameters).visible == 0);
    CHECK(paper_alone(parameters).size() == pixels);
  }
}

TEST_CASE("strokes: arrays of the wrong size are refused") {
  const TestModel model = plate(10);
  StrokeModel spans = model.spans();
  spans.spacings = spans.spacings.first(4);
  CHECK_THROWS_AS(plan_strokes(spans, look(StrokeMedium::oil)), std::invalid_argument);
  const std::vector<std::uint32_t> faces = {0, 1, 9};
  spans = model.spans();
  spans.faces = faces;
  CHECK_THROWS_AS(plan_strokes(spans, look(StrokeMedium::oil)), std::invalid_argument);
  StrokePictureParameters wrong = look(StrokeMedium::oil);
  wrong.many_tones = true;
  wrong.width = 10;
  wrong.margin = 0.5;
  wrong.view = wrong.up;
  wrong.light = {0, 0, 0};
  CHECK(validate(wrong).size() == 5);
  CHECK(validate(look(StrokeMedium::ink)).empty());
  CHECK_THROWS_AS(plan_strokes(model.spans(), wrong), std::invalid_argument);
  const Stroke stray{.x = 10, .y = 10, .length = 5, .width = 2};
  CHECK_THROWS_AS(paint_strokes(std::span(&stray, 1), {}, stroke_style(StrokeMedium::oil), {64, 64, 0, 1},
                                LatticeNoise(picture_key(1))),
                  std::invalid_argument);
}

TEST_CASE("brushes: ten lengths, five variations, empty borders") {
  const LatticeNoise noise(picture_key(1));
  for (std::size_t m = 0; m < stroke_medium_names.size(); ++m) {
    const BrushShape shape = stroke_style(static_cast<StrokeMedium>(m)).brush;
    const BrushSet set = make_brushes(shape, 8, 20, 80, noise);
    REQUIRE(set.textures.size() == brush_lengths * brush_variations);
    CHECK(set.at(0, 0).along == 22);
    CHECK(set.at(9, 0).along == 82);
    for (const BrushTexture& brush : set.textures) {
      CHECK(brush.across == 10);
      CHECK(brush.mean_cover > 0.15f);
      for (std::uint32_t j = 0; j < brush.across; ++j)
        for (std::uint32_t i = 0; i < brush.along; ++i) {
          const BrushTexel& texel = brush.texels[std::size_t{j} * brush.along + i];
          if (i == 0 || j == 0 || i + 1 == brush.along || j + 1 == brush.across) REQUIRE(texel.cover == 0);
          REQUIRE(texel.cover >= 0);
          REQUIRE(texel.cover <= 1 + shape.rim);
          REQUIRE(texel.height >= 0);
        }
    }
    const auto differ = [&](const BrushTexture& a, const BrushTexture& b) {
      double sum = 0;
      for (std::size_t i = 0; i < a.texels.size(); ++i)
        sum += std::abs(double{a.texels[i].cover} - double{b.texels[i].cover});
      return sum;
    };
    for (std::size_t v = 1; v < brush_variations; ++v) CHECK(differ(set.at(4, 0), set.at(4, v)) > 0.5);
  }
}

namespace {

// One brush that covers all of its quadrilateral.
BrushSet full_brush() {
  BrushSet set;
  set.textures.resize(brush_lengths * brush_variations);
  for (BrushTexture& brush : set.textures) {
    brush.along = brush.across = 4;
    brush.texels.assign(16, {1, 0});
    brush.mean_cover = 1;
  }
  return set;
}

RgbImage painted(const std::vector<Stroke>& strokes, bool glaze) {
  StrokeStyle style;
  style.paper_color = {1, 1, 1};
  style.glaze = glaze;
  const std::vector<BrushSet> brushes = {full_brush()};
  return paint_strokes(strokes, brushes, style, {100, 100, 5, 1}, LatticeNoise(picture_key(1)));
}

Stroke stroke_at(float x, float y, LinearColor color) {
  Stroke stroke;
  stroke.x = x;
  stroke.y = y;
  stroke.length = 40;
  stroke.width = 6;
  stroke.color = color;
  return stroke;
}

}  // namespace

TEST_CASE("paint_strokes: a stroke covers its rectangle, bent or rotated, over the earlier ones") {
  const LinearColor black{0, 0, 0}, red{1, 0, 0};
  const auto is_dark = [](const RgbImage& image, std::uint32_t x, std::uint32_t y) {
    return image.pixel(x, y)[1] < 40;
  };
  Stroke stroke = stroke_at(50, 50, black);
  RgbImage image = painted({stroke}, false);
  std::size_t dark = 0;
  for (std::uint32_t y = 0; y < 100; ++y)
    for (std::uint32_t x = 0; x < 100; ++x) {
      const bool inside = x >= 30 && x < 70 && y >= 47 && y < 53;
      CHECK(is_dark(image, x, y) == inside);
      dark += is_dark(image, x, y);
    }
  CHECK(dark == 240);
  // Turned by 30 degrees it keeps its area; its ends lie where they should.
  stroke.cosine = static_cast<float>(std::cos(std::numbers::pi / 6));
  stroke.sine = 0.5f;
  image = painted({stroke}, false);
  dark = 0;
  for (std::uint32_t y = 0; y < 100; ++y)
    for (std::uint32_t x = 0; x < 100; ++x) dark += is_dark(image, x, y);
  CHECK(dark == Approx(240).epsilon(0.04));
  CHECK(is_dark(image, 50 + 15, 50 + 9));
  CHECK_FALSE(is_dark(image, 50 + 15, 50 - 9));
  // Bent: the middle line is at bend s^2 / 2.
  stroke = stroke_at(50, 50, black);
  stroke.bend = 0.04f;
  image = painted({stroke}, false);
  for (const int s : {-18, -10, 0, 10, 18}) {
    const auto x = static_cast<std::uint32_t>(50 + s);
    const double middle = 50 + 0.02 * (s + 0.5) * (s + 0.5);
    CHECK(is_dark(image, x, static_cast<std::uint32_t>(middle)));
    CHECK_FALSE(is_dark(image, x, static_cast<std::uint32_t>(middle + 4.5)));
    CHECK_FALSE(is_dark(image, x, static_cast<std::uint32_t>(middle - 4.5)));
  }
  // The later of two covers; both are cut at the margin of 5.
  Stroke crossing = stroke_at(50, 50, red);
  crossing.cosine = 0;
  crossing.sine = 1;
  CHECK(painted({stroke_at(50, 50, black), crossing}, false).pixel(50, 50)[0] > 200);
  CHECK(painted({crossing, stroke_at(50, 50, black)}, false).pixel(50, 50)[0] < 60);
  image = painted({stroke_at(10, 50, black)}, false);
  CHECK(is_dark(image, 5, 50));
  CHECK_FALSE(is_dark(image, 4, 50));
}

TEST_CASE("paint_strokes: sticks pressed in the dark fill more of the paper grain") {
  const LatticeNoise noise(picture_key(3));
  const StrokeCanvas canvas{100, 100, 5, 1};
  const BrushSet brush = make_brushes({}, 30, 40, 80, noise);
  StrokeStyle style = stroke_style(StrokeMedium::crayon);
  const auto bare_share = [&](LinearColor color, bool sticks) {
    style.sticks = sticks;
    Stroke stroke = stroke_at(50, 50, color);
    stroke.width = 30;
    const std::array<Stroke, 1> one = {stroke};
    const std::array<BrushSet, 1> brushes = {brush};
    const RgbImage image = paint_strokes(one, brushes, style, canvas, noise);
    std::size_t bare = 0;
    for (std::uint32_t y = 42; y < 58; ++y)
      for (std::uint32_t x = 36; x < 64; ++x) bare += image.pixel(x, y)[1] > 120;
    return bare;
  };
  const LinearColor dark{0.01f, 0.01f, 0.02f};
  CHECK(bare_share(dark, false) > 20);
  CHECK(2 * bare_share(dark, true) < bare_share(dark, false));
}

TEST_CASE("paint_strokes: wet washes run into one another in patches, and bare paper stays bare") {
  const LatticeNoise noise(picture_key(3));
  const StrokeCanvas canvas{1400, 100, 5, 1};  // twenty patches across
  const std::array<BrushSet, 1> brushes = {full_brush()};
  Stroke light = stroke_at(700, 40, {0.9f, 0.9f, 0.9f}), deep = stroke_at(700, 62, {0.2f, 0.2f, 0.2f});
  light.width = deep.width = 30;
  light.length = deep.length = 1360;
  const std::array<Stroke, 2> strokes = {light, deep};
  StrokeStyle style;
  style.glaze = true;
  style.paper_color = {1, 1, 1};
  const RgbImage dry = paint_strokes(strokes, brushes, style, canvas, noise);
  style.wet = 1;
  const RgbImage wet = paint_strokes(strokes, brushes, style, canvas, noise);
  // The largest step across the edge of the deep wash, over what it is where all is dry.
  const auto step = [](const RgbImage& image, std::uint32_t x) {
    int most = 0;
    for (std::uint32_t y = 35; y < 60; ++y)
      most = std::max(most, std::abs(int{image.pixel(x, y)[0]} - int{image.pixel(x, y + 1)[0]}));
    return static_cast<double>(most);
  };
  double sum = 0, least = 1, most = 0;
  for (std::uint32_t x = 40; x < 1360; ++x) {
    const double share = step(wet, x) / step(dry, x);
    sum += share / 1320;
    least = std::min(least, share);
    most = std::max(most, share);
  }
  CHECK(sum < 0.75);
  CHECK(least < 0.35);
  CHECK(most > 0.8);
  CHECK(most <= 1);
  for (std::uint32_t x = 0; x < 1400; ++x)
    for (const std::uint32_t y : {8u, 15u, 20u, 84u, 92u})
      CHECK(std::equal(dry.pixel(x, y), dry.pixel(x, y) + 3, wet.pixel(x, y)));
}

TEST_CASE("paint_strokes: glazes multiply the light of the layers below, in any order") {
  const LinearColor one{0.5f, 0.8f, 0.9f}, other{0.9f, 0.5f, 0.7f};
  Stroke a = stroke_at(50, 50, one), b = stroke_at(50, 50, other);
  const RgbImage first = painted({a}, true), second = painted({b}, true), both = painted({a, b}, true),
                 turned = painted({b, a}, true);
  CHECK(both.pixels == turned.pixels);
  const auto light = [](std::uint8_t byte) { return std::pow((byte / 255.0 + 0.055) / 1.055, 2.4); };
  for (std::size_t k = 0; k < 3; ++k)
    CHECK(light(both.pixel(50, 50)[k]) ==
          Approx(light(first.pixel(50, 50)[k]) * light(second.pixel(50, 50)[k])).epsilon(0.06));
}
