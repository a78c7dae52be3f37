#include "kernels/partition/surface_regions.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

#include "kernels/analyse/box_discrepancy.h"
#include "kernels/curve/curve_key.h"
#include "kernels/density/pieces.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/model/model.h"
#include "kernels/partition/bisection_walk.h"
#include "kernels/sample/sample_sites.h"
#include "support/catch.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;

namespace {

const RandomKey test_key = make_random_key(5, {});

// Density x + 2 at every corner (working coordinates lie in [-1, 1]).
Density linear_density(const PreparedMesh& mesh) {
  Density density;
  for (const std::uint32_t v : mesh.triangles) density.corner.push_back(mesh.x[v] + 2);
  return density;
}

ElementParameters parameters_of(ElementOrder order, std::uint64_t samples) {
  ElementParameters parameters;
  parameters.order = order;
  parameters.samples = samples;
  return parameters;
}

// A surface with everything that its elements are made from.
struct Surface {
  PreparedMesh mesh;
  MeshMeasure measure;
  ElementParameters parameters;
  SurfaceRegions regions;
  ElementSource source;

  Surface(const PolygonMesh& file, bool linear, const ElementParameters& wanted)
      : mesh(prepare_mesh(file)),
        measure(measure_of(mesh, linear ? linear_density(mesh) : Density())),
        parameters(wanted),
        regions(build_regions({mesh, measure, test_key}, parameters)),
        source({mesh, measure, test_key}, parameters.order, regions.group) {}

  // Calls take(triangle, path, mass) for the elements of a region, of wide pieces for their parts.
  template <class Take>
  void elements_of(std::size_t region, const Take& take) const {
    if (parameters.order == ElementOrder::balanced) {
      const ElementCells cells = region_cells(regions, source, region);
      REQUIRE(cells.count() == regions.strata(region));
      for (const Cell& cell : cells.cells.cell)
        for (const CellEntry& entry : cells.cells.entries(cell))
          take(cells.triangle[entry.element()], cells.path_of(entry), cells.cells.mass(entry));
    } else {
      const CurveElements elements = region_elements(regions, source, region);
      BisectionWalk walk(mesh, elements);
      for (std::size_t i = 0; i < elements.count(); ++i) {
        const std::size_t parts = parts_of(elements, i);
        const double mass = elements.cumulative[i + 1] - elements.cumulative[i];
        for (std::size_t k = 0; k < parts; ++k) {
          const std::uint32_t path =
              parts == 1 ? elements.path[i]
                         : walk.part_at(i, (static_cast<double>(k) + 0.5) / double(parts)).path;
          take(elements.triangle[i], path, mass / static_cast<double>(parts));
        }
      }
    }
  }

  // 1, or of a wide piece the number of its parts.
  std::size_t parts_of(const CurveElements& elements, std::size_t i) const {
    return elements.place.empty() ? 1 : std::size_t{1} << bisections_of(mesh, elements, i);
  }
};

Model placed(const PolygonMesh& file, SampleParameters parameters, std::uint32_t samples, bool in_regions,
             RandomKey key = test_key) {
  parameters.samples = samples;
  REQUIRE(places_in_regions(parameters));
  Model model;
  model.file = file;
  model.key = key;
  run_stages(charting_stages(parameters), model);
  if (in_regions) {
    run_stages(placing_stages(parameters, nullptr), model);
    return model;
  }
  RepairCounts repairs;
  Notes notes;
  OutputFrame frame = output_frame(model.surface, NormalizeKind::none);
  const ElementParameters elements = element_parameters(parameters);
  const PlaceParameters where = place_parameters(parameters);
  const auto place = [&](const auto& order) {
    return place_samples({{model.surface, model.measure, model.key}, model.file, where}, order, frame,
                         repairs, notes);
  };
  model.row.samples = elements.order == ElementOrder::balanced
                          ? place(build_cells({model.surface, model.measure, model.key}, elements))
                          : place(build_elements({model.surface, model.measure, model.key}, elements));
  return model;
}

// Error over rotated boxes, relative to random points, in the working units of the surface.
double box_error(const Model& model) {
  const PreparedMesh& mesh = model.surface;
  const Samples& samples = model.row.samples;
  std::vector<double> points;
  for (std::size_t i = 0; i < samples.count(); ++i) {
    const std::size_t t = 3 * std::size_t{samples.triangle[i]};
    const double b1 = static_cast<double>(samples.barycentric[2 * i]);
    const double b2 = static_cast<double>(samples.barycentric[2 * i + 1]);
    const Vector3 at = (1 - b1 - b2) * mesh.position(mesh.triangles[t]) +
                       b1 * mesh.position(mesh.triangles[t + 1]) + b2 * mesh.position(mesh.triangles[t + 2]);
    points.insert(points.end(), {at.x, at.y, at.z});
  }
  return box_error_ratio(random_boxes(mesh.x, mesh.y, mesh.z, mesh.triangles, BoxParameters{}), points);
}

}  // namespace

TEST_CASE("build_regions: whole strata, masses of a triangle's elements sum to its mass") {
  constexpr std::uint64_t samples = 150001;
  for (const ElementOrder order : {ElementOrder::balanced, ElementOrder::hilbert})
    for (const bool linear : {false, true}) {
      const Surface surface(torus(16, 9), linear, parameters_of(order, samples));
      const SurfaceRegions& regions = surface.regions;
      REQUIRE(regions.count() == (samples + samples_per_region(surface.parameters) - 1) /
                                     samples_per_region(surface.parameters));
      CHECK(regions.first_stratum.front() == 0);
      CHECK(regions.first_stratum.back() == samples);
      const double total = blocked_sum(surface.measure.masses);
      std::vector<double> sum(surface.mesh.triangle_count(), 0.0);
      for (std::size_t r = 0; r < regions.count(); ++r) {
        CHECK(regions.strata(r) <= samples_per_region(surface.parameters));
        CHECK(regions.strata(r) >= samples / regions.count() / 2);
        double region_mass = 0;
        surface.elements_of(r, [&](std::uint32_t triangle, std::uint32_t, double mass) {
          REQUIRE(mass <= total / (4.0 * samples) * (1 + 1e-9));
          sum[triangle] += mass;
          region_mass += mass;
        });
        const double expected = total * static_cast<double>(regions.strata(r)) / samples;
        REQUIRE(region_mass == Approx(expected).epsilon(1e-9));
      }
      for (std::size_t t = 0; t < sum.size(); ++t)
        REQUIRE(sum[t] == Approx(surface.measure.masses[t]).epsilon(1e-9));
    }
}

TEST_CASE(
    "build_regions: a single region has the elements of the whole surface, except the order of wide pieces") {
  // Pieces of 16 samples, which are wide on the torus where the density is uniform, but not in the needles.
  constexpr std::uint64_t samples = 65536;
  const PolygonMesh round = torus(31, 17), needles = grid_plane(40, 1, 1, 5000);
  for (const auto& [file, linear] : {std::pair{round, true}, {round, false}, {needles, false}}) {
    const Surface surface(file, linear, parameters_of(ElementOrder::hilbert, samples));
    REQUIRE(surface.regions.count() == 1);
    const CurveElements part = region_elements(surface.regions, surface.source, 0);
    const bool wide = !linear && file.x.size() == round.x.size();
    REQUIRE(part.place.empty() == !wide);
    const CurveElements whole = build_elements({surface.mesh, surface.measure, test_key}, surface.parameters);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> in_part, in_whole;
    surface.elements_of(
        0, [&](std::uint32_t triangle, std::uint32_t path, double) { in_part.emplace_back(triangle, path); });
    for (std::size_t i = 0; i < whole.count(); ++i) in_whole.emplace_back(whole.triangle[i], whole.path[i]);
    std::sort(in_part.begin(), in_part.end());
    std::sort(in_whole.begin(), in_whole.end());
    CHECK((in_part == in_whole));
    CHECK(part.total() == Approx(whole.total()).epsilon(1e-12));
    if (wide) {
      CHECK(part.count() < whole.count() / 4);
      continue;
    }
    REQUIRE(part.count() == whole.count());
    if (!linear) continue;  // many of the needles' parts lie on the borders of cells
    // Coarse keys round in float: an element on the border of a cell may lie in the next one.
    std::size_t elsewhere = 0;
    for (std::size_t i = 0; i < part.count(); ++i)
      elsewhere += part.triangle[i] != whole.triangle[i] || part.path[i] != whole.path[i];
    CHECK(elsewhere <= part.count() / 100);
  }
}

TEST_CASE("region_elements: coincident and narrow pieces are cut as on the whole surface") {
  constexpr std::uint64_t samples = 20000;
  const PolygonMesh sheet = torus(24, 12);
  const auto elements_of = [&](const PolygonMesh& file) {
    const Surface surface(file, false, parameters_of(ElementOrder::hilbert, samples));
    REQUIRE(surface.regions.count() == 1);
    return region_elements(surface.regions, surface.source, 0);
  };
  CHECK_FALSE(elements_of(sheet).place.empty());
  CHECK_FALSE(elements_of(merged(sheet, moved(sheet, 1, 5, 0, 0))).place.empty());
  for (const PolygonMesh& doubled : {merged(sheet, sheet), merged(sheet, inside_out(sheet))}) {
    const CurveElements elements = elements_of(doubled);
    CHECK(elements.place.empty());
    CHECK(elements.count() >= 4 * samples);
  }
  // Needles of 40 samples, each of them longer than the strip is wide.
  const CurveElements needles = elements_of(grid_plane(250, 1, 1, 500));
  CHECK(needles.place.empty());
  CHECK(needles.count() >= 4 * samples);
}

TEST_CASE("region_elements: ascend by the whole key of the 3-D Hilbert curve") {
  // Most of the mass, and so most regions, in a small part of the box, whose elements share leading bits.
  const Surface surface(merged(torus(16, 9), moved(icosphere(1), 0.02, 300, 200, 100)), false,
                        parameters_of(ElementOrder::hilbert, 300000));
  REQUIRE(surface.regions.count() > 1);
  for (std::size_t r = 0; r < surface.regions.count(); ++r) {
    const CurveElements elements = region_elements(surface.regions, surface.source, r);
    std::uint64_t before = 0;
    std::size_t descents = 0;
    for (std::size_t i = 0; i < elements.count(); ++i) {
      const Vector3 at = centroid(
          followed(plain_triangle(bisection_corners(surface.mesh, elements.triangle[i])), elements.path[i])
              .corner);
      const auto coordinate = [](double c) { return static_cast<double>(static_cast<float>(c)); };
      const std::uint64_t key = hilbert_key_3d({coordinate(at.x), coordinate(at.y), coordinate(at.z)});
      descents += key < before;
      before = key;
    }
    CHECK(descents == 0);
  }
}

TEST_CASE("build_regions: one triangle, and triangles of very unequal size") {
  PolygonMesh file = merged(tetrahedron(), moved(icosphere(4), 1e-3, 5, 0, 0));
  for (const ElementOrder order : {ElementOrder::balanced, ElementOrder::hilbert}) {
    const Surface surface(file, false, parameters_of(order, 140000));
    std::vector<double> sum(surface.mesh.triangle_count(), 0.0);
    for (std::size_t r = 0; r < surface.regions.count(); ++r)
      surface.elements_of(r,
                          [&](std::uint32_t triangle, std::uint32_t, double mass) { sum[triangle] += mass; });
    for (std::size_t t = 0; t < sum.size(); ++t)
      REQUIRE(sum[t] == Approx(surface.measure.masses[t]).epsilon(1e-6));
  }
}

TEST_CASE("place_samples: a large set in regions has n distinct points, permuted ranks and few far steps") {
  for (const char* method : {"auto", "direct"})
    for (const SequenceKind sequence : {SequenceKind::shifted, SequenceKind::random}) {
      SampleParameters parameters = parameters_for(method);
      parameters.sequence = sequence;
      constexpr std::uint32_t n = 131073;
      const Model model = placed(torus(40, 20), parameters, n, true);
      const Samples& samples = model.row.samples;
      REQUIRE(samples.count() == n);
      std::set<std::tuple<float, float, float>> distinct;
      std::vector<std::array<float, 3>> by_rank(n);
      std::vector<bool> seen(n, false);
      for (std::size_t i = 0; i < n; ++i) {
        const float* p = &samples.points[3 * i];
        distinct.emplace(p[0], p[1], p[2]);
        REQUIRE_FALSE(seen.at(samples.curve_rank[i]));
        seen[samples.curve_rank[i]] = true;
        by_rank[samples.curve_rank[i]] = {p[0], p[1], p[2]};
      }
      CHECK(distinct.size() == n);
      // Along the path neighbors are near each other, but for the few ends of regions.
      const double spacing = std::sqrt(model.row.report.area / n);
      std::size_t far = 0;
      for (std::size_t r = 1; r < n; ++r) {
        double squared = 0;
        for (std::size_t k = 0; k < 3; ++k) {
          const double d = static_cast<double>(by_rank[r][k]) - static_cast<double>(by_rank[r - 1][k]);
          squared += d * d;
        }
        far += std::sqrt(squared) > 10 * spacing;
      }
      CHECK(far < n / 100);
    }
}

TEST_CASE("place_samples: regions over charts keep components together, each with its share of the samples") {
  PolygonMesh file = merged(icosphere(4), moved(torus(30, 15), 0.7, 5, 0, 0));
  constexpr std::uint32_t n = 140000;
  for (const ElementOrder order : {ElementOrder::hilbert, ElementOrder::balanced})
    for (const SequenceKind sequence : {SequenceKind::stratified, SequenceKind::owen}) {
      // Release builds take all pairs.
      if (sanitized && (order == ElementOrder::hilbert) != (sequence == SequenceKind::stratified)) continue;
      SampleParameters parameters = parameters_for("conformal");
      parameters.locate = LocatorKind::elements;
      parameters.curve = order;
      parameters.sequence = sequence;
      parameters.order = OrderKind::curve;
      const Model model = placed(file, parameters, n, true);
      const std::vector<Component>& components = model.surface.components;
      REQUIRE(components.size() == 2);
      CHECK(model.row.report.method == Method::conformal);
      REQUIRE(model.row.samples.count() == n);
      std::array<double, 2> count{};
      std::size_t changes = 0, last = 0;
      for (std::size_t i = 0; i < n; ++i) {
        const std::size_t c = model.row.samples.triangle[i] >= components[1].triangle_begin;
        changes += i > 0 && c != last;
        last = c;
        ++count[c];
      }
      CHECK(changes <= (sequence == SequenceKind::owen ? 3 : 2));
      const double expected = n * components[0].area / (components[0].area + components[1].area);
      CHECK(std::abs(count[0] - expected) <= 8);
    }
}

TEST_CASE("place_samples: a large set in regions is the same for 1, 2 and 8 threads") {
  for (const char* method : {"auto", "direct"}) {
    Samples first;
    for (const std::size_t threads : {1u, 2u, 8u}) {
      const Samples samples = on_threads(
          threads, [&] { return placed(torus(24, 12), parameters_for(method), 200000, true).row.samples; });
      if (threads == 1) first = samples;
      CHECK(samples.points == first.points);
      CHECK(samples.barycentric == first.barycentric);
      CHECK(samples.curve_rank == first.curve_rank);
    }
  }
}

TEST_CASE("samples_at: blocks of sites equal the samples placed as a whole", "[release]") {
  // The second model is so small beside its box that float32 has few places for its points.
  const PolygonMesh small = merged(moved(torus(24, 12), 2e-5, 1, 0, 0), moved(torus(3, 3), 1e-9, -1, 0, 0));
  for (const PolygonMesh& file : {torus(24, 12), small})
    for (const PlaceKind place : {PlaceKind::element, PlaceKind::vertex})
      for (const auto& [method, sequence, normalize] :
           {std::tuple{"auto", SequenceKind::shifted, NormalizeKind::none},
            {"direct", SequenceKind::shifted, NormalizeKind::none},
            {"auto", SequenceKind::owen, NormalizeKind::none},
            {"auto", SequenceKind::shifted, NormalizeKind::pointnet}}) {
        // Release builds take every sequence at curve vertices, too.
        if (sanitized && place == PlaceKind::vertex && sequence != SequenceKind::owen) continue;
        SampleParameters parameters = parameters_for(method);
        parameters.normalize = normalize;
        parameters.sequence = sequence;
        parameters.place = place;
        constexpr std::uint32_t n = 140001;
        const Model whole = placed(file, parameters, n, true);
        parameters.rows_only = true;
        parameters.most_kept_samples = 0;
        const Model model = placed(file, parameters, n, true);
        REQUIRE(model.row.samples.count() == 0);
        REQUIRE(model.sites.count() == n);
        CHECK(model.row.report.status == Status::ok);
        CHECK(model.row.report.repairs.counts == whole.row.report.repairs.counts);
        CHECK(model.row.report.loc == whole.row.report.loc);
        CHECK(model.row.report.scale == whole.row.report.scale);
        parameters.samples = n;
        const Samples& expected = whole.row.samples;
        std::vector<std::array<float, 3>> points;
        for (std::size_t begin = 0, end = 0; begin < n; begin = end) {
          end = std::min<std::size_t>(n, 3 * begin + 1);
          const Samples block = samples_at(model, place_parameters(parameters), begin, end);
          const auto same = [&](const auto& part, const auto& all) {
            const std::size_t width = part.size() / (end - begin);
            return part.size() == width * (end - begin) &&
                   std::equal(part.begin(), part.end(),
                              all.begin() + static_cast<std::ptrdiff_t>(width * begin));
          };
          REQUIRE(same(block.points, expected.points));
          REQUIRE(same(block.normals, expected.normals));
          REQUIRE(same(block.face, expected.face));
          REQUIRE(same(block.corners, expected.corners));
          REQUIRE(same(block.barycentric, expected.barycentric));
          REQUIRE(same(block.curve_rank, expected.curve_rank));
          REQUIRE(same(block.density, expected.density));
          for (std::size_t i = 0; i < end - begin; ++i)
            points.push_back({block.points[3 * i], block.points[3 * i + 1], block.points[3 * i + 2]});
        }
        std::sort(points.begin(), points.end());
        const auto distinct = std::unique(points.begin(), points.end()) - points.begin();
        CHECK(static_cast<std::size_t>(distinct) == n - whole.row.report.repairs[Repair::coincident_points]);
      }
}

TEST_CASE("place_samples: in regions the pointnet frame is that of all samples, for any number of threads") {
  SampleParameters parameters = parameters_for("auto");
  parameters.normalize = NormalizeKind::pointnet;
  parameters.rows_only = true;
  parameters.most_kept_samples = 0;
  const PolygonMesh file = moved(merged(icosphere(2), moved(cube(), 0.2, 3, 0, 0)), 7, 100, -50, 20);
  constexpr std::uint32_t n = 140001;
  const Model model = on_threads(1, [&] { return placed(file, parameters, n, true); });
  parameters.samples = n;
  const Samples samples = samples_at(model, place_parameters(parameters), 0, n);
  Vector3 mean;
  double farthest = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Vector3 point = {samples.points[3 * i], samples.points[3 * i + 1], samples.points[3 * i + 2]};
    mean = mean + 1.0 / n * point;
    farthest = std::max(farthest, norm(point));
  }
  CHECK(norm(mean) < 1e-7);
  CHECK(std::abs(farthest - 1) <= 0x1p-24);
  const Model other = on_threads(3, [&] { return placed(file, parameters, n, true); });
  CHECK(other.row.report.loc == model.row.report.loc);
  CHECK(other.row.report.scale == model.row.report.scale);
}

TEST_CASE("leaves_sites: true for large sets on the surface that no stage needs as a whole") {
  SampleParameters parameters = parameters_for("auto");
  parameters.rows_only = true;
  CHECK_FALSE(leaves_sites(parameters));
  parameters.samples = 1 << 18;
  CHECK_FALSE(leaves_sites(parameters));
  parameters.samples = (1 << 18) + 1;
  CHECK(leaves_sites(parameters));
  const auto with = [&](const auto& change) {
    SampleParameters other = parameters;
    change(other);
    return leaves_sites(other);
  };
  CHECK_FALSE(with([](SampleParameters& p) { p.rows_only = false; }));
  CHECK_FALSE(with([](SampleParameters& p) { p.method = MethodChoice::anisotropic; }));
  CHECK_FALSE(with([](SampleParameters& p) { p.sequence = SequenceKind::spaced; }));
  CHECK_FALSE(with([](SampleParameters& p) { p.curved = true; }));
  CHECK_FALSE(with([](SampleParameters& p) { p.columns[&Samples::rgb] = true; }));
  CHECK_FALSE(with([](SampleParameters& p) { p.columns[&Samples::texcoord] = true; }));
  CHECK_FALSE(with([](SampleParameters& p) { p.attributes = {{"heat", 1}}; }));
  CHECK_FALSE(with([](SampleParameters& p) { p.describe.descriptors = {Descriptor::d2}; }));
  CHECK(with([](SampleParameters& p) { p.method = MethodChoice::conformal; }));
  CHECK(with([](SampleParameters& p) { p.normalize = NormalizeKind::pointnet; }));
}

TEST_CASE("samples_at: values shared by samples of a triangle equal those looked up for each") {
  SampleParameters parameters = parameters_for("direct");
  parameters.rows_only = true;
  parameters.samples = 300000;
  const auto placed_on = [&](const PolygonMesh& file) {
    Model model;
    model.file = file;
    model.key = test_key;
    run_stages(charting_stages(parameters), model);
    run_stages(placing_stages(parameters, nullptr), model);
    return model;
  };
  Model model = placed_on(merged(torus(16, 9), moved(icosphere(2), 0.01, 1e4, -3e5, 7)));
  REQUIRE(model.sites.shared.size() == model.surface.triangle_count());
  for (const std::size_t begin : {0u, 70001u, 299999u}) {
    const std::size_t end = std::min<std::size_t>(begin + 70000, 300000);
    const Samples shared = samples_at(model, place_parameters(parameters), begin, end);
    const std::vector<SharedBySamples> records = std::exchange(model.sites.shared, {});
    const Samples looked_up = samples_at(model, place_parameters(parameters), begin, end);
    model.sites.shared = records;
    CHECK(shared.points == looked_up.points);
    CHECK(shared.normals == looked_up.normals);
    CHECK(shared.face == looked_up.face);
    CHECK(shared.triangle == looked_up.triangle);
    CHECK(shared.corners == looked_up.corners);
    CHECK(shared.barycentric == looked_up.barycentric);
    CHECK(shared.density == looked_up.density);
    CHECK(shared.curve_rank == looked_up.curve_rank);
  }
  // Too many triangles, or normals of the file, which change from sample to sample.
  CHECK(placed_on(icosphere(6)).sites.shared.empty());
  PolygonMesh smooth = icosphere(2);
  for (std::size_t v = 0; v < smooth.vertex_count(); ++v)
    for (const double n : {smooth.x[v], smooth.y[v], smooth.z[v]})
      smooth.normals.push_back(static_cast<float>(n));
  CHECK(placed_on(smooth).sites.shared.empty());
}

TEST_CASE("place_samples: in regions the error over rotated boxes equals that of the whole surface",
          "[slow]") {
  const PolygonMesh file = torus(60, 30);
  for (const char* method : {"auto", "direct"}) {
    double error[2] = {0, 0};
    for (const bool in_regions : {false, true}) {
      double squares = 0;
      for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        const double ratio =
            box_error(placed(file, parameters_for(method), 150000, in_regions, make_random_key(seed, {})));
        squares += ratio * ratio;
      }
      error[in_regions] = std::sqrt(squares / 6);
    }
    INFO(method << ": " << error[0] << " whole, " << error[1] << " in regions");
    CHECK(error[1] <= 1.06 * error[0]);
  }
}

TEST_CASE("sites: large sets of uniform density have the first points of their pieces") {
  constexpr std::uint32_t n = 140001;
  // Triangles whose parts are wide, and needles, whose parts are not.
  for (const PolygonMesh& file : {torus(24, 12), torus(1500, 3)})
    for (const auto& [method, sequence] : {std::pair{"direct", SequenceKind::shifted},
                                           {"direct", SequenceKind::stratified},
                                           {"auto", SequenceKind::owen}}) {
      INFO(file.polygon_count() << " faces, " << method);
      SampleParameters parameters = parameters_for(method);
      parameters.sequence = sequence;
      parameters.rows_only = true;
      parameters.most_kept_samples = 0;
      const Model model = placed(file, parameters, n, true);
      REQUIRE(model.sites.count() == n);
      std::size_t others = 0;  // drawn again, as two fell on one place
      for (std::uint32_t rank = 0; rank < n; ++rank) {
        const SampleSite& site = model.sites.sites.site[rank];
        const Piece piece = piece_of(bisection_corners(model.surface, site.triangle), site.path);
        const auto weights = drawn_point(piece, rank, test_key);
        others += site.b1 != static_cast<float>(weights[0]) || site.b2 != static_cast<float>(weights[1]);
      }
      CHECK(others <= 3);
    }
}
