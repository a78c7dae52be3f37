#include "io/plot/heat_map.h"

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "io/special_values.h"
#include "support/catch.h"

using namespace meander;
using namespace meander::test;

namespace {

Rgb at(const RgbImage& image, std::uint32_t x, std::uint32_t y) {
  const std::uint8_t* pixel = image.pixel(x, y);
  return {pixel[0], pixel[1], pixel[2]};
}

// Lightness in OKLab (Ottosson 2020), from sRGB.
double lightness(Rgb colour) {
  const auto linear = [](std::uint8_t byte) {
    const double v = byte / 255.0;
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  };
  const double r = linear(colour.red), g = linear(colour.green), b = linear(colour.blue);
  return 0.2104542553 * std::cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b) +
         0.7936177850 * std::cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b) -
         0.0040720468 * std::cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
}

}  // namespace

TEST_CASE("map_colour: the ends, and beyond them") {
  CHECK(map_colour(ColourMap::grey, 0) == Rgb{0, 0, 0});
  CHECK(map_colour(ColourMap::grey, 1) == Rgb{255, 255, 255});
  CHECK(map_colour(ColourMap::inverse, 0) == Rgb{255, 255, 255});
  CHECK(map_colour(ColourMap::inverse, 1) == Rgb{0, 0, 0});
  for (const ColourMap map : {ColourMap::grey, ColourMap::lagoon, ColourMap::inverse}) {
    CHECK(map_colour(map, -3) == map_colour(map, 0));
    CHECK(map_colour(map, infinity) == map_colour(map, 1));
    CHECK(map_colour(map, not_a_number) == map_colour(map, 0));
  }
  const Rgb dark = map_colour(ColourMap::lagoon, 0), bright = map_colour(ColourMap::lagoon, 1);
  CHECK(dark.blue > dark.green);  // violet
  CHECK(dark.red > dark.green);
  CHECK(bright.red > 200);  // yellow
  CHECK(bright.green > 200);
  CHECK(bright.blue < 120);
}

TEST_CASE("map_colour: lagoon rises in even steps of lightness, so none of it was cut at the gamut") {
  for (int i = 0; i <= 100; ++i) {
    const double t = i / 100.0;
    CHECK(lightness(map_colour(ColourMap::lagoon, t)) == Approx(0.28 + 0.64 * t).margin(0.004));
  }
}

TEST_CASE("palette_colour: ten chosen colours, then others, none twice") {
  for (std::size_t i = 0; i < 20 * palette_size; ++i) {
    for (std::size_t k = 0; k < i; ++k) CHECK_FALSE(palette_colour(i) == palette_colour(k));
  }
  CHECK(hex_colour(palette_colour(0)) == "#0072b2");
}

TEST_CASE("heat_map: ends of the range, rows and directions") {
  const std::vector<double> values{-2, 0, 2, 6, 4, 2};  // 3 columns, 2 rows
  const RgbImage image = heat_map(values, 3, 2);
  CHECK(image.width == 3);
  CHECK(image.height == 2);
  CHECK(at(image, 0, 0) == Rgb{0, 0, 0});
  CHECK(at(image, 0, 1) == Rgb{255, 255, 255});
  CHECK(at(image, 2, 0) == at(image, 2, 1));
  CHECK(std::abs(at(image, 2, 0).red - 127.5) <= 1);
  HeatMapParameters parameters;
  parameters.upwards = true;
  CHECK(at(heat_map(values, 3, 2, parameters), 0, 0) == Rgb{255, 255, 255});
  parameters.pixels = 4;
  const RgbImage large = heat_map(values, 3, 2, parameters);
  CHECK(large.width == 12);
  CHECK(large.height == 8);
  CHECK(at(large, 3, 3) == Rgb{255, 255, 255});
  CHECK(at(large, 3, 4) == Rgb{0, 0, 0});
}

TEST_CASE("heat_map: given range, clamping, NaN and infinity") {
  const std::vector<double> values{-5, 0, 10, 99, not_a_number, infinity, -infinity};
  HeatMapParameters parameters;
  parameters.lower = 0;
  parameters.upper = 10;
  const RgbImage image = heat_map(values, 7, 1, parameters);
  const std::array<Rgb, 7> wanted{{{0, 0, 0},
                                   {0, 0, 0},
                                   {255, 255, 255},
                                   {255, 255, 255},
                                   parameters.not_a_number,
                                   {255, 255, 255},
                                   {0, 0, 0}}};
  for (std::uint32_t x = 0; x < 7; ++x) CHECK(at(image, x, 0) == wanted[x]);
}

TEST_CASE("heat_map: tones") {
  const std::vector<double> values{0, 0.25, 1};
  HeatMapParameters parameters;
  parameters.tone = ToneMap::square_root;
  CHECK(std::abs(at(heat_map(values, 3, 1, parameters), 1, 0).red - 127.5) <= 1);
  parameters.tone = ToneMap::logarithm;
  const RgbImage image = heat_map(values, 3, 1, parameters);
  CHECK(std::abs(at(image, 1, 0).red - 255 * std::log(26.0) / std::log(101.0)) <= 1);
  CHECK(at(image, 0, 0) == Rgb{0, 0, 0});
  CHECK(at(image, 2, 0) == Rgb{255, 255, 255});
}

TEST_CASE("heat_map_range: quantiles of the finite values") {
  std::vector<double> values{not_a_number, infinity};
  for (int i = 0; i <= 100; ++i) values.push_back((i * 37) % 101);
  HeatMapParameters parameters;
  CHECK(heat_map_range(values, parameters).upper == 100);
  parameters.lower_quantile = 0.05;
  parameters.upper_quantile = 0.9;
  CHECK(heat_map_range(values, parameters).lower == 5);
  CHECK(heat_map_range(values, parameters).upper == 90);
  parameters.lower = 200;  // above all values: an empty range there
  CHECK(heat_map_range(values, parameters).lower == 200);
  CHECK(heat_map_range(values, parameters).upper == 200);
  CHECK(heat_map_range({}, {}).upper == 1);
}

TEST_CASE("heat_map: nothing, all equal, huge") {
  CHECK(heat_map({}, 0, 0).pixels.empty());
  CHECK(at(heat_map(std::vector<double>{3, 3}, 2, 1), 0, 0).red == 128);
  const RgbImage huge = heat_map(std::vector<double>{-1.7e308, 0, 1.7e308}, 3, 1);
  CHECK(std::abs(at(huge, 1, 0).red - 127.5) <= 1);
}

TEST_CASE("heat_map: errors") {
  const std::vector<double> values{1, 2};
  CHECK_THROWS_AS(heat_map(values, 3, 1), std::invalid_argument);
  HeatMapParameters parameters;
  parameters.pixels = 0;
  CHECK_THROWS_AS(heat_map(values, 2, 1, parameters), std::invalid_argument);
  parameters = {};
  parameters.upper_quantile = 1.5;
  CHECK_THROWS_AS(heat_map(values, 2, 1, parameters), std::invalid_argument);
  parameters = {};
  parameters.lower = 2;
  parameters.upper = 1;
  CHECK_THROWS_AS(heat_map(values, 2, 1, parameters), std::invalid_argument);
  parameters.upper = not_a_number;
  CHECK_THROWS_AS(heat_map(values, 2, 1, parameters), std::invalid_argument);
}
