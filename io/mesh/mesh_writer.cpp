#include "io/mesh/mesh_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "io/file/atomic_file.h"
#include "io/mesh/append_numbers.h"

namespace meander {

namespace {

constexpr std::array<const char*, 3> color_properties = {"red", "green", "blue"};
constexpr std::array<const char*, 2> coordinate_properties = {"s", "t"};

// The properties of vertices in a PLY file, without the attributes.
std::vector<std::string> ply_properties(bool colors, bool texcoord) {
  std::vector<std::string> names = {"x", "y", "z"};
  if (colors) names.insert(names.end(), color_properties.begin(), color_properties.end());
  if (texcoord) names.insert(names.end(), coordinate_properties.begin(), coordinate_properties.end());
  return names;
}

class MeshFile {
 public:
  MeshFile(const std::filesystem::path& path, MeshFormat format, const WrittenValues& values)
      : file_(path, FullDisk::stops_run), format_(format), values_(values) {}

  void header(std::size_t vertices, std::size_t faces) {
    const std::string v = std::to_string(vertices), f = std::to_string(faces);
    if (format_ == MeshFormat::off)
      data_ = std::string(values_.rgb.empty() ? "OFF" : "COFF") + "\n" + v + " " + f + " 0\n";
    if (format_ != MeshFormat::ply) return;
    data_ = "ply\nformat binary_little_endian 1.0\nelement vertex " + v +
            "\nproperty double x\nproperty double y\nproperty double z\n";
    const auto property = [&](const char* type, const std::string& name) {
      data_ += std::string("property ") + type + " " + name + "\n";
    };
    for (const char* name : color_properties)
      if (!values_.rgb.empty()) property("uchar", name);
    for (const char* name : coordinate_properties)
      if (!values_.texcoord.empty()) property("float", name);
    for (const WrittenValues::Attribute& attribute : values_.attributes)
      property(attribute.integers ? "int" : "float", attribute.name);
    data_ += "element face " + f + "\nproperty list uchar uint vertex_indices\nend_header\n";
  }

  void vertex(std::size_t v, const std::array<double, 3>& at) {
    const bool colors = !values_.rgb.empty();
    if (format_ == MeshFormat::obj) data_ += "v ";
    const bool more = colors && format_ != MeshFormat::ply;
    for (std::size_t k = 0; k < 3; ++k) number(at[k], k < 2 || more ? ' ' : '\n');
    for (std::size_t k = 0; colors && k < 3; ++k) {
      const std::uint8_t value = values_.rgb[3 * v + k];
      if (format_ == MeshFormat::ply)
        number(value, ' ');
      else
        number(static_cast<float>(value) / 255, k < 2 || format_ == MeshFormat::off ? ' ' : '\n');
    }
    if (more && format_ == MeshFormat::off) data_ += "1\n";
    if (format_ == MeshFormat::ply) {
      for (std::size_t k = 0; k < 2 && !values_.texcoord.empty(); ++k)
        number(values_.texcoord[2 * v + k], ' ');
      for (const WrittenValues::Attribute& attribute : values_.attributes)
        if (attribute.integers)
          number(static_cast<std::int32_t>(attribute.values[v]), ' ');
        else
          number(attribute.values[v], ' ');
    }
    flush_if_full();
  }

  // The texture coordinates of OBJ; vertices without have none.
  void coordinates(std::size_t vertices) {
    if (format_ != MeshFormat::obj || values_.texcoord.empty()) return;
    std::uint32_t count = 0;
    coordinate_.assign(vertices, 0);
    for (std::size_t v = 0; v < vertices; ++v) {
      const float s = values_.texcoord[2 * v], t = values_.texcoord[2 * v + 1];
      if (!std::isfinite(s) || !std::isfinite(t)) continue;
      coordinate_[v] = ++count;
      data_ += "vt ";
      number(s, ' ');
      number(t, '\n');
      flush_if_full();
    }
  }

  void face(std::span<const std::uint32_t> corners) {
    if (format_ == MeshFormat::ply) data_ += '\3';
    if (format_ == MeshFormat::off) data_ += "3 ";
    if (format_ == MeshFormat::obj) data_ += "f ";
    const std::uint32_t first = format_ == MeshFormat::obj ? 1 : 0;
    const bool textured = !coordinate_.empty() && std::all_of(corners.begin(), corners.end(),
                                                              [&](auto v) { return coordinate_[v] > 0; });
    for (std::size_t k = 0; k < 3; ++k) {
      const char behind = k < 2 ? ' ' : '\n';
      number(corners[k] + first, textured ? '/' : behind);
      if (textured) number(coordinate_[corners[k]], behind);
    }
    flush_if_full();
  }

  void commit() {
    file_.append(data_);
    file_.commit();
  }

 private:
  template <class Number>
  void number(Number value, char behind) {
    if (format_ == MeshFormat::ply)
      append_little_endian(data_, value);
    else
      append_decimal(data_, value, behind);
  }

  void flush_if_full() {
    constexpr std::size_t buffer_bytes = std::size_t{1} << 20;
    if (data_.size() < buffer_bytes) return;
    file_.append(data_);
    data_.clear();
  }

  AtomicFile file_;
  const MeshFormat format_;
  const WrittenValues& values_;
  std::vector<std::uint32_t> coordinate_;  // V: numbers of OBJ, 0: none
  std::string data_;
};

void check_values(MeshFormat format, const WrittenValues& values, std::size_t vertices) {
  bool fit = (values.rgb.empty() || values.rgb.size() == 3 * vertices) &&
             (values.texcoord.empty() || values.texcoord.size() == 2 * vertices);
  std::vector<std::string> names;
  for (const WrittenValues::Attribute& attribute : values.attributes) {
    fit = fit && attribute.values.size() == vertices;
    names.push_back(attribute.name);
  }
  if (!fit) throw std::invalid_argument("the values of the vertices of a mesh differ in length");
  if (const std::string problem =
          written_values_problem(format, !values.rgb.empty(), !values.texcoord.empty(), names);
      !problem.empty())
    throw std::invalid_argument(problem);
}

}  // namespace

std::string written_values_problem(MeshFormat format, bool colors, bool texcoord,
                                   std::span<const std::string> attributes) {
  if (format == MeshFormat::off && texcoord) return "OFF files have no texture coordinates: take PLY or OBJ";
  if (format != MeshFormat::ply && !attributes.empty())
    return fmt::format("{} files have no attributes: take PLY", format == MeshFormat::off ? "OFF" : "OBJ");
  std::vector<std::string> names = ply_properties(colors, texcoord);
  for (const std::string& name : attributes) {
    if (name.empty() || name.find_first_of(" \t\r\n\v\f") != std::string::npos)
      return fmt::format("`{}` is no name of a property of PLY, which have no spaces", name);
    if (std::find(names.begin(), names.end(), name) != names.end())
      return fmt::format("the property `{}` of PLY would be there twice", name);
    names.push_back(name);
  }
  return {};
}

void write_mesh(const std::filesystem::path& path, MeshFormat format, std::span<const double> x,
                std::span<const double> y, std::span<const double> z,
                std::span<const std::uint32_t> triangles, const WrittenValues& values) {
  if (format != MeshFormat::ply && format != MeshFormat::off && format != MeshFormat::obj)
    throw std::invalid_argument("meshes are written as PLY, OFF and OBJ");
  if (y.size() != x.size() || z.size() != x.size() || triangles.size() % 3 != 0)
    throw std::invalid_argument("the arrays of a mesh differ in length");
  check_values(format, values, x.size());
  MeshFile file(path, format, values);
  file.header(x.size(), triangles.size() / 3);
  for (std::size_t v = 0; v < x.size(); ++v) file.vertex(v, {x[v], y[v], z[v]});
  file.coordinates(x.size());
  for (std::size_t t = 0; t < triangles.size(); t += 3) file.face(triangles.subspan(t, 3));
  file.commit();
}

}  // namespace meander
