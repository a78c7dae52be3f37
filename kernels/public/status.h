// <meander/status.h>: how the sampling of a model ends: statuses, methods, repairs, exceptions, cancellation.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>

namespace meander {

// How a model ended. The numbers are part of the store format: never renumber, only append.
enum class Status : std::uint8_t {
  ok = 0,
  empty = 1,               // no face at all (a point cloud, a wireframe, an empty file)
  unreadable = 2,          // the bytes are not what the format says, or the file cannot be read
  unsupported_format = 3,  // a format, or a variant of one, that no reader here takes
  non_finite = 4,          // every face has a NaN or infinite vertex, or lengths and areas overflow double
  index_out_of_range = 5,  // every face names a vertex that is not there
  zero_area = 6,           // area <= 1e-14 diagonal^2
  zero_density = 7,        // the density is zero everywhere on the surface
  too_large = 8,           // needs more memory than the whole budget
  timeout = 9,             // the deadline per model passed
  out_of_memory = 10,      // an allocation failed
  crashed = 11,            // a process that did nothing but this item died of SEGV, BUS, FPE, ILL or ABRT
  internal = 12,           // a bug in Meander, caught
  missing_attribute = 13,  // the model lacks the attribute that its density or tensors are to be read from
  incomplete = 14,         // the model has a note that the user does not accept (the setting `strict`)
};
inline constexpr std::array<std::string_view, 15> status_names = {"ok",
                                                                  "empty",
                                                                  "unreadable",
                                                                  "unsupported_format",
                                                                  "non_finite",
                                                                  "index_out_of_range",
                                                                  "zero_area",
                                                                  "zero_density",
                                                                  "too_large",
                                                                  "timeout",
                                                                  "out_of_memory",
                                                                  "crashed",
                                                                  "internal",
                                                                  "missing_attribute",
                                                                  "incomplete"};
constexpr std::string_view name_of(Status status) { return status_names[static_cast<std::size_t>(status)]; }

// How the curve was laid over the surface. The numbers are part of the store format.
// Direct: the 3-D Hilbert curve. Balanced: balanced bisection in space. Anisotropic: over charts that are
// conformal in the metric of a tensor field, or follow its directions.
enum class Method : std::uint8_t {
  none = 0,
  conformal = 1,
  mean_value = 2,
  direct = 3,
  anisotropic = 4,
  balanced = 5
};
inline constexpr std::array<std::string_view, 6> method_names = {"none",   "conformal",   "mean-value",
                                                                 "direct", "anisotropic", "balanced"};
constexpr std::string_view name_of(Method method) { return method_names[static_cast<std::size_t>(method)]; }

// Why a model is not ordered over the charts that its method asked for: what was wrong with the conformal map
// of the component that Method names. The numbers are part of the store format.
enum class OrderReason : std::uint8_t {
  as_asked = 0,    // it is ordered as asked
  flipped = 1,     // triangles that the map turns over stayed so after all repairs
  winding = 2,     // no triangle is turned over, but the map winds round a vertex more than once
  not_finite = 3,  // the map could not be solved for, or its coordinates overflow
  work_limit = 4,  // the bound on the work of a chart came first
};
inline constexpr std::array<std::string_view, 5> order_reason_names = {"as_asked", "flipped", "winding",
                                                                       "not_finite", "work_limit"};
constexpr std::string_view name_of(OrderReason reason) {
  return order_reason_names[static_cast<std::size_t>(reason)];
}

// A model that cannot be sampled: its status, and one sentence that says what is wrong and where.
class ItemError : public std::runtime_error {
 public:
  ItemError(Status status, const std::string& reason) : std::runtime_error(reason), status_(status) {}
  Status status() const { return status_; }

 private:
  Status status_;
};

// The caller stopped the work by CancelToken::canceled.
class RunCanceled : public std::runtime_error {
 public:
  RunCanceled() : std::runtime_error("the run was canceled") {}
};

// Ends long work, which looks at it between its stages and inside of its loops.
struct CancelToken {
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
  const std::atomic<bool>* canceled = nullptr;  // set by the caller to stop; may be null

  // Throws RunCanceled when `canceled` is set, ItemError(timeout) once the deadline has passed. Cost: one
  // clock read.
  void check() const {
    if (canceled != nullptr && canceled->load(std::memory_order_relaxed)) throw RunCanceled();
    if (deadline != std::chrono::steady_clock::time_point::max() &&
        std::chrono::steady_clock::now() > deadline)
      throw ItemError(Status::timeout, "the time limit per model passed");
  }
};

// What was repaired on the way in, counted by name. The order is part of the store format: only append.
enum class Repair : std::uint8_t {
  missing_vertices,    // fewer vertices than the header promised
  missing_faces,       // fewer faces than the header promised
  extra_data,          // bytes after the last promised element were ignored
  short_faces,         // faces with fewer than three corners, dropped
  repeated_corners,    // faces that name one position twice, dropped or shortened
  index_out_of_range,  // faces that name a vertex that is not there, dropped
  non_finite,          // faces with a NaN or infinite corner, dropped
  zero_area_faces,     // triangles of no area: kept for adjacency, never sampled
  concave_polygons,    // polygons that needed ear clipping
  welded_vertices,     // vertices whose position another vertex has too
  split_edges,         // edges of more than two faces, split into boundary edges
  split_vertices,      // extra copies of vertices whose faces form more than one fan
  flipped_faces,       // faces turned round so that neighbors agree
  cut_edges,           // edges cut because the surface is not orientable
  bad_normals,         // normals of the file that are zero or not finite: the geometric normal stands in
  bad_attributes,      // attribute values that could not be read
  coincident_points,   // samples that still coincide in float32 after all redraws
  count
};
inline constexpr std::size_t repair_count = static_cast<std::size_t>(Repair::count);
inline constexpr std::array<std::string_view, repair_count> repair_names = {
    "missing_vertices",   "missing_faces",    "extra_data",      "short_faces",      "repeated_corners",
    "index_out_of_range", "non_finite",       "zero_area_faces", "concave_polygons", "welded_vertices",
    "split_edges",        "split_vertices",   "flipped_faces",   "cut_edges",        "bad_normals",
    "bad_attributes",     "coincident_points"};

struct RepairCounts {
  std::array<std::uint32_t, repair_count> counts{};
  std::uint32_t& operator[](Repair repair) { return counts[static_cast<std::size_t>(repair)]; }
  std::uint32_t operator[](Repair repair) const { return counts[static_cast<std::size_t>(repair)]; }
};

}  // namespace meander
