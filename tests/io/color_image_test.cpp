// PNG and JPEG files as colors: every kind, and what is not decoded.
#include "io/image/color_image.h"

#include <cmath>
#include <cstdlib>

#include "kernels/core/status.h"
#include "support/catch.h"
#include "support/image_files.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::ContainsSubstring;

namespace {

ColorImage decoded(const std::string& bytes) { return decode_color_image(std::as_bytes(std::span(bytes))); }

ImageMemory memory_of(const std::string& bytes) { return memory_of_image(std::as_bytes(std::span(bytes))); }

// A smooth picture, which JPEG keeps within a few.
TestImage ramp(std::uint32_t width, std::uint32_t height) {
  return {width, height, [](std::uint32_t x, std::uint32_t y) {
            return std::vector<int>{static_cast<int>(40 + 3 * x), static_cast<int>(200 - 2 * y),
                                    static_cast<int>(60 + x + y)};
          }};
}

int most_difference(const ColorImage& image, const std::vector<std::uint8_t>& rgb) {
  REQUIRE(image.rgb.size() == rgb.size());
  int most = 0;
  for (std::size_t k = 0; k < rgb.size(); ++k) most = std::max(most, std::abs(image.rgb[k] - rgb[k]));
  return most;
}

struct PngKind {
  int depth, type;
  bool interlaced;
};

// A picture of 13 x 9 whose channels are known.
std::string png_of_kind(const PngKind& kind,
                        const std::function<unsigned(std::size_t, std::size_t, std::size_t)>& value) {
  PngPicture picture{13, 9, kind.depth, kind.type, kind.interlaced, {}, false};
  if (kind.type == PNG_COLOR_TYPE_PALETTE) {
    picture.palette = {{10, 20, 30}, {255, 0, 0}, {0, 200, 0}, {7, 7, 250}};
    picture.transparent = true;
  }
  return png_bytes(picture, value);
}

}  // namespace

TEST_CASE("color_image: PNG of every color type, interlaced or not, without its alpha") {
  for (const bool interlaced : {false, true}) {
    const auto pixel = [](const ColorImage& image, unsigned x, unsigned y) {
      const std::size_t at = 3 * (y * 13 + x);
      return std::vector<int>{image.rgb.at(at), image.rgb.at(at + 1), image.rgb.at(at + 2)};
    };
    const ColorImage rgba =
        decoded(png_of_kind({8, PNG_COLOR_TYPE_RGB_ALPHA, interlaced},
                            [](unsigned x, unsigned y, unsigned c) { return 17 * x + y + 3 * c; }));
    CHECK(rgba.problem.empty());
    CHECK((rgba.width == 13 && rgba.height == 9));
    CHECK(pixel(rgba, 5, 7) == std::vector<int>{92, 95, 98});
    const ColorImage wide =
        decoded(png_of_kind({16, PNG_COLOR_TYPE_RGB, interlaced},
                            [](unsigned x, unsigned, unsigned c) { return 257 * (x + c) + 100; }));
    CHECK(pixel(wide, 4, 0) == std::vector<int>{4, 5, 6});
    const ColorImage gray =
        decoded(png_of_kind({8, PNG_COLOR_TYPE_GRAY_ALPHA, interlaced},
                            [](unsigned x, unsigned, unsigned c) { return c == 0 ? 9 * x : 3u; }));
    CHECK(pixel(gray, 12, 8) == std::vector<int>{108, 108, 108});
    const ColorImage bits = decoded(png_of_kind(
        {1, PNG_COLOR_TYPE_GRAY, interlaced}, [](unsigned x, unsigned y, unsigned) { return (x + y) % 2; }));
    CHECK(pixel(bits, 2, 1) == std::vector<int>{255, 255, 255});
    CHECK(pixel(bits, 2, 2) == std::vector<int>{0, 0, 0});
    const ColorImage palette = decoded(png_of_kind({2, PNG_COLOR_TYPE_PALETTE, interlaced},
                                                   [](unsigned x, unsigned, unsigned) { return x % 4; }));
    CHECK(pixel(palette, 0, 0) == std::vector<int>{10, 20, 30});
    CHECK(pixel(palette, 7, 3) == std::vector<int>{7, 7, 250});
  }
}

TEST_CASE("color_image: JPEG in color, gray and CMYK, baseline and progressive") {
  const TestImage image = ramp(50, 37);
  for (const bool progressive : {false, true}) {
    const ColorImage read = decoded(jpeg_bytes(image, {progressive, false, false}));
    INFO(read.problem);
    CHECK((read.width == 50 && read.height == 37));
    CHECK(most_difference(read, image.rgb) <= 3);
    const ColorImage gray = decoded(jpeg_bytes(image, {progressive, true, false}));
    REQUIRE(gray.rgb.size() == image.rgb.size());
    for (std::size_t p = 0; p < gray.rgb.size(); p += 3) {
      CHECK(std::abs(gray.rgb[p] - image.rgb[p]) <= 2);
      CHECK((gray.rgb[p] == gray.rgb[p + 1] && gray.rgb[p] == gray.rgb[p + 2]));
    }
    // Adobe's inks: 255 is none, so that the three channels are the light that is left.
    CHECK(most_difference(decoded(jpeg_bytes(image, {progressive, false, true})), image.rgb) <= 3);
  }
}

TEST_CASE("color_image: a damaged, oversized or foreign image has no pixels and a reason") {
  const std::string png = png_bytes(ramp(64, 64)), jpeg = jpeg_bytes(ramp(64, 64)),
                    progressive = jpeg_bytes(ramp(64, 64), {true, false, false});
  for (const std::string& whole : {png, jpeg, progressive})
    for (const double share : {0.0, 0.001, 0.01, 0.1, 0.5, 0.9, 0.97}) {
      const auto bytes = static_cast<std::size_t>(share * static_cast<double>(whole.size()));
      const ColorImage image = decoded(whole.substr(0, bytes));
      INFO(bytes << " of " << whole.size());
      CHECK(image.is_lost());
      CHECK_FALSE(image.problem.empty());
      CHECK((image.loss == Note::image_unreadable || bytes < 8));
    }
  CHECK_THAT(decoded("GIF00a").problem, ContainsSubstring("neither"));

  std::string damaged = png;
  damaged[damaged.size() / 2] = static_cast<char>(damaged[damaged.size() / 2] ^ 0x55);
  CHECK(decoded(damaged).is_lost());

  // Headers that promise much: beyond the limit, and within it but more than the bytes can hold.
  const auto with_size = [](std::string bytes, std::size_t at, std::size_t words, std::uint32_t width,
                            std::uint32_t height) {
    for (std::size_t k = 0; k < words; ++k) {
      bytes[at + k] = static_cast<char>(height >> (8 * (words - 1 - k)));
      bytes[at + words + k] = static_cast<char>(width >> (8 * (words - 1 - k)));
    }
    return bytes;
  };
  const std::size_t frame = jpeg.find("\xFF\xC0");
  REQUIRE(frame != std::string::npos);
  const std::string large_jpeg = with_size(jpeg, frame + 5, 2, 9000, 9000);
  CHECK_THAT(decoded(large_jpeg).problem,
             ContainsSubstring("9000 x 9000") && ContainsSubstring(std::to_string(most_image_pixels)));
  CHECK(decoded(large_jpeg).loss == Note::image_too_large);
  CHECK(memory_of(large_jpeg).kept_bytes == 0);
  for (const std::uint32_t size : {20000u, 8192u}) {
    const std::string large_png = with_size(png, 16, 4, size, size);
    CHECK(decoded(large_png).is_lost());  // its checksum is wrong as well
    CHECK(memory_of(large_png).kept_bytes == 0);
  }
}

TEST_CASE("color_image: memory is known from the header") {
  CHECK(memory_of(png_bytes(ramp(64, 32))).kept_bytes == 64 * 32 * 3);
  const ImageMemory plain = memory_of(jpeg_bytes(ramp(64, 32))),
                    progressive = memory_of(jpeg_bytes(ramp(64, 32), {true, false, false}));
  CHECK(plain.kept_bytes == 64 * 32 * 3);
  CHECK(progressive.working_bytes >= plain.working_bytes + 64 * 32 * 6);
  CHECK(memory_of("no image").kept_bytes == 0);
}

TEST_CASE("color_image: cancellation stops the decoder and does not count as a lost image") {
  const std::atomic<bool> canceled{true};
  CancelToken token;
  token.canceled = &canceled;
  for (const std::string& bytes :
       {png_bytes(ramp(64, 64)), jpeg_bytes(ramp(64, 64)), jpeg_bytes(ramp(64, 64), {true, false, false})})
    CHECK_THROWS_AS(decode_color_image(std::as_bytes(std::span(bytes)), token), RunCanceled);
}
