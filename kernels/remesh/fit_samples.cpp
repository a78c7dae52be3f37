#include "kernels/remesh/fit_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "kernels/core/nearest_on_triangle.h"
#include "kernels/core/portable_angles.h"
#include "kernels/remesh/delaunay_flips.h"

namespace meander {

namespace {

constexpr int longest_walk = 64;          // from vertex to vertex, to the one nearest to a point
constexpr double worthwhile_flip = 0.98;  // squared distance after over before,
constexpr double nearer_flip = 1e-3;  // and how much nearer in the mean square, over the edge: flat places
                                      // stay Delaunay
constexpr double edge_weight = 0.5;   // of the middle of an edge over the points around it
constexpr int flip_passes = 3, solver_steps = 40;
constexpr double solved = 1e-5;  // residual over that of the start
constexpr std::uint32_t fits_between_checks = 4096;

class Fitter {
 public:
  Fitter(EditedMesh& mesh, std::uint32_t first, std::uint32_t last, std::span<const FitPoint> points,
         const FitParameters& parameters, const CancelToken& cancel)
      : mesh_(mesh),
        first_(first),
        last_(last),
        points_(points),
        parameters_(parameters),
        cancel_(cancel),
        least_(direction_of(parameters.least_angle * std::numbers::pi / 180).cosine),
        start_(mesh.position),
        near_(points.size()),
        place_(points.size()),
        triangle_(points.size()),
        next_(points.size()) {
    for (std::size_t p = 0; p < points.size(); ++p) near_[p] = points[p].vertex;
  }

  double run() {
    find_movable();
    for (std::uint32_t round = 0; round < parameters_.rounds; ++round) {
      locate_all();
      for (int pass = 0; pass < flip_passes && flip_all() > 0; ++pass) continue;
      locate_all();
      move_all();
    }
    return largest_;
  }

 private:
  Vector3 at(std::uint32_t v) const { return mesh_.position[v]; }

  void find_movable() {
    movable_.assign(mesh_.position.size(), 0);
    mean_edge_.assign(mesh_.position.size(), 0);
    for (std::uint32_t v = first_; v < last_; ++v) {
      bool on_line = false;
      double sum = 0, count = 0;
      mesh_.for_neighbors(v, [&](std::uint32_t w, std::uint32_t h) {
        on_line = on_line || mesh_.is_line(h);
        sum += distance(at(v), at(w));
        ++count;
      });
      movable_[v] = !on_line;
      mean_edge_[v] = sum / count;
    }
  }

  TrianglePlace place_on(std::uint32_t t, Vector3 p) const {
    const std::size_t h = 3 * std::size_t{t};
    return nearest_on_triangle(p, at(mesh_.vertex[h]), at(mesh_.vertex[h + 1]), at(mesh_.vertex[h + 2]));
  }

  // From vertex to nearer vertex, then the nearest triangle around it and around its neighbors.
  void locate(std::size_t i) {
    const Vector3 p = points_[i].position;
    const auto squared = [&](std::uint32_t v) { return dot(at(v) - p, at(v) - p); };
    std::uint32_t v = near_[i];
    double nearest = squared(v);
    for (int step = 0; step < longest_walk; ++step) {
      std::uint32_t next = v;
      mesh_.for_neighbors(v, [&](std::uint32_t w, std::uint32_t) {
        if (squared(w) < nearest) {
          nearest = squared(w);
          next = w;
        }
      });
      if (next == v) break;
      v = next;
    }
    near_[i] = v;
    place_[i] = {};
    const auto look = [&](std::uint32_t t) {
      const TrianglePlace place = place_on(t, p);
      if (place.squared < place_[i].squared) {
        place_[i] = place;
        triangle_[i] = t;
      }
    };
    mesh_.for_outgoing(v, [&](std::uint32_t h) { look(h / 3); });
    // Across the edges of the best one, as long as that is nearer.
    for (int step = 0; step < longest_walk; ++step) {
      const std::uint32_t t = triangle_[i];
      for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h)
        if (mesh_.opposite[h] != no_index) look(mesh_.opposite[h] / 3);
      if (triangle_[i] == t) break;
    }
  }

  void locate_all() {
    first_of_.assign(mesh_.triangle_count(), no_index);
    for (std::size_t i = points_.size(); i-- > 0;) {
      if (i % fits_between_checks == 0) cancel_.check();
      locate(i);
      put(static_cast<std::uint32_t>(i), triangle_[i]);
    }
  }

  void put(std::uint32_t point, std::uint32_t t) {
    next_[point] = first_of_[t];
    first_of_[t] = point;
  }

  bool keeps_angles(Vector3 a, Vector3 b, Vector3 c, Vector3 d) const {
    const double after = std::max(least_angle_cosine(d, b, c), least_angle_cosine(c, a, d));
    return after <= least_ || after <= std::max(least_angle_cosine(a, b, c), least_angle_cosine(b, a, d));
  }

  // The squared distance of a place on the mesh from the plane of the nearest of the members, times the area
  // that these stand for.
  double off_surface(Vector3 place) const {
    double nearest = 1e300, off = 0, area = 0;
    for (const std::uint32_t p : members_) {
      const Vector3 d = place - points_[p].position;
      area += points_[p].weight;
      if (dot(d, d) >= nearest) continue;
      nearest = dot(d, d);
      off = dot(d, points_[p].normal);
    }
    return area * off * off;
  }

  bool flip_if_better(std::uint32_t h) {
    const std::uint32_t g = mesh_.opposite[h], t = h / 3, u = g / 3;
    const Vector3 a = at(mesh_.start(h)), b = at(mesh_.end(h)), c = at(mesh_.apex(h)), d = at(mesh_.apex(g));
    if (!keeps_angles(a, b, c, d)) return false;
    members_.clear();
    for (const std::uint32_t of : {t, u})
      for (std::uint32_t p = first_of_[of]; p != no_index; p = next_[p]) members_.push_back(p);
    double before = edge_weight * off_surface(0.5 * (a + b)),
           after = edge_weight * off_surface(0.5 * (c + d));
    double area = 0;
    for (const std::uint32_t p : members_) {
      const Vector3 q = points_[p].position;
      area += points_[p].weight;
      before += points_[p].weight *
                std::min(nearest_on_triangle(q, a, b, c).squared, nearest_on_triangle(q, b, a, d).squared);
      after += points_[p].weight *
               std::min(nearest_on_triangle(q, d, b, c).squared, nearest_on_triangle(q, c, a, d).squared);
    }
    const double enough = nearer_flip * nearer_flip * dot(b - a, b - a) * area;
    if (!(after < worthwhile_flip * before - enough) || !can_flip(mesh_, h)) return false;
    mesh_.flip(h);
    first_of_[t] = first_of_[u] = no_index;
    for (const std::uint32_t p : members_) {
      const TrianglePlace one = place_on(t, points_[p].position), two = place_on(u, points_[p].position);
      put(p, one.squared <= two.squared ? t : u);
    }
    return true;
  }

  std::uint32_t flip_all() {
    std::uint32_t flips = 0;
    for (std::uint32_t h = 0; h < mesh_.vertex.size(); ++h) {
      if (h % fits_between_checks == 0) cancel_.check();
      if (mesh_.exists(h / 3) && !mesh_.is_line(h) && h < mesh_.opposite[h]) flips += flip_if_better(h);
    }
    return flips;
  }

  // One equation a point: the heights of the corners of its triangle, weighted, are its own over the
  // triangle.
  struct Equation {
    std::array<std::uint32_t, 3> vertex;
    std::array<double, 3> factor;
    double height = 0, weight = 0;
  };

  void vertex_normals() {
    normal_.assign(mesh_.position.size(), {});
    for (std::uint32_t t = 0; t < mesh_.triangle_count(); ++t) {
      if (!mesh_.exists(t)) continue;
      for (std::uint32_t k = 0; k < 3; ++k) {
        Vector3& n = normal_[mesh_.vertex[3 * t + k]];
        n = n + mesh_.area_vector(t);
      }
    }
    for (Vector3& n : normal_) {
      const double length = norm(n);
      n = length > 0 ? (1 / length) * n : Vector3{};
    }
  }

  void set_up_equations() {
    equations_.clear();
    diagonal_.assign(mesh_.position.size(), 0);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const std::size_t h = 3 * std::size_t{triangle_[i]};
      const Vector3 area = mesh_.area_vector(triangle_[i]);
      const double length = norm(area);
      if (!(length > 0)) continue;
      const Vector3 n = (1 / length) * area;
      Equation equation;
      const TrianglePlace& place = place_[i];
      const std::array<double, 3> share = {1 - place.weight1 - place.weight2, place.weight1, place.weight2};
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = mesh_.vertex[h + k];
        equation.vertex[k] = v;
        equation.factor[k] = movable_[v] ? share[k] * dot(n, normal_[v]) : 0;
      }
      equation.height = dot(n, points_[i].position - at(mesh_.vertex[h]));
      equation.weight = points_[i].weight;
      equations_.push_back(equation);
      for (std::size_t k = 0; k < 3; ++k)
        diagonal_[equation.vertex[k]] += equation.weight * equation.factor[k] * equation.factor[k];
    }
    for (double& d : diagonal_) d *= parameters_.stiffness;
  }

  // The matrix of the normal equations times x.
  void apply(const std::vector<double>& x, std::vector<double>& y) const {
    for (std::size_t v = 0; v < y.size(); ++v) y[v] = diagonal_[v] * x[v];
    for (const Equation& e : equations_) {
      double sum = 0;
      for (std::size_t k = 0; k < 3; ++k) sum += e.factor[k] * x[e.vertex[k]];
      for (std::size_t k = 0; k < 3; ++k) y[e.vertex[k]] += e.weight * sum * e.factor[k];
    }
  }

  static double product(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
  }

  std::vector<double> solve() const {
    std::vector<double> x(diagonal_.size(), 0), r(x.size(), 0), q(x.size());
    for (const Equation& e : equations_)
      for (std::size_t k = 0; k < 3; ++k) r[e.vertex[k]] += e.weight * e.height * e.factor[k];
    std::vector<double> p = r;
    double rr = product(r, r);
    const double enough = solved * solved * rr;
    for (int step = 0; step < solver_steps && rr > enough; ++step) {
      apply(p, q);
      const double curvature = product(p, q);
      if (!(curvature > 0)) break;
      const double alpha = rr / curvature;
      for (std::size_t i = 0; i < x.size(); ++i) {
        x[i] += alpha * p[i];
        r[i] -= alpha * q[i];
      }
      const double next = product(r, r), beta = next / rr;
      for (std::size_t i = 0; i < x.size(); ++i) p[i] = r[i] + beta * p[i];
      rr = next;
    }
    return x;
  }

  void move_all() {
    vertex_normals();
    set_up_equations();
    const std::vector<double> height = solve();
    largest_ = 0;
    for (std::uint32_t v = first_; v < last_; ++v) {
      if (!movable_[v]) continue;
      Vector3 shift = at(v) + height[v] * normal_[v] - start_[v];
      const double length = norm(shift), most = parameters_.largest_shift * mean_edge_[v];
      if (!std::isfinite(length)) continue;
      if (length > most) shift = (most / length) * shift;
      mesh_.position[v] = start_[v] + shift;
      if (mean_edge_[v] > 0) largest_ = std::max(largest_, norm(shift) / mean_edge_[v]);
    }
  }

  EditedMesh& mesh_;
  const std::uint32_t first_, last_;
  const std::span<const FitPoint> points_;
  const FitParameters& parameters_;
  const CancelToken& cancel_;
  const double least_;  // cosine of FitParameters::least_angle
  const std::vector<Vector3> start_;
  std::vector<std::uint32_t> near_;                       // P: a vertex near each point
  std::vector<TrianglePlace> place_;                      // P: on its triangle
  std::vector<std::uint32_t> triangle_;                   // P: when it was last located
  std::vector<std::uint32_t> next_, first_of_, members_;  // lists of the points of each triangle
  std::vector<std::uint8_t> movable_;
  std::vector<double> mean_edge_, diagonal_;
  std::vector<Vector3> normal_;
  std::vector<Equation> equations_;
  double largest_ = 0;
};

}  // namespace

double fit_samples(EditedMesh& mesh, std::uint32_t first, std::uint32_t last,
                   std::span<const FitPoint> points, const FitParameters& parameters,
                   const CancelToken& cancel) {
  return Fitter(mesh, first, last, points, parameters, cancel).run();
}

}  // namespace meander
