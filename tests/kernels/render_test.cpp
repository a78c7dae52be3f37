#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "kernels/render/sampled_surface.h"
#include "kernels/render/splat_picture.h"
#include "kernels/render/surface_picture.h"
#include "support/catch.h"

using namespace meander;

namespace {

struct Cloud {
  std::vector<float> points, normals;
  void add(double x, double y, double z, double nx, double ny, double nz) {
    for (const double v : {x, y, z}) points.push_back(static_cast<float>(v));
    for (const double v : {nx, ny, nz}) normals.push_back(static_cast<float>(v));
  }
};

// Spherical Fibonacci points with their outward normals.
Cloud sphere(int count) {
  Cloud cloud;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count, r = std::sqrt(1 - z * z), a = 2.399963229728653 * i;
    cloud.add(r * std::cos(a), r * std::sin(a), z, r * std::cos(a), r * std::sin(a), z);
  }
  return cloud;
}

bool white(const RgbImage& image, std::uint32_t x, std::uint32_t y) {
  const std::uint8_t* p = image.pixel(x, y);
  return p[0] == 255 && p[1] == 255 && p[2] == 255;
}

std::size_t painted(const RgbImage& image) {
  std::size_t count = 0;
  for (std::uint32_t y = 0; y < image.height; ++y)
    for (std::uint32_t x = 0; x < image.width; ++x) count += white(image, x, y) ? 0 : 1;
  return count;
}

constexpr double sphere_area = 12.566370614359172;

}  // namespace

TEST_CASE("splat_picture: a dense sphere covers a disk of the right size") {
  const Cloud cloud = sphere(20000);
  SplatParameters parameters;
  parameters.size = 200;
  const RgbImage image = splat_picture(cloud.points, cloud.normals, sphere_area, parameters);
  REQUIRE(image.width == 200);
  REQUIRE(image.pixels.size() == 200 * 200 * 3);
  // The sphere with discs of radius sqrt(4 pi / 20000) = 0.025 on its contour fills 0.92 x 200 pixels.
  const double most = 3.14159 * 92 * 92, least = 3.14159 * 89 * 89;
  CHECK(painted(image) > least);
  CHECK(painted(image) < 1.02 * most);  // pixels that are painted in part
  CHECK_FALSE(white(image, 100, 100));
  CHECK(white(image, 3, 3));
}

TEST_CASE("splat_picture: the nearer surface hides the farther one") {
  // A square towards the eye in front of one that faces sideways: the picture of both is that of the first.
  SplatParameters parameters;
  parameters.size = 100;
  parameters.view = {0, 0, 1};
  Cloud front, both;
  for (int j = 0; j < 60; ++j)
    for (int i = 0; i < 60; ++i) front.add(i / 59.0, j / 59.0, 1, 0, 0, 1);
  both = front;
  for (int j = 1; j < 30; ++j)
    for (int i = 1; i < 30; ++i) both.add(i / 30.0, j / 30.0, 0.9, 1, 0, 0.1);
  const RgbImage a = splat_picture(front.points, front.normals, 1, parameters);
  const RgbImage b = splat_picture(both.points, both.normals, 1.2, parameters);
  // Colors differ by the depth range; where something is painted does not, and the middle is one flat
  // color.
  CHECK(painted(b) == Approx(static_cast<double>(painted(a))).epsilon(0.02));
  // The same shade left and right of the middle as at it: nothing of the other square shines through.
  const int shade = b.pixel(50, 50)[0];
  for (std::uint32_t x = 40; x < 60; ++x) CHECK(std::abs(b.pixel(x, 50)[0] - shade) < 40);
}

TEST_CASE("splat_picture: inward normals look the same") {
  const Cloud cloud = sphere(500);
  std::vector<float> inward = cloud.normals;
  for (float& n : inward) n = -n;
  CHECK(splat_picture(cloud.points, cloud.normals, sphere_area).pixels ==
        splat_picture(cloud.points, inward, sphere_area).pixels);
}

TEST_CASE("splat_picture: invariant to scale and position of the model") {
  const Cloud cloud = sphere(400);
  // A power of two scales float32 coordinates exactly.
  std::vector<float> large = cloud.points;
  for (float& p : large) p *= 1048576;
  CHECK(splat_picture(cloud.points, cloud.normals, sphere_area).pixels ==
        splat_picture(large, cloud.normals, sphere_area * 0x1p40).pixels);
}

TEST_CASE("splat_picture: empty, one point, non-finite input") {
  SplatParameters parameters;
  parameters.size = 40;
  const RgbImage none = splat_picture({}, {}, 0, parameters);
  CHECK(painted(none) == 0);
  CHECK(none.pixels.size() == 40 * 40 * 3);
  Cloud one;
  one.add(5, 6, 7, 0, 0, 0);
  CHECK_FALSE(white(splat_picture(one.points, one.normals, 0, parameters), 20, 20));
  Cloud bad;
  bad.add(std::numeric_limits<double>::quiet_NaN(), 0, 0, 0, 0, 1);
  CHECK(painted(splat_picture(bad.points, bad.normals, 1, parameters)) == 0);
  bad.add(0, 0, 0, std::numeric_limits<double>::quiet_NaN(), 0, 1);
  CHECK(painted(splat_picture(bad.points, bad.normals, 1, parameters)) > 0);
}

namespace {

// The square [-1, 1]^2 at a height, seen along z.
struct Plate {
  std::vector<double> positions;
  std::vector<std::uint32_t> faces;
  void add(double half, double height) {
    const auto first = static_cast<std::uint32_t>(positions.size() / 3);
    positions.insert(positions.end(),
                     {-half, -half, height, half, -half, height, half, half, height, -half, half, height});
    for (const std::uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) faces.push_back(first + k);
  }
};

SurfacePictureParameters from_above(std::uint32_t size) {
  SurfacePictureParameters parameters;
  parameters.size = size;
  parameters.margin = 0.05;
  parameters.view = {0, 0, 1};
  return parameters;
}

// Pixels where the first part of the color clearly beats the other two.
std::size_t red_pixels(const RgbImage& image) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < image.pixels.size(); i += 3)
    count += image.pixels[i] > image.pixels[i + 1] + 60 && image.pixels[i] > image.pixels[i + 2] + 60;
  return count;
}

}  // namespace

TEST_CASE("surface_picture: a plate covers its exact pixels, in the color of its faces") {
  Plate plate;
  plate.add(1, 0);
  SurfaceScene scene{plate.positions, plate.faces, {{200, 20, 20}, {200, 20, 20}}};
  const RgbImage image = surface_picture(scene, from_above(200));
  CHECK(painted(image) == Approx(180 * 180).epsilon(0.03));
  // All but the rim, which is pale.
  CHECK(red_pixels(image) >= 178 * 178);
  // No gap along the diagonal.
  for (std::uint32_t i = 12; i < 188; ++i) CHECK_FALSE(white(image, i, i));
}

TEST_CASE("surface_picture: an ellipse has its area and axes, and is hidden by nearer surfaces") {
  Plate plate;
  plate.add(1, 0);
  SurfaceScene scene{plate.positions, plate.faces, {}};
  scene.ellipses.push_back({{0.1, -0.2, 0}, {0.6, 0, 0}, {0, 0.15, 0}, {220, 10, 10}});
  const RgbImage image = surface_picture(scene, from_above(200));
  const double unit = 90;  // pixels
  CHECK(static_cast<double>(red_pixels(image)) == Approx(3.14159 * 0.6 * 0.15 * unit * unit).epsilon(0.05));
  const auto red_at = [&](double x, double y) {
    const std::uint8_t* p =
        image.pixel(static_cast<std::uint32_t>(100 + unit * x), static_cast<std::uint32_t>(100 - unit * y));
    return p[0] > p[1] + 60;
  };
  CHECK(red_at(0.65, -0.2));
  CHECK_FALSE(red_at(0.1, 0));
  plate.add(0.9, 0.5);
  scene.positions = plate.positions;
  scene.faces = plate.faces;
  CHECK(red_pixels(surface_picture(scene, from_above(200))) == 0);
}

TEST_CASE("surface_picture: lines have their width, dots their radius, and nearer surfaces hide both") {
  Plate plate;
  plate.add(1, 0);
  SurfaceScene scene{plate.positions, plate.faces, {}};
  scene.lines.push_back({{-0.5, -0.3, 0}, {0.5, 0.4, 0}, 4, {230, 0, 0}});
  const double length = 90 * std::hypot(1.0, 0.7);
  CHECK(static_cast<double>(red_pixels(surface_picture(scene, from_above(200)))) ==
        Approx(4 * length + 12.6).epsilon(0.15));
  scene.lines.clear();
  scene.dots.push_back({{0.2, 0.2, 0}, 10, {230, 0, 0}});
  // Without the white rim: 62 % of the disk.
  CHECK(static_cast<double>(red_pixels(surface_picture(scene, from_above(200)))) ==
        Approx(0.62 * 314.16).epsilon(0.12));
  scene.lines.push_back({{-0.5, -0.3, 0}, {0.5, 0.4, 0}, 4, {230, 0, 0}});
  plate.add(0.9, 0.5);
  scene.positions = plate.positions;
  scene.faces = plate.faces;
  CHECK(red_pixels(surface_picture(scene, from_above(200))) == 0);
}

TEST_CASE("surface_picture: non-finite elements are skipped, arrays of the wrong size are refused") {
  Plate plate;
  plate.add(1, 0);
  SurfaceScene scene{plate.positions, plate.faces, {}};
  const RgbImage plain = surface_picture(scene, from_above(64));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  scene.ellipses.push_back({{nan, 0, 0}, {1, 0, 0}, {0, 1, 0}, {255, 0, 0}});
  scene.ellipses.push_back({{0, 0, 0}, {0, 0, 0}, {0, 1, 0}, {255, 0, 0}});
  scene.lines.push_back({{0, 0, 0}, {nan, 0, 0}, 2, {255, 0, 0}});
  scene.dots.push_back({{0, nan, 0}, 5, {255, 0, 0}});
  CHECK(surface_picture(scene, from_above(64)).pixels == plain.pixels);
  scene.faces = {};
  CHECK(painted(surface_picture(scene, from_above(64))) == 0);
  scene.faces = plate.faces;
  scene.face_colors = {{1, 2, 3}};
  CHECK_THROWS_AS(surface_picture(scene, from_above(64)), std::invalid_argument);
  const std::vector<std::uint32_t> wrong = {0, 1, 4};
  scene.face_colors.clear();
  scene.faces = wrong;
  CHECK_THROWS_AS(surface_picture(scene, from_above(64)), std::invalid_argument);
}

TEST_CASE("splat_picture: beads have their given colors") {
  Cloud cloud;
  cloud.add(-1, 0, 0, 0, 0, 1);
  cloud.add(1, 0, 0, 0, 0, 1);
  SplatParameters parameters;
  parameters.size = 100;
  parameters.view = {0, 0, 1};
  const std::array<SrgbColor, 2> colors = {SrgbColor{250, 0, 0}, SrgbColor{0, 0, 250}};
  const RgbImage image = splat_picture(cloud.points, cloud.normals, 1, parameters, colors);
  std::size_t red_left = 0, blue_right = 0, wrong = 0;
  for (std::uint32_t y = 0; y < 100; ++y)
    for (std::uint32_t x = 0; x < 100; ++x) {
      const std::uint8_t* const p = image.pixel(x, y);
      const bool red = p[0] > p[2] + 60, blue = p[2] > p[0] + 60;
      red_left += red && x < 50;
      blue_right += blue && x >= 50;
      wrong += (red && x >= 50) || (blue && x < 50);
    }
  CHECK(red_left > 10);
  CHECK(blue_right > 10);
  CHECK(wrong == 0);
  CHECK_THROWS_AS(splat_picture(cloud.points, cloud.normals, 1, parameters, std::array<SrgbColor, 3>{}),
                  std::invalid_argument);
}

TEST_CASE("sampled_surface_picture: discs have their area and lie on the visible side") {
  Plate plate;
  plate.add(1, 0);
  const std::array<double, 6> points = {-0.5, 0, 0, 0.5, 0, 0};
  std::array<float, 6> normals = {0, 0, 1, 0, 0, -1};  // either sense
  const std::array<SrgbColor, 1> red = {SrgbColor{220, 20, 20}};
  const std::array<double, 1> radius = {0.3};
  const SampledSurface sampled{plate.positions, plate.faces, points, normals, red, radius};
  const RgbImage image = sampled_surface_picture(sampled, from_above(200));
  // Two discs of radius 0.3 of a square of side 2 that takes 0.9 of the width.
  const double unit = 0.9 * 200 / 2;
  CHECK(static_cast<double>(red_pixels(image)) == Approx(2 * 3.14159265 * 0.09 * unit * unit).epsilon(0.05));
  SampledSurface wrong = sampled;
  wrong.normals = std::span<const float>(normals).first(3);
  CHECK_THROWS_AS(sampled_surface_picture(wrong, from_above(64)), std::invalid_argument);
  SampledSurface none{plate.positions, plate.faces, {}, {}, {}, {}};
  const RgbImage blank = sampled_surface_picture(none, from_above(64));
  CHECK(red_pixels(blank) == 0);
  // A line across the plate, 58 pixels long and two wide.
  const std::array<double, 6> line = {-1, 0, 0, 1, 0, 0};
  none.lines = line;
  const RgbImage lined = sampled_surface_picture(none, from_above(64));
  std::size_t blue = 0;
  for (std::size_t i = 0; i < lined.pixels.size(); i += 3) blue += lined.pixels[i + 2] > lined.pixels[i] + 40;
  CHECK(blue >= 110);
  CHECK(blue <= 240);
}
