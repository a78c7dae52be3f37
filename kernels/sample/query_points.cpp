#include "kernels/sample/query_points.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "kernels/core/half.h"
#include "kernels/core/parallel.h"
#include "kernels/core/radix_sort.h"
#include "kernels/core/share_search.h"
#include "kernels/core/spelling.h"
#include "kernels/curve/curve_key.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/mesh/surface_walk.h"
#include "kernels/query/curve_order.h"
#include "kernels/query/nearest_triangle.h"
#include "kernels/query/oriented_surface.h"
#include "kernels/query/triangle_tree.h"
#include "kernels/sample/point_frames.h"
#include "kernels/sample/scrambled_net.h"

namespace meander {

namespace {

constexpr std::size_t query_block = 4096, most_groups = 255;

// ---- text

template <class Number>
bool take_number(std::string_view text, Number& number) {
  const char* const end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && at == end;
}

std::string number_text(double number) {
  std::array<char, 32> text;
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), number);
  return {text.data(), end};
}

std::string take_sizes(std::string_view text, std::vector<double>& sizes) {
  while (true) {
    const std::string_view word = text.substr(0, text.find(','));
    double size = 0;
    if (!take_number(word, size) || !(size > 0 && size <= largest_query_size))
      return "`" + std::string(word) + "` is no size: a number above 0, up to 100";
    sizes.push_back(size);
    if (word.size() == text.size()) return {};
    text.remove_prefix(word.size() + 1);
  }
}

std::string take_term(std::string_view text, QueryTerm& term) {
  const std::string quoted = "`" + std::string(text) + "`: ";
  const std::size_t equals = text.find('=');
  if (equals == text.npos) return quoted + "a term is KIND=COUNT@SIZE,SIZE...";
  if (!take_word(query_kind_words, text.substr(0, equals), term.kind))
    return quoted + none_of(text.substr(0, equals), all_words(query_kind_words));
  text.remove_prefix(equals + 1);
  const std::size_t at = text.find('@');
  const std::string_view count = text.substr(0, at);
  if (!take_number(count, term.count) || term.count < 1 || term.count > most_queries)
    return quoted + "`" + std::string(count) + "` is no number of points, 1 to " +
           std::to_string(most_queries);
  if (at == text.npos) {
    if (term.kind != QueryKind::volume) return quoted + "it needs a size: COUNT@SIZE";
    term.sizes = {1};
    return {};
  }
  if (const std::string problem = take_sizes(text.substr(at + 1), term.sizes); !problem.empty())
    return quoted + problem;
  return term.sizes.size() > term.count ? quoted + "it has fewer points than sizes" : "";
}

// ---- points of a group

// The triangles along the 3-D Hilbert curve with their shares of the area.
class AreaShares {
 public:
  explicit AreaShares(const PreparedMesh& mesh) : mesh_(mesh) {
    std::vector<KeyIndex> keys, scratch;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t)
      if (mesh.area[t] > 0) keys.push_back({hilbert_key_3d(mesh.centroid(t)), t});
    radix_sort(keys, scratch);
    end_.reserve(keys.size());
    double sum = 0;
    for (const KeyIndex& key : keys) {
      triangle_.push_back(key.index);
      end_.push_back(sum += mesh.area[key.index]);
    }
    search_.emplace(end_);
  }
  AreaShares(const AreaShares&) = delete;
  AreaShares& operator=(const AreaShares&) = delete;

  std::uint32_t triangle(double share) const { return triangle_[(*search_)(share)]; }
  Vector3 place(std::uint32_t triangle, double first, double second) const {
    const std::uint32_t* const corner = &mesh_.triangles[3 * std::size_t{triangle}];
    const double root = std::sqrt(first), b1 = 1 - root, b2 = second * root;
    const Vector3 a = mesh_.position(corner[0]);
    return a + b1 * (mesh_.position(corner[1]) - a) + b2 * (mesh_.position(corner[2]) - a);
  }

 private:
  const PreparedMesh& mesh_;
  std::vector<std::uint32_t> triangle_;
  std::vector<double> end_;
  std::optional<ShareSearch> search_;
};

// Which group a point belongs to, and its number there.
struct QueryPlace {
  std::uint32_t group, number;
};

// The group that is the farthest behind is next; of equals the first.
std::vector<QueryPlace> interleaved(const std::vector<QueryGroup>& groups) {
  // When the next point of a group is due: (taken + 1/2) / count. Where these of two groups differ, they do
  // so by 1 / (2 count count) and more, which the roundings of doubles leave.
  static_assert(0.5 / most_queries / most_queries > 0x1p-52);
  std::vector<double> due;
  std::vector<std::uint32_t> taken(groups.size(), 0);
  std::uint64_t count = 0;
  for (const QueryGroup& group : groups) {
    due.push_back(0.5 / group.count);
    count += group.count;
  }
  std::vector<QueryPlace> places;
  places.reserve(count);
  while (places.size() < count) {
    const auto next = static_cast<std::uint32_t>(std::min_element(due.begin(), due.end()) - due.begin());
    places.push_back({next, taken[next]++});
    due[next] = (taken[next] + 0.5) / groups[next].count;
  }
  return places;
}

// The moves of a size, in working units.
class Moves {
 public:
  Moves(const QueryParameters& parameters, double size, double unit)
      : kind_(parameters.move), size_(size * unit), cut_(parameters.cut * unit) {
    if (cut_ > 0) share_ = normal_share(parameters.cut / size);
  }

  // From numbers in (0, 1).
  Vector3 operator()(Vector3 normal, double x, double y, double z) const {
    if (kind_ == QueryMove::uniform) return size_ * Vector3{2 * x - 1, 2 * y - 1, 2 * z - 1};
    if (kind_ == QueryMove::along_normal) return gaussian(x) * normal;
    return {gaussian(x), gaussian(y), gaussian(z)};
  }

 private:
  double gaussian(double u) const {
    if (!(cut_ > 0)) return size_ * normal_quantile(u);
    return std::clamp(size_ * normal_quantile(0.5 + share_ * (u - 0.5)), -cut_, cut_);
  }

  QueryMove kind_;
  double size_, cut_, share_ = 1;
};

// Where sizes are measured from and by, in working units.
struct QueryFrame {
  Vector3 center;
  double unit = 1;
};

QueryFrame query_frame(const PreparedMesh& mesh, const ItemReport& report, bool in_box) {
  if (!in_box)
    return {to_working(mesh, {report.loc[0], report.loc[1], report.loc[2]}), report.scale / mesh.unit};
  const std::array<double, 6>& box = mesh.bbox;
  const double longest = std::max({box[3] - box[0], box[4] - box[1], box[5] - box[2]});
  // Halves first: sums may overflow.
  const Vector3 center = {box[0] / 2 + box[3] / 2, box[1] / 2 + box[4] / 2, box[2] / 2 + box[5] / 2};
  return {to_working(mesh, center), longest / 2 / mesh.unit};
}

// In working units of the surface.
std::vector<double> query_places(const PreparedMesh& surface, const QueryParameters& parameters,
                                 const std::vector<QueryGroup>& groups, const std::vector<QueryPlace>& places,
                                 const SharpEdges& edges, const QueryFrame& frame, RandomKey key,
                                 const CancelToken& cancel) {
  cancel.check();
  const bool has_edges = edges.length() > 0, needs_normals = parameters.move == QueryMove::along_normal;
  std::optional<AreaShares> area;
  if (parameters.has(QueryKind::near) || (parameters.has(QueryKind::near_sharp) && !has_edges))
    area.emplace(surface);
  std::vector<ScrambledNet> nets;
  std::vector<Moves> moves;
  for (std::uint32_t g = 0; g < groups.size(); ++g) {
    nets.emplace_back(key, Stream::query_points, g);
    moves.emplace_back(parameters, groups[g].size, frame.unit);
  }
  // Those on edges are found together.
  std::vector<double> shares;
  std::vector<std::uint32_t> on_edges(has_edges ? places.size() : 0);
  for (std::size_t i = 0; i < on_edges.size(); ++i) {
    if (groups[places[i].group].kind != QueryKind::near_sharp) continue;
    on_edges[i] = static_cast<std::uint32_t>(shares.size());
    shares.push_back(nets[places[i].group].first_four(places[i].number)[0]);
  }
  const EdgePoints at_edges = points_on_edges(surface, edges, shares);
  std::vector<double> points(3 * places.size());
  parallel_blocks(places.size(), query_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    for (std::size_t i = begin; i < end; ++i) {
      const QueryGroup& group = groups[places[i].group];
      const ScrambledNet& net = nets[places[i].group];
      Vector3 at;
      if (group.kind == QueryKind::volume) {
        const auto u = net.first_four(places[i].number);
        at = frame.center + group.size * frame.unit * Vector3{2 * u[0] - 1, 2 * u[1] - 1, 2 * u[2] - 1};
      } else {
        const auto u = net(places[i].number);
        Vector3 normal;
        if (group.kind == QueryKind::near_sharp && has_edges) {
          const double* const from = &at_edges.point[3 * std::size_t{on_edges[i]}];
          at = {from[0], from[1], from[2]};
          if (needs_normals) normal = edge_normal(surface, edges, at_edges.edge[on_edges[i]]);
        } else {
          const std::uint32_t triangle = area->triangle(u[0]);
          at = area->place(triangle, u[1], u[2]);
          if (needs_normals) normal = triangle_normal(surface, triangle);
        }
        at = at + moves[places[i].group](normal, u[3], u[4], u[5]);
      }
      points[3 * i] = at.x;
      points[3 * i + 1] = at.y;
      points[3 * i + 2] = at.z;
    }
  });
  return points;
}

// ---- distances and sides

// The surface without doubled faces and with its topology: the one given, or one of its own.
class QuerySurface {
 public:
  QuerySurface(const PolygonMesh& file, const PreparedMesh& surface, const CancelToken& cancel)
      : file_(&file), mesh_(&surface) {
    PolygonMesh single;
    single.x = file.x;
    single.y = file.y;
    single.z = file.z;
    single.polygon_begin = file.polygon_begin;
    single.corners = file.corners;
    cancel.check();
    if (drop_doubled_faces(single) == 0 && surface.has_topology()) return;
    own_file_ = std::move(single);
    own_ = prepare_mesh(own_file_, cancel);
    file_ = &own_file_;
    mesh_ = &own_;
  }
  QuerySurface(const QuerySurface&) = delete;
  QuerySurface& operator=(const QuerySurface&) = delete;

  const PreparedMesh& mesh() const { return *mesh_; }
  std::uint32_t corner(std::size_t triangle, std::size_t k) const {
    return file_->corners[mesh_->corner_slot[3 * triangle + k]];
  }

 private:
  PolygonMesh own_file_;
  PreparedMesh own_;
  const PolygonMesh* file_;
  const PreparedMesh* mesh_;
};

// Tells the sides of points along a curve.
PointSides sides_of(const PreparedMesh& mesh, const TriangleTree& tree, SignChoice choice,
                    std::span<const double> points, const NearestTriangles& nearest,
                    const CancelToken& cancel) {
  const OrientedSurface oriented = orient_outward(mesh);
  cancel.check();
  const SignRule rule = chosen_rule(choice, mesh, tree, oriented).value_or(SignRule::none);
  cancel.check();
  return point_sides(tree, oriented, rule, points, nearest, cancel);
}

void add_sides(const CurvePoints& along, PointSides sides, Row& row) {
  const std::size_t count = sides.inside.size();
  Samples& samples = row.samples;
  row.report.sign_rule = sides.rule;
  row.report.uncertain = static_cast<std::uint32_t>(sides.rule == SignRule::none ? count : sides.uncertain);
  if (sides.rule == SignRule::none) std::fill(sides.certain.begin(), sides.certain.end(), std::uint8_t{0});
  samples.query_winding.assign(count, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < sides.winding.size(); ++i)
    samples.query_winding[along.order[i]] = static_cast<float>(sides.winding[i]);
  samples.query_inside = along.as_given(sides.inside);
  samples.query_certain = along.as_given(sides.certain);
}

void add_nearest(const QuerySurface& surface, const CurvePoints& along, const NearestTriangles& nearest,
                 Samples& samples) {
  const std::size_t count = nearest.triangle.size();
  samples.query_face.resize(count);
  samples.query_corners.resize(3 * count);
  samples.query_barycentric.resize(2 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t point = along.order[i];
    const std::uint32_t t = nearest.triangle[i];
    samples.query_face[point] = surface.mesh().polygon[t];
    for (std::size_t k = 0; k < 3; ++k) samples.query_corners[3 * point + k] = surface.corner(t, k);
    for (std::size_t k = 0; k < 2; ++k)
      samples.query_barycentric[2 * point + k] = static_cast<float>(nearest.weights[2 * i + k]);
  }
}

}  // namespace

bool QueryParameters::has(QueryKind kind) const {
  return std::any_of(terms.begin(), terms.end(), [&](const QueryTerm& term) { return term.kind == kind; });
}

std::string queries_text(const std::vector<QueryTerm>& terms) {
  std::string text;
  for (const QueryTerm& term : terms) {
    text += (text.empty() ? "" : " ") + std::string(text_of(query_kind_words, term.kind)) + "=" +
            std::to_string(term.count);
    for (std::size_t s = 0; s < term.sizes.size(); ++s)
      text += (s == 0 ? "@" : ",") + number_text(term.sizes[s]);
  }
  return text;
}

std::string take_queries(std::string_view text, std::vector<QueryTerm>& terms) {
  terms.clear();
  while (true) {
    text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
    if (text.empty()) break;
    const std::string_view word = text.substr(0, text.find(' '));
    text.remove_prefix(word.size());
    if (const std::string problem = take_term(word, terms.emplace_back()); !problem.empty()) return problem;
  }
  std::uint64_t count = 0, groups = 0;
  for (const QueryTerm& term : terms) {
    count += term.count;
    groups += term.sizes.size();
  }
  if (count > most_queries)
    return "there are " + std::to_string(count) + " points, at most " + std::to_string(most_queries) +
           " are possible";
  if (groups > most_groups)
    return "there are " + std::to_string(groups) + " sizes, at most " + std::to_string(most_groups) +
           " are possible";
  return {};
}

std::vector<QueryGroup> query_groups(const std::vector<QueryTerm>& terms) {
  std::vector<QueryGroup> groups;
  for (const QueryTerm& term : terms) {
    const auto sizes = static_cast<std::uint32_t>(term.sizes.size());
    for (std::uint32_t s = 0; s < sizes; ++s)
      groups.push_back(
          {term.kind, term.count / sizes + (s < term.count % sizes ? 1 : 0), term.sizes[s],
           std::string(text_of(query_kind_words, term.kind)) + "@" + number_text(term.sizes[s])});
  }
  return groups;
}

std::uint32_t query_count(const std::vector<QueryTerm>& terms) {
  std::uint32_t count = 0;
  for (const QueryTerm& term : terms) count += term.count;
  return count;
}

void add_query_points(const PolygonMesh& file, const PreparedMesh& surface, const QueryParameters& parameters,
                      const SharpEdges& edges, bool in_box, RandomKey key, const CancelToken& cancel,
                      Row& row) {
  const std::vector<QueryGroup> groups = query_groups(parameters.terms);
  const std::vector<QueryPlace> places = interleaved(groups);
  Samples& samples = row.samples;
  const ItemReport& report = row.report;
  samples.query_points =
      stored_points(query_places(surface, parameters, groups, places, edges,
                                 query_frame(surface, report, in_box), key, cancel),
                    surface, {{report.loc[0], report.loc[1], report.loc[2]}, report.scale});
  if (parameters.halves) round_to_halves(samples.query_points);
  samples.query_kind.resize(places.size());
  for (std::size_t i = 0; i < places.size(); ++i)
    samples.query_kind[i] = static_cast<std::uint8_t>(places[i].group);

  const QuerySurface queried(file, surface, cancel);
  const PreparedMesh& mesh = queried.mesh();
  const CurvePoints along = along_curve(working_points(report, samples.query_points, mesh));
  const TriangleTree tree = build_triangle_tree(mesh.x, mesh.y, mesh.z, mesh.triangles);
  cancel.check();
  const NearestTriangles nearest = nearest_triangles(tree, along.points, cancel);
  const bool has_sign = parameters.sign != SignChoice::none;
  if (has_sign) add_sides(along, sides_of(mesh, tree, parameters.sign, along.points, nearest, cancel), row);
  const double scale = mesh.unit / report.scale;
  samples.query_distance.resize(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const std::size_t point = along.order[i];
    const auto distance = static_cast<float>(nearest.distance[i] * scale);
    samples.query_distance[point] = has_sign && samples.query_inside[point] != 0 ? -distance : distance;
  }
  if (parameters.halves) {
    round_to_halves(samples.query_distance);
    round_to_halves(samples.query_winding);
  }
  if (parameters.nearest) add_nearest(queried, along, nearest, samples);
}

double query_bytes(double queries, double triangles, double vertices) {
  // Places, points in three frames, their order, and those on edges; the row and its chunks.
  constexpr double per_query = 8 + 24 + 24 + 24 + curve_order_bytes + 48 + 2 * 70;
  // A copy of the file's faces, and a mesh of its own made of it.
  const double own = 24 * vertices + 16 * triangles +
                     std::max(drop_doubled_faces_bytes(triangles, 3 * triangles, vertices),
                              prepared_bytes(triangles, vertices, true).peak);
  return queries * per_query + own + triangle_tree_bytes(triangles) + nearest_triangles_bytes(queries) +
         orient_outward_bytes(triangles) + point_sides_bytes(triangles, queries);
}

}  // namespace meander
