#include "support/test_meshes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace meander::test {

namespace {

void add_vertex(PolygonMesh& mesh, double x, double y, double z) {
  mesh.x.push_back(x);
  mesh.y.push_back(y);
  mesh.z.push_back(z);
}

void add_face(PolygonMesh& mesh, std::initializer_list<std::uint32_t> corners) {
  if (mesh.polygon_begin.empty()) mesh.polygon_begin.push_back(0);
  mesh.corners.insert(mesh.corners.end(), corners);
  mesh.polygon_begin.push_back(static_cast<std::uint32_t>(mesh.corners.size()));
}

}  // namespace

PolygonMesh polygon_mesh(std::vector<double> xyz, std::vector<std::vector<std::uint32_t>> faces) {
  PolygonMesh mesh;
  for (std::size_t i = 0; i + 2 < xyz.size(); i += 3) add_vertex(mesh, xyz[i], xyz[i + 1], xyz[i + 2]);
  mesh.polygon_begin.push_back(0);
  for (const auto& face : faces) {
    mesh.corners.insert(mesh.corners.end(), face.begin(), face.end());
    mesh.polygon_begin.push_back(static_cast<std::uint32_t>(mesh.corners.size()));
  }
  return mesh;
}

PolygonMesh tetrahedron() {
  return polygon_mesh({1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1},
                      {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}});
}

PolygonMesh cube() {
  return polygon_mesh({-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1},
                      {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}});
}

PolygonMesh icosphere(int subdivisions, double radius) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  PolygonMesh mesh =
      polygon_mesh({-1, g,  0,  1, g, 0,  -1, -g, 0,  1, -g, 0, 0,  -1, g,  0,  1, g,
                    0,  -1, -g, 0, 1, -g, g,  0,  -1, g, 0,  1, -g, 0,  -1, -g, 0, 1},
                   {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}});
  for (int s = 0; s < subdivisions; ++s) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middle;
    const auto midpoint = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, inserted] =
          middle.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.x.size()));
      if (inserted)
        add_vertex(mesh, 0.5 * (mesh.x[a] + mesh.x[b]), 0.5 * (mesh.y[a] + mesh.y[b]),
                   0.5 * (mesh.z[a] + mesh.z[b]));
      return at->second;
    };
    const std::vector<std::uint32_t> old = std::move(mesh.corners);
    mesh.corners.clear();
    mesh.polygon_begin.clear();
    for (std::size_t t = 0; t < old.size(); t += 3) {
      const std::uint32_t a = old[t], b = old[t + 1], c = old[t + 2];
      const std::uint32_t ab = midpoint(a, b), bc = midpoint(b, c), ca = midpoint(c, a);
      add_face(mesh, {a, ab, ca});
      add_face(mesh, {b, bc, ab});
      add_face(mesh, {c, ca, bc});
      add_face(mesh, {ab, bc, ca});
    }
  }
  for (std::size_t i = 0; i < mesh.x.size(); ++i) {
    const double scale = radius / std::hypot(mesh.x[i], mesh.y[i], mesh.z[i]);
    mesh.x[i] *= scale;
    mesh.y[i] *= scale;
    mesh.z[i] *= scale;
  }
  return mesh;
}

PolygonMesh torus(std::uint32_t around, std::uint32_t across, double major, double minor) {
  PolygonMesh mesh;
  const double turn = 2 * std::numbers::pi;
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < across; ++j) {
      const double s = turn * i / around, t = turn * j / across;
      const double r = major + minor * std::cos(t);
      add_vertex(mesh, r * std::cos(s), r * std::sin(s), minor * std::sin(t));
    }
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return i % around * across + j % across; };
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < across; ++j) {
      add_face(mesh, {at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      add_face(mesh, {at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

PolygonMesh grid_plane(std::uint32_t nx, std::uint32_t ny, double width, double height) {
  PolygonMesh mesh;
  for (std::uint32_t j = 0; j <= ny; ++j)
    for (std::uint32_t i = 0; i <= nx; ++i) add_vertex(mesh, width * i / nx, height * j / ny, 0);
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return j * (nx + 1) + i; };
  for (std::uint32_t j = 0; j < ny; ++j)
    for (std::uint32_t i = 0; i < nx; ++i) {
      add_face(mesh, {at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      add_face(mesh, {at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

PolygonMesh moebius_strip(std::uint32_t around) {
  PolygonMesh mesh;
  for (std::uint32_t i = 0; i < around; ++i) {
    const double s = 2 * std::numbers::pi * i / around;
    for (const double w : {-0.3, 0.3}) {
      const double r = 1 + w * std::cos(s / 2);
      add_vertex(mesh, r * std::cos(s), r * std::sin(s), w * std::sin(s / 2));
    }
  }
  for (std::uint32_t i = 0; i < around; ++i) {
    const std::uint32_t a = 2 * i, b = 2 * i + 1;
    // After one turn the two sides have changed places.
    const std::uint32_t c = i + 1 == around ? 1 : 2 * i + 2, d = i + 1 == around ? 0 : 2 * i + 3;
    add_face(mesh, {a, c, d});
    add_face(mesh, {a, d, b});
  }
  return mesh;
}

PolygonMesh two_sided_plate(std::uint32_t n, double thickness) {
  PolygonMesh mesh;
  for (const double z : {0.0, thickness})
    for (std::uint32_t j = 0; j <= n; ++j)
      for (std::uint32_t i = 0; i <= n; ++i)
        add_vertex(mesh, static_cast<double>(i) / n, static_cast<double>(j) / n, z);
  const std::uint32_t layer = (n + 1) * (n + 1);
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return j * (n + 1) + i; };
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      add_face(mesh, {a, c, b});
      add_face(mesh, {a, d, c});
      add_face(mesh, {layer + a, layer + b, layer + c});
      add_face(mesh, {layer + a, layer + c, layer + d});
    }
  const auto wall = [&](std::uint32_t a, std::uint32_t b) {  // a -> b runs counter-clockwise round the plate
    add_face(mesh, {a, b, layer + b});
    add_face(mesh, {a, layer + b, layer + a});
  };
  for (std::uint32_t i = 0; i < n; ++i) {
    wall(at(i, 0), at(i + 1, 0));
    wall(at(n, i), at(n, i + 1));
    wall(at(n - i, n), at(n - i - 1, n));
    wall(at(0, n - i), at(0, n - i - 1));
  }
  return mesh;
}

PolygonMesh folded_sheet(std::uint32_t folds, std::uint32_t n, double gap) {
  PolygonMesh mesh = grid_plane(folds * n, n, folds, 1);
  for (std::size_t i = 0; i < mesh.x.size(); ++i) {
    // Layer and place in it from the column, which is exact, not from the rounded coordinate.
    const auto column = static_cast<std::uint32_t>(i % (folds * n + 1));
    const std::uint32_t layer = std::min(column / n, folds - 1);
    const double along = static_cast<double>(column - layer * n) / n;
    mesh.x[i] = layer % 2 == 0 ? along : 1 - along;
    mesh.z[i] = gap * (layer + along);
  }
  return mesh;
}

PolygonMesh merged(const PolygonMesh& a, const PolygonMesh& b) {
  PolygonMesh mesh = a;
  const auto vertices = static_cast<std::uint32_t>(a.x.size());
  const auto corners = static_cast<std::uint32_t>(a.corners.size());
  mesh.x.insert(mesh.x.end(), b.x.begin(), b.x.end());
  mesh.y.insert(mesh.y.end(), b.y.begin(), b.y.end());
  mesh.z.insert(mesh.z.end(), b.z.begin(), b.z.end());
  for (const std::uint32_t corner : b.corners) mesh.corners.push_back(corner + vertices);
  for (std::size_t p = 1; p < b.polygon_begin.size(); ++p)
    mesh.polygon_begin.push_back(b.polygon_begin[p] + corners);
  return mesh;
}

PolygonMesh mesh_with_attributes() {
  PolygonMesh mesh = merged(cube(), tetrahedron());
  mesh.vertex_attributes.push_back({"quality", mesh.x});
  mesh.face_attributes.push_back({"label", std::vector<double>(mesh.polygon_count(), 7)});
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    for (const double value : {mesh.x[v], mesh.y[v], mesh.z[v]})
      mesh.normals.push_back(static_cast<float>(value));
  return mesh;
}

PolygonMesh moved(const PolygonMesh& mesh, double scale, double shift_x, double shift_y, double shift_z) {
  // A rotation about (1, 2, 3) by one radian (Rodrigues).
  const double n = std::sqrt(14.0), kx = 1 / n, ky = 2 / n, kz = 3 / n, c = std::cos(1.0), s = std::sin(1.0);
  PolygonMesh result = mesh;
  for (std::size_t i = 0; i < mesh.x.size(); ++i) {
    const double x = mesh.x[i], y = mesh.y[i], z = mesh.z[i];
    const double along = (kx * x + ky * y + kz * z) * (1 - c);
    result.x[i] = scale * (x * c + (ky * z - kz * y) * s + kx * along) + shift_x;
    result.y[i] = scale * (y * c + (kz * x - kx * z) * s + ky * along) + shift_y;
    result.z[i] = scale * (z * c + (kx * y - ky * x) * s + kz * along) + shift_z;
  }
  return result;
}

PolygonMesh plate_with_holes(std::uint32_t holes) {
  const std::uint32_t cells = 3 * holes;
  std::vector<double> xyz;
  for (std::uint32_t j = 0; j <= cells; ++j)
    for (std::uint32_t i = 0; i <= cells; ++i)
      xyz.insert(xyz.end(), {static_cast<double>(i), static_cast<double>(j), 0.0});
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t j = 0; j < cells; ++j)
    for (std::uint32_t i = 0; i < cells; ++i) {
      const std::uint32_t corner = i + (cells + 1) * j;
      if (i % 3 != 1 || j % 3 != 1)
        faces.push_back({corner, corner + 1, corner + cells + 2, corner + cells + 1});
    }
  return polygon_mesh(xyz, faces);
}

PolygonMesh slab_with_tunnels(std::uint32_t holes) {
  const std::uint32_t nx = 2 * holes + 1, ny = 3;
  std::vector<double> xyz;
  for (std::uint32_t k = 0; k < 2; ++k)
    for (std::uint32_t j = 0; j <= ny; ++j)
      for (std::uint32_t i = 0; i <= nx; ++i) xyz.insert(xyz.end(), {1.0 * i, 1.0 * j, 1.0 * k});
  const auto at = [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
    return (k * (ny + 1) + j) * (nx + 1) + i;
  };
  const auto solid = [&](int i, int j) {
    if (i < 0 || j < 0 || i >= static_cast<int>(nx) || j >= static_cast<int>(ny)) return false;
    return !(i % 2 == 1 && j == 1);
  };
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t j = 0; j < ny; ++j)
    for (std::uint32_t i = 0; i < nx; ++i) {
      const int si = static_cast<int>(i), sj = static_cast<int>(j);
      if (!solid(si, sj)) continue;
      faces.push_back({at(i, j, 1), at(i + 1, j, 1), at(i + 1, j + 1, 1), at(i, j + 1, 1)});
      faces.push_back({at(i, j, 0), at(i, j + 1, 0), at(i + 1, j + 1, 0), at(i + 1, j, 0)});
      if (!solid(si, sj - 1)) faces.push_back({at(i, j, 0), at(i + 1, j, 0), at(i + 1, j, 1), at(i, j, 1)});
      if (!solid(si, sj + 1))
        faces.push_back({at(i + 1, j + 1, 0), at(i, j + 1, 0), at(i, j + 1, 1), at(i + 1, j + 1, 1)});
      if (!solid(si - 1, sj)) faces.push_back({at(i, j + 1, 0), at(i, j, 0), at(i, j, 1), at(i, j + 1, 1)});
      if (!solid(si + 1, sj))
        faces.push_back({at(i + 1, j, 0), at(i + 1, j + 1, 0), at(i + 1, j + 1, 1), at(i + 1, j, 1)});
    }
  return polygon_mesh(std::move(xyz), std::move(faces));
}

PolygonMesh inside_out(PolygonMesh mesh) {
  for (std::size_t f = 0; f < mesh.polygon_count(); ++f)
    std::reverse(mesh.corners.begin() + static_cast<std::ptrdiff_t>(mesh.polygon_begin[f]),
                 mesh.corners.begin() + static_cast<std::ptrdiff_t>(mesh.polygon_begin[f + 1]));
  return mesh;
}

std::vector<std::uint32_t> triangles_of(const PolygonMesh& mesh) {
  std::vector<std::uint32_t> triangles;
  for (std::size_t p = 0; p < mesh.polygon_count(); ++p)
    for (std::uint32_t c = mesh.polygon_begin[p] + 1; c + 1 < mesh.polygon_begin[p + 1]; ++c)
      triangles.insert(triangles.end(),
                       {mesh.corners[mesh.polygon_begin[p]], mesh.corners[c], mesh.corners[c + 1]});
  return triangles;
}

}  // namespace meander::test
