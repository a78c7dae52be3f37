#include "jobs/python/row_arrays.h"

#include <pybind11/eval.h>
#include <pybind11/numpy.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace py = pybind11;

namespace meander {

namespace {

struct OwnedRow {
  Row row;
  std::vector<double> weights;
};

// n x columns (n where columns is 0) values that `owner` keeps alive; None for none.
template <class Value>
py::object view_of(std::vector<Value>& values, py::ssize_t columns, const py::capsule& owner) {
  if (values.empty()) return py::none();
  const auto count = static_cast<py::ssize_t>(values.size());
  std::vector<py::ssize_t> shape = {count};
  if (columns > 0) shape = {count / columns, columns};
  return py::array_t<Value>(shape, values.data(), owner);
}

template <class Name>
py::str text_of_name(Name name) {
  const std::string_view text = name_of(name);
  return py::str(text.data(), text.size());
}

std::vector<double> weights_of(const Row& row) {
  std::vector<double> weights(row.samples.count());
  const double share = row.report.measure / static_cast<double>(weights.size());
  for (std::size_t i = 0; i < weights.size(); ++i)
    weights[i] = row.samples.density.empty() ? share : share / static_cast<double>(row.samples.density[i]);
  return weights;
}

void add_report(const ItemReport& report, py::dict& members) {
  members["area"] = report.area;
  members["measure"] = report.measure;
  members["bbox"] = py::array_t<double>({2, 3}, report.bbox.data());
  members["loc"] = py::array_t<double>(3, report.loc.data());
  members["scale"] = report.scale;
  members["method"] = text_of_name(report.method);
  members["components"] = report.components;
  members["genus"] = report.genus;
  members["boundaries"] = report.boundaries;
  py::dict repairs;
  for (std::size_t i = 0; i < repair_count; ++i)
    if (report.repairs.counts[i] > 0)
      repairs[py::str(std::string(repair_names[i]))] = report.repairs.counts[i];
  members["repairs"] = repairs;
}

// Kept alive for ever: an exception class outlives every object of the module.
py::handle sampling_error_class;

}  // namespace

py::dict arrays_of(Row row, const std::array<std::uint8_t, 32>& content) {
  if (row.report.status != Status::ok) {
    const py::object error = sampling_error(row.report);
    PyErr_SetObject(sampling_error_class.ptr(), error.ptr());
    throw py::error_already_set();
  }
  auto owned = std::make_unique<OwnedRow>();
  owned->weights = weights_of(row);
  owned->row = std::move(row);
  OwnedRow& kept = *owned;
  const py::capsule owner(owned.release(), [](void* memory) { delete static_cast<OwnedRow*>(memory); });
  Samples& samples = kept.row.samples;
  py::dict members;
  members["points"] = view_of(samples.points, 3, owner);
  members["normals"] = view_of(samples.normals, 3, owner);
  members["face_index"] = view_of(samples.face, 0, owner);
  members["corners"] = view_of(samples.corners, 3, owner);
  members["barycentric"] = view_of(samples.barycentric, 2, owner);
  members["uv"] = view_of(samples.uv, 2, owner);
  members["curve_rank"] = view_of(samples.curve_rank, 0, owner);
  members["density"] = view_of(samples.density, 0, owner);
  members["weights"] = view_of(kept.weights, 0, owner);
  members["tensor_direction"] = view_of(samples.tensor_direction, 3, owner);
  members["tensor_spacing"] = view_of(samples.tensor_spacing, 2, owner);
  py::dict descriptors;
  for (DescriptorRow& descriptor : kept.row.descriptors)
    descriptors[py::str(descriptor.name)] = view_of(descriptor.values, 0, owner);
  members["descriptors"] = descriptors;
  add_report(kept.row.report, members);
  members["content"] = py::bytes(reinterpret_cast<const char*>(content.data()), content.size());
  return members;
}

py::object sampling_error(const ItemReport& report) {
  return py::reinterpret_borrow<py::object>(sampling_error_class)(text_of_name(report.status), report.reason);
}

void add_sampling_error(py::module_& module) {
  // In Python, for its attributes: the base of an exception made in C cannot take more than its arguments.
  py::dict scope;
  scope["__name__"] = "meander";
  py::exec(R"(
class SamplingError(RuntimeError):
    """A mesh or surface that cannot be sampled.

    status: the word that a store has for it (`empty`, `zero_area`, `non_finite`, `timeout` ...).
    reason: one sentence that says what is wrong and where.
    index: the number of the mesh in sample_many, None elsewhere.
    """

    def __init__(self, status, reason, index=None):
        super().__init__(status, reason, index)
        self.status, self.reason, self.index = status, reason, index

    def __str__(self):
        where = "" if self.index is None else "mesh %d: " % self.index
        return "%s%s: %s" % (where, self.status, self.reason)
)",
           scope);
  const py::object made = scope["SamplingError"];
  module.attr("SamplingError") = made;
  sampling_error_class = made.ptr();
  sampling_error_class.inc_ref();
}

}  // namespace meander
