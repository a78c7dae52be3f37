// Densities from images: masses against closed forms, and samples against masses.
#include "kernels/density/texture_density.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <numeric>

#include "kernels/core/parallel.h"
#include "kernels/density/density_pieces.h"
#include "kernels/density/pieces.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/mesh/surface_textures.h"
#include "kernels/mesh/texture_colors.h"
#include "kernels/model/model.h"
#include "kernels/rays/embree_locator.h"
#include "support/catch.h"

using namespace meander;

namespace {

// The unit square as two triangles that show one image from edge to edge, pixels as they are; v points down,
// as the rows of the image do. gray: the displayed value of the pixel at (x, y), 0 to 255.
PolygonMesh textured_square(std::uint32_t width, std::uint32_t height,
                            const std::function<int(std::uint32_t, std::uint32_t)>& gray) {
  PolygonMesh mesh;
  mesh.x = {0, 1, 1, 0};
  mesh.y = {0, 0, 1, 1};
  mesh.z = {0, 0, 0, 0};
  mesh.corners = {0, 1, 2, 0, 2, 3};
  mesh.polygon_begin = {0, 3, 6};
  auto textures = std::make_shared<SurfaceTextures>();
  ColorImage image;
  image.width = width;
  image.height = height;
  for (std::uint32_t y = 0; y < height; ++y)
    for (std::uint32_t x = 0; x < width; ++x)
      image.rgb.insert(image.rgb.end(), 3, static_cast<std::uint8_t>(gray(x, y)));
  textures->images.push_back(std::move(image));
  Texture texture;
  texture.image = 0;
  texture.nearest = true;
  texture.wrap_u = texture.wrap_v = TextureWrap::clamp;
  textures->textures.push_back(texture);
  textures->face = {0, 0};
  textures->coordinates = {0, 0, 1, 0, 1, 1, 0, 1};
  textures->corner = {0, 1, 2, 0, 2, 3};
  mesh.colors.textures = textures;
  return mesh;
}

// The left half black, the right half white.
PolygonMesh half_and_half() {
  return textured_square(8, 8, [](std::uint32_t x, std::uint32_t) { return x < 4 ? 0 : 255; });
}

DensityParameters texture_parameters(DensityKind kind = DensityKind::texture) {
  DensityParameters parameters;
  parameters.kind = kind;
  return parameters;
}

Density density_of(const PolygonMesh& file, const DensityParameters& parameters = texture_parameters()) {
  return make_texture_density(file, prepare_mesh(file), parameters);
}

// The integral over the unit square.
double integral(const PolygonMesh& file, const DensityParameters& parameters = texture_parameters()) {
  const PreparedMesh mesh = prepare_mesh(file);
  return file_measure(mesh, blocked_sum(triangle_masses(mesh, make_texture_density(file, mesh, parameters))));
}

Model sampled_model(const PolygonMesh& file, SampleParameters parameters, std::uint32_t samples) {
  static const EmbreeDevice device;
  parameters.density.kind = DensityKind::texture;
  parameters.columns[&Samples::rgb] = true;
  parameters.samples = samples;
  REQUIRE(validate(parameters).empty());
  Model model;
  model.file = file;
  model.key = make_random_key(3, {});
  run_stages(stages_of(parameters, &device), model);
  return model;
}

struct Way {
  const char* name;
  SampleParameters parameters;
  std::uint32_t samples = 4096;
};

std::vector<Way> ways() {
  std::vector<Way> all;
  for (const char* method : {"auto", "direct", "conformal"}) all.push_back({method, parameters_for(method)});
  all.push_back({"conformal, elements", parameters_for("conformal")});
  all.back().parameters.locate = LocatorKind::elements;
  all.push_back({"conformal, first hit", parameters_for("conformal")});
  all.back().parameters.locate = LocatorKind::first_hit;
  all.back().parameters.place = PlaceKind::vertex;
  all.back().parameters.locator.curve.leaves_per_sample = 64;
  all.push_back({"direct at vertices", parameters_for("direct")});
  all.back().parameters.place = PlaceKind::vertex;
  all.back().parameters.elements.elements_per_sample = 64;
  for (const char* method : {"auto", "direct"}) {
    all.push_back({"spaced", parameters_for(method)});
    all.back().parameters.sequence = SequenceKind::spaced;
  }
  for (const char* method : {"auto", "direct"}) {
    all.push_back({"in regions", parameters_for(method), 200000});
    REQUIRE(places_in_regions([&] {
      all.back().parameters.samples = 200000;
      return all.back().parameters;
    }()));
  }
  return all;
}

}  // namespace

TEST_CASE("make_texture_density: masses are the integral of the image luminance") {
  const double dark = 0.02;
  CHECK(integral(half_and_half()) == Approx((1 + dark) / 2).epsilon(1e-12));
  CHECK(integral(half_and_half(), texture_parameters(DensityKind::texture_inverse)) ==
        Approx((1 + dark) / 2).epsilon(1e-12));
  DensityParameters shaped = texture_parameters();
  shaped.floor = 0.25;
  shaped.exponent = 2;
  const PolygonMesh gray = textured_square(1, 1, [](std::uint32_t, std::uint32_t) { return 128; });
  const double light = linear_light(128 / 255.0);
  CHECK(integral(gray, shaped) == Approx(0.25 + 0.75 * light * light).epsilon(1e-6));
  shaped.kind = DensityKind::texture_inverse;
  CHECK(integral(gray, shaped) == Approx(0.25 + 0.75 * (1 - light) * (1 - light)).epsilon(1e-6));
  // Green is bright, blue is dark (Rec. 709), and the factor of a material counts.
  PolygonMesh tinted = textured_square(1, 1, [](std::uint32_t, std::uint32_t) { return 255; });
  tinted.colors.face = {0, 1, 0, 0, 0, 1};
  CHECK(integral(tinted) == Approx(0.02 + 0.98 * (0.7152 + 0.0722) / 2).epsilon(1e-6));
}

TEST_CASE(
    "make_texture_density: a ramp between pixels is followed, and details finer than pieces are averaged") {
  PolygonMesh ramp = textured_square(2, 1, [](std::uint32_t x, std::uint32_t) { return x == 0 ? 0 : 255; });
  auto bilinear = std::make_shared<SurfaceTextures>(*ramp.colors.textures);
  bilinear->textures[0].nearest = false;
  ramp.colors.textures = bilinear;
  ramp.colors.linear = true;
  // Black up to 1/4, white from 3/4, in linear light between them.
  CHECK(integral(ramp) == Approx(0.51).epsilon(1e-6));
  const PreparedMesh mesh = prepare_mesh(ramp);
  const Density density = make_texture_density(ramp, mesh, texture_parameters());
  const TriangleSource source = source_of(mesh, density, 0);
  double worst = 0;
  for (double b1 = 0.05; b1 < 0.9; b1 += 0.1)
    for (double b2 = 0.02; b1 + b2 < 1; b2 += 0.1) {
      const Vector3 at = mesh.center + mesh.unit * source.at(b1, b2);
      const double expected = 0.02 + 0.98 * std::clamp(2 * at.x - 0.5, 0.0, 1.0);
      worst = std::max(worst, std::abs(source.density_at(b1, b2) - expected));
    }
  CHECK(worst < 0.3);  // pieces are a quarter of a pixel
  CHECK(integral(textured_square(2048, 2048, [](std::uint32_t x, std::uint32_t y) {
          return (x + y) % 2 == 0 ? 0 : 255;
        })) == Approx(0.51).margin(0.02));
}

TEST_CASE("make_texture_density: means equal those of their halves, and the number of pieces is bounded") {
  for (const std::uint32_t size : {1u, 16u, 300u, 2048u}) {
    const PolygonMesh file = textured_square(size, size, [](std::uint32_t x, std::uint32_t y) {
      return static_cast<int>((x * 7 + y * 13) % 256);
    });
    const Density density = density_of(file);
    REQUIRE(density.in_pieces());
    CHECK(density.piece_mean.size() <= 2 * (most_density_pieces + 2));
    CHECK(static_cast<double>(density.piece_mean.size() * sizeof(double) +
                              density.piece_begin.size() * sizeof(std::size_t)) <= piece_density_bytes(2));
    for (std::size_t t = 0; t < 2; ++t) {
      const double* const mean = density.piece_mean.data() + density.piece_begin[t];
      const std::size_t held = density.piece_begin[t + 1] - density.piece_begin[t];
      for (std::size_t path = 1; 2 * path < held; ++path)
        REQUIRE(mean[path] == Approx((mean[2 * path] + mean[2 * path + 1]) / 2).epsilon(1e-14));
    }
  }
}

TEST_CASE("make_texture_density: parts without a texture have density 1") {
  PolygonMesh file = half_and_half();
  const auto with = [&](const std::function<void(SurfaceTextures&)>& change) {
    auto textures = std::make_shared<SurfaceTextures>(*half_and_half().colors.textures);
    change(*textures);
    file.colors.textures = textures;
  };
  with([](SurfaceTextures& textures) { textures.images[0].rgb.clear(); });
  CHECK(density_of(file).uniform());
  with([](SurfaceTextures& textures) { textures.textures[0].image = no_index; });
  CHECK(density_of(file).uniform());
  with([](SurfaceTextures& textures) { textures.corner.assign(6, no_index); });
  CHECK(density_of(file).uniform());
  with([](SurfaceTextures& textures) { textures.coordinates[4] = std::numeric_limits<float>::quiet_NaN(); });
  CHECK(density_of(file).uniform());
  file.colors.textures = nullptr;
  CHECK(density_of(file).uniform());
  for (const bool linear : {false, true}) {  // looked up out of the range of double
    with([](SurfaceTextures& textures) {
      textures.coordinates.assign(8, 1e30f);
      textures.textures[0].placement = {1e300, 0, 0, 0, 1e300, 0};
    });
    file.colors.linear = linear;
    CHECK(integral(file) == Approx(1).epsilon(1e-12));
  }
  file.colors.linear = false;
  with([](SurfaceTextures& textures) { textures.face[1] = no_index; });
  CHECK(integral(file) == Approx(0.5 + (0.25 * 3 / 2 * 1 + 0.25 / 2 * 0.02)).epsilon(1e-12));
}

TEST_CASE("texture density: every way of sampling gives each part its share of the integral",
          "[statistics]") {
  for (const Way& way : ways()) {
    INFO(way.name);
    // Squares of 1/8, as a chessboard inside the two triangles; the darker ones have 1/51 of the lighter
    // ones.
    const PolygonMesh board =
        textured_square(8, 8, [](std::uint32_t x, std::uint32_t y) { return (x + y) % 2 == 0 ? 255 : 0; });
    const Model model = sampled_model(board, way.parameters, way.samples);
    const Samples& samples = model.row.samples;
    REQUIRE(samples.count() == way.samples);
    CHECK(model.row.report.measure == Approx(0.51).epsilon(1e-9));
    std::array<double, 64> found{};
    double inverse = 0, light = 0;
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < samples.count(); ++i) {
      const double x = model.row.report.loc[0] +
                       model.row.report.scale * static_cast<double>(samples.points[3 * i]),
                   y = model.row.report.loc[1] +
                       model.row.report.scale * static_cast<double>(samples.points[3 * i + 1]);
      const auto column = static_cast<std::size_t>(std::clamp(x * 8, 0.0, 7.0)),
                 row = static_cast<std::size_t>(std::clamp(y * 8, 0.0, 7.0));
      ++found[8 * row + column];
      const bool bright = (row + column) % 2 == 0;
      light += bright ? 1 : 0;
      wrong += std::abs(static_cast<double>(samples.density[i]) - (bright ? 1.0 : 0.02)) > 1e-6;
      inverse += 1 / static_cast<double>(samples.density[i]);
    }
    const double n = way.samples;
    CHECK(static_cast<double>(wrong) <= 0.001 * n);  // at the edges of squares points are rounded
    const double bright = 1 / 1.02;
    if (way.parameters.sequence == SequenceKind::spaced) {
      // Samples that keep their distance from brighter places beside them: at jumps of the density dark
      // places get more than their share, those of faces as much as those of images.
      CHECK(light > 0.9 * n);
      continue;
    }
    // Shares within the noise of independent samples, five standard deviations; weights give the area back.
    CHECK(std::abs(light - bright * n) < 5 * std::sqrt(n * bright * (1 - bright)));
    const double deviation = std::sqrt((1 - bright) * bright) * 49;
    CHECK(std::abs(model.row.report.measure * inverse / n - 1) < 5 * 0.51 * deviation / std::sqrt(n));
    for (std::size_t k = 0; k < 64; ++k) {
      const double expected = n / 32 / 1.02 * ((k / 8 + k % 8) % 2 == 0 ? 1 : 0.02);
      CHECK(std::abs(found[k] - expected) < 5 * std::sqrt(expected + 1));
    }
  }
}

TEST_CASE("texture density: masses of elements and cells sum to those of triangles") {
  const PolygonMesh file = textured_square(
      64, 64, [](std::uint32_t x, std::uint32_t y) { return static_cast<int>((x * x + 31 * y) % 256); });
  for (const char* method : {"auto", "direct"}) {
    const Model model = sampled_model(file, parameters_for(method), 1000);
    std::vector<double> sum(2, 0.0);
    if (const auto* const elements = std::get_if<CurveElements>(&model.order)) {
      for (std::size_t i = 0; i < elements->count(); ++i)
        sum[elements->triangle[i]] += elements->cumulative[i + 1] - elements->cumulative[i];
    } else {
      const auto& cells = std::get<ElementCells>(model.order);
      for (const Cell& cell : cells.cells.cell)
        for (const CellEntry& entry : cells.cells.entries(cell))
          sum[cells.triangle[entry.element()]] += cells.cells.mass(entry);
    }
    for (std::size_t t = 0; t < 2; ++t) CHECK(sum[t] == Approx(model.measure.masses[t]).epsilon(1e-9));
  }
}

TEST_CASE("part_by_mass: parts are chosen in proportion to their mass") {
  const PolygonMesh file = half_and_half();
  const PreparedMesh mesh = prepare_mesh(file);
  const Density density = make_texture_density(file, mesh, texture_parameters());
  const TriangleSource source = source_of(mesh, density, 0);
  const double whole = source.mean_of(1);
  std::vector<double> chosen(std::size_t{2} << source.piece_bisections);
  constexpr int count = 100000;
  for (int i = 0; i < count; ++i) {
    const WorkPiece part = part_by_mass(source, 1, (i + 0.5) / count);
    REQUIRE(part.path >= 1u << source.piece_bisections);
    const auto [b1, b2] = centroid(part.weights);
    REQUIRE(source.piece_at(b1, b2) == part.path);
    chosen[part.path] += 1.0 / count;
  }
  const double pieces = std::ldexp(1.0, source.piece_bisections);
  for (std::uint32_t path = 1u << source.piece_bisections; path < chosen.size(); ++path)
    REQUIRE(chosen[path] == Approx(source.mean_of(path) / whole / pieces).margin(2.0 / count));
}

TEST_CASE("validate: texture densities need colors, and exclude tensors") {
  SampleParameters parameters = parameters_for("anisotropic");
  parameters.density.kind = DensityKind::texture;
  const std::vector<std::string> problems = validate(parameters);
  REQUIRE(problems.size() == 2);
  CHECK(problems[0] == "the density `texture` is read from the images of models: set colors");
  CHECK(problems[1].find("anisotropic") != std::string::npos);
}
