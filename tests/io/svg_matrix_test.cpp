#include "io/plot/svg_matrix.h"

#include <limits>
#include <stdexcept>

#include "support/catch.h"

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

TEST_CASE("matrix_image: cells in the colours of their shares, numbers and names drawn, many classes small") {
  const auto dark = [](const RgbImage& image, std::uint32_t x, std::uint32_t y, std::uint32_t width,
                       std::uint32_t height) {
    std::size_t count = 0;
    for (std::uint32_t row = y; row < y + height; ++row)
      for (std::uint32_t column = x; column < x + width; ++column)
        count += image.pixel(column, row)[0] < 120 ? 1 : 0;
    return count;
  };
  const NamedMatrix matrix{
      "title", "of", "found", {"a", "bee"}, {"x", "y", "z"}, {1, 0, 0.25, 0.004, 0.5, -1}};
  const RgbImage image = matrix_image(matrix);
  const std::uint32_t left = image.width - 12 - 3 * 36, top = image.height - 12 - 2 * 36;
  const auto corner = [&](std::uint32_t i, std::uint32_t j) {
    const std::uint8_t* const pixel = image.pixel(left + 36 * j + 1, top + 36 * i + 1);
    return Rgb{pixel[0], pixel[1], pixel[2]};
  };
  CHECK(corner(0, 0) == share_colour(1));
  CHECK(corner(0, 1) == Rgb{255, 255, 255});
  CHECK(corner(0, 2) == share_colour(0.25));
  CHECK(corner(1, 1) == share_colour(0.5));
  CHECK(dark(image, left + 72, top, 36, 36) > 15);       // 25
  CHECK(dark(image, left, top + 36, 36, 36) == 0);       // below half a percent
  CHECK(dark(image, left - 30, top + 36, 29, 36) > 30);  // bee
  CHECK(dark(image, left + 36, top - 40, 36, 39) > 5);   // y
  CHECK(dark(image, 12, top, 20, 72) > 10);              // of
  // 200 classes: no numbers; 1,000: no names either.
  const auto many = [](std::size_t n) {
    return matrix_image({"", "", "", std::vector<std::string>(n, "abc"), std::vector<std::string>(n, "abc"),
                         std::vector<double>(n * n, 0.25)});
  };
  CHECK(many(200).width > 12 + 5 + 8 * 200 + 12);
  CHECK(many(200).width < 12 + 5 + 8 * 200 + 12 + 60);
  CHECK(many(1000).width == 12 + 1000 + 12);
  CHECK(matrix_image({}).width > 0);
  CHECK_THROWS_AS(matrix_image({"", "", "", {"a"}, {"b"}, {}}), std::invalid_argument);
}
