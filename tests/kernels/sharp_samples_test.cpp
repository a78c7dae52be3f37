#include "kernels/sample/sharp_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "kernels/mesh/prepare_mesh.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

// A row with samples at the first corners of triangles, in a frame of its own.
Row placed_row(const PreparedMesh& mesh, std::uint32_t count) {
  Row row;
  row.report.status = Status::ok;
  row.report.loc = {0.5, 0, -1};
  row.report.scale = 2;
  for (std::uint32_t i = 0; i < count; ++i) {
    row.samples.triangle.push_back(i % static_cast<std::uint32_t>(mesh.triangle_count()));
    for (std::uint32_t k = 0; k < 3; ++k) {
      row.samples.points.push_back(static_cast<float>(3 * i + k));
      row.samples.normals.push_back(k == 2 ? 1 : 0);
    }
  }
  return row;
}

Row with_sharp_samples(const PolygonMesh& file, const SharpParameters& parameters,
                       OrderKind order = OrderKind::progressive, std::uint64_t seed = 1) {
  const PreparedMesh mesh = prepare_mesh(file);
  Row row = placed_row(mesh, 10);
  Notes notes;
  add_sharp_samples(mesh, sharp_edges_of(file, mesh, parameters, notes), parameters, order, 0.25,
                    make_random_key(seed, {}), {}, row);
  row.report.notes = notes.counts;
  row.report.note_text = text_of(notes);
  return row;
}

std::array<double, 3> vector_at(const std::vector<float>& values, std::size_t i) {
  return {double{values[3 * i]}, double{values[3 * i + 1]}, double{values[3 * i + 2]}};
}

// Coordinates of the file.
std::array<double, 3> place_of(const Row& row, std::size_t i) {
  std::array<double, 3> at = vector_at(row.samples.sharp_points, i);
  for (std::size_t k = 0; k < 3; ++k) at[k] = row.report.loc[k] + row.report.scale * at[k];
  return at;
}

}  // namespace

TEST_CASE("add_sharp_samples: each edge of a cube has a twelfth of the points, and so has every prefix") {
  for (const PolygonMesh& mesh : {cube(), merged(cube(), inside_out(cube()))})
    for (const std::uint32_t count : {12u, 96u, 1000u}) {
      SharpParameters parameters;
      parameters.samples = count;
      const Row row = with_sharp_samples(mesh, parameters);
      CHECK(row.report.sharp_edges == 12);
      CHECK(row.report.sharp_length == Approx(24));
      REQUIRE(row.samples.sharp_points.size() == 3 * count);
      for (const std::uint32_t prefix : {count, count / 2, count / 4}) {
        std::map<std::uint32_t, double> on_edge;
        for (std::uint32_t i = 0; i < prefix; ++i) ++on_edge[row.samples.sharp_edge[i]];
        for (std::uint32_t e = 0; e < 12; ++e)
          CHECK(std::abs(on_edge[e] - prefix / 12.0) < (prefix == count ? 1.5 : 2.5));
      }
    }
}

TEST_CASE("add_sharp_samples: points lie on their edges, normals between their faces, tangents along them") {
  // Every second face the other way round: no winding tells which way is out, but the faces of an edge agree.
  PolygonMesh mixed = cube();
  std::reverse(mixed.corners.begin(), mixed.corners.begin() + 4);
  SharpParameters parameters;
  parameters.samples = 500;
  for (const PolygonMesh& mesh : {cube(), mixed}) {
    const Row row = with_sharp_samples(mesh, parameters);
    for (std::size_t i = 0; i < parameters.samples; ++i) {
      const auto at = place_of(row, i), normal = vector_at(row.samples.sharp_normals, i),
                 along = vector_at(row.samples.sharp_tangents, i);
      std::size_t axis = 0;
      while (axis < 2 && std::abs(along[axis]) < 0.5) ++axis;
      for (std::size_t k = 0; k < 3; ++k) {
        const bool is_axis = k == axis;
        CHECK(std::abs(along[k]) == Approx(is_axis ? 1 : 0).margin(1e-6));
        if (!is_axis) CHECK(std::abs(at[k]) == Approx(1).margin(1e-6));
        CHECK(normal[k] == Approx(is_axis ? 0 : at[k] * std::numbers::sqrt2 / 2).margin(1e-6));
      }
    }
  }
}

TEST_CASE("add_sharp_samples: where no edge is sharp the samples stand in, or NaN") {
  SharpParameters parameters;
  parameters.samples = 25;
  const Row row = with_sharp_samples(icosphere(3), parameters);
  CHECK(row.report.sharp_edges == 0);
  CHECK(row.report.sharp_length == 0);
  for (std::size_t i = 0; i < 25; ++i) {
    CHECK(vector_at(row.samples.sharp_points, i) == vector_at(row.samples.points, i % 10));
    CHECK(vector_at(row.samples.sharp_normals, i) == vector_at(row.samples.normals, i % 10));
    const auto along = vector_at(row.samples.sharp_tangents, i);
    CHECK(std::hypot(along[0], along[1], along[2]) == Approx(1).margin(1e-6));
    CHECK(row.samples.sharp_edge[i] == no_sharp_edge);
  }
  parameters.fill = SharpFill::nan;
  const Row empty = with_sharp_samples(icosphere(3), parameters);
  for (const auto* const values :
       {&empty.samples.sharp_points, &empty.samples.sharp_normals, &empty.samples.sharp_tangents}) {
    REQUIRE(values->size() == 75);
    CHECK(std::all_of(values->begin(), values->end(), [](float v) { return std::isnan(v); }));
  }
}

TEST_CASE("add_sharp_samples: borders count where they are asked for, the angle decides, seeds differ") {
  SharpParameters parameters;
  parameters.samples = 40;
  CHECK(with_sharp_samples(grid_plane(3, 2), parameters).report.sharp_edges == 0);
  parameters.borders = true;
  const Row row = with_sharp_samples(grid_plane(3, 2), parameters, OrderKind::curve);
  CHECK(row.report.sharp_edges == 10);
  CHECK(row.report.sharp_length == Approx(4));
  CHECK(std::is_sorted(row.samples.sharp_edge.begin(), row.samples.sharp_edge.end()));
  parameters.angle = 91;
  CHECK(with_sharp_samples(cube(), parameters).report.sharp_edges == 0);
  parameters.angle = 89;
  const Row first = with_sharp_samples(cube(), parameters),
            second = with_sharp_samples(cube(), parameters, OrderKind::progressive, 2);
  CHECK(first.samples.sharp_points != second.samples.sharp_points);
  CHECK(first.samples.sharp_points == with_sharp_samples(cube(), parameters).samples.sharp_points);
}

TEST_CASE("add_sharp_samples: corners come first by option, and others are spread as before") {
  SharpParameters parameters;
  parameters.corners = true;
  const auto is_corner = [](const Row& row, std::size_t i) {
    const auto at = place_of(row, i);
    return std::all_of(at.begin(), at.end(), [](double x) { return std::abs(std::abs(x) - 1) < 1e-6; });
  };
  for (const OrderKind order : {OrderKind::progressive, OrderKind::curve}) {
    parameters.samples = 104;
    const Row row = with_sharp_samples(cube(), parameters, order);
    REQUIRE(row.samples.sharp_points.size() == 312);
    std::set<std::array<double, 3>> corners;
    std::map<std::uint32_t, double> on_edge;
    for (std::size_t i = 0; i < 104; ++i) {
      CHECK(is_corner(row, i) == (i < 8));
      if (i < 8) corners.insert(vector_at(row.samples.sharp_points, i));
      if (i >= 8) ++on_edge[row.samples.sharp_edge[i]];
      const auto normal = vector_at(row.samples.sharp_normals, i);
      CHECK(std::hypot(normal[0], normal[1], normal[2]) == Approx(1).margin(1e-6));
    }
    CHECK(corners.size() == 8);
    for (std::uint32_t e = 0; e < 12; ++e) CHECK(std::abs(on_edge[e] - 8) < 1.5);
    CHECK(with_sharp_samples(cube(), parameters, order).samples.sharp_points == row.samples.sharp_points);
  }
  // Fewer points than corners: each another one.
  parameters.samples = 5;
  const Row few = with_sharp_samples(cube(), parameters);
  std::set<std::array<double, 3>> corners;
  for (std::size_t i = 0; i < 5; ++i) {
    CHECK(is_corner(few, i));
    corners.insert(vector_at(few.samples.sharp_points, i));
  }
  CHECK(corners.size() == 5);
}

TEST_CASE("add_sharp_samples: edges of an attribute of faces, where the model has it") {
  SharpParameters parameters;
  parameters.samples = 30;
  parameters.attribute = "part";
  PolygonMesh sheet = grid_plane(2, 2);
  const ItemReport without = with_sharp_samples(sheet, parameters).report;
  CHECK(without.sharp_edges == 0);
  CHECK(without.notes[static_cast<std::size_t>(Note::feature_ignored)] == 1);
  CHECK(without.note_text.find("the attribute `part`: the faces have none") != std::string::npos);
  sheet.asked_face_attributes.push_back({"part", {0, 0, 0, 0, 1, 1, 1, 1}, true});
  const Row row = with_sharp_samples(sheet, parameters);
  CHECK(row.report.sharp_edges == 2);
  CHECK(row.report.sharp_length == Approx(1));
  for (std::size_t i = 0; i < 30; ++i) {
    CHECK(place_of(row, i)[1] == Approx(0.5).margin(1e-6));
    CHECK(std::abs(vector_at(row.samples.sharp_normals, i)[2]) == Approx(1).margin(1e-6));
  }
  CHECK(row.report.note_text.empty());
  // Faces without a value are one class, those of an attribute of vertices none.
  sheet.asked_face_attributes.back().values.resize(4);
  CHECK(with_sharp_samples(sheet, parameters).report.sharp_edges == 2);
  sheet.asked_attributes.push_back({"part", std::vector<double>(9, 1), true});
  sheet.asked_face_attributes.clear();
  CHECK(with_sharp_samples(sheet, parameters).report.notes == without.notes);
}
