#include "jobs/laboratory/figures/figure_models.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "kernels/surface/surface.h"

namespace meander {

FigureMesh torus_mesh(std::uint32_t around, std::uint32_t across) {
  FigureMesh mesh;
  mesh.name = "torus";
  std::vector<double> u, v;
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < across; ++j) {
      u.push_back(static_cast<double>(i) / around);
      v.push_back(static_cast<double>(j) / across);
    }
  std::vector<Vector3> positions(u.size());
  make_surface("torus")->positions(u, v, positions);
  for (const Vector3& p : positions) mesh.positions.insert(mesh.positions.end(), {p.x, p.y, p.z});
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < across; ++j) {
      const std::uint32_t next_i = (i + 1) % around, next_j = (j + 1) % across;
      const std::uint32_t a = i * across + j, b = next_i * across + j, c = next_i * across + next_j,
                          d = i * across + next_j;
      mesh.faces.insert(mesh.faces.end(), {a, b, c, a, c, d});
    }
  return mesh;
}

FigureMesh sphere_mesh(std::uint32_t rings) {
  FigureMesh mesh;
  mesh.name = "sphere";
  const std::uint32_t sectors = 2 * rings, south = 1 + (rings - 1) * sectors;
  const auto vertex = [&](std::uint32_t ring, std::uint32_t sector) {
    return ring == 0 ? 0 : ring == rings ? south : 1 + (ring - 1) * sectors + sector % sectors;
  };
  mesh.positions = {0, 0, 1};
  for (std::uint32_t i = 1; i < rings; ++i)
    for (std::uint32_t j = 0; j < sectors; ++j) {
      const double polar = std::numbers::pi * i / rings, around = 2 * std::numbers::pi * j / sectors;
      mesh.positions.insert(mesh.positions.end(), {std::sin(polar) * std::cos(around),
                                                   std::sin(polar) * std::sin(around), std::cos(polar)});
    }
  mesh.positions.insert(mesh.positions.end(), {0, 0, -1});
  for (std::uint32_t i = 0; i < rings; ++i)
    for (std::uint32_t j = 0; j < sectors; ++j) {
      const std::uint32_t a = vertex(i, j), b = vertex(i, j + 1), c = vertex(i + 1, j),
                          d = vertex(i + 1, j + 1);
      if (i > 0) mesh.faces.insert(mesh.faces.end(), {a, c, b});
      if (i + 1 < rings) mesh.faces.insert(mesh.faces.end(), {b, c, d});
    }
  return mesh;
}

namespace {

// A tube around a closed curve that is never vertical. around, across >= 3.
template <class Curve>
FigureMesh tube_mesh(const char* name, std::uint32_t around, std::uint32_t across, double radius,
                     const Curve& curve) {
  FigureMesh mesh;
  mesh.name = name;
  for (std::uint32_t i = 0; i < around; ++i) {
    const double t = 2 * std::numbers::pi * i / around, step = 1e-4;
    const Vector3 centre = curve(t), along = curve(t + step) - curve(t - step);
    const Vector3 side = cross(along, {0, 1, 0}), above = cross(side, along);
    for (std::uint32_t j = 0; j < across; ++j) {
      const double a = 2 * std::numbers::pi * j / across;
      const Vector3 p =
          centre + (radius * std::cos(a) / norm(side)) * side + (radius * std::sin(a) / norm(above)) * above;
      mesh.positions.insert(mesh.positions.end(), {p.x, p.y, p.z});
    }
  }
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < across; ++j) {
      const std::uint32_t next_i = (i + 1) % around, next_j = (j + 1) % across;
      const std::uint32_t a = i * across + j, b = next_i * across + j, c = next_i * across + next_j,
                          d = i * across + next_j;
      mesh.faces.insert(mesh.faces.end(), {a, c, b, a, d, c});
    }
  return mesh;
}

// A square of the given corner and sides, which shares no vertices with others.
void add_square(FigureMesh& mesh, Vector3 corner, Vector3 u, Vector3 v, std::uint32_t side) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size() / 3);
  for (std::uint32_t j = 0; j <= side; ++j)
    for (std::uint32_t i = 0; i <= side; ++i) {
      const Vector3 p = corner + static_cast<double>(i) / side * u + static_cast<double>(j) / side * v;
      mesh.positions.insert(mesh.positions.end(), {p.x, p.y, p.z});
    }
  for (std::uint32_t j = 0; j < side; ++j)
    for (std::uint32_t i = 0; i < side; ++i) {
      const std::uint32_t a = first + j * (side + 1) + i, b = a + 1, c = a + side + 2, d = a + side + 1;
      mesh.faces.insert(mesh.faces.end(), {a, b, c, a, c, d});
    }
}

}  // namespace

FigureMesh knot_mesh(std::uint32_t around, std::uint32_t across) {
  return tube_mesh("knot", around, across, 0.42, [](double t) {
    return Vector3{std::sin(t) + 2 * std::sin(2 * t), -0.9 * std::sin(3 * t),
                   std::cos(t) - 2 * std::cos(2 * t)};
  });
}

FigureMesh eight_mesh(std::uint32_t around, std::uint32_t across) {
  return tube_mesh("eight", around, across, 0.3, [](double t) {
    return Vector3{2 * std::sin(t), 0.45 * std::cos(t), 1.5 * std::sin(t) * std::cos(t)};
  });
}

FigureMesh square_mesh(std::uint32_t side) {
  FigureMesh mesh;
  mesh.name = "unit-square";
  add_square(mesh, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, side);
  return mesh;
}

FigureMesh cube_mesh(std::uint32_t side) {
  FigureMesh mesh;
  mesh.name = "unit-cube";
  const Vector3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  add_square(mesh, {0, 0, 0}, y, x, side);
  add_square(mesh, z, x, y, side);
  add_square(mesh, {0, 0, 0}, x, z, side);
  add_square(mesh, y, z, x, side);
  add_square(mesh, {0, 0, 0}, z, y, side);
  add_square(mesh, x, y, z, side);
  return mesh;
}

}  // namespace meander
