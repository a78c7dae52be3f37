#include "io/mesh/mesh_writer.h"

#include <array>
#include <stdexcept>
#include <string>

#include "io/file/atomic_file.h"
#include "io/mesh/append_numbers.h"

namespace meander {

namespace {

class MeshFile {
 public:
  MeshFile(const std::filesystem::path& path, MeshFormat format) : file_(path), format_(format) {}

  void header(std::size_t vertices, std::size_t faces) {
    const std::string v = std::to_string(vertices), f = std::to_string(faces);
    if (format_ == MeshFormat::off) data_ = "OFF\n" + v + " " + f + " 0\n";
    if (format_ == MeshFormat::ply)
      data_ = "ply\nformat binary_little_endian 1.0\nelement vertex " + v +
              "\nproperty double x\nproperty double y\nproperty double z\nelement face " + f +
              "\nproperty list uchar uint vertex_indices\nend_header\n";
  }

  void vertex(const std::array<double, 3>& at) {
    if (format_ == MeshFormat::obj) data_ += "v ";
    for (std::size_t k = 0; k < 3; ++k) number(at[k], k < 2 ? ' ' : '\n');
    flush_if_full();
  }

  void face(std::span<const std::uint32_t> corners) {
    if (format_ == MeshFormat::ply) data_ += '\3';
    if (format_ == MeshFormat::off) data_ += "3 ";
    if (format_ == MeshFormat::obj) data_ += "f ";
    const std::uint32_t first = format_ == MeshFormat::obj ? 1 : 0;
    for (std::size_t k = 0; k < 3; ++k) number(corners[k] + first, k < 2 ? ' ' : '\n');
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
  std::string data_;
};

}  // namespace

void write_mesh(const std::filesystem::path& path, MeshFormat format, std::span<const double> x,
                std::span<const double> y, std::span<const double> z,
                std::span<const std::uint32_t> triangles) {
  if (format == MeshFormat::stl || format == MeshFormat::gltf)
    throw std::invalid_argument("meshes are not written as STL or glTF");
  if (y.size() != x.size() || z.size() != x.size() || triangles.size() % 3 != 0)
    throw std::invalid_argument("the arrays of a mesh differ in length");
  MeshFile file(path, format);
  file.header(x.size(), triangles.size() / 3);
  for (std::size_t v = 0; v < x.size(); ++v) file.vertex({x[v], y[v], z[v]});
  for (std::size_t t = 0; t < triangles.size(); t += 3) file.face(triangles.subspan(t, 3));
  file.commit();
}

}  // namespace meander
