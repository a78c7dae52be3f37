// Splats: closed forms of their shapes, depth order, white space; samples chosen for a view.
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "kernels/core/random.h"
#include "kernels/render/oriented_splats.h"
#include "kernels/render/view_detail.h"
#include "support/catch.h"

using namespace meander;

namespace {

using std::numbers::pi;

struct SplatCloud {
  std::vector<float> centers, normals, directions, half_axes;
  std::vector<SrgbColor> colors;

  void add(Vector3 center, Vector3 normal, Vector3 direction, double a, double b,
           SrgbColor color = {200, 60, 30}) {
    for (const double v : {center.x, center.y, center.z}) centers.push_back(static_cast<float>(v));
    for (const double v : {normal.x, normal.y, normal.z}) normals.push_back(static_cast<float>(v));
    for (const double v : {direction.x, direction.y, direction.z})
      directions.push_back(static_cast<float>(v));
    for (const double v : {a, b}) half_axes.push_back(static_cast<float>(v));
    colors.push_back(color);
  }
  OrientedSplats splats() const { return {centers, normals, directions, half_axes, colors}; }
};

// The square [0, cells]^2 in the plane z = 0, a splat in the middle of every unit cell.
SplatCloud lattice(int cells, double a, double b) {
  SplatCloud cloud;
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) cloud.add({i + 0.5, j + 0.5, 0}, {0, 0, 1}, {1, 0, 0}, a, b);
  return cloud;
}

std::vector<double> square(double side, double z) { return {0, 0, z, side, 0, z, side, side, z, 0, side, z}; }
const std::vector<std::uint32_t> square_faces = {0, 1, 2, 0, 2, 3};

// White share of unit cells with a disc each, neighbors' discs reaching in.
double white_of_lattice(double r) {
  if (r <= 0.5) return 1 - pi * r * r;
  const double outside = r * r * std::acos(0.5 / r) - 0.5 * std::sqrt(r * r - 0.25);
  return 1 - (pi * r * r - 4 * outside);
}

// From the direction of the eye, without a margin.
SplatView square_view(double side, Vector3 towards, std::uint32_t size) {
  const std::vector<float> corners = {0, 0, 0, static_cast<float>(side), static_cast<float>(side), 0};
  SplatView view = fitted_view(corners, {0, 0, 1}, {0, 1, 0}, size, size, 0.02);
  view.back = (1 / norm(towards)) * towards;
  view.right = cross({0, 1, 0}, view.back);
  view.right = (1 / norm(view.right)) * view.right;
  view.down = -1.0 * cross(view.back, view.right);
  return view;
}

bool is_white(const std::uint8_t* p) { return p[0] == 255 && p[1] == 255 && p[2] == 255; }

// 2^bits points of a spherical Fibonacci set, every prefix of which is spread over the sphere.
struct BallSamples {
  explicit BallSamples(unsigned bits) {
    const std::uint32_t count = 1u << bits;
    for (std::uint32_t r = 0; r < count; ++r) {
      std::uint32_t i = 0;
      for (unsigned b = 0; b < bits; ++b) i |= ((r >> b) & 1u) << (bits - 1 - b);
      const double height = 1 - (2 * i + 1.0) / count, ring = std::sqrt(1 - height * height),
                   angle = 2.399963229728653 * i;
      x.push_back(static_cast<float>(ring * std::cos(angle)));
      y.push_back(static_cast<float>(ring * std::sin(angle)));
      z.push_back(static_cast<float>(height));
      area.push_back(static_cast<float>(4 * pi / count));
    }
  }
  ViewedSamples samples() const { return {x, y, z, area}; }
  std::vector<float> x, y, z, area;
};

}  // namespace

TEST_CASE("white_space: lattices of discs and ellipses leave the exact share, from above and obliquely") {
  const int cells = 12;
  for (const Vector3 towards : {Vector3{0, 0, 1}, Vector3{0.3, 0.6, 0.8}}) {
    const SplatView view = square_view(cells, towards, 900);
    const std::vector<float> depth = surface_depth(square(cells, 0), square_faces, view);
    for (const double r : {0.2, 0.45, 0.55, 0.65}) {
      INFO(r << " " << towards.y);
      const WhiteSpace discs = white_space(lattice(cells, r, r).splats(), view, depth);
      CHECK(discs.pixels > 200000);
      // At the rim the discs of the next cells are missing.
      CHECK(discs.share() == Approx(white_of_lattice(r)).margin(r > 0.5 ? 0.012 : 0.003));
    }
    // Ellipses that do not meet have the area of the discs.
    const WhiteSpace ellipses = white_space(lattice(cells, 0.48, 0.12).splats(), view, depth);
    CHECK(ellipses.share() == Approx(1 - pi * 0.48 * 0.12).margin(0.003));
  }
}

TEST_CASE("white_space: splats far behind the surface do not cover it") {
  const SplatView view = square_view(4, {0, 0, 1}, 200);
  const SplatCloud cloud = lattice(4, 1, 1);
  CHECK(white_space(cloud.splats(), view, surface_depth(square(4, 0), square_faces, view)).white == 0);
  const WhiteSpace behind =
      white_space(cloud.splats(), view, surface_depth(square(4, 1.5), square_faces, view));
  CHECK(behind.white == behind.pixels);
  CHECK(behind.share() == 1);
  CHECK(WhiteSpace{}.share() == 0);
  CHECK_THROWS_AS(white_space(cloud.splats(), view, {}), std::invalid_argument);
}

TEST_CASE("surface_depth: the nearer triangle wins, in pixels toward the eye") {
  const SplatView view = square_view(2, {0, 0, 1}, 100);
  std::vector<double> positions = square(2, 0);
  const std::vector<double> nearer = square(1, 0.25);
  positions.insert(positions.end(), nearer.begin(), nearer.end());
  const std::vector<std::uint32_t> faces = {4, 5, 6, 4, 6, 7, 0, 1, 2, 0, 2, 3};
  const std::vector<float> depth = surface_depth(positions, faces, view);
  const auto at = [&](double x, double y) {
    const Vector3 p = view.point({x, y, 0});
    return depth[static_cast<std::size_t>(p.y) * 100 + static_cast<std::size_t>(p.x)];
  };
  CHECK(at(0.5, 0.5) - at(1.5, 1.5) == Approx(0.25 * view.scale).epsilon(1e-5));
  CHECK(at(1.5, 0.5) == at(0.5, 1.5));
  CHECK(depth[0] == -std::numeric_limits<float>::infinity());
  CHECK_THROWS_AS(surface_depth(square(1, 0), std::vector<std::uint32_t>{0, 1, 4}, view),
                  std::invalid_argument);
}

TEST_CASE("ellipse_axes: the requested area and the ratio of the tensor") {
  for (const double ratio : {1.0, 2.5, 8.0}) {
    const HalfAxes axes = ellipse_axes(0.7, ratio);
    CHECK(pi * axes.along * axes.across == Approx(0.7));
    CHECK(axes.along / axes.across == Approx(ratio));
  }
}

TEST_CASE("draw_splats: the image of an ellipse has the moments of the projected tensor") {
  // In a tilted plane, its long axis aslant in it.
  const Vector3 normal{0, 0.6, 0.8}, u{1, 0, 0}, w{0, 0.8, -0.6};
  const double a = 0.8, b = 0.25, turn = 0.5;
  const Vector3 along = std::cos(turn) * u + std::sin(turn) * w,
                across = -std::sin(turn) * u + std::cos(turn) * w;
  SplatCloud cloud;
  cloud.add({1, 1, 0}, normal, along, a, b);
  const SplatView view = square_view(2, {0, 0, 1}, 400);
  const SplatImage drawn = draw_splats(cloud.splats(), view);
  double count = 0, mx = 0, my = 0, xx = 0, xy = 0, yy = 0;
  for (int y = 0; y < 400; ++y)
    for (int x = 0; x < 400; ++x) {
      if (is_white(drawn.image.pixel(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)))) continue;
      ++count;
      mx += x;
      my += y;
      xx += x * x;
      xy += x * y;
      yy += y * y;
    }
  mx /= count;
  my /= count;
  const double s = 0.25 * view.scale * view.scale;
  CHECK(mx == Approx(199.5).margin(0.3));
  CHECK(my == Approx(199.5).margin(0.3));
  // Rows run downwards.
  CHECK(xx / count - mx * mx ==
        Approx(s * (a * a * along.x * along.x + b * b * across.x * across.x)).epsilon(0.03));
  CHECK(yy / count - my * my ==
        Approx(s * (a * a * along.y * along.y + b * b * across.y * across.y)).epsilon(0.04));
  CHECK(xy / count - mx * my ==
        Approx(-s * (a * a * along.x * along.y + b * b * across.x * across.y)).epsilon(0.04));
  CHECK(drawn.covered == Approx(pi * a * b * 0.8 * view.scale * view.scale / 160000).epsilon(0.02));
}

TEST_CASE("draw_splats: nearer splats hide farther ones, in any order") {
  const SplatView view = square_view(4, {0, 0, 1}, 120);
  constexpr SrgbColor red = {220, 30, 20}, blue = {20, 40, 220};
  for (const bool far_first : {false, true}) {
    SplatCloud cloud;
    for (const bool first : {true, false}) {
      const bool farther = first == far_first;
      for (int j = 0; j < 8; ++j)
        for (int i = 0; i < 8; ++i)
          cloud.add({(i + 0.5) / 2, (j + 0.5) / 2, farther ? -2.0 : 0.0}, {0, 0, 1}, {1, 0, 0}, 0.5, 0.5,
                    farther ? blue : red);
    }
    const RgbImage image = draw_splats(cloud.splats(), view).image;
    for (std::uint32_t x = 20; x < 100; x += 7) {
      const std::uint8_t* p = image.pixel(x, 60);
      CHECK(p[0] > 120);
      CHECK(p[2] < 60);
    }
  }
}

TEST_CASE("draw_splats: colors blend where splats of equal depth overlap") {
  SplatCloud cloud;
  cloud.add({1.2, 2, 0}, {0, 0, 1}, {1, 0, 0}, 1.2, 1.2, {230, 20, 20});
  cloud.add({2.8, 2, 0}, {0, 0, -1}, {1, 0, 0}, 1.2, 1.2, {20, 20, 230});
  const SplatView view = square_view(4, {0, 0, 1}, 200);
  const RgbImage image = draw_splats(cloud.splats(), view).image;
  const auto red_at = [&](double x) {
    return int{image.pixel(static_cast<std::uint32_t>(view.point({x, 2, 0}).x), 100)[0]};
  };
  int before = red_at(1.2);
  CHECK(before > 120);
  for (double x = 1.3; x < 2.8; x += 0.1) {
    CHECK(red_at(x) <= before);
    CHECK(before - red_at(x) < 60);  // no edge
    before = red_at(x);
  }
  CHECK(before < 60);
  CHECK(red_at(2.0) ==
        Approx(image.pixel(static_cast<std::uint32_t>(view.point({2.0, 2, 0}).x), 100)[2]).margin(12));
}

TEST_CASE("draw_splats: back faces, prefixes, and splats below a pixel") {
  const SplatView view = square_view(2, {0, 0, 1}, 100);
  SplatCloud cloud;
  cloud.add({1, 1, 0}, {0, 0, -1}, {1, 0, 0}, 0.5, 0.5);
  const double whole = draw_splats(cloud.splats(), view).covered;
  CHECK(whole > 0);
  SplatLook look;
  look.backs = false;
  CHECK(draw_splats(cloud.splats(), view, look).covered == 0);
  look = {};
  look.shown = 0.5;
  CHECK(draw_splats(cloud.splats(), view, look).covered == Approx(0.25 * whole).epsilon(0.03));
  SplatCloud tiny;
  for (int i = 0; i < 50; ++i) tiny.add({0.02 + 0.04 * i, 1.013 + 0.001 * i, 0}, {0, 0, 1}, {}, 1e-6, 1e-6);
  const RgbImage image = draw_splats(tiny.splats(), view).image;
  for (int i = 0; i < 50; ++i) {
    const Vector3 p = view.point({0.02 + 0.04 * i, 1.013 + 0.001 * i, 0});
    CHECK_FALSE(is_white(image.pixel(static_cast<std::uint32_t>(p.x), static_cast<std::uint32_t>(p.y))));
  }
}

TEST_CASE("draw_splats: empty, non-finite and too large input") {
  const SplatView view = square_view(2, {0, 0, 1}, 64);
  CHECK(draw_splats({}, view).covered == 0);
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinity = std::numeric_limits<double>::infinity();
  SplatCloud bad;
  bad.add({nan, 0, 0}, {0, 0, 1}, {1, 0, 0}, 1, 1);
  bad.add({0, infinity, 0}, {0, 0, 1}, {1, 0, 0}, 1, 1);
  bad.add({1, 1, 0}, {0, 0, 0}, {1, 0, 0}, 1, 1);
  bad.add({1, 1, 0}, {0, nan, 1}, {1, 0, 0}, 1, 1);
  bad.add({1, 1, 0}, {0, 0, 1}, {1, 0, 0}, 0, 1);
  bad.add({1, 1, 0}, {0, 0, 1}, {1, 0, 0}, nan, 1);
  bad.add({1e30, 1, 0}, {0, 0, 1}, {1, 0, 0}, 1, 1);
  CHECK(draw_splats(bad.splats(), view).covered == 0);
  CHECK(fitted_view(std::vector<float>{}, {0, 0, 1}, {0, 1, 0}, 64, 64).scale == 1);
  // A direction that is not one still gives a disc.
  SplatCloud plain;
  plain.add({1, 1, 0}, {0, 0, 1}, {nan, 0, 0}, 0.5, 0.5);
  CHECK(draw_splats(plain.splats(), view).covered > 0);
  SplatCloud large;
  for (int i = 0; i < 900; ++i) large.add({1, 1, 0.001 * i}, {0, 0, 1}, {1, 0, 0}, 1, 1);
  CHECK_THROWS_AS(draw_splats(large.splats(), view), std::invalid_argument);
  large.half_axes.pop_back();
  CHECK_THROWS_AS(draw_splats(large.splats(), view), std::invalid_argument);
}

TEST_CASE("draw_splats: the same picture for any number of threads") {
  SplatCloud cloud;
  for (int i = 0; i < 20000; ++i) {
    const double height = 1 - (2 * i + 1.0) / 20000, ring = std::sqrt(1 - height * height), angle = 2.4 * i;
    const Vector3 n{ring * std::cos(angle), ring * std::sin(angle), height};
    cloud.add(n, n, {n.y, -n.x, 0}, 0.03, 0.01);
  }
  const SplatView view = fitted_view(cloud.centers, {0.5, 0.4, 1}, {0, 1, 0}, 300, 200);
  RgbImage first;
  for (const std::size_t threads : {1u, 2u, 7u}) {
    const oneapi::tbb::global_control control(oneapi::tbb::global_control::max_allowed_parallelism, threads);
    const RgbImage image = draw_splats(cloud.splats(), view).image;
    if (first.pixels.empty()) first = image;
    CHECK(image.pixels == first.pixels);
  }
}

TEST_CASE("turning_view: the model stays in the picture all the way around") {
  std::vector<float> points;
  for (const float x : {-3.0f, 1.0f})
    for (const float y : {0.0f, 5.0f})
      for (const float z : {-1.0f, 4.0f}) points.insert(points.end(), {x, y, z});
  double widest = 0;
  const SplatView first = turning_view(points, {0, 0.5, 1}, {0, 1, 0}, 200, 300, 0.05);
  for (int k = 0; k < 60; ++k) {
    const double angle = 2 * pi * k / 60;
    SplatView view = turning_view(points, {std::sin(angle), 0.5, std::cos(angle)}, {0, 1, 0}, 200, 300, 0.05);
    view.scale = first.scale;
    view.center = first.center;
    for (std::size_t i = 0; i < points.size(); i += 3) {
      const Vector3 p = view.point({points[i], points[i + 1], points[i + 2]});
      CHECK(p.x >= 10 - 1e-9);
      CHECK(p.x <= 190 + 1e-9);
      CHECK(p.y >= 10 - 1e-9);
      CHECK(p.y <= 290 + 1e-9);
      widest = std::max(widest, std::abs(p.x - 100));
    }
  }
  CHECK(widest > 85);  // and fills it
}

TEST_CASE("view_weight: one on the silhouette, little in front, nothing behind") {
  const Vector3 v{0, 0, 2};
  ViewDetailParameters parameters;
  CHECK(view_weight({1, 0, -1e-6}, v, parameters) == Approx(1));
  CHECK(view_weight({0.96, 0, -0.28}, v, parameters) == Approx(0.04));  // four fifths of the fade behind
  CHECK(view_weight({0, 0.93, -0.3501}, v, parameters) == 0);
  CHECK(view_weight({0, 0, -1}, v, parameters) == 0);
  parameters.fade = 0;
  CHECK(view_weight({1, 0, 0}, v, parameters) == 0);
  CHECK(view_weight({1, 0, -1e-6}, v, parameters) == 0);
  CHECK(view_weight({0, 0, 1}, v, parameters) == Approx(0.1));
  CHECK(view_weight({0, 0.8, 0.6}, v, parameters) == Approx(0.1 + 0.9 * std::pow(0.4, 4)));
  CHECK(view_weight({1, 0, 1e-6}, v, parameters) == Approx(1));
  CHECK(view_weight({0, 0.8, -0.6}, v, parameters) == 0);
  CHECK(view_weight({std::nan(""), 0, 1}, v, parameters) == 0);
  parameters.both_sides = true;
  CHECK(view_weight({0, 0.8, -0.6}, v, parameters) == Approx(0.1 + 0.9 * std::pow(0.4, 4)));
}

TEST_CASE("view_detail: sums, number and density of a sphere have closed forms") {
  const BallSamples ball(16);
  ViewDetailParameters parameters;
  parameters.samples_per_area = 2000;
  const double behind = parameters.fade / 3;
  CHECK(mean_view_weight(parameters) == Approx(0.5 * (0.28 + behind)));
  const ViewDetail faded = view_detail(ball.samples(), {0.2, 0.3, 0.9}, parameters);
  CHECK(faded.weight_sum == Approx(65536 * mean_view_weight(parameters)).epsilon(0.001));
  CHECK(faded.projected_area == Approx(pi).epsilon(0.001));
  CHECK(static_cast<double>(faded.kept.size()) == Approx(2000 * pi).epsilon(0.02));
  std::size_t hidden = 0;
  for (const std::uint32_t i : faded.kept)
    hidden += 0.2 * double{ball.x[i]} + 0.3 * double{ball.y[i]} + 0.9 * double{ball.z[i]} <= 0;
  CHECK(static_cast<double>(hidden) / static_cast<double>(faded.kept.size()) ==
        Approx(behind / (0.28 + behind)).margin(0.012));
  parameters.fade = 0;
  CHECK(mean_view_weight(parameters) == Approx(0.14));
  const ViewDetail detail = view_detail(ball.samples(), {0.2, 0.3, 0.9}, parameters);
  // Of the cosine, uniform in [-1, 1] over a sphere.
  CHECK(detail.weight_sum == Approx(65536 * 0.5 * (0.1 + 0.9 / 5)).epsilon(0.001));
  CHECK(detail.projected_area == Approx(pi).epsilon(0.001));
  CHECK(static_cast<double>(detail.kept.size()) == Approx(2000 * pi).epsilon(0.02));
  const double length = std::sqrt(0.04 + 0.09 + 0.81);
  std::array<double, 4> bands{};
  for (const std::uint32_t i : detail.kept) {
    const double cosine =
        (0.2 * double{ball.x[i]} + 0.3 * double{ball.y[i]} + 0.9 * double{ball.z[i]}) / length;
    REQUIRE(cosine > 0);
    ++bands[std::min<std::size_t>(3, static_cast<std::size_t>(4 * cosine))];
  }
  // Integral of the weight over [c, c + 1/4], over 0.28.
  for (std::size_t k = 0; k < 4; ++k) {
    const double c = 0.25 * static_cast<double>(k);
    const double share = (0.025 + 0.18 * (std::pow(1 - c, 5) - std::pow(0.75 - c, 5))) / 0.28;
    INFO(k);
    CHECK(bands[k] / static_cast<double>(detail.kept.size()) == Approx(share).margin(0.012));
  }
}

TEST_CASE("view_detail: the first samples of the set are kept around every place") {
  // All normals equal: the kept ones are a prefix, as long as the share says.
  const std::size_t count = 40000;
  const std::vector<float> zero(count, 0.0f), up(count, 0.8f), aside(count, 0.6f), area(count, 1.0f / 40000);
  ViewDetailParameters parameters;
  parameters.samples_per_area = 10000;
  const ViewDetail detail = view_detail({aside, zero, up, area}, {0, 0, 1}, parameters);
  REQUIRE(detail.kept.size() == 8000);  // 10,000 on the projected area 0.8
  for (std::uint32_t i = 0; i < 8000; ++i) REQUIRE(detail.kept[i] == i);
  // More than there are: all; from behind and of nothing: none.
  parameters.samples_per_area = 1e9;
  CHECK(view_detail({aside, zero, up, area}, {0, 0, 1}, parameters).kept.size() == count);
  CHECK(view_detail({aside, zero, up, area}, {0, 0, -1}, parameters).kept.empty());
  CHECK(view_detail({}, {0, 0, 1}, parameters).kept.empty());
  CHECK_THROWS_AS(view_detail({aside, zero, up, {}}, {0, 0, 1}, parameters), std::invalid_argument);
}

TEST_CASE("view_detail: flat faces that turn away and into view keep nine of ten samples") {
  // A box whose six faces turn over the silhouette all at once: 20,000 samples each, in random order.
  const std::array<Vector3, 6> outwards = {
      {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};
  std::vector<float> x, y, z;
  const RandomKey key = make_random_key(7, {});
  for (std::uint64_t i = 0; i < 120000; ++i) {
    const Vector3 n = outwards[random_words(key, Stream::test_shapes, i, 0)[0] % 6];
    x.push_back(static_cast<float>(n.x));
    y.push_back(static_cast<float>(n.y));
    z.push_back(static_cast<float>(n.z));
  }
  const std::vector<float> area(x.size(), 1.0f / 20000);
  ViewDetailParameters parameters;
  parameters.samples_per_area = 6000;
  double least = 1, least_without_fade = 1;
  for (double* const worst : {&least, &least_without_fade}) {
    std::vector<std::uint32_t> before;
    for (int k = 0; k <= 90; ++k) {
      const double angle = k * pi / 90;
      std::vector<std::uint32_t> now =
          view_detail({x, y, z, area}, {std::sin(angle), 0.35, std::cos(angle)}, parameters).kept;
      if (k > 0)
        *worst = std::min(
            *worst, static_cast<double>(samples_that_stay(before, now)) / static_cast<double>(before.size()));
      before = std::move(now);
    }
    parameters.fade = 0;
  }
  CHECK(least >= 0.9);
  CHECK(least_without_fade < 0.5);
}

TEST_CASE("view_detail: nine of ten samples stay over two degrees, for any threads") {
  const BallSamples ball(15);
  ViewDetailParameters parameters;
  parameters.samples_per_area = 1400;
  std::vector<std::uint32_t> before;
  for (int k = 0; k < 180; ++k) {
    const double angle = k * pi / 90;
    const Vector3 towards{std::sin(angle), 0.35, std::cos(angle)};
    const ViewDetail detail = view_detail(ball.samples(), towards, parameters);
    REQUIRE(std::is_sorted(detail.kept.begin(), detail.kept.end()));
    if (k > 0) {
      std::vector<std::uint32_t> both;
      std::set_intersection(before.begin(), before.end(), detail.kept.begin(), detail.kept.end(),
                            std::back_inserter(both));
      REQUIRE(samples_that_stay(before, detail.kept) == both.size());
      REQUIRE(both.size() >= 9 * before.size() / 10);
      REQUIRE(both.size() < before.size());
    }
    before = detail.kept;
    if (k % 60 > 0) continue;
    const oneapi::tbb::global_control control(oneapi::tbb::global_control::max_allowed_parallelism, 1);
    const ViewDetail alone = view_detail(ball.samples(), towards, parameters);
    CHECK(alone.kept == detail.kept);
    CHECK(alone.weight_sum == detail.weight_sum);
  }
}
