// meander render: sheets of sampled models, with and without their meshes.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "io/image/color_image.h"
#include "support/catch.h"
#include "support/colored_square.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/run_process.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;
namespace fs = std::filesystem;

namespace {

// Two models and one that cannot be read.
struct Place {
  Place() {
    fs::create_directories(scratch / "in/ball");
    fs::create_directories(scratch / "in/ring");
    write_mesh(scratch / "in/ball/a.off", icosphere(3));
    write_mesh(scratch / "in/ring/b.ply", torus(24, 12));
    write_file(scratch / "in/ring/c.off", "OFF\n7 8");
    const ProcessResult run =
        run_process({program, "run", path("in"), "-o", path("s.h5"), "-n", "256", "--label-from-folder"});
    REQUIRE(run.exit_code == 3);
  }
  std::string path(std::string_view name) const { return (scratch / name).string(); }
  ProcessResult sheet(std::vector<std::string> more, bool with_input = true) const {
    std::vector<std::string> words = {program, "render", "sheet", path("s.h5")};
    if (with_input) words.push_back(path("in"));
    words.insert(words.end(), more.begin(), more.end());
    return run_process(words);
  }
  std::string refusal(const std::vector<std::string>& more, bool with_input = true) const {
    const ProcessResult result = sheet(more, with_input);
    CHECK(result.exit_code == 2);
    CHECK(result.out.empty());
    return result.err;
  }

  ScratchFolder scratch;
};

}  // namespace

TEST_CASE("render sheet: surfaces, failed items and a summary, the same for one thread and two") {
  const Place place;
  for (const char* threads : {"1", "2"}) {
    const ProcessResult result =
        place.sheet({"-o", place.path(std::string(threads) + ".png"), "-j", threads});
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
    CHECK(contains(result.out, "3 models, 1 without points"));
    CHECK(result.err.empty());
  }
  const std::string bytes = read_file(place.path("1.png"));
  CHECK(bytes.starts_with("\x89PNG"));
  CHECK(bytes.size() > 20000);
  CHECK(bytes == read_file(place.path("2.png")));
  const ProcessResult json = place.sheet({"-o", place.path("json.png"), "--json"});
  CHECK(json.exit_code == 0);
  CHECK(json.out.starts_with("{\"picture\":\"" + place.path("json.png") + "\",\"without_surface\":0,"));
  CHECK(contains(json.out, "\"without_points\":1,\"models\":[{\"title\":"));
  CHECK(std::count(json.out.begin(), json.out.end(), '\n') == 1);
  CHECK(read_file(place.path("json.png")) == bytes);
  // No edges of the ball or of the ring are as sharp as 60 degrees, all are at 1.
  for (const auto& [angle, same] : {std::pair{"60", true}, std::pair{"1", false}}) {
    REQUIRE(place.sheet({"-o", place.path("sharp.png"), "--sharp-edges", angle}).exit_code == 0);
    CHECK((read_file(place.path("sharp.png")) == bytes) == same);
  }
  CHECK(contains(place.refusal({"-o", place.path("sharp.png"), "--sharp-edges", "30"}, false), "give INPUT"));
  // Solid surfaces and lone points differ; without INPUT the program says what is missing.
  const ProcessResult alone = place.sheet({"-o", place.path("3.png")}, false);
  CHECK(alone.exit_code == 0);
  CHECK(contains(alone.err, "a store holds no surfaces: give the INPUT of its run"));
  CHECK(bytes != read_file(place.path("3.png")));
}

namespace {

// The mean color of what is drawn in a part of the first cell, of 200 pixels: columns [begin, end) of its
// width, from 0 to 1.
std::array<double, 3> mean_color(const ColorImage& picture, double begin, double end) {
  std::array<double, 3> sum{};
  double count = 0;
  const auto at = [&](double share) { return 18 + static_cast<std::size_t>(share * 200); };
  for (std::size_t y = 60; y < 180; ++y)
    for (std::size_t x = at(begin); x < at(end); ++x) {
      const std::uint8_t* const pixel = &picture.rgb[3 * (y * picture.width + x)];
      if (*std::min_element(pixel, pixel + 3) > 185) continue;
      for (std::size_t k = 0; k < 3; ++k) sum[k] += pixel[k] / 255.0;
      ++count;
    }
  REQUIRE(count > 100);
  for (double& value : sum) value /= count;
  return sum;
}

}  // namespace

TEST_CASE("render: samples are colored by what the store has, and by nothing else", "[release]") {
  const ScratchFolder scratch;
  fs::create_directory(scratch / "in");
  write_file(scratch / "in/square.ply", colored_square());
  write_mesh(scratch / "in/plain.off", icosphere(2));
  const std::string store = scratch / "s.h5";
  REQUIRE(run_process({program, "run", scratch / "in", "-o", store, "-n", "600", "--colors", "--texcoord",
                       "--attribute", "heat,kind", "--density", "mean"})
              .exit_code == 0);
  const auto render = [&](const std::string& style, const std::string& color, const std::string& item) {
    const std::string file = scratch / "p.png";
    const ProcessResult result =
        run_process({program, "render", style, store, "-o", file, "--size", "200", "--view", "0,0,1",
                     "--color", color, "--item", item, "--memory", "1G"});
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
    const std::string bytes = read_file(file);
    return decode_color_image(std::as_bytes(std::span(bytes)));
  };
  for (const char* style : {"splats", "points", "sheet"}) {
    INFO(style);
    const auto halves = [&](const std::string& color) {
      const ColorImage picture = render(style, color, "square.ply");
      return std::pair(mean_color(picture, 0.1, 0.45), mean_color(picture, 0.55, 0.9));
    };
    auto [left, right] = halves("rgb");
    CHECK(left[0] > left[2] + 0.2);
    CHECK(right[2] > right[0] + 0.2);
    std::tie(left, right) = halves("texture");  // u is red
    CHECK(right[0] > left[0] + 0.15);
    CHECK(std::abs(right[1] - left[1]) < 0.15);
    std::tie(left, right) = halves("heat");  // from violet to yellow
    CHECK(left[2] > left[1] + 0.05);
    CHECK(right[1] > right[2] + 0.05);
    CHECK(right[1] > left[1] + 0.15);
    std::tie(left, right) = halves("kind");  // 3 is pink, 7 indigo
    CHECK(left[0] > left[1] + 0.1);
    CHECK(right[2] > right[0] + 0.1);
    CHECK(left[0] > right[0] + 0.2);
    // A model that lacks the attribute is gray.
    for (const char* color : {"heat", "attribute:kind"}) {
      const auto [red, green, blue] = mean_color(render(style, color, "plain.off"), 0.3, 0.7);
      CHECK(std::abs(red - green) < 0.02);
      CHECK(std::abs(green - blue) < 0.02);
    }
  }
  // Numbers have a bar with their range below the picture, classes a line of keys.
  const auto height = [&](const std::string& color) { return render("points", color, "square.ply").height; };
  CHECK(height("heat") > height("kind"));
  CHECK(height("kind") > height("plain"));
  for (const char* color : {"curve_rank", "face_index", "normals", "density"})
    CHECK(height(color) > height("plain"));

  // Frames of a turning model have no legend; the command prints it.
  const auto frame = [&](const std::string& color) {
    const ProcessResult result =
        run_process({program, "render", "turntable", store, "--item", "square.ply", "-o", scratch / "turn",
                     "--frames", "1", "--color", color, "--from", "0", "--elevation", "0"});
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
    return std::pair(result.out, read_file(scratch / "turn/frame-0000.png"));
  };
  CHECK(contains(frame("heat").first, " (violet) to 0.9"));
  CHECK(frame("rgb").second != frame("plain").second);

  const auto refusal = [&](const std::string& name, const std::string& color) {
    const ProcessResult result =
        run_process({program, "render", "points", name, "-o", scratch / "q.png", "--color", color});
    CHECK(result.exit_code == 2);
    return result.err;
  };
  const std::string unknown = refusal(store, "heatt");
  CHECK(contains(unknown, "--color: no color for `heatt`: the store has neither a column nor an attribute"));
  CHECK(contains(unknown, "did you mean `heat`?"));
  CHECK(contains(unknown, "; there are plain, normal, face_index, rank, density, rgb, texcoord, heat, kind"));
  CHECK(contains(refusal(store, "class"), "the models of the store have no classes"));
  CHECK(contains(refusal(store, "uv"), "the store has none: its models are meshes"));
  CHECK(contains(refusal(store, "barycentric"), "it says where samples are"));
  const std::string bare = scratch / "bare.h5";
  REQUIRE(run_process(
              {program, "run", scratch / "in", "-o", bare, "-n", "64", "--store", "points,normals,density"})
              .exit_code == 0);
  CHECK(contains(refusal(bare, "rgb"), "the store has none: it was made without --colors"));
  CHECK(contains(refusal(bare, "rank"), "the store was made with a --store that leaves it out"));
}

TEST_CASE("render sheet: every color, prefix, axis and size changes the picture") {
  const Place place;
  std::vector<std::string> pictures;
  const std::vector<std::vector<std::string>> looks = {{},
                                                       {"--colour", "density"},
                                                       {"--colour", "rank"},
                                                       {"--colour", "normal"},
                                                       {"--color", "label"},
                                                       {"--points", "64"},
                                                       {"--up", "z"},
                                                       {"--up", "x"},
                                                       {"--view", "1,0.2,-3"},
                                                       {"--size", "200"},
                                                       {"--columns", "1"},
                                                       {"--models", "2"},
                                                       {"--item", "ball/a.off", "2"}};
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const std::string file = place.path("p" + std::to_string(i) + ".png");
    std::vector<std::string> words = {"-o", file};
    words.insert(words.end(), looks[i].begin(), looks[i].end());
    const ProcessResult result = place.sheet(words);
    INFO(i << " " << result.err);
    REQUIRE(result.exit_code == 0);
    pictures.push_back(read_file(file));
    for (std::size_t j = 0; j < i; ++j) CHECK(pictures[j] != pictures[i]);
  }
}

TEST_CASE(
    "render sheet: discs on stacked sheets do not cover visible ones, and a constant has no scale bar") {
  // A cube with thirty others inside it, which no picture shows.
  const ScratchFolder scratch;
  PolygonMesh shells = cube();
  for (int k = 1; k <= 30; ++k) shells = merged(shells, moved(cube(), 1 - 0.01 * k, 0, 0, 0));
  write_mesh(scratch / "shells.off", shells);
  const std::string store = scratch / "s.h5";
  REQUIRE(run_process({program, "run", scratch / "shells.off", "-o", store, "-n", "4096"}).exit_code == 0);
  const auto sheet = [&](const std::string& color) {
    const std::string file = scratch / (color + ".png");
    const ProcessResult result = run_process({program, "render", "sheet", store, scratch / "shells.off", "-o",
                                              file, "--size", "200", "--colour", color});
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
    const std::string bytes = read_file(file);
    return decode_color_image(std::as_bytes(std::span(bytes)));
  };
  const ColorImage plain = sheet("plain");
  std::size_t discs = 0, model = 0;
  for (std::size_t p = 0; p + 2 < plain.rgb.size(); p += 3) {
    discs += plain.rgb[p] > plain.rgb[p + 1] + 50;
    model += plain.rgb[p + 1] < 240;
  }
  CHECK(discs > 50);
  CHECK(10 * discs < 2 * model);
  // The legend: a title alone where every density is the same.
  CHECK(sheet("density").height > plain.height);
  CHECK(sheet("rank").height > sheet("density").height + 10);
}

TEST_CASE("render sheet: missing, changed and too large meshes are named, their points drawn") {
  const Place place;
  write_mesh(place.path("in/ball/a.off"), icosphere(2));
  fs::remove(place.path("in/ring/b.ply"));
  const ProcessResult result = place.sheet({"-o", place.path("p.png")});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK(contains(result.out, "3 models, 2 without a surface, 1 without points"));
  // A mesh that does not fit beside the sheet, the same for any number of threads.
  const Place other;
  write_mesh(other.path("in/ball/a.off"), icosphere(6));
  REQUIRE(run_process({program, "run", other.path("in"), "-o", other.path("s.h5"), "-n", "256", "--fresh"})
              .exit_code == 3);
  for (const char* threads : {"1", "2"}) {
    const ProcessResult little = other.sheet(
        {"-o", other.path(std::string(threads) + ".png"), "--size", "100", "--memory", "12M", "-j", threads});
    INFO(little.err);
    CHECK(contains(little.out, "3 models, 1 without a surface, 1 without points"));
  }
  CHECK(read_file(other.path("1.png")) == read_file(other.path("2.png")));
}

TEST_CASE("render sheet: mistakes are usage errors, and nothing is written") {
  const Place place;
  const std::string out = place.path("p.png");
  CHECK(contains(place.refusal({"-o", place.path("p.jpg")}), "should end in .png"));
  CHECK(contains(place.refusal({"-o", out, "--view", "1,2"}), "give three numbers"));
  CHECK(contains(place.refusal({"-o", out, "--view", "1,2,x"}), "give three numbers"));
  CHECK(contains(place.refusal({"-o", out, "--view", "0,1,0"}), "must not lie along the axis"));
  CHECK(contains(place.refusal({"-o", out, "--view", "0,0,0"}), "must not lie along the axis"));
  CHECK(contains(place.refusal({"-o", out, "--colour", "rnak"}), "rank"));
  CHECK(contains(place.refusal({"-o", out, "--item", "ball/b.off"}), "ball/b.off"));
  CHECK(contains(place.refusal({"-o", out, "--models", "0"}), "--models"));
  CHECK(contains(place.refusal({"-o", out, "--memory", "much"}), "much"));
  CHECK(contains(place.refusal({"-o", out, "--memory", "100K"}), "or lower --size or --models"));
  CHECK(contains(place.refusal({"-o", out, "--item", "0", "--models", "5"}), "--models"));
  CHECK(contains(place.refusal({"-o", out, "-0"}, false), "give INPUT as well"));
  CHECK(contains(place.refusal({"-o", out, "--root", place.path("in")}, false), "give INPUT as well"));
  CHECK(contains(place.refusal({"-o", place.path("in/ball/a.off")}), "should end in .png"));
  CHECK(run_process({program, "render"}).exit_code == 2);
  CHECK_FALSE(fs::exists(out));
}

// ---- splats, points, turntable ----------------------------------------------------------------------------

namespace {

// The numbers of "... 94.3 % of ..., 92.6 % ..." in order.
std::vector<double> percentages(const std::string& text) {
  std::vector<double> values;
  for (std::size_t at = text.find(" %"); at != std::string::npos; at = text.find(" %", at + 1)) {
    const std::size_t begin = text.find_last_of(" \n", at - 1);
    values.push_back(std::stod(text.substr(begin + 1, at - begin - 1)));
  }
  return values;
}

}  // namespace

TEST_CASE("render splats: white space with the meshes, failed items, the same for one thread and two") {
  const Place place;
  const auto splats = [&](const std::string& name, std::vector<std::string> more, bool with_input) {
    std::vector<std::string> words = {program, "render", "splats", place.path("s.h5")};
    if (with_input) words.push_back(place.path("in"));
    words.insert(words.end(), {"-o", place.path(name), "--size", "200"});
    words.insert(words.end(), more.begin(), more.end());
    return run_process(words);
  };
  for (const char* threads : {"1", "2"}) {
    const ProcessResult result = splats(std::string(threads) + ".png", {"-j", threads}, true);
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
    CHECK(contains(result.out, "3 models, 1 without points"));
    CHECK(contains(result.out, "ring/c.off: unreadable"));
    CHECK(percentages(result.out).size() == 2);
    for (const double white : percentages(result.out)) CHECK(white < 3);
  }
  CHECK(read_file(place.path("1.png")) == read_file(place.path("2.png")));
  // Smaller splats leave more.
  const ProcessResult small = splats("small.png", {"--cover", "0.5"}, true);
  for (const double white : percentages(small.out)) {
    CHECK(white > 50);
    CHECK(white < 75);
  }
  const ProcessResult alone = splats("alone.png", {}, false);
  CHECK(alone.exit_code == 0);
  CHECK(alone.err.empty());
  CHECK(percentages(alone.out).empty());
  write_mesh(place.path("in/ball/a.off"), icosphere(2));
  CHECK(contains(splats("changed.png", {}, true).out, "white space unknown: the mesh has changed"));
  REQUIRE(splats("colored.png", {"--colour", "normal"}, false).exit_code == 0);
  CHECK(read_file(place.path("colored.png")) != read_file(place.path("alone.png")));
  CHECK(splats("p.png", {"--cover", "0"}, false).exit_code == 2);
  const ProcessResult points =
      run_process({program, "render", "points", place.path("s.h5"), "-o", place.path("points.png")});
  CHECK(points.exit_code == 0);
  CHECK(read_file(place.path("points.png")).size() > 10000);
}

TEST_CASE("render splats: back faces are culled only on closed meshes whose normals point outward") {
  const ScratchFolder scratch;
  PolygonMesh inward = icosphere(2), open = icosphere(2);
  for (std::size_t c = 0; c < inward.corners.size(); c += 3)
    std::swap(inward.corners[c], inward.corners[c + 1]);
  open.corners.resize(open.corners.size() - 300);
  open.polygon_begin.resize(open.polygon_begin.size() - 100);
  fs::create_directories(scratch / "in");
  write_mesh(scratch / "in/ball.off", icosphere(2));
  write_mesh(scratch / "in/inward.off", inward);
  write_mesh(scratch / "in/open.off", open);
  const std::string store = scratch / "s.h5";
  REQUIRE(run_process({program, "run", scratch / "in", "-o", store, "-n", "200"}).exit_code == 0);
  const auto draw = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {program, "render", "splats", store, "--cover",
                                      "1",     "--size", "64",     "-o",  scratch / "p.png"};
    words.insert(words.end(), more.begin(), more.end());
    REQUIRE(run_process(words).exit_code == 0);
    return read_file(scratch / "p.png");
  };
  CHECK(draw({"--item", "ball.off"}) != draw({"--item", "ball.off", "--both-sides"}));
  const std::vector<std::string> others = {"--item", "inward.off", "open.off"};
  CHECK(draw(others) == draw({"--both-sides", "--item", "inward.off", "open.off"}));
}

TEST_CASE("render splats: anisotropic samples are ellipses unless discs are requested") {
  const ScratchFolder scratch;
  write_mesh(scratch / "ring.off", torus(48, 24));
  const std::string store = scratch / "s.h5";
  REQUIRE(
      run_process({program, "run", scratch / "ring.off", "-o", store, "-n", "400", "--method", "anisotropic"})
          .exit_code == 0);
  std::vector<double> white;
  for (const std::vector<std::string>& look : {std::vector<std::string>{}, {"--round"}}) {
    std::vector<std::string> words = {program, "render",          "splats",  store, scratch / "ring.off",
                                      "-o",    scratch / "p.png", "--cover", "2"};
    words.insert(words.end(), look.begin(), look.end());
    const ProcessResult result = run_process(words);
    INFO(result.err);
    REQUIRE(percentages(result.out).size() == 1);
    white.push_back(percentages(result.out)[0]);
  }
  CHECK(white[0] < 0.9 * white[1]);
}

TEST_CASE("render turntable: samples stay the same over all frames, for one thread and two") {
  const ScratchFolder scratch;
  write_mesh(scratch / "ring.off", torus(64, 32));
  write_file(scratch / "bad.off", "OFF\n7 8");
  const std::string store = scratch / "s.h5";
  REQUIRE(run_process({program, "run", scratch / "ring.off", scratch / "bad.off", "-o", store, "-n", "20000"})
              .exit_code == 3);
  const auto turn = [&](std::vector<std::string> more) {
    std::vector<std::string> words = {program, "render", "turntable", store};
    words.insert(words.end(), more.begin(), more.end());
    return run_process(words);
  };
  const std::vector<std::string> small = {"--width", "120", "--height", "80", "--frames", "4"};
  const auto with = [&](std::vector<std::string> words) {
    words.insert(words.end(), small.begin(), small.end());
    return words;
  };
  const ProcessResult json = turn(with({"-o", scratch / "json", "--json"}));
  CHECK(json.exit_code == 0);
  CHECK(json.out.starts_with("{\"frames\":4,\"output\":\"" + (scratch / "json").string() +
                             "\",\"item\":\"ring.off\","));
  CHECK(contains(json.out, "\"median_share_kept\":0."));
  const ProcessResult first = turn(with({"-o", scratch / "a", "-j", "1"}));
  INFO(first.err);
  REQUIRE(first.exit_code == 0);
  CHECK(contains(first.out, "4 frames of "));
  CHECK(contains(first.out, "none moves"));
  REQUIRE(percentages(first.out).size() == 3);  // median, worst frame, behind the silhouette
  CHECK(percentages(first.out)[0] >= percentages(first.out)[1]);
  CHECK(percentages(first.out)[1] >= 90);
  CHECK(contains(first.out, "behind the silhouette"));
  REQUIRE(turn(with({"-o", scratch / "b%02d.png", "-j", "2"})).exit_code == 0);
  for (int k = 0; k < 4; ++k) {
    const std::string digit = std::to_string(k);
    CHECK(read_file(scratch / ("a/frame-000" + digit + ".png")) ==
          read_file(scratch / ("b0" + digit + ".png")));
  }
  CHECK(read_file(scratch / "b00.png") != read_file(scratch / "b03.png"));
  CHECK(contains(turn(with({"-o", scratch / "c", "--samples", "500"})).out, " samples each"));
  // Mistakes.
  CHECK(contains(turn({"-o", scratch / "x%s.png"}).err, "pattern of file names"));
  CHECK(contains(turn({"-o", scratch / "x%d%d.png"}).err, "pattern of file names"));
  CHECK(contains(turn({"-o", scratch / "x%04d.jpg"}).err, "pattern of file names"));
  CHECK(contains(turn({"-o", scratch / "d", "--item", "0"}).err, "has no samples: unreadable"));
  CHECK(contains(turn({"-o", scratch / "d", "--memory", "100K"}).err, "need"));
  CHECK(turn({"-o", store}).exit_code == 2);
  CHECK(turn({"-o", scratch / "d", "--elevation", "90"}).exit_code == 2);
  CHECK_FALSE(fs::exists(scratch / "d"));
  REQUIRE(run_process(
              {program, "run", scratch / "ring.off", "-o", scratch / "c.h5", "-n", "64", "--order", "curve"})
              .exit_code == 0);
  CHECK(contains(run_process({program, "render", "turntable", scratch / "c.h5", "-o", scratch / "e"}).err,
                 "progressive"));
}
