// Sums are gathered at every vertex from the triangles around it, so no two threads add to one number.
#include "kernels/tensor/vertex_tensors.h"

#include "kernels/core/parallel.h"
#include "kernels/mesh/vertex_corners.h"

namespace meander {

namespace {

constexpr std::size_t smoothing_block = 2048;
// Sums of normals shorter than this share of their terms are rounding errors.
constexpr double min_sum = 1e-9;

struct NormalSum {
  Vector3 sum;
  double weight = 0;  // the length of the sum if all normals agreed

  void add(Vector3 v, double w) {
    sum = sum + v;
    weight += w;
  }
  bool known() const { return norm(sum) > min_sum * weight && weight > 0; }
};

NormalSum max_normal(const PreparedMesh& mesh, std::span<const std::uint32_t> corners) {
  NormalSum normal;
  for (const std::uint32_t h : corners) {
    if (!(mesh.area[h / 3] > 0)) continue;
    const Vector3 p = mesh.position(mesh.triangles[h]);
    const Vector3 q = mesh.position(mesh.triangles[next_half_edge(h)]) - p;
    const Vector3 r = mesh.position(mesh.triangles[previous_half_edge(h)]) - p;
    const double scale = dot(q, q) * dot(r, r);
    const Vector3 twice = cross(q, r);
    if (!(scale > 0) || !(norm(twice) > 0)) continue;
    normal.add((1 / scale) * twice, norm(twice) / scale);
  }
  return normal;
}

// The transport of tensors from a neighbor into the frame of a vertex: the double angle that their deviators
// turn by, and the sum of the areas beside the edge.
struct FrameTurn {
  std::uint32_t to, from;
  double cosine, sine, weight;
};

TangentTensor turned(TangentTensor a, const FrameTurn& turn) {
  const double middle = 0.5 * (a.xx + a.yy), half = 0.5 * (a.xx - a.yy);
  const double x = turn.cosine * half - turn.sine * a.xy, y = turn.sine * half + turn.cosine * a.xy;
  return {middle + x, y, middle - x};
}

// The transport() of a tensor as an angle. Both half-edges of an edge turn by the same angle, in opposite
// directions.
FrameTurn turn_between(const TangentFrame& from, const TangentFrame& to) {
  const TangentTensor x = transport(TangentTensor{1, 0, -1}, from, to);
  return {0, 0, 0.5 * (x.xx - x.yy), x.xy, 0};
}

// The turns of all vertices, ascending by `to`.
std::vector<FrameTurn> turns_to_neighbors(const PreparedMesh& mesh, std::span<const TangentFrame> frames,
                                          const CancelToken& cancel) {
  const auto area_at = [&](std::uint32_t h) { return h == no_index ? 0.0 : mesh.area[h / 3]; };
  std::vector<std::uint32_t> begin(mesh.vertex_count() + 1, 0);
  const auto each_edge = [&](const auto& body) {
    for (std::uint32_t h = 0; h < mesh.triangles.size(); ++h) {
      const std::uint32_t other = mesh.opposite[h];
      if (other != no_index && other < h) continue;
      const double weight = area_at(h) + area_at(other);
      if (weight > 0) body(mesh.triangles[h], mesh.triangles[next_half_edge(h)], weight);
    }
  };
  each_edge([&](std::uint32_t a, std::uint32_t b, double) {
    ++begin[a + 1];
    ++begin[b + 1];
  });
  for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
  std::vector<FrameTurn> turns(begin.back());
  cancel.check();
  each_edge([&](std::uint32_t a, std::uint32_t b, double weight) {
    const FrameTurn turn = turn_between(frames[b], frames[a]);
    turns[begin[a]++] = {a, b, turn.cosine, turn.sine, weight};
    turns[begin[b]++] = {b, a, turn.cosine, -turn.sine, weight};
  });
  return turns;
}

}  // namespace

TangentTensor tangent_part(const AmbientTensor& a, const TangentFrame& frame) {
  const auto times = [&](Vector3 v) {
    return Vector3{a.xx * v.x + a.xy * v.y + a.xz * v.z, a.xy * v.x + a.yy * v.y + a.yz * v.z,
                   a.xz * v.x + a.yz * v.y + a.zz * v.z};
  };
  const Vector3 x = times(frame.x), y = times(frame.y);
  return {dot(frame.x, x), dot(frame.y, x), dot(frame.y, y)};
}

std::vector<TangentFrame> vertex_frames(const PreparedMesh& mesh) {
  const VertexCorners around(mesh);
  const std::size_t vertices = mesh.vertex_count();
  std::vector<TangentFrame> frames(vertices);
  std::vector<std::uint8_t> known(vertices, 0);
  const auto set = [&](std::size_t v, Vector3 sum) { frames[v] = frame_of_normal((1 / norm(sum)) * sum); };
  parallel_blocks(vertices, smoothing_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const NormalSum normal = max_normal(mesh, around.of(v));
      if (!normal.known()) continue;
      set(v, normal.sum);
      known[v] = 1;
    }
  });
  const std::vector<std::uint32_t> unknown = fill_from_neighbors<NormalSum>(
      mesh, around, known,
      [&](NormalSum& sum, std::uint32_t, std::uint32_t neighbor) { sum.add(frames[neighbor].normal, 1); },
      [&](const NormalSum& sum, std::uint32_t v) {
        if (sum.known()) set(v, sum.sum);
        return sum.known();
      });
  for (const std::uint32_t v : unknown) frames[v] = frame_of_normal({0, 0, 1});
  return frames;
}

void smooth_tensors(const PreparedMesh& mesh, std::span<const TangentFrame> frames,
                    std::span<TangentTensor> log_spacing, unsigned rounds, const CancelToken& cancel) {
  if (rounds == 0) return;
  const std::vector<FrameTurn> turns = turns_to_neighbors(mesh, frames, cancel);
  std::vector<std::uint32_t> begin(mesh.vertex_count() + 1, 0);
  for (const FrameTurn& turn : turns) ++begin[turn.to + 1];
  for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
  std::vector<TangentTensor> before(log_spacing.size());
  for (unsigned round = 0; round < rounds; ++round) {
    cancel.check();
    std::copy(log_spacing.begin(), log_spacing.end(), before.begin());
    parallel_blocks(before.size(), smoothing_block, [&](std::size_t first, std::size_t last) {
      for (std::size_t v = first; v < last; ++v) {
        TangentTensor sum;
        double weight = 0;
        for (std::uint32_t i = begin[v]; i < begin[v + 1]; ++i) {
          sum = sum + turns[i].weight * turned(before[turns[i].from], turns[i]);
          weight += turns[i].weight;
        }
        if (weight > 0) log_spacing[v] = 0.5 * before[v] + (0.5 / weight) * sum;
      }
    });
  }
}

}  // namespace meander
