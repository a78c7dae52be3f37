#include "io/image/png_reader.h"

#include <png.h>
#include <zlib.h>

#include <cstdio>
#include <functional>
#include <string>

#include "io/plot/png_writer.h"
#include "kernels/core/status.h"
#include "support/catch.h"
#include "support/mesh_files.h"
#include "support/png_files.h"

using namespace meander;
using namespace meander::test;

namespace {

GrayImage read(const std::string& bytes, std::uint64_t most_bytes = 1 << 20) {
  return decode_gray_png(std::as_bytes(std::span(bytes)), most_bytes);
}

std::string result(const std::string& bytes, std::uint64_t most_bytes = 1 << 20) {
  try {
    return std::to_string(read(bytes, most_bytes).values.size()) + " values";
  } catch (const ItemError& error) {
    return std::string(name_of(error.status())) + ": " + error.what();
  }
}

unsigned noise(std::size_t x, std::size_t y, std::size_t channel, int depth) {
  return static_cast<unsigned>((x * 40503 + y * 30011 + channel * 7919 + x * y) & ((1u << depth) - 1));
}

// A chunk with its length and check sum.
std::string chunk(const std::string& type, const std::string& data) {
  const auto word = [](std::uint32_t value) {
    std::string bytes;
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 255);
    return bytes;
  };
  const std::string body = type + data;
  return word(static_cast<std::uint32_t>(data.size())) + body +
         word(static_cast<std::uint32_t>(
             crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()))));
}

const std::string signature = "\x89PNG\r\n\x1A\n";

}  // namespace

TEST_CASE("read_gray_png: gray of every depth, interlaced or not, with or without alpha") {
  for (const int depth : {1, 2, 4, 8, 16})
    for (const bool interlaced : {false, true})
      for (const int type : {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA})
        for (const auto& [width, height] : {std::pair{1u, 1u}, std::pair{13u, 9u}, std::pair{3u, 40u}}) {
          if (type == PNG_COLOR_TYPE_GRAY_ALPHA && depth < 8) continue;
          PngPicture picture{width, height, depth, type, interlaced, {}, type == PNG_COLOR_TYPE_GRAY};
          const GrayImage image =
              read(png_bytes(picture, [&](auto x, auto y, auto c) { return noise(x, y, c, depth); }));
          REQUIRE(image.width == width);
          REQUIRE(image.height == height);
          REQUIRE(image.values.size() == std::size_t{width} * height);
          bool equal = true;
          for (std::size_t y = 0; y < height; ++y)
            for (std::size_t x = 0; x < width; ++x)
              equal = equal && image.values[y * width + x] ==
                                   static_cast<float>(noise(x, y, 0, depth) / double((1 << depth) - 1));
          CAPTURE(depth, interlaced, type, width);
          REQUIRE(equal);
        }
}

TEST_CASE("read_gray_png: colors become BT.709 luma, and gray colors stay gray") {
  for (const int depth : {8, 16})
    for (const int type : {PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_RGB_ALPHA})
      for (const bool interlaced : {false, true}) {
        const PngPicture picture{11, 7, depth, type, interlaced, {}, false};
        const double white = (1 << depth) - 1;
        const GrayImage image =
            read(png_bytes(picture, [&](auto x, auto y, auto c) { return noise(x, y, c, depth); }));
        for (std::size_t i = 0; i < 77; ++i) {
          const auto s = [&](std::size_t c) { return noise(i % 11, i / 11, c, depth) / white; };
          REQUIRE(image.values[i] == Approx(0.2126 * s(0) + 0.7152 * s(1) + 0.0722 * s(2)).margin(1e-7));
        }
        const GrayImage gray =
            read(png_bytes(picture, [&](auto x, auto y, auto) { return noise(x, y, 0, depth); }));
        for (std::size_t i = 0; i < 77; ++i)
          REQUIRE(gray.values[i] == static_cast<float>(noise(i % 11, i / 11, 0, depth) / white));
      }
  // Pure colors distinguish the channels.
  const GrayImage pure = read(png_bytes({3, 1, 8, PNG_COLOR_TYPE_RGB, false, {}, false},
                                        [](auto x, auto, auto c) { return x == c ? 255u : 0u; }));
  REQUIRE(pure.values == std::vector<float>{0.2126f, 0.7152f, 0.0722f});
}

TEST_CASE("read_gray_png: palettes of every depth") {
  const std::vector<png_color> palette = {{255, 0, 0}, {10, 10, 10}};
  for (const int depth : {1, 2, 4, 8})
    for (const bool transparent : {false, true}) {
      const GrayImage image =
          read(png_bytes({9, 2, depth, PNG_COLOR_TYPE_PALETTE, depth == 4, palette, transparent},
                         [](auto x, auto y, auto) { return unsigned((x + y) % 2); }));
      for (std::size_t i = 0; i < 18; ++i)
        REQUIRE(image.values[i] == ((i % 9 + i / 9) % 2 == 1 ? static_cast<float>(10 / 255.0) : 0.2126f));
    }
}

TEST_CASE("read_gray_png: reads what write_png writes, top row first") {
  const ScratchFolder folder;
  RgbImage image(5, 3);
  for (std::uint32_t y = 0; y < 3; ++y)
    for (std::uint32_t x = 0; x < 5; ++x)
      for (int c = 0; c < 3; ++c) image.pixel(x, y)[c] = static_cast<std::uint8_t>(50 * y + x);
  write_png(folder / "a.png", image);
  const GrayImage again = read_gray_png(folder / "a.png");
  REQUIRE(again.width == 5);
  REQUIRE(again.height == 3);
  for (std::size_t i = 0; i < 15; ++i)
    REQUIRE(again.values[i] == static_cast<float>((50 * (i / 5) + i % 5) / 255.0));
}

TEST_CASE("read_gray_png: errors say what is wrong") {
  const std::string good = png_bytes({20, 20, 8, PNG_COLOR_TYPE_GRAY, false, {}, false},
                                     [](auto x, auto y, auto c) { return noise(x, y, c, 8); });
  CHECK(result(good) == "400 values");
  CHECK(result("") == "unreadable: not a PNG file: it does not begin with the PNG signature");
  CHECK(result("\xFF\xD8\xFF\xE0 a photograph") ==
        "unreadable: not a PNG file: it does not begin with the PNG signature");
  for (std::size_t size = 8; size < good.size(); ++size) {
    const std::string said = result(good.substr(0, size));
    if (said.find("unreadable: the PNG file cannot be decoded: ") != 0) FAIL(size << " bytes: " << said);
  }
  CHECK(result(good.substr(0, 60)) == "unreadable: the PNG file cannot be decoded: the file ends too early");
  std::string damaged = good;
  damaged[good.find("IDAT") + 100] ^= 1;
  CHECK_THAT(result(damaged), Catch::Matchers::StartsWith("unreadable: the PNG file cannot be decoded: "));
  const ScratchFolder folder;
  CHECK_THROWS_WITH(read_gray_png(folder / "absent.png"),
                    "the file cannot be opened: No such file or directory");
  CHECK_THROWS_WITH(read_gray_png(folder.path()), "not a regular file");
}

TEST_CASE("read_gray_png: sizes are checked before memory is allocated") {
  // Two thousand million pixels a side, in a file of a few bytes.
  const auto header = [](const std::string& width, const std::string& height, char interlace) {
    return signature + chunk("IHDR", width + height + std::string("\x10\x06\0\0", 4) + interlace) +
           chunk("IDAT", "x");
  };
  const std::string huge = "\x7F\xFF\xFF\xFF", one("\0\0\0\1", 4), zero(4, '\0');
  for (const char interlace : {'\0', '\1'})
    for (const auto& [width, height] : {std::pair{huge, huge}, {one, huge}, {huge, one}})
      CHECK_THAT(result(header(width, height, interlace), ~std::uint64_t{0}),
                 Catch::Matchers::StartsWith("unreadable: the header promises ") ||
                     Catch::Matchers::StartsWith("unreadable: the PNG file cannot be decoded: "));
  CHECK(result(header(one, huge, 0)) ==
        "unreadable: the header promises 1 x 2147483647 pixels, more than 46 bytes can hold");
  CHECK_THAT(result(header(zero, one, 0)),
             Catch::Matchers::StartsWith("unreadable: the PNG file cannot be decoded: "));
  // A file that is whole, and larger than allowed.
  for (const bool interlaced : {false, true}) {
    const std::string good = png_bytes({1000, 100, 8, PNG_COLOR_TYPE_GRAY, interlaced, {}, false},
                                       [](auto, auto, auto) { return 0u; });
    const std::uint64_t needed = interlaced ? 500000 : 400000;
    CHECK(result(good, needed) == "100000 values");
    CHECK(result(good, needed - 1) == "unreadable: 1000 x 100 pixels need more memory than the " +
                                          std::to_string(needed - 1) + " bytes allowed");
  }
}

TEST_CASE("read_gray_png: a changed byte gives a picture or an error") {
  for (const int type : {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_PALETTE}) {
    const std::string good =
        png_bytes({7, 5, 8, type, true,
                   type == PNG_COLOR_TYPE_PALETTE ? std::vector<png_color>{{1, 2, 3}, {4, 5, 6}}
                                                  : std::vector<png_color>{},
                   true},
                  [](auto x, auto, auto) { return unsigned(x % 2); });
    for (std::size_t at = 0; at < good.size(); ++at)
      for (const int bit : {1, 16, 128}) {
        std::string changed = good;
        changed[at] = static_cast<char>(changed[at] ^ bit);
        const std::string said = result(changed);
        if (said != "35 values" && said.find("unreadable: ") != 0) FAIL("byte " << at << ": " << said);
      }
  }
}
