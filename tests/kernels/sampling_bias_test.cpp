// Samples are unbiased: over many seeds every part of a surface gets its share of area x density, along the
// seams of the charts as anywhere else.
//
// Three tests that complement each other:
//  - The first sample of the file, over seeds, is an independent draw: Pearson's chi-square is exact, but has
//    only one draw a seed.
//  - Pearson's chi-square over all samples. The counts of a low-discrepancy set vary less than those of
//    independent draws, so a p-value near 1 is what to expect; only gross bias makes it small.
//  - The sharp one: the mean count of every cell over the seeds against n x share, in units of the standard
//    error that the seeds themselves show. The sum of squares of these scores is compared with a scaled
//    chi-square whose first two moments come from the correlations of the cells (Satterthwaite 1946).

#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "kernels/analyse/chi_square.h"
#include "kernels/model/model.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

constexpr std::uint32_t samples_per_seed = 64;
// The cases hold some 70 p-values; a change of the method draws them all anew, and none should fail by
// chance.
constexpr double least_p = 1e-5;

struct BiasModel {
  Model state;
  SampleParameters parameters;
};

BiasModel charted(const PolygonMesh& file, MethodChoice method, bool linear_density,
                  const CoarsenParameters& coarsen = {}) {
  BiasModel model;
  model.state.file = file;
  model.parameters.coarsen = coarsen;
  model.parameters.method = method;
  if (linear_density) {
    model.parameters.density.kind = DensityKind::vertex_attribute;
    model.parameters.density.attribute = "height";
    ScalarAttribute height{"height", {}};
    for (std::size_t v = 0; v < file.x.size(); ++v)
      height.values.push_back(2 + file.x[v] + 0.5 * file.z[v]);  // the shapes lie within 1.4 of the origin
    model.state.file.vertex_attributes.push_back(height);
  }
  model.parameters.samples = samples_per_seed;
  run_stages(charting_stages(model.parameters), model.state);
  return model;
}

const Samples& sample(BiasModel& model, std::uint64_t seed) {
  static const EmbreeDevice device;
  model.state.key = make_random_key(seed, {});
  run_stages(placing_stages(model.parameters, &device), model.state);
  return model.state.row.samples;
}

// Expected shares of the four quarters (midpoint subdivision; 0..2 at the corners in file order, 3 in the
// middle) of every triangle of the file: area x mean density, which is exact for a linear density.
std::vector<double> quarter_shares(const Model& state, bool linear_density) {
  const PolygonMesh& file = state.file;
  std::vector<double> shares;
  for (std::size_t c = 0; c < file.corners.size(); c += 3) {
    const std::uint32_t* v = file.corners.data() + c;
    const auto at = [&](std::uint32_t i) { return Vector3{file.x[i], file.y[i], file.z[i]}; };
    const double quarter = triangle_area(at(v[0]), at(v[1]), at(v[2])) / 4;
    std::array<double, 3> d{1, 1, 1};
    if (linear_density)
      for (std::size_t k = 0; k < 3; ++k) d[k] = file.vertex_attributes[0].values[v[k]];
    const double sum = d[0] + d[1] + d[2];
    for (std::size_t k = 0; k < 3; ++k) shares.push_back(quarter * (d[k] / 2 + sum / 6));
    shares.push_back(quarter * sum / 3);
  }
  const double total = std::accumulate(shares.begin(), shares.end(), 0.0);
  for (double& share : shares) share /= total;
  return shares;
}

std::size_t quarter_of(const PolygonMesh& file, const Samples& samples, std::size_t i) {
  const double b1 = static_cast<double>(samples.barycentric[2 * i]);
  const double b2 = static_cast<double>(samples.barycentric[2 * i + 1]);
  const std::array<double, 3> weight{1 - b1 - b2, b1, b2};
  const std::size_t face = samples.face[i];
  for (std::size_t k = 0; k < 3; ++k) {
    if (!(weight[k] > 0.5)) continue;
    // The corners of a sample may begin at another corner than the face of the file.
    for (std::size_t j = 0; j < 3; ++j)
      if (file.corners[3 * face + j] == samples.corners[3 * i + k]) return 4 * face + j;
  }
  return 4 * face + 3;
}

// Counts by seed and cell, seeds x cells.
struct Counts {
  std::size_t seeds = 0, cells = 0;
  std::vector<std::uint32_t> of_seed;     // all samples
  std::vector<std::uint64_t> all, first;  // over the seeds: all samples, the first sample only
};

Counts count_quarters(BiasModel& model, std::uint64_t seeds) {
  Counts counts;
  counts.seeds = seeds;
  counts.cells = 4 * model.state.file.polygon_count();
  counts.of_seed.assign(counts.seeds * counts.cells, 0);
  counts.all.assign(counts.cells, 0);
  counts.first.assign(counts.cells, 0);
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    const Samples& samples = sample(model, 1 + seed);
    REQUIRE(samples.count() == samples_per_seed);
    for (std::size_t i = 0; i < samples.count(); ++i) {
      const std::size_t cell = quarter_of(model.state.file, samples, i);
      ++counts.of_seed[seed * counts.cells + cell];
      ++counts.all[cell];
      if (i == 0) ++counts.first[cell];
    }
  }
  return counts;
}

// Cells gathered into groups: group_of[cell] < groups.
Counts gathered(const Counts& counts, const std::vector<std::size_t>& group_of, std::size_t groups) {
  Counts result;
  result.seeds = counts.seeds;
  result.cells = groups;
  result.of_seed.assign(result.seeds * groups, 0);
  result.all.assign(groups, 0);
  result.first.assign(groups, 0);
  for (std::size_t c = 0; c < counts.cells; ++c) {
    result.all[group_of[c]] += counts.all[c];
    result.first[group_of[c]] += counts.first[c];
    for (std::size_t s = 0; s < counts.seeds; ++s)
      result.of_seed[s * groups + group_of[c]] += counts.of_seed[s * counts.cells + c];
  }
  return result;
}

std::vector<double> gathered(const std::vector<double>& shares, const std::vector<std::size_t>& group_of,
                             std::size_t groups) {
  std::vector<double> result(groups, 0.0);
  for (std::size_t c = 0; c < shares.size(); ++c) result[group_of[c]] += shares[c];
  return result;
}

// p-value of the sharp test of the head of this file.
double score_p_value(const Counts& counts, const std::vector<double>& shares) {
  const auto seeds = static_cast<double>(counts.seeds);
  // Standardised counts, cell by cell; a cell whose count never varies must have the expected count.
  std::vector<std::vector<double>> columns;
  double sum = 0;
  for (std::size_t c = 0; c < counts.cells; ++c) {
    std::vector<double> column(counts.seeds);
    for (std::size_t s = 0; s < counts.seeds; ++s) column[s] = counts.of_seed[s * counts.cells + c];
    const double mean = std::accumulate(column.begin(), column.end(), 0.0) / seeds;
    double variance = 0;
    for (double& value : column) {
      value -= mean;
      variance += value * value;
    }
    const double expected = samples_per_seed * shares[c];
    // Cells that hardly ever get a sample: the expected variance steadies the measured one.
    variance = std::max(variance / (seeds - 1), 0.25 * expected * std::max(0.0, 1 - expected));
    if (variance == 0) {
      CHECK(mean == Approx(expected));
      continue;
    }
    sum += (mean - expected) * (mean - expected) / (variance / seeds);
    const double scale = 1 / std::sqrt(variance * (seeds - 1));
    for (double& value : column) value *= scale;
    columns.push_back(std::move(column));
  }
  // Trace of the correlation matrix and of its square; the square of a sample correlation is too large by
  // about 1 / seeds.
  const auto cells = static_cast<double>(columns.size());
  double square = 0;
  for (std::size_t a = 0; a < columns.size(); ++a)
    for (std::size_t b = 0; b <= a; ++b) {
      const double r = std::inner_product(columns[a].begin(), columns[a].end(), columns[b].begin(), 0.0);
      square += (a == b ? 1 : 2) * std::max(0.0, a == b ? r * r : r * r - 1 / seeds);
    }
  const double scale = square / cells, degrees = cells * cells / square;
  return chi_square_p_value(sum / scale, degrees);
}

void check_unbiased(const Counts& counts, const std::vector<double>& shares) {
  const double first = chi_square_test(counts.first, shares).p_value;
  const double all = chi_square_test(counts.all, shares).p_value;
  const double score = score_p_value(counts, shares);
  CAPTURE(counts.cells, first, all, score);
  CHECK(first > least_p);
  CHECK(all > least_p);
  CHECK(score > least_p);
}

// By quarter, by triangle, and (with charts) along the seams: the triangles that touch a seam vertex against
// the others, and triangle by triangle in that band.
void check_model(const PolygonMesh& file, MethodChoice method, bool linear_density, std::uint64_t seeds) {
  BiasModel model = charted(file, method, linear_density);
  const Counts quarters = count_quarters(model, seeds);
  const std::vector<double> shares = quarter_shares(model.state, linear_density);
  check_unbiased(quarters, shares);
  std::vector<std::size_t> triangle(quarters.cells);
  for (std::size_t c = 0; c < quarters.cells; ++c) triangle[c] = c / 4;
  const Counts triangles = gathered(quarters, triangle, quarters.cells / 4);
  const std::vector<double> triangle_shares = gathered(shares, triangle, quarters.cells / 4);
  check_unbiased(triangles, triangle_shares);
  if (!method_of(model.parameters).makes_charts) return;

  std::vector<std::uint8_t> on_seam(model.state.surface.vertex_count(), 0);
  for (const FlatChart& chart : model.state.charts)
    for (std::uint32_t h = 0; h < chart.cut.seam.size(); ++h)
      if (chart.cut.seam[h] != 0)
        for (const std::uint32_t corner : {h, next_half_edge(h)})
          on_seam[chart.cut.source_vertex[chart.cut.triangles[corner]]] = 1;
  const PreparedMesh& mesh = model.state.surface;
  std::vector<std::size_t> band(triangles.cells, 0), cell_of_band(triangles.cells, 0);
  std::size_t cells = 1;  // cell 0: the interior
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    bool touches = false;
    for (std::size_t k = 0; k < 3; ++k) touches = touches || on_seam[mesh.triangles[3 * t + k]] != 0;
    if (!touches) continue;
    band[mesh.polygon[t]] = 1;
    cell_of_band[mesh.polygon[t]] = cells++;
  }
  REQUIRE(cells > 1);
  REQUIRE(cells < triangles.cells);
  check_unbiased(gathered(triangles, band, 2), gathered(triangle_shares, band, 2));
  check_unbiased(gathered(triangles, cell_of_band, cells), gathered(triangle_shares, cell_of_band, cells));
}

// Triangles of unequal size and shape, closed, genus 1.
PolygonMesh small_torus() { return moved(torus(11, 6), 1, 0, 0, 0); }

}  // namespace

TEST_CASE("sampling bias: every quarter of every triangle gets its share, 300 seeds", "[statistics]") {
  check_model(small_torus(), MethodChoice::automatic, false, 300);
  check_model(small_torus(), MethodChoice::direct, false, 300);
  check_model(small_torus(), MethodChoice::conformal, false, 300);
}

TEST_CASE("sampling bias: linear density, 300 seeds", "[statistics]") {
  check_model(small_torus(), MethodChoice::automatic, true, 300);
  check_model(small_torus(), MethodChoice::direct, true, 300);
  check_model(small_torus(), MethodChoice::conformal, true, 300);
}

TEST_CASE("sampling bias: over coarse charts, 300 seeds", "[statistics]") {
  for (const bool linear_density : {false, true}) {
    BiasModel model =
        charted(moved(torus(20, 11), 1, 0, 0, 0), MethodChoice::conformal, linear_density, {0.25, 64, 64});
    REQUIRE(!model.state.coarse.empty());
    const Counts quarters = count_quarters(model, 300);
    const std::vector<double> shares = quarter_shares(model.state, linear_density);
    check_unbiased(quarters, shares);
    std::vector<std::size_t> triangle(quarters.cells);
    for (std::size_t c = 0; c < quarters.cells; ++c) triangle[c] = c / 4;
    check_unbiased(gathered(quarters, triangle, quarters.cells / 4),
                   gathered(shares, triangle, quarters.cells / 4));
  }
}

TEST_CASE("sampling bias: the sharp test detects a bias of a tenth") {
  // Expectations 10 % wrong on half of the triangles.
  BiasModel model = charted(small_torus(), MethodChoice::direct, false);
  const Counts quarters = count_quarters(model, 300);
  std::vector<double> shares = quarter_shares(model.state, false);
  for (std::size_t c = 0; c < shares.size(); ++c) shares[c] *= c < shares.size() / 2 ? 1.1 : 0.9;
  std::vector<std::size_t> triangle(quarters.cells);
  for (std::size_t c = 0; c < quarters.cells; ++c) triangle[c] = c / 4;
  CHECK(score_p_value(gathered(quarters, triangle, quarters.cells / 4),
                      gathered(shares, triangle, quarters.cells / 4)) < least_p);
}

TEST_CASE("sampling bias: 2000 seeds", "[slow]") {
  for (const PolygonMesh& file : {small_torus(), icosphere(1), moved(two_sided_plate(4, 0.05), 1, 0, 0, 0)})
    for (const MethodChoice method : {MethodChoice::automatic, MethodChoice::direct, MethodChoice::conformal})
      for (const bool linear_density : {false, true}) {
        CAPTURE(file.polygon_count(), static_cast<int>(method), linear_density);
        check_model(file, method, linear_density, 2000);
      }
}
