// WebP, GIF, BMP and TGA files as colors: every kind, what is not decoded and why, and the memory that it
// takes. The pixels are those that the files were made of, and those of stb_image where that reads the kind.
#include <stb/stb_image.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>

#include "io/image/color_image.h"
#include "kernels/core/status.h"
#include "support/allocation_counter.h"
#include "support/catch.h"
#include "support/image_encoders.h"

using namespace meander;
using namespace meander::test;
using namespace std::string_literals;
using Catch::Matchers::ContainsSubstring;

namespace {

std::span<const std::byte> bytes_of(const std::string& bytes) { return std::as_bytes(std::span(bytes)); }

ColorImage decoded(const std::string& bytes) { return decode_color_image(bytes_of(bytes)); }

ImageMemory memory_of(const std::string& bytes) { return memory_of_image(bytes_of(bytes)); }

// Without symmetry, in few colors.
TestImage tiles(std::uint32_t width, std::uint32_t height, std::uint32_t colors = 14) {
  return {width, height, [=](std::uint32_t x, std::uint32_t y) {
            const std::uint32_t number = ((x / 3) * 7 + (y / 2) * 5 + x * y / 11) % colors;
            return std::vector<int>{static_cast<int>(number * 37 % 256), static_cast<int>(255 - number),
                                    static_cast<int>(number * number % 256)};
          }};
}

TestImage smooth(std::uint32_t width, std::uint32_t height) {
  return {width, height, [](std::uint32_t x, std::uint32_t y) {
            return std::vector<int>{static_cast<int>((x + y / 2) % 256), static_cast<int>((3 * y + x) % 256),
                                    static_cast<int>(60 + (x + y) % 100)};
          }};
}

int most_difference(const std::vector<std::uint8_t>& a, const std::uint8_t* b) {
  int most = 0;
  for (std::size_t k = 0; k < a.size(); ++k) most = std::max(most, std::abs(a[k] - b[k]));
  return most;
}

// stb's pixels differ by no more than `most`.
void check_with_stb(const std::string& bytes, const ColorImage& image, int most = 0) {
  int width = 0, height = 0, channels = 0;
  stbi_uc* const pixels =
      stbi_load_from_memory(reinterpret_cast<const stbi_uc*>(bytes.data()), static_cast<int>(bytes.size()),
                            &width, &height, &channels, 3);
  REQUIRE(pixels != nullptr);
  CHECK((image.width == static_cast<std::uint32_t>(width) &&
         image.height == static_cast<std::uint32_t>(height)));
  if (3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height) == image.rgb.size())
    CHECK(most_difference(image.rgb, pixels) <= most);
  stbi_image_free(pixels);
}

void check_pixels(const std::string& bytes, const TestImage& image) {
  const ColorImage read = decoded(bytes);
  INFO(read.problem);
  CHECK(read.problem.empty());
  CHECK((read.width == image.width && read.height == image.height));
  CHECK((read.rgb == image.rgb));  // thousands of numbers, not to be printed
  CHECK(memory_of(bytes).kept_bytes == image.rgb.size());
}

// The same, of channels with fewer bits.
TestImage in_bits(const TestImage& image, const std::array<unsigned, 3>& bits) {
  TestImage fewer = image;
  for (std::size_t k = 0; k < fewer.rgb.size(); ++k) {
    const double most = (1u << bits[k % 3]) - 1;
    fewer.rgb[k] = static_cast<std::uint8_t>((fewer.rgb[k] >> (8 - bits[k % 3])) * 255.0 / most + 0.5);
  }
  return fewer;
}

void check_lost(const ColorImage& image, Note loss, const std::string& part) {
  CHECK(image.is_lost());
  CHECK(image.rgb.empty());
  CHECK(image.loss == loss);
  CHECK_THAT(image.problem, ContainsSubstring(part));
}

std::string with_number(std::string bytes, std::size_t at, std::size_t size, std::uint32_t value) {
  for (std::size_t k = 0; k < size; ++k) bytes.at(at + k) = static_cast<char>(value >> (8 * k));
  return bytes;
}

std::string chunk(const std::string& name, const std::string& content) {
  std::string bytes = name;
  append_number(bytes, static_cast<std::uint32_t>(content.size()), 4);
  return bytes + content + (content.size() % 2 == 1 ? "\0"s : ""s);
}

std::string riff(const std::string& chunks) { return chunk("RIFF", "WEBP" + chunks); }

// An animation of pictures that are whole files by themselves, each at (2, 4) in 40 x 30 pixels of a color.
std::string animation(const std::vector<std::string>& files, std::uint32_t columns, std::uint32_t rows) {
  std::string canvas("\x02\0\0\0", 4), options("\x0A\x14\x1E\xFF\0\0", 6), frames;
  append_number(canvas, 39, 3);
  append_number(canvas, 29, 3);
  for (const std::string& file : files) {
    std::string frame;
    for (const std::uint32_t number : {1u, 2u, columns - 1, rows - 1, 100u}) append_number(frame, number, 3);
    frames += chunk("ANMF", frame + '\0' + file.substr(12));
  }
  return riff(chunk("VP8X", canvas) + chunk("ANIM", options) + frames);
}

// The bits of a lossless WebP stream, the lowest first.
class LosslessBits {
 public:
  void put(std::uint32_t value, unsigned count) {
    for (unsigned k = 0; k < count; ++k) {
      if (used_ % 8 == 0) bytes_ += '\0';
      bytes_.back() = static_cast<char>(bytes_.back() | (value >> k & 1) << used_++ % 8);
    }
  }
  // A byte by a code of eight bits for each.
  void put_reversed(std::uint32_t byte) {
    for (unsigned k = 8; k-- > 0;) put(byte >> k & 1, 1);
  }
  // The symbol 0 alone, which takes no bits.
  void put_code_of_zero() { put(1, 4); }
  // Eight bits for each of the first 256 symbols, none for others.
  void put_code_of_bytes(std::uint32_t symbols) {
    put(0, 1);
    put(19 - 4 - 7, 4);  // lengths of the lengths 17 18 0 1 2 3 4 5 16 6 7 8: one bit for 8 and 18
    for (const std::uint32_t length : {0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}) put(length, 3);
    put(0, 1);
    for (int k = 0; k < 256; ++k) put(0, 1);
    if (symbols == 256) return;
    put(1, 1);
    put(symbols - 256 - 11, 7);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  unsigned used_ = 0;
};

struct NamedFile {
  std::string name, bytes;
};

// Small files of every new format and kind.
std::vector<NamedFile> all_kinds() {
  const TestImage image = tiles(21, 13), two = tiles(13, 5, 2);
  std::vector<NamedFile> files = {
      {"bmp, 1 bit", bmp_bytes(two, {1})},
      {"bmp, 4 bits", bmp_bytes(image, {4})},
      {"bmp, 8 bits", bmp_bytes(image, {8})},
      {"bmp, 16 bits", bmp_bytes(image, {16})},
      {"bmp, 24 bits", bmp_bytes(image, {24})},
      {"bmp, 32 bits", bmp_bytes(image, {32, true})},
      {"bmp, masks", bmp_bytes(image, {16, false, false, 40, {0xF800, 0x07E0, 0x001F}})},
      {"bmp, runs of 8 bits", bmp_bytes(image, {8, false, true})},
      {"bmp, runs of 4 bits", bmp_bytes(image, {4, false, true})},
      {"bmp, short header", bmp_bytes(image, {8, false, false, 12})},
      {"gif", gif_bytes(image)},
      {"gif, interlaced", gif_bytes(image, {true, true, true})},
      {"gif, smaller", gif_bytes(image, {false, false, false, 40, 30, 2, 4, 1, 2})},
      {"webp, lossless", webp_bytes(image)},
      {"webp, lossy", webp_bytes(image, {80, false})},
      {"webp, lossy with alpha", webp_bytes(image, {80, false, true})},
      {"webp, animation", animation({webp_bytes(image), webp_bytes(image)}, 21, 13)}};
  for (const bool runs : {false, true}) {
    const std::string kind = runs ? "tga, runs, " : "tga, ";
    TgaKind palette{8, true, false, runs}, gray{8, false, true, runs};
    files.push_back({kind + "palette", tga_bytes(image, palette)});
    files.push_back({kind + "gray", tga_bytes(image, gray)});
    for (const unsigned bits : {16u, 24u, 32u}) {
      TgaKind colors;
      colors.bits = bits;
      colors.runs = runs;
      files.push_back({kind + std::to_string(bits) + " bits", tga_bytes(image, colors)});
    }
  }
  return files;
}

}  // namespace

TEST_CASE("image formats: BMP of every bit depth, bottom-up and top-down, decodes to its pixels") {
  for (const bool top_down : {false, true})
    for (const std::uint32_t width : {1u, 2u, 3u, 5u, 7u, 8u, 9u, 31u, 33u}) {
      CAPTURE(top_down, width);
      const TestImage few = tiles(width, 11, 2), some = tiles(width, 11), many = smooth(width, 11);
      for (const auto& [bits, image] :
           {std::pair{1u, few}, {2u, few}, {4u, some}, {8u, some}, {24u, many}, {32u, many}}) {
        CAPTURE(bits);
        const std::string bytes = bmp_bytes(image, {bits, top_down});
        check_pixels(bytes, image);
        if (bits != 2) check_with_stb(bytes, decoded(bytes));
      }
      const std::string sixteen = bmp_bytes(many, {16, top_down});
      check_pixels(sixteen, in_bits(many, {5, 5, 5}));
      check_with_stb(sixteen, decoded(sixteen), 1);
    }
}

TEST_CASE("image formats: BMP with bit masks, RLE and other header lengths decodes to its pixels") {
  const TestImage many = smooth(23, 9), some = tiles(41, 17);
  check_pixels(bmp_bytes(many, {16, false, false, 40, {0xF800, 0x07E0, 0x001F}}), in_bits(many, {5, 6, 5}));
  check_pixels(bmp_bytes(many, {16, true, false, 40, {0x000F, 0x00F0, 0x0F00}}), in_bits(many, {4, 4, 4}));
  check_pixels(bmp_bytes(many, {32, false, false, 40, {0xFF, 0xFF00, 0xFF0000}}), many);
  check_pixels(bmp_bytes(many, {32, false, false, 108, {0xFF000000, 0xFF0000, 0xFF00}}), many);
  for (const std::uint32_t header : {12u, 40u, 52u, 56u, 64u, 108u, 124u}) {
    CAPTURE(header);
    check_pixels(bmp_bytes(many, {24, false, false, header}), many);
    check_pixels(bmp_bytes(some, {8, false, false, header}), some);
    if (header != 12) check_pixels(bmp_bytes(some, {4, header != 40, false, header}), some);
  }
  for (const unsigned bits : {4u, 8u})
    for (const std::uint32_t width : {1u, 2u, 3u, 4u, 5u, 6u, 41u, 300u, 601u}) {
      CAPTURE(bits, width);
      const TestImage image = tiles(width, 9), plain = tiles(width, 3, 1);
      check_pixels(bmp_bytes(image, {bits, false, true}), image);
      check_pixels(bmp_bytes(plain, {bits, false, true}), plain);
    }
}

TEST_CASE("image formats: BMP RLE may skip pixels, and needs no end marker") {
  const TestImage image = tiles(6, 4);
  std::string bytes = bmp_bytes(image, {8, false, true});
  const auto pixels_at = static_cast<std::uint8_t>(bytes[10]);
  const std::uint8_t* const first = image.rgb.data();  // number 0 is the first color from above
  // Two pixels of number 1, on from there by two and one up, one pixel of number 2, the end.
  const std::string runs("\2\1\0\2\2\1\1\2\0\1", 10);
  const ColorImage read = decoded(bytes.substr(0, pixels_at) + runs);
  REQUIRE(read.rgb.size() == image.rgb.size());
  const ImagePalette palette(image);
  const auto at = [&](std::size_t x, std::size_t y) {
    const std::uint8_t* const pixel = read.rgb.data() + 3 * (y * 6 + x);
    return ImageColor{pixel[0], pixel[1], pixel[2]};
  };
  CHECK(at(1, 3) == palette.colors[1]);
  CHECK(at(4, 2) == palette.colors[2]);
  CHECK(at(5, 3) == ImageColor{first[0], first[1], first[2]});

  bytes.resize(bytes.size() - 2);  // neither of the picture
  check_pixels(bytes, image);
  bytes.resize(bytes.size() - 2);  // nor of its last row
  check_pixels(bytes, image);
  check_lost(decoded(bytes.substr(0, bytes.size() - 1)), Note::image_unreadable, "ends too early");
  check_lost(decoded(bytes.substr(0, pixels_at) + "\7\1\0\1"s), Note::image_unreadable, "beyond");
  check_lost(decoded(bytes.substr(0, pixels_at) + "\0\2\7\0\0\1"s), Note::image_unreadable, "beyond");
}

TEST_CASE("image formats: TGA of every type, depth and origin decodes to its pixels") {
  const TestImage image = tiles(37, 19), gray(37, 19, [](std::uint32_t x, std::uint32_t y) {
    const int value = static_cast<int>((5 * x + 11 * y) % 256);
    return std::vector<int>{value, value, value};
  });
  const TestImage five = in_bits(image, {5, 5, 5});
  for (const bool runs : {false, true})
    for (const bool top_down : {false, true})
      for (const bool from_right : {false, true})
        for (const bool footer : {false, true}) {
          CAPTURE(runs, top_down, from_right, footer);
          TgaKind kind;
          kind.runs = runs;
          kind.top_down = top_down;
          kind.from_right = from_right;
          kind.footer = footer;
          const auto check = [&](const TestImage& source, const TestImage& expected) {
            const std::string bytes = tga_bytes(source, kind);
            CAPTURE(kind.bits, kind.palette, kind.gray);
            check_pixels(bytes, expected);
            // stb takes mirrored files as they are stored, and skips bytes for colors that are left out.
            if (!from_right && kind.first_color == 0 && !(kind.palette && kind.bits == 16))
              check_with_stb(bytes, decoded(bytes), 1);
          };
          for (const unsigned bits : {24u, 32u}) {
            kind.bits = bits;
            check(image, image);
          }
          kind.bits = 16;
          check(image, five);
          kind.bits = 8;
          kind.gray = true;
          check(gray, gray);
          kind.gray = false;
          kind.palette = true;
          for (const unsigned bits : {8u, 16u})
            for (const std::uint32_t first : {0u, 100u})
              for (const unsigned palette_bits : {16u, 24u, 32u}) {
                kind.bits = bits;
                kind.first_color = first;
                kind.palette_bits = palette_bits;
                check(image, palette_bits == 16 ? five : image);
              }
        }
}

TEST_CASE("image formats: TGA packets may cross rows, and 15-bit depth is read") {
  const TestImage plain = tiles(5, 8, 1);  // 40 pixels of one color
  const std::string bytes = tga_bytes(plain);
  const std::string whole = with_number(bytes.substr(0, 21), 2, 1, 10) + "\xA7"s + bytes.substr(21, 3);
  check_pixels(whole, plain);
  TgaKind kind;
  kind.bits = 16;
  check_pixels(with_number(tga_bytes(tiles(9, 9), kind), 16, 1, 15), in_bits(tiles(9, 9), {5, 5, 5}));
}

TEST_CASE("image formats: GIF, interlaced, with a local palette or transparent, decodes to its pixels") {
  for (const bool interlaced : {false, true})
    for (const bool local : {false, true})
      for (const bool transparent : {false, true})
        for (const auto& [width, height] : {std::pair{1u, 1u}, {3u, 2u}, {40u, 3u}, {7u, 9u}, {90u, 70u}})
          for (const std::uint32_t colors : {1u, 2u, 14u, 200u}) {
            CAPTURE(interlaced, local, transparent, width, height, colors);
            const TestImage image = tiles(width, height, colors);
            const std::string bytes = gif_bytes(image, {interlaced, local, transparent});
            check_pixels(bytes, image);
            // stb makes transparent pixels black.
            if (!transparent) check_with_stb(bytes, decoded(bytes));
          }
  // More codes than there is room for: the table is begun again.
  const TestImage large(300, 200, [](std::uint32_t x, std::uint32_t y) {
    const std::uint32_t value = (x * 2654435761u ^ y * 40503u) >> 9 & 127;
    return std::vector<int>{static_cast<int>(value), 3, static_cast<int>(2 * value)};
  });
  check_pixels(gif_bytes(large), large);
}

TEST_CASE("image formats: GIF and WebP animations give their first frame over the background color") {
  const TestImage image = tiles(21, 13);
  const std::string gif = gif_bytes(image, {true, false, false, 40, 30, 2, 4, 3, 5}),
                    webp = animation({webp_bytes(image), webp_bytes(smooth(21, 13))}, 21, 13);
  const ImageColor gif_background = ImagePalette(image).colors[3];
  const std::array<NamedFile, 2> files = {{{"gif", gif}, {"webp", webp}}};
  for (const NamedFile& file : files) {
    CAPTURE(file.name);
    const ImageColor background = file.name == "gif" ? gif_background : ImageColor{0x1E, 0x14, 0x0A};
    const TestImage whole(40, 30, [&](std::uint32_t x, std::uint32_t y) {
      const bool inside = x >= 2 && y >= 4 && x < 23 && y < 17;
      const ImageColor color = inside ? color_at(image, x - 2, y - 4) : background;
      return std::vector<int>{color[0], color[1], color[2]};
    });
    check_pixels(file.bytes, whole);
  }
  check_lost(decoded(gif_bytes(image, {false, false, false, 22, 30, 2, 4})), Note::image_unreadable, "edges");
  check_lost(decoded(animation({webp_bytes(smooth(39, 13))}, 39, 13)), Note::image_unreadable, "edges");
  // A whole without a size has that of its picture.
  check_pixels(with_number(gif_bytes(image), 6, 4, 0), image);
}

TEST_CASE("image formats: WebP, lossless, lossy and with alpha, decodes to its pixels") {
  for (const TestImage& image : {smooth(61, 47), tiles(61, 47), tiles(200, 130, 200), tiles(64, 64, 2),
                                 tiles(1, 1, 1), smooth(700, 500)})
    for (const bool alpha : {false, true}) {
      CAPTURE(image.width, image.height, alpha);
      for (const int method : {0, 3, 6}) check_pixels(webp_bytes(image, {75, true, alpha, method}), image);
    }
  const TestImage image(120, 90, [](std::uint32_t x, std::uint32_t y) {
    return std::vector<int>{static_cast<int>(x), static_cast<int>(2 * y), 90};
  });
  for (const bool alpha : {false, true})
    for (const float quality : {60.0f, 100.0f}) {
      const ColorImage read = decoded(webp_bytes(image, {quality, false, alpha}));
      INFO(read.problem);
      REQUIRE(read.rgb.size() == image.rgb.size());
      CHECK(most_difference(read.rgb, image.rgb.data()) <= 12);
    }
  // Other chunks, in front of the pixels and behind them.
  const std::string pixels = webp_bytes(image).substr(12);
  std::string canvas(4, '\0');
  append_number(canvas, 119, 3);
  append_number(canvas, 89, 3);
  check_pixels(riff(chunk("VP8X", canvas) + chunk("ICCP", "odd") + pixels + chunk("EXIF", "what")) + "rest",
               image);
  check_lost(decoded(riff(chunk("VP8X", with_number(canvas, 4, 1, 8)) + pixels)), Note::image_unreadable,
             "size");
}

TEST_CASE("image formats: an image is recognized by its content") {
  // decode_color_image knows no names; nor does a file end where its content does.
  const TestImage image = tiles(21, 13);
  for (const std::string& bytes : {webp_bytes(image), gif_bytes(image), bmp_bytes(image), tga_bytes(image)})
    check_pixels(bytes + "and more"s, image);
}

TEST_CASE("image formats: files cut at any byte give the whole image or a reason, never a wrong pixel") {
  for (const NamedFile& file : all_kinds()) {
    CAPTURE(file.name);
    const ColorImage whole = decoded(file.bytes);
    INFO(whole.problem);
    REQUIRE(whole.problem.empty());
    std::size_t images = 0;
    for (std::size_t size = 0; size < file.bytes.size(); ++size) {
      const std::string cut = file.bytes.substr(0, size);
      const ColorImage image = decoded(cut);
      CAPTURE(size);
      if (image.problem.empty()) {
        ++images;
        REQUIRE((image.rgb == whole.rgb));
        REQUIRE(memory_of(cut).kept_bytes == whole.rgb.size());
      } else {
        REQUIRE(image.is_lost());
        REQUIRE((image.loss == Note::image_unreadable || image.loss == Note::image_unsupported));
      }
    }
    // Marks at the end, the padding of a last row and later pictures of a GIF can be missed.
    CHECK(images <= (file.name == "gif, smaller" ? file.bytes.size() / 2 : 5));
  }
}

TEST_CASE("image formats: damaged files give pixels or a reason") {
  for (const NamedFile& file : all_kinds())
    for (std::size_t at = 0; at < file.bytes.size(); ++at)
      for (const int change : {0x01, 0x80, 0xFF}) {
        std::string damaged = file.bytes;
        damaged[at] = static_cast<char>(damaged[at] ^ change);
        // Sizes of up to 65535 x 65535 are among them: what a small budget refuses.
        const ImageMemory memory = memory_of(damaged);
        if (memory.kept_bytes > 1 << 20) continue;
        const ColorImage image = decoded(damaged);
        CAPTURE(file.name, at, change, image.problem);
        REQUIRE(image.problem.empty() != image.is_lost());
        REQUIRE(image.rgb.size() == std::size_t{3} * image.width * image.height);
        REQUIRE(image.rgb.size() == (image.is_lost() ? 0 : memory.kept_bytes));
      }
}

TEST_CASE("image formats: zero and oversized dimensions are refused before memory is allocated") {
  const TestImage image = tiles(21, 13);
  const std::string bmp = bmp_bytes(image), tga = tga_bytes(image), gif = gif_bytes(image),
                    runs = bmp_bytes(image, {8, false, true});
  TgaKind tga_runs;
  tga_runs.runs = true;
  const std::string packed = tga_bytes(image, tga_runs), lossless = webp_bytes(image),
                    lossy = webp_bytes(image, {80, false});
  const std::uint32_t large = 16000, most = 8192;
  const auto sized = [](const std::string& bytes, std::size_t at, std::size_t size, std::uint32_t width,
                        std::uint32_t height) {
    return with_number(with_number(bytes, at, size, width), at + size, size, height);
  };
  for (const std::string& bytes :
       {sized(bmp, 18, 4, large, large), sized(runs, 18, 4, 0x7FFFFFFF, 0x7FFFFFFF),
        sized(bmp, 18, 4, large, 0x80000000), sized(tga, 12, 2, large, large),
        sized(packed, 12, 2, 65535, 65535), sized(gif, 6, 2, 65535, 65535),
        with_number(lossless, 21, 4, 0x0FFFFFFF), sized(lossy, 26, 2, large, large)}) {
    check_lost(decoded(bytes), Note::image_too_large, "more than the " + std::to_string(most_image_pixels));
    CHECK(memory_of(bytes).kept_bytes == 0);
  }
  // Within the bound, and more than the bytes can hold.
  for (const std::string& bytes :
       {sized(bmp, 18, 4, most, most), sized(tga, 12, 2, most, most), sized(packed, 12, 2, most, most)}) {
    check_lost(decoded(bytes), Note::image_unreadable, "ends too early");
    CHECK(memory_of(bytes).kept_bytes == 0);
  }
  const std::size_t frame = gif.find('\x2C') + 5;
  check_lost(decoded(sized(sized(gif, 6, 2, most, most), frame, 2, most, most)), Note::image_unreadable,
             "ends too early");
  for (const std::string& bytes : {sized(bmp, 18, 4, 0, 13), sized(bmp, 18, 4, 21, 0),
                                   sized(gif, frame, 2, 21, 0), sized(lossy, 26, 2, 0, 13)})
    check_lost(decoded(bytes), Note::image_unreadable, "are none");
  check_lost(decoded(with_number(bmp, 18, 4, 0xFFFFFFFF)), Note::image_unreadable, "negative");
}

TEST_CASE("image formats: palette indices out of range and unknown header values are named") {
  const TestImage image = tiles(21, 13);
  const std::string bmp = bmp_bytes(image, {8});
  check_lost(decoded(with_number(bmp, 46, 4, 3)), Note::image_unreadable, "palette does not have");
  std::string gif = gif_bytes(tiles(8, 8, 3));  // of four colors in the palette
  gif[10] = static_cast<char>(0x80);            // two; the rest of the palette is taken for a block
  check_lost(decoded(gif), Note::image_unreadable, "GIF file");
  TgaKind palette;
  palette.bits = 8;
  palette.palette = true;
  palette.first_color = 5;
  check_lost(decoded(with_number(tga_bytes(image, palette), 3, 2, 9)), Note::image_unreadable,
             "palette does not have");
  check_lost(decoded(with_number(bmp, 30, 4, 4)), Note::image_unsupported, "compression 4");
  check_lost(decoded(with_number(bmp, 14, 4, 41)), Note::image_unreadable, "header of 41 bytes");
  check_lost(decoded(with_number(bmp, 28, 2, 7)), Note::image_unreadable, "7 bits");
  check_lost(decoded(with_number(bmp, 10, 4, 20)), Note::image_unreadable, "within its header");
  check_lost(decoded(with_number(bmp_bytes(image, {16, false, false, 40, {1, 2, 4}}), 54, 4, 5)),
             Note::image_unreadable, "side by side");
}

TEST_CASE("image formats: unsupported formats are named") {
  const auto boxes = [](const std::string& kinds) {
    return "\0\0\0\x1C"s + "ftyp" + kinds + std::string(60, 'x');
  };
  const std::string rest(200, '\0');
  for (const auto& [bytes, name] : {std::pair{"\xABKTX 20\xBB\r\n\x1A\n"s, "KTX2"s},
                                    {"\xABKTX 11\xBB\r\n\x1A\n"s, "KTX"s},
                                    {"DDS |"s, "DDS"s},
                                    {boxes("avif\0\0\0\0avifmif1miaf"s), "AVIF"s},
                                    {boxes("mif1\0\0\0\0mif1avifmiaf"s), "AVIF"s},
                                    {boxes("heic\0\0\0\0mif1heic"s), "HEIC"s},
                                    {boxes("mif1\0\0\0\0mif1heic"s), "HEIC"s},
                                    {"II*\0"s, "TIFF"s},
                                    {"MM\0*"s, "TIFF"s},
                                    {"8BPS\0\1"s, "PSD"s},
                                    {"v/1\1\2"s, "EXR"s},
                                    {"#?RADIANCE\n"s, "HDR"s},
                                    {"\x0A\5\1\x08"s, "PCX"s},
                                    {"<?xml version=\"1.0\"?>\n<!-- a -->\n<svg width=\"3\">"s, "SVG"s},
                                    {"\xEF\xBB\xBF <SVG>"s, "SVG"s},
                                    {"P6\n3 3\n255\n"s, "Netpbm"s},
                                    {"version https://git-lfs.github.com/spec/v1\n"s, "Git LFS"s},
                                    {"<!DOCTYPE html><html>"s, "HTML"s}}) {
    CAPTURE(name);
    check_lost(decoded(bytes + rest), Note::image_unsupported, name);
    CHECK(memory_of(bytes + rest).kept_bytes == 0);
  }
  check_lost(decoded("what is no image at all"), Note::image_unsupported, "neither");
  check_lost(decoded(""), Note::image_unreadable, "empty");
}

TEST_CASE("image formats: damaged files of other formats are not taken for TGA") {
  const TestImage image = tiles(40, 30);
  std::vector<std::string> files = {png_bytes(image), jpeg_bytes(image)};
  for (const NamedFile& file : all_kinds())
    if (!file.name.starts_with("tga")) files.push_back(file.bytes);
  const auto check = [](const std::string& damaged) {
    REQUIRE_FALSE(decoded(damaged).problem.starts_with("the TGA file"));
  };
  // Numbers that a header of TGA has: one at each place, and two where it says what kind it is.
  const std::vector<char> numbers = {0, 1, 2, 3, 8, 9, 10, 11, 15, 16, 24, 32, 64, '\x80', '\xFF'};
  for (const std::string& file : files)
    for (const char number : numbers) {
      std::string damaged = file;
      for (std::size_t at = 0; at < 8; ++at) {
        damaged = file;
        damaged[at] = number;
        check(damaged);
      }
      damaged = file;
      damaged[1] = number;
      for (const char kind : numbers) {
        damaged[2] = kind;
        check(damaged);
      }
    }
  for (const std::size_t size : {18u, 100u, 5000u})
    for (int value = 0; value < 256; ++value) {
      const ColorImage read = decoded(std::string(size, static_cast<char>(value)));
      CHECK(read.is_lost());
      REQUIRE_FALSE(read.problem.starts_with("the TGA file"));
    }
}

TEST_CASE("image formats: decoding takes no more memory than declared") {
  const TestImage image = smooth(400, 300), few = tiles(400, 300);
  std::vector<NamedFile> files = {{"bmp", bmp_bytes(image)},
                                  {"bmp, runs", bmp_bytes(few, {8, false, true})},
                                  {"gif", gif_bytes(few, {true})},
                                  {"tga", tga_bytes(image)},
                                  {"png", png_bytes(image)},
                                  {"jpeg", jpeg_bytes(image)},
                                  {"jpeg, progressive", jpeg_bytes(image, {true, false, false})},
                                  {"webp, animation", animation({webp_bytes(smooth(30, 20))}, 30, 20)}};
  for (const int method : {0, 4, 6})
    for (const bool alpha : {false, true}) {
      files.push_back(
          {"webp, lossless " + std::to_string(method), webp_bytes(image, {75, true, alpha, method})});
      files.push_back(
          {"webp, of few colors " + std::to_string(method), webp_bytes(few, {75, true, alpha, method})});
      files.push_back(
          {"webp, lossy " + std::to_string(method), webp_bytes(image, {75, false, alpha, method})});
    }
  TgaKind palette;
  palette.palette = palette.runs = true;
  palette.bits = 16;
  files.push_back({"tga, palette", tga_bytes(few, palette)});
  for (const NamedFile& file : files) {
    CAPTURE(file.name);
    std::int64_t before = allocated_bytes();
    reset_peak();
    const ImageMemory memory = memory_of(file.bytes);
    const std::int64_t peeking = peak_allocated_bytes() - before;
    before = allocated_bytes();
    reset_peak();
    const ColorImage read = decoded(file.bytes);
    const std::int64_t taken = peak_allocated_bytes() - before;
    REQUIRE(read.problem.empty());
    CHECK(memory.kept_bytes == read.rgb.size());
    if (!counts_allocations()) continue;
    CHECK(peeking < 1 << 17);
    CHECK(taken >= static_cast<std::int64_t>(memory.kept_bytes));
    CHECK(taken <= static_cast<std::int64_t>(memory.kept_bytes + memory.working_bytes));
    CHECK(memory.working_bytes <= 12 * read.rgb.size() + (1 << 24));
  }
}

TEST_CASE("image formats: WebP with many Huffman groups takes no more memory than declared") {
  struct Codes {
    std::uint32_t tiles_side, groups, cache_bits;
    bool each;  // tile names the group of its number; otherwise all name the last one
  };
  for (const Codes& codes : {Codes{40, 1600, 0, true},
                             {40, 1600, 11, true},
                             {70, 4900, 10, true},
                             {40, 1000, 11, false},
                             {40, 3000, 11, false},
                             {1, 16, 3, false}}) {
    CAPTURE(codes.groups, codes.cache_bits, codes.each);
    const std::uint32_t side = 4 * codes.tiles_side;
    LosslessBits bits;
    bits.put(0x2F, 8);
    bits.put(side - 1, 14);
    bits.put(side - 1, 14);
    bits.put(0, 5);  // no transformation, and then a cache of colors or none
    bits.put(codes.cache_bits == 0 ? 0 : 1, 1);
    if (codes.cache_bits != 0) bits.put(codes.cache_bits, 4);
    bits.put(1, 1);  // groups by tiles of four by four
    bits.put(0, 3);
    bits.put(0, 1);
    for (int code = 0; code < 2; ++code) bits.put_code_of_bytes(code == 0 ? 280 : 256);
    for (int code = 0; code < 3; ++code) bits.put_code_of_zero();
    for (std::uint32_t tile = 0; tile < codes.tiles_side * codes.tiles_side; ++tile) {
      const std::uint32_t group = codes.each ? tile : codes.groups - 1;
      bits.put_reversed(group & 255);
      bits.put_reversed(group >> 8);
    }
    for (std::uint32_t group = 0; group < codes.groups; ++group)
      for (int code = 0; code < 5; ++code) bits.put_code_of_zero();
    bits.put(0, 32);
    const std::string bytes = riff(chunk("VP8L", bits.bytes()));
    const ImageMemory memory = memory_of(bytes);
    const std::int64_t before = allocated_bytes();
    reset_peak();
    const ColorImage read = decoded(bytes);
    const std::int64_t taken = peak_allocated_bytes() - before;
    INFO(read.problem);
    CHECK(read.problem.empty());
    CHECK(read.rgb.size() == std::size_t{3} * side * side);
    CHECK((read.rgb == std::vector<std::uint8_t>(read.rgb.size(), 0)));
    const bool counted = codes.each || codes.groups <= 1000;
    if (!counts_allocations()) continue;
    CHECK(taken <= static_cast<std::int64_t>(memory.kept_bytes + memory.working_bytes));
    if (counted) CHECK(taken >= static_cast<std::int64_t>(codes.groups) * 11800);
  }
}

TEST_CASE("image formats: cancellation stops the decoder and does not count as a lost image") {
  const std::atomic<bool> canceled{true};
  CancelToken token;
  token.canceled = &canceled;
  for (const NamedFile& file : all_kinds()) {
    CAPTURE(file.name);
    CHECK_THROWS_AS(decode_color_image(bytes_of(file.bytes), token), RunCanceled);
  }
}
