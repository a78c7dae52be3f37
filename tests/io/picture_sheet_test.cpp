#include "io/plot/picture_sheet.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "io/plot/text_painter.h"
#include "support/catch.h"

using namespace meander;

namespace {

std::size_t painted(const RgbImage& image, std::uint32_t x0, std::uint32_t y0, std::uint32_t x1,
                    std::uint32_t y1) {
  std::size_t count = 0;
  for (std::uint32_t y = y0; y < y1; ++y)
    for (std::uint32_t x = x0; x < x1; ++x) {
      const std::uint8_t* const p = image.pixel(x, y);
      count += p[0] != 255 || p[1] != 255 || p[2] != 255;
    }
  return count;
}
std::size_t painted(const RgbImage& image) { return painted(image, 0, 0, image.width, image.height); }

RgbImage filled(std::uint32_t size, std::uint8_t red) {
  RgbImage image(size, size);
  for (std::size_t i = 0; i < image.pixels.size(); i += 3) image.pixels[i + 1] = image.pixels[i + 2] = 0;
  for (std::size_t i = 0; i < image.pixels.size(); i += 3) image.pixels[i] = red;
  return image;
}

}  // namespace

TEST_CASE("text: width grows with length and size") {
  const TextStyle style{20};
  CHECK(painted_width("", style) == 0);
  CHECK(painted_width("mm", style) == Approx(2 * painted_width("m", style)).epsilon(0.02));
  CHECK(painted_width("m", {40}) == Approx(2 * painted_width("m", style)).epsilon(0.05));
  CHECK(painted_width("m", style) > 1.5 * painted_width("i", style));
}

TEST_CASE("text: is drawn where requested, and clipped") {
  const TextStyle style{20};
  RgbImage image(200, 60);
  paint_text(image, "group", 20, 40, style);
  const auto width = static_cast<std::uint32_t>(painted_width("group", style));
  CHECK(painted(image) > 100);
  CHECK(painted(image, 0, 0, 18, 60) == 0);
  CHECK(painted(image, 20 + width + 2, 0, 200, 60) == 0);
  CHECK(painted(image, 0, 0, 200, 20) == 0);
  CHECK(painted(image, 0, 42, 200, 60) > 10);  // descenders
  RgbImage centered(200, 60), right(200, 60);
  paint_text(centered, "group", 20 + 0.5 * painted_width("group", style), 40, style, TextAlign::center);
  paint_text(right, "group", 20 + painted_width("group", style), 40, style, TextAlign::right);
  CHECK(centered.pixels == image.pixels);
  CHECK(right.pixels == image.pixels);
  paint_text(image, "outside", -1e4, 40, style);
  paint_text(image, "outside", 20, 1e4, style);
  CHECK(centered.pixels == image.pixels);
  paint_text(image, "cut", 190, 62, style);  // partly outside
  CHECK(centered.pixels != image.pixels);
}

TEST_CASE("text: any bytes can be drawn") {
  RgbImage image(200, 40);
  for (const std::string& text : {std::string("\xFF\xFE"), std::string("a\0b", 3), std::string("\n\t\x01"),
                                  std::string("caf\xC3\xA9 \xE6\xBC\xA2 \xF0\x9F\x90\xB0")}) {
    paint_text(image, text, 4, 30, {20});
    CHECK(painted_width(text, {20}) > 0);
  }
  CHECK(painted(image) > 0);
}

TEST_CASE("text: is shortened at the front, never within a character") {
  const TextStyle style{15};
  const std::string path = "a/very/long/folder/\xC3\xA9\xC3\xA9\xC3\xA9\xC3\xA9/model.off";
  CHECK(shortened_at_front(path, 1e4, style) == path);
  for (double width = 20; width < 300; width += 7) {
    const std::string text = shortened_at_front(path, width, style);
    INFO(width << " " << text);
    if (text == path) break;
    REQUIRE(text.starts_with("\xE2\x80\xA6"));
    CHECK(path.ends_with(text.substr(3)));
    CHECK((text.size() == 3 || (static_cast<unsigned char>(text[3]) & 0xC0) != 0x80));
    CHECK((text.size() == 3 || painted_width(text, style) <= width));
  }
}

TEST_CASE("text: lines break between words") {
  const TextStyle style{15};
  const std::string text = "the header promises 353535235358 vertices, but only 289 bytes follow it";
  const std::vector<std::string> lines = wrapped_text(text, 150, 10, style);
  REQUIRE(lines.size() > 2);
  std::string joined;
  for (const std::string& line : lines) {
    CHECK(painted_width(line, style) <= 150);
    joined += (joined.empty() ? "" : " ") + line;
  }
  CHECK(joined == text);
  const std::vector<std::string> two = wrapped_text(text, 150, 2, style);
  REQUIRE(two.size() == 2);
  CHECK(two[1].ends_with("\xE2\x80\xA6"));
  CHECK(wrapped_text("", 100, 3, style) == std::vector<std::string>{""});
  CHECK(painted_width(two[1], style) <= 150);
  const std::vector<std::string> narrow = wrapped_text("an unbreakable word", 50, 3, style);
  REQUIRE(narrow.size() == 3);
  for (const std::string& line : narrow) CHECK(painted_width(line, style) <= 50);
  CHECK(narrow[1].starts_with("\xE2\x80\xA6"));
}

TEST_CASE("picture_sheet: cells, names, failures and legend have their places") {
  SheetLook look;
  look.cell = 100;
  look.gap = 10;
  std::vector<SheetCell> cells(5);
  for (std::size_t i = 0; i < 5; ++i) {
    cells[i].title = "item " + std::to_string(i);
    if (i != 3) cells[i].picture = filled(100, static_cast<std::uint8_t>(50 * i));
  }
  cells[3].failure = "empty: the file holds no face";
  const RgbImage sheet = picture_sheet(cells, {}, look);
  CHECK(sheet.width == 10 + 3 * 110);
  const std::uint32_t caption = 23;  // 1.5 lines of 15 pixels
  REQUIRE(sheet.height == 10 + 2 * (100 + caption + 10));
  for (std::uint32_t i = 0; i < 6; ++i) {
    const std::uint32_t x = 10 + i % 3 * 110, y = 10 + i / 3 * (110 + caption);
    INFO(i);
    if (i == 5) {
      CHECK(painted(sheet, x, y, x + 100, y + 100 + caption) == 0);
      continue;
    }
    CHECK(sheet.pixel(x + 1, y + 1)[0] == (i == 3 ? 243 : 50 * i));
    CHECK(painted(sheet, x, y, x + 100, y + 100) == 100 * 100);
    CHECK(painted(sheet, x, y + 100, x + 100, y + 100 + caption) > 50);
  }
  const RgbImage legend = picture_sheet(cells, SheetLegend{"density", true, "0", "1"}, look);
  CHECK(legend.height > sheet.height + 30);
  std::size_t first = 0, last = 0;
  const Rgb low = map_color(0), high = map_color(1);
  for (std::uint32_t y = sheet.height; y < legend.height; ++y)
    for (std::uint32_t x = 0; x < legend.width; ++x) {
      const std::uint8_t* const p = legend.pixel(x, y);
      const Rgb own{p[0], p[1], p[2]};
      first += own == low;
      last += own == high;
    }
  CHECK(first >= 15);
  CHECK(last >= 15);
  cells[0].picture = filled(99, 0);
  CHECK_THROWS_AS(picture_sheet(cells, {}, look), std::invalid_argument);
  CHECK(painted(picture_sheet({}, {}, look)) == 0);
}
