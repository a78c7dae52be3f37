#include "io/plot/svg_plot.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <regex>
#include <string>

#include "io/plot/markup.h"
#include "io/plot/svg_writer.h"
#include "io/special_values.h"
#include "io/xml_reader.h"
#include "support/catch.h"

using namespace meander;
using namespace meander::test;
using meander::test::named;
using meander::test::XmlElement;
using meander::test::XmlReader;

namespace {

std::vector<std::string> labels(AxisScale scale, double lower, double upper, std::size_t most) {
  std::vector<std::string> found;
  for (const AxisTick& tick : axis_ticks(scale, lower, upper, most))
    if (!tick.label.empty()) found.push_back(tick.label);
  return found;
}
using Labels = std::vector<std::string>;

PlotSeries series_of(std::vector<double> x, std::vector<double> y, SeriesStyle style = SeriesStyle::line) {
  PlotSeries series;
  series.x = std::move(x);
  series.y = std::move(y);
  series.style = style;
  return series;
}

// Paths drawn in a colour of the palette, in order.
std::vector<std::string> paths_in(const std::vector<XmlElement>& elements, std::size_t colour) {
  std::vector<std::string> found;
  for (const XmlElement& path : named(elements, "path")) {
    const auto has = [&](const char* key) {
      const auto at = path.attributes.find(key);
      return at != path.attributes.end() && at->second == hex_colour(palette_colour(colour));
    };
    if (has("stroke") || has("fill")) found.push_back(path.attributes.at("d"));
  }
  return found;
}

// Every number of the text is a number.
bool is_finite_text(const std::string& svg) {
  return !std::regex_search(svg, std::regex("[\" ,MLHVhvl-](nan|inf)"));
}

}  // namespace

TEST_CASE("axis_ticks: linear ticks are multiples of 1, 2 or 5") {
  CHECK(labels(AxisScale::linear, 0, 1, 6) == Labels{"0", "0.2", "0.4", "0.6", "0.8", "1.0"});
  CHECK(labels(AxisScale::linear, 0, 1, 5) == Labels{"0", "0.5", "1.0"});
  CHECK(labels(AxisScale::linear, -1.2, 3.4, 6) == Labels{"\u22121", "0", "1", "2", "3"});
  CHECK(labels(AxisScale::linear, 0, 16384, 5) == Labels{"0", "5000", "10000", "15000"});
  CHECK(labels(AxisScale::linear, 0.0101, 0.0139, 5) == Labels{"0.011", "0.012", "0.013"});
  CHECK(labels(AxisScale::linear, 0, 3e-6, 4) ==
        Labels{"0", "10^{\u22126}", "2\u00D710^{\u22126}", "3\u00D710^{\u22126}"});
  CHECK(labels(AxisScale::linear, -1e7, 1e7, 5) ==
        Labels{"\u22121.0\u00D710^{7}", "\u22120.5\u00D710^{7}", "0", "0.5\u00D710^{7}", "1.0\u00D710^{7}"});
}

TEST_CASE("axis_ticks: never more than asked for, ascending and inside") {
  for (const auto& [lower, upper] : {std::pair{0.0, 1.0},
                                     {-7.3e-5, 2e9},
                                     {1e300, 1.5e300},
                                     {-1e300, 1e300},
                                     {1.0, std::nextafter(1.0, 2.0)},
                                     {1e-300, 3e-300},
                                     {-0.3, 0.7000001},
                                     {12345.678, 12345.679}})
    for (std::size_t most = 2; most <= 12; ++most) {
      const auto ticks = axis_ticks(AxisScale::linear, lower, upper, most);
      CHECK(ticks.size() <= most);
      CHECK(std::ranges::is_sorted(ticks, std::ranges::less_equal{}, &AxisTick::value));
      for (const AxisTick& tick : ticks) {
        CHECK(tick.value >= lower);
        CHECK(tick.value <= upper);
      }
    }
}

TEST_CASE("axis_ticks: decades have minor ticks, many decades are thinned") {
  CHECK(labels(AxisScale::log10, 1, 1e3, 10) == Labels{"10^{0}", "10^{1}", "10^{2}", "10^{3}"});
  CHECK(axis_ticks(AxisScale::log10, 1, 1e3, 10).size() == 4 + 3 * 8);
  CHECK(labels(AxisScale::log10, 2, 2e6, 10).size() == 6);
  CHECK(labels(AxisScale::log10, 1e-9, 1e2, 5) ==
        Labels{"10^{\u22129}", "10^{\u22126}", "10^{\u22123}", "10^{0}"});
  const auto thinned = axis_ticks(AxisScale::log10, 1e-9, 1e2, 5);
  CHECK(thinned.size() == 12);  // every power of ten, no 2..9
  CHECK(std::ranges::count_if(thinned, &AxisTick::major) == 4);
}

TEST_CASE("axis_ticks: short log axes have 1-2-5 labels, very short ones linear ticks") {
  CHECK(labels(AxisScale::log10, 300, 3000, 10) == Labels{"500", "1000", "2000"});
  CHECK(labels(AxisScale::log10, 0.03, 0.08, 10) == Labels{"0.03", "0.04", "0.05", "0.06", "0.07", "0.08"});
  CHECK(labels(AxisScale::log10, 0.3, 8, 10) == Labels{"0.5", "1", "2", "5"});
}

TEST_CASE("axis_ticks: ranges that are none are errors") {
  CHECK_THROWS_AS(axis_ticks(AxisScale::linear, 1, 1, 5), std::invalid_argument);
  CHECK_THROWS_AS(axis_ticks(AxisScale::linear, 1, not_a_number, 5), std::invalid_argument);
  CHECK_THROWS_AS(axis_ticks(AxisScale::linear, 0, infinity, 5), std::invalid_argument);
  CHECK_THROWS_AS(axis_ticks(AxisScale::linear, 0, 1, 1), std::invalid_argument);
  CHECK_THROWS_AS(axis_ticks(AxisScale::log10, 0, 1, 5), std::invalid_argument);
}

TEST_CASE("escape_markup and text_runs") {
  CHECK(escape_markup("a<b> & \"c\" 'd'") == "a&lt;b&gt; &amp; &quot;c&quot; &#39;d&#39;");
  CHECK(escape_markup("\u221AN\t\n") == "\u221AN\t\n");
  CHECK(escape_markup(std::string_view("\x01\xFF\0", 3)) == "\uFFFD\uFFFD\uFFFD");
  CHECK(escape_markup("\xEF\xBF\xBF") == "\uFFFD");
  const auto runs = text_runs("N^{-1/2} d_{min}");
  REQUIRE(runs.size() == 4);
  CHECK(runs[1].text == "-1/2");
  CHECK(runs[1].shift == -1);
  CHECK(runs[2].text == " d");
  CHECK(runs[3].shift == 1);
  CHECK(text_runs("cut ^{off").size() == 1);
  CHECK(text_runs("").empty());
}

TEST_CASE("svg_plot: well-formed, escaped, with every text in it") {
  Plot plot;
  plot.title = "a < b & \"c\"";
  plot.x = {"N ]]> \x02", AxisScale::log10, {}, {}};
  plot.y.label = "D_{N}^{*}";
  plot.series = {series_of({1, 10, 100}, {3, 2, 1}, SeriesStyle::line_and_points)};
  plot.series[0].name = "<script>alert('x')</script>";
  plot.guides = {{2, false, "g & h"}, {50, true, ""}};
  plot.annotations = {{10, 2, "note <1>", TextAnchor::end, 3}, {1e9, 2, "outside"}};
  const auto elements = XmlReader::read(svg_plot(plot));
  CHECK(elements[0].name == "svg");
  CHECK(elements[0].attributes.at("viewBox") == "0 0 640 420");
  CHECK(elements[0].attributes.at("xmlns") == "http://www.w3.org/2000/svg");
  CHECK(named(elements, "title").at(0).text == plot.title);
  const std::string all = elements[0].text;
  for (const char* text :
       {"a < b & \"c\"", "N ]]> \uFFFD", "DN*", "<script>alert('x')</script>", "g & h", "note <1>"})
    CHECK(all.find(text) != std::string::npos);
  CHECK(all.find("outside") == std::string::npos);
  CHECK(named(elements, "script").empty());
  CHECK(svg_plot(plot) == svg_plot(plot));
}

TEST_CASE("svg_plot: a straight line in data is a straight line in px at the right places") {
  Plot plot;
  plot.x.lower = 0;
  plot.x.upper = 10;
  plot.y.lower = 0;
  plot.y.upper = 1;
  plot.series = {series_of({0, 5, 10}, {0, 0.5, 1})};
  const auto elements = XmlReader::read(svg_plot(plot));
  const auto path = paths_in(elements, 0).at(0);
  double x0, y0, x1, y1, x2, y2;
  REQUIRE(std::sscanf(path.c_str(), "M%lf %lfL%lf %lfL%lf %lf", &x0, &y0, &x1, &y1, &x2, &y2) == 6);
  CHECK(x1 == Approx(0.5 * (x0 + x2)).margin(0.02));
  CHECK(y1 == Approx(0.5 * (y0 + y2)).margin(0.02));
  // The axes run through the line's ends: M left top V bottom H right.
  double left, top, bottom, right;
  const auto axes = std::ranges::find_if(elements, [&](const XmlElement& element) {
    return element.name == "path" && std::sscanf(element.attributes.at("d").c_str(), "M%lf %lfV%lfH%lf",
                                                 &left, &top, &bottom, &right) == 4;
  });
  REQUIRE(axes != elements.end());
  CHECK(x0 == left);
  CHECK(x2 == right);
  CHECK(y0 == bottom);
  CHECK(y2 == top);
}

TEST_CASE("svg_plot: what cannot be drawn is skipped and leaves a gap") {
  Plot plot;
  plot.x.scale = plot.y.scale = AxisScale::log10;
  plot.series = {series_of({1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 0, -3, not_a_number, infinity},
                           {1, 1, not_a_number, 2, 2, 0, 3, 3, -1, infinity, 1, 1, 1, 1})};
  const std::string svg = svg_plot(plot);
  const auto paths = paths_in(XmlReader::read(svg), 0);
  REQUIRE(paths.size() == 1);
  CHECK(std::ranges::count(paths[0], 'M') == 3);
  CHECK(std::ranges::count(paths[0], 'L') == 3);
  CHECK(is_finite_text(svg));
  plot.series[0].style = SeriesStyle::points;
  const auto dots = paths_in(XmlReader::read(svg_plot(plot)), 0);
  REQUIRE(dots.size() == 1);
  CHECK(std::ranges::count(dots[0], 'z') == 6);
}

TEST_CASE("svg_plot: nothing to draw, one point, extremes") {
  std::vector<Plot> plots(9);
  plots[1].x.scale = plots[1].y.scale = AxisScale::log10;
  plots[2].series = {series_of({}, {}), series_of({not_a_number, infinity}, {1, 2})};
  plots[3].series = {series_of({3}, {-4}, SeriesStyle::line_and_points)};
  plots[4].series = {series_of({0, 1}, {-1e308, 1e308}), series_of({-1e300, 1e300}, {-1e300, 1e300})};
  plots[5].x.scale = plots[5].y.scale = AxisScale::log10;
  plots[5].series = {series_of({5e-324, 1e308}, {1e-300, 1e300})};
  plots[6].series = {series_of({1, 1, 1}, {2, 2, 2}, SeriesStyle::steps)};
  plots[7].x = {"x", AxisScale::linear, 5, 5};
  plots[7].y = {"y", AxisScale::log10, -1, infinity};
  plots[7].series = {series_of({1, 2}, {1, 2})};
  plots[8].x = {"x", AxisScale::linear, 0, 1e-9};  // the line leaves the frame at once
  plots[8].series = {series_of({0, 1e250}, {0, 1})};
  for (Plot& plot : plots) {
    for (PlotSeries& series : plot.series) series.name = "s";
    for (const double width : {160.0, 640.0}) {
      plot.width = width;
      const std::string svg = svg_plot(plot);
      CHECK_NOTHROW(XmlReader::read(svg));
      CHECK(is_finite_text(svg));
    }
  }
  CHECK(paths_in(XmlReader::read(svg_plot(plots[3])), 0).size() >= 1);
}

TEST_CASE("svg_plot: error bars end at the frame where they reach zero on a log axis") {
  Plot plot;
  plot.y.scale = AxisScale::log10;
  plot.legend = LegendPlace::none;
  plot.series = {series_of({1, 2, 3, 4}, {1, 2, 3, 4}, SeriesStyle::points)};
  plot.series[0].error = {0.5, 5, not_a_number, 0};
  const std::string svg = svg_plot(plot);
  CHECK(is_finite_text(svg));
  const auto paths = paths_in(XmlReader::read(svg), 0);
  REQUIRE(paths.size() == 2);  // bars, markers
  CHECK(std::ranges::count(paths[0], 'V') == 2);
  CHECK(std::ranges::count(paths[0], 'h') == 3);  // two caps, and one at the head of the second
}

TEST_CASE("svg_plot: steps hold each value to the next x") {
  Plot plot;
  plot.series = {series_of({0, 1, 2}, {5, 7, 6}, SeriesStyle::steps)};
  const auto path = paths_in(XmlReader::read(svg_plot(plot)), 0).at(0);
  std::vector<double> x(5), y(5);
  REQUIRE(std::sscanf(path.c_str(), "M%lf %lfL%lf %lfL%lf %lfL%lf %lfL%lf %lf", &x[0], &y[0], &x[1], &y[1],
                      &x[2], &y[2], &x[3], &y[3], &x[4], &y[4]) == 10);
  CHECK(y[0] == y[1]);
  CHECK(x[1] == x[2]);
  CHECK(y[2] == y[3]);
  CHECK(x[3] == x[4]);
}

TEST_CASE("svg_plot: the legend is placed where nothing is drawn") {
  // A falling line leaves top right free, one that fills every corner sends the legend out of the frame.
  Plot plot;
  plot.series = {series_of({0, 1}, {1, 0})};
  plot.series[0].name = "falling";
  const auto boxes = [](const Plot& p) { return named(XmlReader::read(svg_plot(p)), "rect"); };
  REQUIRE(boxes(plot).size() == 2);  // background and legend
  CHECK(std::stod(boxes(plot)[1].attributes.at("x")) > 320);
  CHECK(std::stod(boxes(plot)[1].attributes.at("y")) < 100);
  plot.series.push_back(series_of({0, 1}, {0, 1}));
  CHECK(boxes(plot).size() == 1);
  plot.legend = LegendPlace::bottom_left;
  REQUIRE(boxes(plot).size() == 2);
  CHECK(std::stod(boxes(plot)[1].attributes.at("y")) > 210);
  plot.legend = LegendPlace::none;
  CHECK(svg_plot(plot).find("falling") == std::string::npos);
  for (const LegendPlace place : {LegendPlace::right, LegendPlace::below}) {
    plot.legend = place;
    CHECK(svg_plot(plot).find("falling") != std::string::npos);
  }
}

TEST_CASE("svg_plot: the text of a guide gives way to the curves") {
  Plot plot;
  plot.legend = LegendPlace::none;
  plot.guides = {{0.5, false, "guide"}};
  const auto x_of_text = [&] {
    const auto elements = XmlReader::read(svg_plot(plot));
    for (const XmlElement& text : named(elements, "text"))
      if (text.text == "guide") return std::stod(text.attributes.at("x"));
    throw std::runtime_error("no text");
  };
  plot.series = {series_of({0, 1}, {0, 0})};
  CHECK(x_of_text() > 400);
  plot.series.push_back(series_of({0.99, 0.99}, {0, 1}));  // through the right end
  CHECK(x_of_text() < 200);
}

TEST_CASE("svg_plot: colours follow the series, or are given, or neutral") {
  Plot plot;
  plot.series = {series_of({0, 1}, {0, 1}), series_of({0, 1}, {1, 1}), series_of({0, 1}, {1, 0})};
  plot.series[1].colour = 5;
  plot.series[2].neutral = true;
  const std::string svg = svg_plot(plot);
  const auto elements = XmlReader::read(svg);
  CHECK(paths_in(elements, 0).size() == 1);
  CHECK(paths_in(elements, 1).empty());
  CHECK(paths_in(elements, 2).empty());
  CHECK(paths_in(elements, 5).size() == 1);
  CHECK(svg.find(hex_colour(neutral_colour)) != std::string::npos);
}

TEST_CASE("svg_plot: lengths that differ and sizes that are none are errors") {
  Plot plot;
  plot.series = {series_of({0, 1}, {0})};
  CHECK_THROWS_AS(svg_plot(plot), std::invalid_argument);
  plot.series = {series_of({0, 1}, {0, 1})};
  plot.series[0].error = {1};
  CHECK_THROWS_AS(svg_plot(plot), std::invalid_argument);
  plot.series.clear();
  plot.width = not_a_number;
  CHECK_THROWS_AS(svg_plot(plot), std::invalid_argument);
}

TEST_CASE("svg::clip: against a slow search along the segment") {
  const svg::Box box{0, 0, 4, 3};
  for (int a = -2; a <= 6; ++a)
    for (int b = -2; b <= 5; ++b)
      for (int c = -2; c <= 6; ++c)
        for (int d = -2; d <= 5; ++d) {
          const svg::Point from{a + 0.25, b + 0.25}, to{c + 0.125, d + 0.125};
          const auto part = svg::clip(from, to, box);
          int inside = 0;
          constexpr int steps = 64;
          for (int k = 0; k <= steps; ++k) {
            const double t = static_cast<double>(k) / steps;
            const svg::Point at{from.x + t * (to.x - from.x), from.y + t * (to.y - from.y)};
            inside += box.contains(at);
          }
          const double length = std::hypot(to.x - from.x, to.y - from.y);
          const double kept =
              part ? std::hypot(part->second.x - part->first.x, part->second.y - part->first.y) : 0.0;
          CHECK(std::abs(kept - length * inside / steps) <= 1.0001 * length / steps);
          if (part) {
            CHECK(box.contains(part->first));
            CHECK(box.contains(part->second));
          }
        }
}

TEST_CASE("svg::number, fit_text, wrap_text") {
  CHECK(svg::number(1.0) == "1");
  CHECK(svg::number(-0.001) == "0");
  CHECK(svg::number(100) == "100");
  CHECK(svg::number(2.505) == "2.5");
  CHECK(svg::number(-3.25) == "-3.25");
  CHECK(svg::fit_text("short", 12, 100) == "short");
  const std::string cut =
      svg::fit_text("\u00E4\u00E4\u00E4\u00E4\u00E4\u00E4\u00E4\u00E4\u00E4\u00E4", 10, 40);
  CHECK(cut.ends_with("\u2026"));
  CHECK(cut.size() % 2 == 1);  // whole characters of two bytes and the ellipsis of three
  CHECK(svg::text_width(cut, 10) <= 40);
  const auto lines = svg::wrap_text(" one two  three four ", 10, 60);
  std::string joined;
  for (const std::string& line : lines) {
    CHECK(svg::text_width(line, 10) <= 60);
    joined += line + " ";
  }
  CHECK(lines.size() > 1);
  CHECK(joined == "one two three four ");
  CHECK(svg::wrap_text("", 10, 60).empty());
}
