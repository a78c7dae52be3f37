// A sampled row as numpy arrays.
#pragma once

#include <pybind11/pybind11.h>

#include <array>
#include <cstdint>

#include "kernels/sample/samples.h"

namespace meander {

// The members of meander.Samples by name. The arrays show the memory of the row, which lives as long as any
// of them; those that it does not have are None. Only `weights`, the shares of the surface in area
// (measure / (n density)), are computed. Throws meander.SamplingError when the status of the row is not ok.
pybind11::dict arrays_of(Row row, const std::array<std::uint8_t, 32>& content);

// The exception for a row that is not ok: status and reason.
pybind11::object sampling_error(const ItemReport& report);
// Makes meander.SamplingError.
void add_sampling_error(pybind11::module_& module);

}  // namespace meander
