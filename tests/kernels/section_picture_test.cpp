#include "kernels/render/section_picture.h"

#include <cmath>
#include <stdexcept>

#include "support/catch.h"
#include "support/sided_mesh.h"
#include "support/test_meshes.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;

namespace {

bool is_orange(const RgbImage& picture, std::uint32_t x, std::uint32_t y) {
  const std::uint8_t* const at = picture.pixel(x, y);
  return at[0] > at[2] + 20;
}
bool is_blue(const RgbImage& picture, std::uint32_t x, std::uint32_t y) {
  const std::uint8_t* const at = picture.pixel(x, y);
  return at[2] > at[0] + 20;
}

Section section_of(const SidedMesh& sided, const SectionParameters& parameters) {
  return section_picture(sided.mesh, sided.tree, sided.oriented, sided.rule, parameters);
}

}  // namespace

TEST_CASE("section_picture: a ball is a disc of its radius, orange in blue with a black outline") {
  const SidedMesh ball(icosphere(5));
  for (const std::size_t axis : {0, 1, 2})
    for (const double share : {0.0, 0.6}) {
      SectionParameters parameters;
      parameters.axis = axis;
      parameters.size = 200;
      parameters.margin = 0.1;
      parameters.at = share / ball.mesh.unit;
      const Section section = section_of(ball, parameters);
      CHECK(section.uncertain == 0);
      // The box of the ball is 160 pixels wide.
      const double radius = 80 * std::sqrt(1 - share * share);
      CHECK(section.inside == Approx(3.14159265 * radius * radius / 40000).epsilon(0.02));
      std::size_t wrong = 0, black = 0;
      for (std::uint32_t y = 0; y < 200; ++y)
        for (std::uint32_t x = 0; x < 200; ++x) {
          const double away = std::hypot(x + 0.5 - 100, y + 0.5 - 100);
          if (std::abs(away - radius) < 0.3) black += section.picture.pixel(x, y)[0] < 60;
          if (std::abs(away - radius) < 3) continue;
          wrong += !(away < radius ? is_orange(section.picture, x, y) : is_blue(section.picture, x, y));
        }
      CHECK(wrong == 0);
      CHECK(black > 100);
      CHECK(on_threads(1, [&] { return section_of(ball, parameters); }).picture.pixels ==
            on_threads(3, [&] { return section_of(ball, parameters); }).picture.pixels);
    }
}

TEST_CASE("section_picture: x runs to the right, y or z upwards") {
  // A brick and a peg on it: up along z, to the right along x.
  PolygonMesh brick = cube();
  for (std::size_t v = 0; v < brick.x.size(); ++v) {
    brick.x[v] *= 2;
    brick.z[v] *= 0.5;
  }
  PolygonMesh peg = cube();
  for (std::size_t v = 0; v < peg.x.size(); ++v) {
    peg.x[v] = 1.5 + 0.3 * peg.x[v];
    peg.y[v] *= 0.3;
    peg.z[v] = 1 + 0.8 * peg.z[v];
  }
  const SidedMesh sided(merged(brick, peg));
  SectionParameters parameters;
  parameters.axis = 1;
  parameters.at = 0.1 / sided.mesh.unit;
  parameters.size = 100;
  const RgbImage picture = section_of(sided, parameters).picture;
  CHECK(is_orange(picture, 80, 40));  // the peg
  CHECK(is_blue(picture, 20, 40));
  CHECK(is_orange(picture, 20, 64));  // the brick
}

TEST_CASE("section_picture: uncertain points are hatched, and gray has no side") {
  const SidedMesh pierced(with_holes(icosphere(4), 0.05, 3));
  SectionParameters parameters;
  parameters.size = 200;
  const Section section = section_of(pierced, parameters);
  std::size_t hatched = 0;
  for (std::uint32_t y = 0; y < 200; ++y)
    for (std::uint32_t x = 0; x < 200; ++x) {
      const std::uint8_t* const at = section.picture.pixel(x, y);
      hatched += at[0] > 2 * at[1] && at[2] > 2 * at[1] && at[1] < 40;
    }
  CHECK(section.uncertain > 0.005);
  CHECK(static_cast<double>(hatched) / 40000 == Approx(section.uncertain / 2).epsilon(0.4));
  const Section none =
      section_picture(pierced.mesh, pierced.tree, pierced.oriented, SignRule::none, parameters);
  CHECK(none.inside == 0);
  CHECK(none.uncertain == 1);
  CHECK_FALSE(is_orange(none.picture, 100, 100));
  CHECK_FALSE(is_blue(none.picture, 100, 100));
}

TEST_CASE("section_picture: has bounds, and a plane beside the surface is all outside") {
  const SidedMesh ball(icosphere(2));
  SectionParameters parameters;
  parameters.size = 64;
  parameters.at = 3;
  CHECK(section_of(ball, parameters).inside == 0);
  const auto refuse = [&](auto change) {
    SectionParameters wrong;
    change(wrong);
    CHECK_THROWS_AS(section_of(ball, wrong), std::invalid_argument);
  };
  refuse([](SectionParameters& p) { p.axis = 3; });
  refuse([](SectionParameters& p) { p.size = 15; });
  refuse([](SectionParameters& p) { p.size = 4097; });
  refuse([](SectionParameters& p) { p.margin = 0.5; });
  refuse([](SectionParameters& p) { p.at = std::nan(""); });
}
