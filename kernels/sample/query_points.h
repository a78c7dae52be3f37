// Points on and around a surface with their signed distances from it: what implicit functions are trained on.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/random.h"
#include "kernels/core/words.h"
#include "kernels/data/samples.h"
#include "kernels/mesh/polygon_mesh.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/query/surface_sides.h"
#include "kernels/sample/sharp_samples.h"

namespace meander {

// near: points of the surface, moved; near_sharp: points of its sharp edges, moved; volume: in a box.
enum class QueryKind : std::uint8_t { near, near_sharp, volume };
inline constexpr Word<QueryKind> query_kind_words[] = {
    {"near", QueryKind::near}, {"near-sharp", QueryKind::near_sharp}, {"volume", QueryKind::volume}};

// How points of the surface and of its edges are moved: along each axis by a Gaussian whose standard
// deviation is the size, or evenly by up to the size; or by such a Gaussian along the normal of their face,
// or the mean of the normals of the two faces at their edge.
enum class QueryMove : std::uint8_t { gaussian, uniform, along_normal };
inline constexpr Word<QueryMove> query_move_words[] = {{"gaussian", QueryMove::gaussian},
                                                       {"uniform", QueryMove::uniform},
                                                       {"along-normal", QueryMove::along_normal}};

// KIND=COUNT@SIZE,SIZE...: so many points, in equal shares for each of the sizes: those of the moves, or half
// the side of the box.
struct QueryTerm {
  QueryKind kind = QueryKind::near;
  std::uint32_t count = 0;
  std::vector<double> sizes;
  friend bool operator==(const QueryTerm&, const QueryTerm&) = default;
};

struct QueryParameters {
  std::vector<QueryTerm> terms;
  QueryMove move = QueryMove::gaussian;
  double cut = 0;  // Gaussians are those that are no larger; 0: all
  SignChoice sign = SignChoice::automatic;
  bool halves = false;   // points and values are such that float16 holds, and distances those of such points
  bool nearest = false;  // the face, corners and weights of the nearest point, too

  bool any() const { return !terms.empty(); }
  bool has(QueryKind kind) const;
  bool has_moves() const { return has(QueryKind::near) || has(QueryKind::near_sharp); }
};

inline constexpr double largest_query_size = 100;
inline constexpr std::uint32_t most_queries = most_sharp_samples;
// The terms as a text, apart by blanks, and back: the problem with the text, or "". A term without sizes has
// none but `volume`, whose box has the size 1.
std::string queries_text(const std::vector<QueryTerm>& terms);
std::string take_queries(std::string_view text, std::vector<QueryTerm>& terms);

// The points of one size of a term.
struct QueryGroup {
  QueryKind kind = QueryKind::near;
  std::uint32_t count = 0;
  double size = 0;
  std::string name;  // KIND@SIZE
};
// In the order of the terms; at most 255 (take_queries).
std::vector<QueryGroup> query_groups(const std::vector<QueryTerm>& terms);
std::uint32_t query_count(const std::vector<QueryTerm>& terms);

// Adds the points to a row whose samples are placed, in its frame, and what the report says of them. Their
// groups take turns, so that every prefix has its share of each, up to about one point.
//
// The points of a group are those of a scrambled net in six dimensions. near: one for the share of the area,
// along the triangles in the order of the 3-D Hilbert curve, two within the triangle, and three that become
// the move along the axes, or the first of them the move along the normal: Gaussian by normal_quantile, of
// the middle share of probabilities where they are cut. near_sharp: one for the share of the length of all
// sharp edges, and three for the move; where there is none in `edges`, as near. volume: three. Sizes are in
// stored units, the box is around the origin; where `in_box`, they are in halves of the longest side of the
// model's box, and the box is around its center.
//
// Distances are those of the points as stored, computed in double; negative inside. Sides are told by
// point_sides from the surface without doubled faces; by the choice `closed` only where it is closed: else
// the points have no side, and none is certain. `file` needs its polygons. The same for every thread count.
// Throws timeout / RunCanceled. O((T + Q) log T).
void add_query_points(const PolygonMesh& file, const PreparedMesh& surface, const QueryParameters& parameters,
                      const SharpEdges& edges, bool in_box, RandomKey key, const CancelToken& cancel,
                      Row& row);

// Upper bound of the bytes that add_query_points takes, the points of the row and their encoding included.
double query_bytes(double queries, double triangles, double vertices);

}  // namespace meander
