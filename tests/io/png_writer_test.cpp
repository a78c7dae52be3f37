#include "io/plot/png_writer.h"

#include <png.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "io/run_error.h"
#include "support/catch.h"
#include "support/mesh_files.h"

using namespace meander;
using meander::test::ScratchFolder;

namespace {

RgbImage gradient(std::uint32_t width, std::uint32_t height) {
  RgbImage image(width, height);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    image.pixels[i] = static_cast<std::uint8_t>(7 * i + i / 97);
  return image;
}

RgbImage decode(const std::vector<std::byte>& bytes) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  REQUIRE(png_image_begin_read_from_memory(&header, bytes.data(), bytes.size()) != 0);
  header.format = PNG_FORMAT_RGB;
  RgbImage image(header.width, header.height);
  REQUIRE(png_image_finish_read(&header, nullptr, image.pixels.data(), 0, nullptr) != 0);
  return image;
}

std::vector<std::byte> file_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<std::byte> bytes;
  for (std::istreambuf_iterator<char> at(file), end; at != end; ++at)
    bytes.push_back(static_cast<std::byte>(*at));
  return bytes;
}

}  // namespace

TEST_CASE("encode_png: pixels survive a round trip") {
  for (const auto& [width, height] : {std::pair{1u, 1u}, std::pair{3u, 200u}, std::pair{257u, 31u}}) {
    const RgbImage image = gradient(width, height);
    const RgbImage again = decode(encode_png(image));
    CHECK(again.width == width);
    CHECK(again.height == height);
    CHECK(again.pixels == image.pixels);
    CHECK(encode_png(image) == encode_png(image));
  }
}

TEST_CASE("encode_png: a buffer of the wrong size is an error") {
  CHECK_THROWS_AS(encode_png(RgbImage{}), std::invalid_argument);
  RgbImage image(4, 4);
  image.pixels.pop_back();
  CHECK_THROWS_AS(encode_png(image), std::invalid_argument);
}

TEST_CASE("write_png: replaces a file and leaves no temporary file") {
  const ScratchFolder folder;
  const std::filesystem::path path = folder / "a.png";
  write_png(path, gradient(5, 6));
  const RgbImage image = gradient(40, 30);
  write_png(path, image);
  CHECK(file_bytes(path) == encode_png(image));
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("write_png: a missing folder, and a folder of that name, are errors") {
  const ScratchFolder folder;
  CHECK_THROWS_AS(write_png(folder / "no/a.png", gradient(2, 2)), RunError);
  std::filesystem::create_directories(folder / "taken/inside");
  CHECK_THROWS_AS(write_png(folder / "taken", gradient(2, 2)), RunError);
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
}
