#include "kernels/tensor/tensor_field.h"

#include "kernels/core/parallel.h"
#include "kernels/core/portable_functions.h"
#include "kernels/tensor/tensor_blocks.h"

namespace meander {

TangentFrame frame_of_normal(Vector3 n) {
  // The axis farthest from the normal is never nearly parallel to it.
  const double ax = std::abs(n.x), ay = std::abs(n.y), az = std::abs(n.z);
  const Vector3 axis = ax <= ay && ax <= az ? Vector3{1, 0, 0}
                       : ay <= az           ? Vector3{0, 1, 0}
                                            : Vector3{0, 0, 1};
  TangentFrame frame;
  const Vector3 x = axis - dot(axis, n) * n;
  frame.x = (1 / norm(x)) * x;
  frame.normal = n;
  frame.y = cross(n, frame.x);
  return frame;
}

Vector3 transport(Vector3 v, Vector3 from, Vector3 to) {
  // Rodrigues' formula without angles: R v = c v + k x v + k (k . v) / (1 + c), k = from x to.
  const double c = dot(from, to);
  if (c < -1 + 1e-12) return v - 2 * dot(v, from) * from;
  const Vector3 k = cross(from, to);
  return c * v + cross(k, v) + (dot(k, v) / (1 + c)) * k;
}

TangentTensor transport(TangentTensor tensor, const TangentFrame& from, const TangentFrame& to) {
  const Vector3 x = transport(from.x, from.normal, to.normal);
  // x of `from` lies in the plane of `to` at this angle; the x axis of `to` lies at minus the angle.
  const double cosine = dot(x, to.x), sine = dot(x, to.y), length = std::sqrt(cosine * cosine + sine * sine);
  if (!(length > 0)) return tensor;
  return in_turned_frame(tensor, cosine / length, -sine / length);
}

TangentFrame triangle_frame(const PreparedMesh& mesh, std::uint32_t t) {
  TangentFrame frame;
  if (!(mesh.area[t] > 0)) return frame;
  const Vector3 a = mesh.position(mesh.triangles[3 * t]);
  const Vector3 e = mesh.position(mesh.triangles[3 * t + 1]) - a;
  const Vector3 n = cross(e, mesh.position(mesh.triangles[3 * t + 2]) - a);
  const double edge = norm(e), height = norm(n);
  if (!(edge > 0) || !(height > 0)) return frame;
  frame.x = (1 / edge) * e;
  frame.normal = (1 / height) * n;
  frame.y = cross(frame.normal, frame.x);
  return frame;
}

TangentTensor interpolate(const TensorField& field, std::uint32_t t, const std::array<double, 3>& b) {
  return b[0] * field.corner[3 * t] + b[1] * field.corner[3 * t + 1] + b[2] * field.corner[3 * t + 2];
}

TensorField field_from_vertices(const PreparedMesh& mesh, std::span<const TangentFrame> frames,
                                std::span<const TangentTensor> log_spacing) {
  TensorField field;
  field.corner.resize(mesh.triangles.size());
  parallel_blocks(mesh.triangle_count(), tensor_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      if (!(mesh.area[t] > 0)) continue;
      const TangentFrame frame = triangle_frame(mesh, static_cast<std::uint32_t>(t));
      for (std::size_t h = 3 * t; h < 3 * t + 3; ++h) {
        const std::uint32_t v = mesh.triangles[h];
        field.corner[h] = transport(log_spacing[v], frames[v], frame);
      }
    }
  });
  return field;
}

std::vector<double> tensor_density(const TensorField& field) {
  std::vector<double> density(field.corner.size());
  parallel_blocks(density.size(), tensor_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t h = begin; h < end; ++h) density[h] = portable::exp(-trace(field.corner[h]));
  });
  return density;
}

double normalize_spacings(const PreparedMesh& mesh, TensorField& field) {
  const std::vector<double> density = tensor_density(field);
  std::vector<double> mass(mesh.triangle_count());
  for (std::size_t t = 0; t < mass.size(); ++t)
    mass[t] = mesh.area[t] * (density[3 * t] + density[3 * t + 1] + density[3 * t + 2]) / 3;
  // Spacings times f divide the density by f^2.
  const double squared = blocked_sum(mass) / mesh.total_area;
  const double shift = 0.5 * portable::log(squared);
  for (std::size_t h = 0; h < field.corner.size(); ++h) {
    if (!(mesh.area[h / 3] > 0)) continue;
    field.corner[h].xx += shift;
    field.corner[h].yy += shift;
  }
  return std::sqrt(squared);
}

std::vector<double> metric_edge_lengths(const PreparedMesh& mesh, const TensorField& field) {
  std::vector<double> length(mesh.triangles.size());
  parallel_blocks(mesh.triangle_count(), tensor_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const TangentFrame frame = triangle_frame(mesh, static_cast<std::uint32_t>(t));
      std::array<TangentTensor, 3> metric;
      for (std::size_t k = 0; k < 3; ++k) metric[k] = metric_of(field.corner[3 * t + k]);
      for (std::size_t k = 0; k < 3; ++k) {
        const Vector3 e =
            mesh.position(mesh.triangles[3 * t + (k + 1) % 3]) - mesh.position(mesh.triangles[3 * t + k]);
        if (!(mesh.area[t] > 0)) {
          length[3 * t + k] = norm(e);
          continue;
        }
        const double x = dot(e, frame.x), y = dot(e, frame.y);
        length[3 * t + k] =
            std::sqrt(std::max(0.0, quadratic(0.5 * (metric[k] + metric[(k + 1) % 3]), x, y)));
      }
    }
  });
  // A triangle without area has no tensor of its own: its edges take the length of their other side.
  std::vector<double> both(length.size());
  for (std::size_t h = 0; h < length.size(); ++h) {
    const std::uint32_t o = mesh.opposite[h];
    const bool here = mesh.area[h / 3] > 0, there = o != no_index && mesh.area[o / 3] > 0;
    if (here == there)
      both[h] = o == no_index ? length[h] : 0.5 * (length[h] + length[o]);
    else
      both[h] = here ? length[h] : length[o];
  }
  return both;
}

}  // namespace meander
