#include "io/store/row_ranges.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "kernels/core/portable_functions.h"

namespace meander::store {

namespace {

constexpr double rounding = 1e-5;        // of weights whose sum was rounded to float32
constexpr double unit_tolerance = 1e-3;  // of the length of a direction
// Points lifted to a curved surface leave the box of a coarse mesh, by less than this share of its diagonal.
constexpr double box_margin = 0.5;

bool within(double value, double least, double most) { return value >= least && value <= most; }  // no NaN

std::string wrong(std::string_view name, double value, std::string_view must) {
  return fmt::format("has the {} {}, which must be {}", name, value, must);
}

// A model of a smaller area, as a share of the squared diagonal of its box, has the status zero_area.
constexpr double smallest_area_share = 1e-14;

double squared_diagonal(const std::array<double, 6>& box) {
  double sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    sum += (box[axis + 3] - box[axis]) * (box[axis + 3] - box[axis]);
  return sum;
}

void check_box(const std::array<double, 6>& box, const Complain& complain) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!std::isfinite(box[axis]) || !std::isfinite(box[axis + 3]) || box[axis] > box[axis + 3])
      return complain(
          fmt::format("has a bbox from {} to {}, which is not an interval", box[axis], box[axis + 3]));
}

// Reports the first of `count` values outside [least, most].
void check_each(std::span<const float> values, double least, double most, const DatasetSpec& spec,
                std::string_view must, const Complain& complain) {
  for (const float value : values)
    if (!within(static_cast<double>(value), least, most))
      return complain(fmt::format("has {} in {}, which must be {}", value, spec.path, must));
}

void check_weights(std::span<const float> values, const DatasetSpec& spec, const Complain& complain) {
  for (std::size_t at = 0; at + 1 < values.size(); at += 2) {
    const double first = static_cast<double>(values[at]), second = static_cast<double>(values[at + 1]);
    if (!within(first, -rounding, 1 + rounding) || !within(second, -rounding, 1 + rounding) ||
        first + second > 1 + rounding)
      return complain(
          fmt::format("has the weights {}, {} in {}, which must be within [0, 1] and sum to 1 at most", first,
                      second, spec.path));
  }
}

void check_unit_vectors(std::span<const float> values, const DatasetSpec& spec, const Complain& complain) {
  for (std::size_t at = 0; at + 2 < values.size(); at += 3) {
    const double length = portable::hypot(values[at], values[at + 1], values[at + 2]);
    if (!within(length, 1 - unit_tolerance, 1 + unit_tolerance))
      return complain(fmt::format("has a vector of length {} in {}, which must be 1", length, spec.path));
  }
}

// A loc or scale that is wrong moves the points away from the box that was taken from the file itself.
void check_at_box(std::span<const float> points, const ItemReport& report, const Complain& complain) {
  const auto& box = report.bbox;
  const double margin = box_margin * portable::hypot(box[3] - box[0], box[4] - box[1], box[5] - box[2]);
  if (!std::isfinite(margin)) return;
  for (std::size_t at = 0; at < points.size(); ++at) {
    const std::size_t axis = at % 3;
    const double value = report.loc[axis] + report.scale * static_cast<double>(points[at]);
    if (!within(value, box[axis] - margin, box[axis + 3] + margin))
      return complain(fmt::format("has a point at {} (loc + scale * point), but its bbox is {} to {} there",
                                  value, box[axis], box[axis + 3]));
  }
}

// NaN stands for what a model lacks, and its item says that it lacks some.
void check_chosen(std::span<const float> values, const DatasetSpec& spec, const ItemReport& report,
                  const Complain& complain) {
  const bool lacks_some = (report.lacks >> *spec.lacks_bit & 1) != 0;
  bool has_fill = false, has_value = false;
  for (const float value : values) {
    if (std::isinf(value)) return complain(fmt::format("has a value in {} that is infinite", spec.path));
    has_fill = has_fill || std::isnan(value);
    has_value = has_value || !std::isnan(value);
  }
  if (has_value && (report.missing >> *spec.lacks_bit & 1) != 0)
    complain(fmt::format("has values in {}, but /items/missing says that it has none", spec.path));
  if (has_fill != lacks_some)
    complain(fmt::format("has {} in {}, but /items/lacks says {}", has_fill ? "NaN" : "no NaN", spec.path,
                         lacks_some ? "that it lacks some" : "that it lacks none"));
}

}  // namespace

void check_item_ranges(const ItemReport& report, RowKind rows, bool topology, const Complain& complain) {
  const auto positive = [&](std::string_view name, double value) {
    if (!(value > 0) || !std::isfinite(value)) complain(wrong(name, value, "positive and finite"));
  };
  const auto at_least_one = [&](std::string_view name, double value) {
    if (value < 1) complain(wrong(name, value, "1 or more"));
  };
  // The area of a model that is smaller than about 1e-147 is below what double holds: it may have become 0.
  const double least_area = smallest_area_share * squared_diagonal(report.bbox);
  if (report.area != 0 || least_area >= std::numeric_limits<double>::min()) {
    positive("area", report.area);
    positive("measure", report.measure);
  }
  positive("scale", report.scale);
  for (const double loc : report.loc)
    if (!std::isfinite(loc)) complain(wrong("loc", loc, "finite"));
  check_box(report.bbox, complain);
  if (!(report.sharp_length >= 0) || !std::isfinite(report.sharp_length) ||
      (report.sharp_length > 0 && report.sharp_edges == 0))
    complain(wrong("sharp_length", report.sharp_length, "0 or more, and 0 without sharp edges"));
  if (!within(report.overlap, 0, 1)) complain(wrong("overlap", report.overlap, "within [0, 1]"));
  positive("area_scale_range", report.area_scale_range);
  positive("distortion", report.distortion);
  if (topology)
    at_least_one("number of components", report.components);
  else if (report.components + report.genus + report.boundaries > 0)
    complain("has components, but the run did not look for the topology");
  if (rows == RowKind::surfaces) return;  // neither vertices nor faces, and no chart has a method
  at_least_one("number of vertices", static_cast<double>(report.vertices));
  at_least_one("number of faces", static_cast<double>(report.faces));
  if (report.method == Method::none) complain("is ok, but no method placed its samples");
}

void check_class_ranges(const DatasetSpec& spec, std::span<const std::int32_t> values,
                        const ItemReport& report, const Complain& complain) {
  if (!spec.lacks_bit) return;
  const bool is_missing = (report.missing >> *spec.lacks_bit & 1) != 0;
  const auto fills = std::count(values.begin(), values.end(), no_sample_class);
  if ((report.lacks >> *spec.lacks_bit & 1) != 0 && fills == 0)
    complain(
        fmt::format("has no {} in {}, but /items/lacks says that it lacks some", no_sample_class, spec.path));
  if (is_missing && static_cast<std::size_t>(fills) != values.size())
    complain(fmt::format("has classes in {}, but /items/missing says that it has none", spec.path));
}

void check_sample_ranges(const DatasetSpec& spec, std::span<const float> values, const ItemReport& report,
                         RowKind rows, const Complain& complain) {
  if (spec.lacks_bit) return check_chosen(values, spec, report, complain);
  const Values rule = spec.column == nullptr ? Values::any : spec.column->values;
  if ((rule == Values::sharp_points || rule == Values::sharp_vectors) && report.sharp_edges == 0 &&
      std::all_of(values.begin(), values.end(), [](float value) { return std::isnan(value); }))
    return;
  const bool has_winding = report.sign_rule == SignRule::winding || report.sign_rule == SignRule::closed;
  if (rule == Values::windings && !has_winding) {
    if (!std::all_of(values.begin(), values.end(), [](float value) { return std::isnan(value); }))
      complain(fmt::format("has winding numbers in {}, but sides decided by {}", spec.path,
                           name_of(report.sign_rule)));
    return;
  }
  for (const float value : values)
    if (!std::isfinite(value))
      return complain(fmt::format("has a value in {} that is not finite", spec.path));
  constexpr double largest = std::numeric_limits<double>::max();
  switch (rule) {
    case Values::at_box:
    case Values::sharp_points:
      return check_at_box(values, report, complain);
    case Values::weights:
      return check_weights(values, spec, complain);
    case Values::parameters:
      return check_each(values, 0, 1, spec, "within [0, 1]", complain);
    case Values::not_negative:
      return check_each(values, 0, largest, spec, "0 or more", complain);
    case Values::positive:
      return check_each(values, std::numeric_limits<float>::denorm_min(), largest, spec, "positive",
                        complain);
    case Values::sharp_vectors:
      return check_unit_vectors(values, spec, complain);
    case Values::unit_vectors:
      // A parametric surface has no normal where its parametrisation degenerates.
      if (rows != RowKind::surfaces) check_unit_vectors(values, spec, complain);
      return;
    default:
      return;
  }
}

}  // namespace meander::store
