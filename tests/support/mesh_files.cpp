#include "support/mesh_files.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <stdexcept>
#include <vector>

namespace meander::test {

namespace {

void put(std::string& text, double number, char behind) {
  std::array<char, 32> digits;
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), number);
  text.append(digits.data(), end);
  text += behind;
}

template <class T>
void put_bytes(std::string& data, T value, bool big_endian) {
  std::array<char, sizeof value> bytes;
  std::memcpy(bytes.data(), &value, sizeof value);
  if (big_endian != (std::endian::native == std::endian::big)) std::reverse(bytes.begin(), bytes.end());
  data.append(bytes.data(), bytes.size());
}

std::string number(std::uint64_t value) { return std::to_string(value); }

bool has_vertex_normals(const PolygonMesh& mesh) {
  return mesh.corner_normals.empty() && mesh.normals.size() == 3 * mesh.vertex_count() &&
         !mesh.normals.empty();
}

template <class Action>
void for_each_polygon(const PolygonMesh& mesh, const Action& action) {
  for (std::size_t p = 0; p < mesh.polygon_count(); ++p)
    action(p, std::vector<std::uint32_t>(mesh.corners.begin() + mesh.polygon_begin[p],
                                         mesh.corners.begin() + mesh.polygon_begin[p + 1]));
}

std::string off_text(const PolygonMesh& mesh) {
  const bool normals = has_vertex_normals(mesh);
  std::string text = (normals ? "NOFF\n" : "OFF\n") + number(mesh.vertex_count()) + " " +
                     number(mesh.polygon_count()) + " 0\n";
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    put(text, mesh.x[v], ' ');
    put(text, mesh.y[v], ' ');
    put(text, mesh.z[v], normals ? ' ' : '\n');
    for (std::size_t k = 0; normals && k < 3; ++k)
      put(text, double{mesh.normals[3 * v + k]}, k < 2 ? ' ' : '\n');
  }
  for_each_polygon(mesh, [&](std::size_t, const std::vector<std::uint32_t>& polygon) {
    text += number(polygon.size());
    for (const std::uint32_t corner : polygon) (text += ' ') += number(corner);
    text += "\n";
  });
  return text;
}

std::string off_binary(const PolygonMesh& mesh) {
  const bool normals = has_vertex_normals(mesh);
  std::string data = normals ? "NOFF BINARY\n" : "OFF BINARY\n";
  for (const std::size_t count : {mesh.vertex_count(), mesh.polygon_count(), std::size_t{0}})
    put_bytes(data, static_cast<std::uint32_t>(count), true);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    for (const double value : {mesh.x[v], mesh.y[v], mesh.z[v]})
      put_bytes(data, static_cast<float>(value), true);
    for (std::size_t k = 0; normals && k < 3; ++k) put_bytes(data, mesh.normals[3 * v + k], true);
  }
  for_each_polygon(mesh, [&](std::size_t, const std::vector<std::uint32_t>& polygon) {
    put_bytes(data, static_cast<std::uint32_t>(polygon.size()), true);
    for (const std::uint32_t corner : polygon) put_bytes(data, corner, true);
    put_bytes(data, std::uint32_t{0}, true);
  });
  return data;
}

std::string obj_text(const PolygonMesh& mesh) {
  std::string text;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    text += "v ";
    put(text, mesh.x[v], ' ');
    put(text, mesh.y[v], ' ');
    put(text, mesh.z[v], '\n');
  }
  for (std::size_t n = 0; n + 2 < mesh.normals.size(); n += 3) {
    text += "vn ";
    for (std::size_t k = 0; k < 3; ++k) put(text, double{mesh.normals[n + k]}, k < 2 ? ' ' : '\n');
  }
  for_each_polygon(mesh, [&](std::size_t p, const std::vector<std::uint32_t>& polygon) {
    text += "f";
    for (std::size_t c = 0; c < polygon.size(); ++c) {
      (text += ' ') += number(std::uint64_t{polygon[c]} + 1);
      if (!mesh.corner_normals.empty())
        (text += "//") += number(std::uint64_t{mesh.corner_normals[mesh.polygon_begin[p] + c]} + 1);
      else if (has_vertex_normals(mesh))
        (text += "//") += number(std::uint64_t{polygon[c]} + 1);
    }
    text += "\n";
  });
  return text;
}

// Whether a byte can hold the size of every polygon.
bool has_short_polygons(const PolygonMesh& mesh) {
  for (std::size_t p = 0; p < mesh.polygon_count(); ++p)
    if (mesh.polygon_begin[p + 1] - mesh.polygon_begin[p] > 255) return false;
  return true;
}

std::string ply(const PolygonMesh& mesh, MeshFile kind) {
  const bool ascii = kind == MeshFile::ply_ascii, big_endian = kind == MeshFile::ply_big_endian;
  const bool normals = has_vertex_normals(mesh), short_polygons = has_short_polygons(mesh);
  std::string data = std::string("ply\nformat ") +
                     (ascii        ? "ascii"
                      : big_endian ? "binary_big_endian"
                                   : "binary_little_endian") +
                     " 1.0\nelement vertex " + number(mesh.vertex_count()) +
                     "\nproperty double x\nproperty double y\nproperty double z\n";
  if (normals) data += "property float nx\nproperty float ny\nproperty float nz\n";
  for (const ScalarAttribute& attribute : mesh.vertex_attributes)
    data += "property double " + attribute.name + "\n";
  data += "element face " + number(mesh.polygon_count()) + "\nproperty list " +
          (short_polygons ? "uchar" : "uint") + " int vertex_indices\n";
  for (const ScalarAttribute& attribute : mesh.face_attributes)
    data += "property double " + attribute.name + "\n";
  data += "end_header\n";
  const auto write = [&](auto value) {
    if (ascii)
      put(data, static_cast<double>(value), ' ');
    else
      put_bytes(data, value, big_endian);
  };
  const auto end_row = [&] {
    if (ascii) data.back() = '\n';
  };
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    for (const double value : {mesh.x[v], mesh.y[v], mesh.z[v]}) write(value);
    for (std::size_t k = 0; normals && k < 3; ++k) write(mesh.normals[3 * v + k]);
    for (const ScalarAttribute& attribute : mesh.vertex_attributes) write(attribute.values[v]);
    end_row();
  }
  for_each_polygon(mesh, [&](std::size_t p, const std::vector<std::uint32_t>& polygon) {
    if (short_polygons)
      write(static_cast<std::uint8_t>(polygon.size()));
    else
      write(static_cast<std::uint32_t>(polygon.size()));
    for (const std::uint32_t corner : polygon) write(static_cast<std::int32_t>(corner));
    for (const ScalarAttribute& attribute : mesh.face_attributes) write(attribute.values[p]);
    end_row();
  });
  return data;
}

std::string stl(const PolygonMesh& mesh, bool ascii) {
  std::string data;
  std::uint32_t facets = 0;
  const auto corner = [&](std::uint32_t v) {
    if (ascii) data += "      vertex ";
    for (const double value : {mesh.x.at(v), mesh.y.at(v), mesh.z.at(v)}) {
      if (ascii)
        put(data, value, ' ');
      else
        put_bytes(data, static_cast<float>(value), false);
    }
    if (ascii) data.back() = '\n';
  };
  for_each_polygon(mesh, [&](std::size_t, const std::vector<std::uint32_t>& polygon) {
    for (std::size_t c = 2; c < polygon.size(); ++c) {
      data += ascii ? "  facet normal 0 0 0\n    outer loop\n" : std::string(12, '\0');
      for (const std::uint32_t v : {polygon[0], polygon[c - 1], polygon[c]}) corner(v);
      data += ascii ? "    endloop\n  endfacet\n" : std::string(2, '\0');
      ++facets;
    }
  });
  if (ascii) return "solid mesh\n" + data + "endsolid mesh\n";
  std::string head(80, ' ');
  put_bytes(head, facets, false);
  return head + data;
}

}  // namespace

std::string mesh_bytes(const PolygonMesh& mesh, MeshFile kind) {
  switch (kind) {
    case MeshFile::off:
      return off_text(mesh);
    case MeshFile::off_binary:
      return off_binary(mesh);
    case MeshFile::obj:
      return obj_text(mesh);
    case MeshFile::stl_ascii:
      return stl(mesh, true);
    case MeshFile::stl_binary:
      return stl(mesh, false);
    default:
      return ply(mesh, kind);
  }
}

void write_mesh(const std::filesystem::path& path, const PolygonMesh& mesh, MeshFile kind) {
  write_file(path, mesh_bytes(mesh, kind));
}

void write_mesh(const std::filesystem::path& path, const PolygonMesh& mesh) {
  const std::string extension = path.extension().string();
  if (extension == ".off") return write_mesh(path, mesh, MeshFile::off);
  if (extension == ".obj") return write_mesh(path, mesh, MeshFile::obj);
  if (extension == ".ply") return write_mesh(path, mesh, MeshFile::ply_little_endian);
  if (extension == ".stl") return write_mesh(path, mesh, MeshFile::stl_binary);
  throw std::invalid_argument("no mesh format has the extension " + extension);
}

}  // namespace meander::test
