#include "io/plot/svg_points.h"

#include <algorithm>
#include <limits>
#include <string>

#include "io/special_values.h"
#include "io/xml_reader.h"
#include "support/catch.h"

using namespace meander;
using namespace meander::test;
using meander::test::named;
using meander::test::XmlElement;
using meander::test::XmlReader;

namespace {

double value(const XmlElement& element, const char* key) { return std::stod(element.attributes.at(key)); }

}  // namespace

TEST_CASE("svg_points: dots stand where they belong, y upwards, one scale") {
  PlanarDrawing drawing;
  drawing.x_max = 2;  // a 2 x 1 window in a square picture
  drawing.caption = "a & b";
  DotSet dots;
  dots.x = {0, 2, 1, 3, not_a_number, 1};
  dots.y = {0, 1, 0.5, 0.5, 0.5, not_a_number};
  drawing.dots = {dots};
  const auto elements = XmlReader::read(svg_points(drawing, 402, 402));
  const auto circles = named(elements, "circle");
  REQUIRE(circles.size() == 3);
  CHECK(value(circles[1], "cx") - value(circles[0], "cx") == Approx(400));
  CHECK(value(circles[0], "cy") - value(circles[1], "cy") == Approx(200));
  CHECK(value(circles[2], "cx") == Approx(0.5 * (value(circles[0], "cx") + value(circles[1], "cx"))));
  const auto frame = named(elements, "rect").at(1);  // after that of the background
  CHECK(value(frame, "width") == Approx(400));
  CHECK(value(frame, "height") == Approx(200));
  CHECK(elements[0].text.find("a & b") != std::string::npos);
}

TEST_CASE("svg_points: a colour for every dot") {
  PlanarDrawing drawing;
  DotSet dots;
  dots.x = dots.y = {0.25, 0.5};
  dots.colours = {{255, 0, 0}, {0, 0, 255}};
  drawing.dots = {dots};
  const auto circles = named(XmlReader::read(svg_points(drawing)), "circle");
  CHECK(circles.at(0).attributes.at("fill") == "#ff0000");
  CHECK(circles.at(1).attributes.at("fill") == "#0000ff");
}

TEST_CASE("svg_points: polylines are cut at the window, interrupted by NaN, closed, coloured along") {
  PlanarDrawing drawing;
  drawing.frame = false;
  PlanarPolyline line;
  line.x = {0.1, 0.9, 5, 0.9, not_a_number, 0.2, 0.3};
  line.y = {0.1, 0.1, 0.5, 0.9, 0.5, 0.5, 0.5};
  drawing.lines = {line};
  const auto path = named(XmlReader::read(svg_points(drawing)), "path").at(0).attributes.at("d");
  CHECK(std::ranges::count(path, 'M') == 3);  // leaves, comes back, and begins again after the NaN
  CHECK(std::ranges::count(path, 'L') == 4);

  PlanarPolyline square;
  square.x = {0.2, 0.8, 0.8, 0.2};
  square.y = {0.2, 0.2, 0.8, 0.8};
  square.closed = true;
  drawing.lines = {square};
  CHECK(std::ranges::count(named(XmlReader::read(svg_points(drawing)), "path").at(0).attributes.at("d"),
                           'L') == 4);
  square.along = true;
  drawing.lines = {square};
  const auto pieces = named(XmlReader::read(svg_points(drawing)), "path");
  REQUIRE(pieces.size() == 4);
  CHECK(pieces[0].attributes.at("stroke") != pieces[3].attributes.at("stroke"));
}

TEST_CASE("svg_points: a fitted window holds everything") {
  PlanarDrawing drawing;
  drawing.fit = true;
  DotSet dots;
  dots.x = {-1e6, 3e6, not_a_number};
  dots.y = {10, 12, 0};
  drawing.dots = {dots};
  CHECK(named(XmlReader::read(svg_points(drawing)), "circle").size() == 2);
  drawing.dots[0].x = drawing.dots[0].y = {7, 7, 7};  // a window of no size
  CHECK(named(XmlReader::read(svg_points(drawing)), "circle").size() == 3);
  drawing.dots.clear();
  CHECK_NOTHROW(XmlReader::read(svg_points(drawing)));
}

TEST_CASE("svg_panels: every drawing in its own place, captions wrapped below") {
  std::vector<PlanarDrawing> drawings(6);
  for (std::size_t i = 0; i < 6; ++i)
    drawings[i].caption = "a caption of several words, number " + std::to_string(i);
  const auto elements = XmlReader::read(svg_panels(drawings, {"six", 0, 100, 100, 10}));
  const auto groups = named(elements, "g");
  REQUIRE(groups.size() == 6);  // 3 columns, 2 rows
  const auto place = [&](std::size_t i) { return groups[i].attributes.at("transform"); };
  CHECK(place(0) == "translate(12 40)");
  CHECK(place(2) == "translate(232 40)");
  CHECK(place(3).starts_with("translate(12 "));
  CHECK(value(elements[0], "width") == 344);
  CHECK(named(elements, "text").size() > 7);  // wrapped
  CHECK(named(XmlReader::read(svg_panels(drawings, {"", 6, 100, 100, 10})), "g")[5].attributes.at(
            "transform") == "translate(562 12)");
  CHECK_NOTHROW(XmlReader::read(svg_panels(std::vector<PlanarDrawing>{})));
}

TEST_CASE("svg_panels: whole plots") {
  std::vector<Plot> plots(2);
  plots[0].title = "first";
  plots[1].x.scale = AxisScale::log10;
  const auto elements = XmlReader::read(svg_panels(plots, {"both", 0, 300, 200, 10}));
  CHECK(named(elements, "g").size() == 2);
  CHECK(elements[0].text.find("first") != std::string::npos);
}

TEST_CASE("svg_points: lengths that differ and windows that are none are errors") {
  PlanarDrawing drawing;
  drawing.dots = {DotSet{}};
  drawing.dots[0].x = {1};
  CHECK_THROWS_AS(svg_points(drawing), std::invalid_argument);
  drawing.dots[0].y = {1};
  drawing.dots[0].colours = {Rgb{}, Rgb{}};
  CHECK_THROWS_AS(svg_points(drawing), std::invalid_argument);
  drawing.dots.clear();
  drawing.lines = {PlanarPolyline{}};
  drawing.lines[0].y = {1};
  CHECK_THROWS_AS(svg_points(drawing), std::invalid_argument);
  drawing.lines.clear();
  drawing.x_min = 1;
  CHECK_THROWS_AS(svg_points(drawing), std::invalid_argument);
  drawing.x_min = not_a_number;
  CHECK_THROWS_AS(svg_points(drawing), std::invalid_argument);
}
