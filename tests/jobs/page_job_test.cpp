// meander export --html: what is on the page, that it is nothing but text of the store, and, where Chromium
// is installed, that it is drawn.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "io/image/color_image.h"
#include "io/image/png_reader.h"
#include "io/json/json_reader.h"
#include "io/page/model_page.h"
#include "io/store/store_reader.h"
#include "support/catch.h"
#include "support/chromium.h"
#include "support/colored_square.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;
namespace fs = std::filesystem;

namespace {

std::string between(const std::string& text, const std::string& from, const std::string& to) {
  const std::size_t begin = text.find(from);
  REQUIRE(begin != std::string::npos);
  const std::size_t end = text.find(to, begin + from.size());
  REQUIRE(end != std::string::npos);
  return text.substr(begin + from.size(), end - begin - from.size());
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

std::vector<std::uint8_t> from_base64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<std::uint8_t> bytes;
  std::uint32_t bits = 0, held = 0;
  for (const char c : text.substr(0, text.find('='))) {
    const std::size_t digit = digits.find(c);
    REQUIRE(digit != std::string::npos);
    bits = bits << 6 | static_cast<std::uint32_t>(digit);
    if ((held += 6) >= 8) bytes.push_back(static_cast<std::uint8_t>(bits >> (held -= 8)));
  }
  return bytes;
}

std::array<double, 3> from_octahedral(double u, double v) {
  double z = 1 - std::abs(u) - std::abs(v);
  const double fold = std::max(-z, 0.0);
  u += u >= 0 ? -fold : fold;
  v += v >= 0 ? -fold : fold;
  const double length = std::sqrt(u * u + v * v + z * z);
  return {u / length, v / length, z / length};
}

double cosine(const std::array<double, 3>& a, const float* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

struct Page {
  explicit Page(const fs::path& path)
      : text(read_file(path)),
        facts(between(text, "<script type=\"application/json\" id=\"facts\">", "</script>"), "the page") {}
  std::vector<std::uint8_t> block(std::size_t model) const {
    return from_base64(between(
        text, "<script type=\"text/plain\" id=\"model-" + std::to_string(model) + "\">", "</script>"));
  }
  const std::string& fact(const std::string& name) const { return facts.members().at(name); }

  std::string text;
  JsonObject facts;
};

// The block of a model against the samples of these numbers, by its own little decoder.
void check_points(const std::vector<std::uint8_t>& block, const Samples& samples,
                  const std::vector<std::size_t>& chosen) {
  REQUIRE(block.size() >= chosen.size() * packed_point_bytes);
  std::array<double, 3> low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  double lightest = 1e300, densest = 0;
  for (const std::size_t i : chosen) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min<double>(low[axis], samples.points[3 * i + axis]);
      high[axis] = std::max<double>(high[axis], samples.points[3 * i + axis]);
    }
    lightest = std::min<double>(lightest, samples.density[i]);
    densest = std::max<double>(densest, samples.density[i]);
  }
  double worst_place = 0, worst_normal = 1, worst_density = 0, worst_rank = 0;
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    const std::size_t i = chosen[k];
    const std::uint8_t* point = block.data() + k * packed_point_bytes;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double share = (point[2 * axis] + 256 * point[2 * axis + 1]) / 65535.0;
      const double place = low[axis] + share * (high[axis] - low[axis]);
      worst_place = std::max(worst_place, std::abs(place - samples.points[3 * i + axis]) /
                                              std::max(high[axis] - low[axis], 1e-300));
    }
    const auto normal = from_octahedral(static_cast<std::int8_t>(point[6]) / 127.0,
                                        static_cast<std::int8_t>(point[7]) / 127.0);
    worst_normal = std::min(worst_normal, cosine(normal, samples.normals.data() + 3 * i));
    const double level =
        densest > lightest ? std::log(samples.density[i] / lightest) / std::log(densest / lightest) : 0;
    worst_density = std::max(worst_density, std::abs(level - point[8] / 255.0));
    const double rank = samples.curve_rank[i] / static_cast<double>(samples.count() - 1);
    worst_rank = std::max(worst_rank, std::abs(rank - point[9] / 255.0));
  }
  CHECK(worst_place <= 0.5001 / 65535);
  CHECK(worst_normal > std::cos(0.02));
  CHECK(worst_density <= 0.5001 / 255);
  CHECK(worst_rank <= 0.5001 / 255);
}

struct Collection {
  explicit Collection(const std::vector<std::string>& more = {}) {
    fs::create_directories(scratch / "in/ring");
    fs::create_directories(scratch / "in/ball");
    write_mesh(scratch / "in/ring/a.off", torus(24, 12));
    write_mesh(scratch / "in/ring/b.off", torus(24, 12, 1, 0.2));
    write_mesh(scratch / "in/ball/c.off", icosphere(2));
    write_file(scratch / "in/broken.off", "OFF\n3 1 0\n0 0 0\n");
    std::vector<std::string> command{"run", path("in"),           "-o", path("s.h5"), "-n",
                                     "400", "--label-from-folder"};
    command.insert(command.end(), more.begin(), more.end());
    REQUIRE(meander_with(command).exit_code == 3);
  }
  std::string path(std::string_view name) const { return scratch / name; }
  ProcessResult page(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"export", path("s.h5"), "--html", path("page.html"), "--fresh"});
    const ProcessResult result = meander_with(more);
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
    return result;
  }
  ScratchFolder scratch;
};

// Opens the page; nothing may be said on its console.
std::string visit(const Collection& c, const std::string& fragment, const std::string& what) {
  const ProcessResult result =
      open_page("file://" + c.path("page.html") + "#" + fragment, what, "900,700", c.path("profile"));
  CHECK(result.exit_code == 0);
  INFO(result.err);
  CHECK_FALSE(contains(result.err, "CONSOLE"));
  return result.out;
}

}  // namespace

TEST_CASE("page: base64 and octahedral normals are decoded correctly") {
  const auto encoded = [](std::string_view text) { return base64(std::as_bytes(std::span(text))); };
  CHECK(encoded("") == "");  // RFC 4648
  CHECK(encoded("f") == "Zg==");
  CHECK(encoded("fo") == "Zm8=");
  CHECK(encoded("foo") == "Zm9v");
  CHECK(encoded("\xFF\xFE\xFD\xFC") == "//79/A==");
  const float axes[6][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
  const std::array<std::int8_t, 2> codes[6] = {{127, 0}, {0, 127}, {0, 0}, {-127, 0}, {0, -127}, {127, 127}};
  for (int i = 0; i < 6; ++i) CHECK((octahedral_normal(axes[i]) == codes[i]));
  double worst = 1;
  for (int i = 0; i < 20000; ++i) {  // a spiral over the sphere
    const double z = 1 - (2 * i + 1) / 20000.0, r = std::sqrt(1 - z * z), angle = 2.39996322972865 * i;
    const float normal[3] = {static_cast<float>(r * std::cos(angle)), static_cast<float>(r * std::sin(angle)),
                             static_cast<float>(z)};
    const auto code = octahedral_normal(normal);
    worst = std::min(worst, cosine(from_octahedral(code[0] / 127.0, code[1] / 127.0), normal));
  }
  CHECK(std::acos(worst) < 3.14159265 / 180);
  const float bad[3] = {0, std::nanf(""), 0};
  CHECK((octahedral_normal(bad) == std::array<std::int8_t, 2>{0, 0}));
  CHECK(json_in_markup(R"(["<!-- </script>"])") == R"(["\u003c!-- \u003c/script>"])");
}

TEST_CASE("page: the blocks hold the first points of every model as stored") {
  const Collection c({"--density", "mean", "--describe", "d2,basics", "--bins", "16"});
  const ProcessResult result = c.page({"--points", "150"});
  CHECK(contains(result.out, "3 models x 150 points in "));
  CHECK(contains(result.out, "of every model 150 of 400 points (--points)"));
  const StoreReader store(c.path("s.h5"));
  const Page page(c.path("page.html"));
  std::vector<std::size_t> first(150);
  for (std::size_t i = 0; i < first.size(); ++i) first[i] = i;
  std::size_t model = 0;
  for (std::uint64_t row = 0; row < store.rows(); ++row) {
    if (store.report(row).status != Status::ok) continue;
    const Row content = store.read_row(row);
    const std::vector<std::uint8_t> block = page.block(model++);
    check_points(block, content.samples, first);
    // Behind them the bins of d2, over the largest.
    REQUIRE(block.size() == 150 * packed_point_bytes + 16);
    const std::vector<float>& bins = content.descriptors.front().values;
    const float peak = *std::max_element(bins.begin(), bins.end());
    for (std::size_t b = 0; b < 16; ++b)
      CHECK(std::abs(block[150 * packed_point_bytes + b] / 255.0 - bins[b] / peak) <= 0.5001 / 255);
    CHECK(contains(page.fact("models"), "\"id\":\"" + store.id(row) + "\""));
  }
  CHECK(model == 3);
  CHECK(page.facts.integer("points") == 150);
  CHECK(page.facts.integer("rows") == 4);
  CHECK(page.facts.integer("failed") == 1);
  CHECK(page.facts.text("store") == "s.h5");
  CHECK(page.facts.text("parameters") == store.parameters_json());
  CHECK(contains(page.fact("failures"), "[\"broken.off\",\"unreadable\",\""));
  CHECK(contains(page.fact("values"), "\"columns\":\"area,"));
  // The two tori are nearer to each other than to the ball: positions 0 ball, 1 and 2 tori.
  CHECK(page.fact("near").substr(0, 4) == "[[[1" + std::string());
  CHECK(contains(page.fact("near"), "],[2,"));
}

namespace {

// A store of the colored square, whose library of materials is missing, and of a torus that has no colors.
struct ColoredCollection : Collection {
  ColoredCollection() {
    fs::remove_all(scratch / "in");
    fs::create_directories(scratch / "in");
    write_file(scratch / "in/square.ply", colored_square());
    write_mesh(scratch / "in/torus.off", torus(24, 12));
    write_file(scratch / "in/box.obj", "mtllib none.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    REQUIRE(meander_with({"run", path("in"), "-o", path("s.h5"), "-n", "150", "--fresh", "--colors",
                          "--texcoord", "--attribute", "heat,kind"})
                .exit_code == 0);
    page();
  }
};

}  // namespace

TEST_CASE(
    "page: what samples are colored by stands behind their points, notes and sources of colors in the "
    "facts") {
  const ColoredCollection c;
  const Page page(c.path("page.html"));
  const std::string& colorings = page.fact("colorings");
  for (const char* coloring :
       {R"({"word":"rgb","title":"colors of the model","kind":"colors","bytes":3})",
        R"({"word":"texcoord","title":"texture coordinates","kind":"colors","bytes":3})",
        R"({"word":"heat","title":"heat","kind":"number","bytes":1})",
        R"({"word":"kind","title":"kind","kind":"classes","bytes":2})"})
    CHECK(contains(colorings, coloring));
  const StoreReader store(c.path("s.h5"));
  constexpr std::size_t n = 150;
  for (std::size_t model = 0; model < 3; ++model) {
    const Samples samples = store.read_row(model).samples;
    const std::vector<std::uint8_t> block = page.block(model);
    REQUIRE(block.size() == n * (packed_point_bytes + 3 + 3 + 1 + 2));
    const std::uint8_t* at = block.data() + n * packed_point_bytes;
    CHECK(std::equal(samples.rgb.begin(), samples.rgb.end(), at));
    const std::uint8_t* const heat = at + 6 * n;
    std::array<float, 2> range = {1, -1};
    for (const float value : samples.attributes[0])
      range = {std::min(range[0], value), std::max(range[1], value)};
    for (std::size_t i = 0; i < n; ++i) {
      const float u = samples.texcoord[2 * i], value = samples.attributes[0][i];
      const std::uint8_t* const color = at + 3 * n + 3 * i;
      if (model == 1) {
        CHECK(std::abs(color[0] - 255 * u) <= 0.501f);
        CHECK(std::abs(heat[i] - 254 * (value - range[0]) / (range[1] - range[0])) <= 0.501f);
      } else {
        CHECK(color[0] == 150);  // gray
        CHECK(heat[i] == 255);   // none
      }
      CHECK(
          heat[n + 2 * i] + 256 * heat[n + 2 * i + 1] ==
          (model == 1
               ? (samples.points[3 * i] * store.report(model).scale + store.report(model).loc[0] < 0 ? 3 : 7)
               : 65535));
    }
  }
  const std::string& models = page.fact("models");
  CHECK(contains(models, R"("color_source":"vertex","color_fills":0)"));
  CHECK(contains(models, R"("color_source":"none","color_fills":150)"));
  CHECK(contains(models, R"("notes":"library_missing 1: )"));
  CHECK(contains(models, R"([[3,"3"],[7,"7"]])"));
  CHECK(contains(models, "\"paint\":[[],[],[],[]]"));

  MEANDER_NEEDS_CHROMIUM();
  const std::string square = visit(c, "model=square.ply&colour=kind", "--dump-dom");
  CHECK(contains(square, "of its vertices"));
  CHECK(contains(square, "rgb(204, 121, 167)"));  // class 3
  CHECK(contains(square, "rgb(51, 34, 136)"));    // class 7
  const std::string box = visit(c, "model=box.obj&color=heat", "--dump-dom");
  CHECK(contains(box, "library missing 1: "));
  CHECK(contains(box, "none in the file; gray at 150 of 150 points"));
  CHECK(contains(box, "heat: no value"));
  for (const char* word : {"rgb", "texcoord", "heat", "kind"})
    CHECK(contains(box, "<option value=\"" + std::string(word) + "\">"));
}

TEST_CASE("page: Chromium draws samples in their colors, small enough to be told apart") {
  MEANDER_NEEDS_CHROMIUM();
  const ColoredCollection c;
  const auto picture = [&](const std::string& fragment) {
    visit(c, "model=square.ply&theme=light&yaw=0&pitch=0&" + fragment, "--screenshot=" + c.path("view.png"));
    const std::string bytes = read_file(c.path("view.png"));
    return decode_color_image(std::as_bytes(std::span(bytes)));
  };
  // Pixels of the square's halves, which lie on both sides of the middle of the large view.
  const auto count_of_pixels = [](const ColorImage& image, std::size_t strong, std::size_t weak) {
    std::size_t count = 0;
    for (std::size_t p = 0; p + 2 < image.rgb.size(); p += 3)
      count += image.rgb[p + strong] > image.rgb[p + weak] + 90;
    return count;
  };
  const ColorImage rgb = picture("color=rgb");
  CHECK(count_of_pixels(rgb, 0, 2) > 500);
  CHECK(count_of_pixels(rgb, 2, 0) > 500);
  const ColorImage surface = picture("color=rgb&style=surface");
  CHECK(count_of_pixels(surface, 0, 2) > 3 * count_of_pixels(rgb, 0, 2));

  // Red discs that do not touch each other: most of the 150.
  const ColorImage plain = picture("color=plain");
  const auto is_disc = [&](std::size_t pixel) {
    return plain.rgb[3 * pixel] > plain.rgb[3 * pixel + 2] + 60;
  };
  std::vector<bool> seen(plain.rgb.size() / 3);
  std::size_t discs = 0;
  for (std::size_t first = 0; first < seen.size(); ++first) {
    if (seen[first] || !is_disc(first)) continue;
    ++discs;
    std::vector<std::size_t> open = {first};
    seen[first] = true;
    while (!open.empty()) {
      const std::size_t pixel = open.back();
      open.pop_back();
      for (const std::size_t next : {pixel - 1, pixel + 1, pixel - plain.width, pixel + plain.width})
        if (next < seen.size() && !seen[next] && is_disc(next)) {
          seen[next] = true;
          open.push_back(next);
        }
    }
  }
  CHECK(discs > 120);
  CHECK(discs <= 150);
}

TEST_CASE("page: in curve order points are spread along the curve") {
  const Collection c({"--order", "curve"});
  c.page({"--points", "100"});
  const StoreReader store(c.path("s.h5"));
  std::vector<std::size_t> spread(100);
  for (std::size_t i = 0; i < spread.size(); ++i) spread[i] = (2 * i + 1) * 400 / 200;
  check_points(Page(c.path("page.html")).block(0), store.read_row(0).samples, spread);
}

TEST_CASE("page: the same bytes again, limits, refusals") {
  const Collection c;
  c.page();
  const std::string bytes = read_file(c.path("page.html"));
  c.page();
  CHECK((read_file(c.path("page.html")) == bytes));
  CHECK(bytes.size() < 150000);
  CHECK(contains(c.page({"--models", "2"}).out, "2 models x 400 points"));
  CHECK(contains(c.page({"--models", "2"}).out, "1 model left out (--models)"));
  CHECK(contains(c.page({"ring/b.off"}).out, "1 model x 400 points"));

  const auto refused = [&](const std::vector<std::string>& more, const std::string& words) {
    std::vector<std::string> command{"export", c.path("s.h5")};
    command.insert(command.end(), more.begin(), more.end());
    const auto before = content_of(c.scratch.path());
    const ProcessResult result = meander_with(command);
    INFO(result.err);
    CHECK(result.exit_code == 2);
    CHECK(contains(result.err, words));
    CHECK((content_of(c.scratch.path()) == before));
  };
  refused({"--html", c.path("page.html")}, "exists (--fresh replaces it)");
  refused({"--html", c.path("s.h5"), "--fresh"}, "is the store itself");
  refused({"--html", c.path("in/ring/a.off"), "--fresh"}, "is an OFF mesh");
  refused({"--html", c.path("none/page.html")}, "does not exist");
  refused({"--html", c.path("p.html"), "-o", c.path("out")}, "--html");
  refused({"--html", c.path("p.html"), "--format", "ply"}, "--html");
  refused({"--html", c.path("p.html"), "--pointnet"}, "--html");
  refused({"--html", c.path("p.html"), "broken.off"}, "has no points");
  refused({"--models", "3", "-o", c.path("out")}, "apply to --html only");
  refused({"--html", c.path("p.html"), "--models", "0"}, "--models");
}

TEST_CASE("page: nothing in a store is markup, in the file and in the browser") {
  const std::string hostile =
      "script><img src=x onerror=document.title=1>\"'&amp;\xE2\x80\xAE"
      "ffo.off";
  const std::string longest = std::string(200, 'w') + ".off";
  const Collection c;
  fs::create_directories(c.scratch / "in/a<");
  write_mesh(c.scratch / "in/a<" / hostile, cube());
  write_mesh(c.scratch / "in" / longest, cube());
  write_file(c.scratch / "in/a<" / ("bad" + hostile), "OFF\n<b>\n");
  REQUIRE(meander_with({"run", c.path("in"), "-o", c.path("s.h5"), "-n", "64", "--fresh",
                        "--label-from-folder", "--describe", "d2"})
              .exit_code == 3);
  c.page();
  const Page page(c.path("page.html"));
  CHECK(count_of(page.text, "<img") == 0);
  CHECK(count_of(page.text, "</script") == 5 + 2);  // models, facts, script
  CHECK(count_of(page.text, "<script") == count_of(page.text, "</script"));
  CHECK(contains(page.text, "default-src 'none'"));
  for (const char* loads :
       {" src=", "<link", "@import", "url(", "fetch(", "XMLHttpRequest", "innerHTML", "eval("})
    CHECK(count_of(page.text, loads) == (std::string(loads) == " src=" ? 2 : 0));  // the two hostile ids
  CHECK(contains(page.fact("models"), "a\\u003c/script>\\u003cimg src=x"));

  MEANDER_NEEDS_CHROMIUM();
  const std::string dom = visit(c, "model=ring/a.off", "--dump-dom");
  CHECK(contains(dom, "<title>ring/a.off \xE2\x80\x93 s.h5 \xE2\x80\x93 5 models</title>"));
  const std::string body = dom.substr(dom.find("<body"));
  CHECK(count_of(body, "<img") == 0);
  CHECK(contains(body, "a&lt;/badscript&gt;&lt;img src=x"));  // the failure, as text
  CHECK(contains(body, "wwwww.off</bdi>"));                   // shortened at the front
  CHECK(contains(body, "Nearest by d2"));
  CHECK(contains(body, "class=\"histogram\""));
}

TEST_CASE("page: Chromium draws the models, and fewer points or other colors change the picture") {
  MEANDER_NEEDS_CHROMIUM();
  const Collection c;
  c.page();
  const auto picture = [&](const std::string& fragment) {
    visit(c, fragment, "--screenshot=" + c.path("view.png"));
    return read_gray_png(c.path("view.png"));
  };
  const GrayImage all = picture("model=ring/a.off"), few = picture("model=ring/a.off&points=20&colour=rank");
  REQUIRE(all.values.size() == few.values.size());
  // Of the lower half, which the settings and the names above do not reach.
  std::size_t differing = 0, ink = 0;
  for (std::size_t i = all.values.size() / 2; i < all.values.size(); ++i) {
    differing += std::abs(all.values[i] - few.values[i]) > 0.1f;
    ink += all.values[i] < 0.8f;
  }
  CHECK(ink > 5000);
  CHECK(differing > 5000);
}

TEST_CASE("page: Chromium draws the points that view_detail.h keeps for a view") {
  MEANDER_NEEDS_CHROMIUM();
  const Collection c;
  c.page();
  // What the page says that it drew of the 400 points of a ring, which is closed.
  const auto kept = [&](const std::string& fragment) {
    const std::string dom = visit(c, "model=ring/a.off" + fragment, "--dump-dom");
    const std::size_t at = dom.find(" of 400 for this view");
    REQUIRE(at != std::string::npos);
    return std::stoi(dom.substr(dom.rfind('>', at) + 1));
  };
  const StoreReader store(c.path("s.h5"));
  const std::vector<float> normals = store.read_row(*store.find("ring/a.off")).samples.normals;
  const auto expected = [&](std::size_t axis, float sign) {
    constexpr double least = 0.1, fade = 0.35, front = least + (1 - least) / 5;
    std::vector<double> weights;
    double sum = 0, projected = 0, count = 0;
    for (std::size_t i = axis; i < normals.size(); i += 3) {
      const double cosine = sign * normals[i];
      weights.push_back(cosine > 0       ? least + (1 - least) * std::pow(1 - cosine, 4)
                        : cosine > -fade ? std::pow(1 + cosine / fade, 2)
                                         : 0.0);
      sum += weights.back();
      projected += std::max(0.0, cosine);
    }
    const double share = 0.5 * (front + fade / 3) / 0.25 * projected / sum;
    for (std::size_t i = 0; i < weights.size(); ++i)
      count += (static_cast<double>(i) + 0.5) / static_cast<double>(weights.size()) < share * weights[i];
    return count;
  };
  // Normals have one byte a coordinate there. Yaw and pitch 0: the eye is on the z axis, else on the x axis.
  const double above = expected(2, 1), beside = expected(0, -1);
  CHECK(kept("&detail=view&yaw=0&pitch=0") == Approx(above).margin(6));
  CHECK(kept("&detail=view&yaw=1.571&pitch=0") == Approx(beside).margin(6));
  CHECK(above < 300);
}
