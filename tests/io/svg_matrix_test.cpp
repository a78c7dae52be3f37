#include "io/plot/svg_matrix.h"

#include <catch2/catch.hpp>
#include <limits>
#include <stdexcept>

using namespace meander;

namespace {

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

}  // namespace

TEST_CASE("svg_matrix: one square a share above zero, its value in percent, names escaped") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::string picture =
      svg_matrix({"<confusion>", "of", "found", {"a&b", "c"}, {"x", "y", "z"}, {1, 0, nan, 0.25, 2, -1}});
  CHECK(count_of(picture, "<rect") == 2 + 3);  // paper, frame, three shares
  CHECK(count_of(picture, ">100<") == 2);      // 2 is clamped
  CHECK(count_of(picture, ">25<") == 1);
  CHECK(count_of(picture, "a&amp;b") == 1);
  CHECK(count_of(picture, "&lt;confusion&gt;") == 2);
  CHECK(svg_matrix({}).starts_with("<?xml"));
  CHECK_THROWS_AS(svg_matrix({"", "", "", {"a"}, {"b"}, {}}), std::invalid_argument);
}
