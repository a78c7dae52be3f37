// The settings of samples: the one list behind the options of `run` and `remesh`, stored parameters, the
// keywords of Python, the ranges that validate checks, and the tables of the documents.
#pragma once

#include <span>
#include <string>

#include "kernels/core/setting.h"
#include "kernels/model/sample_parameters.h"

namespace meander {

using SampleSettings = SettingList<SampleParameters>;

// Decide the samples: number, method, density, sequence, order, and the tensor field of the method
// anisotropic.
const SampleSettings& point_settings();
// Decide what samples take over from the models.
const SampleSettings& value_settings();
// Decide which columns are computed from the surface.
const SampleSettings& column_settings();
// Decide what else networks are trained on: further sets of points.
const SampleSettings& training_settings();
// Decide what else is found and stored for a collection.
const SampleSettings& collection_settings();
// All settings that a caller may give: these five lists.
std::span<const SampleSettings* const> sample_settings();
// Constants that are recorded although no option changes them: of sampling, and of charts for methods that
// make them.
const SampleSettings& sampling_constants();
const SampleSettings& chart_constants();

// How descriptors are made.
using DescribeSettings = SettingList<DescribeParameters>;
const DescribeSettings& describe_settings();

// The descriptors for which `has` is true: "d2 and geodesic".
std::string descriptors_with(bool (*has)(const DescriptorGroup&));

// What follows from settings where it was not given itself: the place of samples, the number of segments.
void settle(SampleParameters& parameters, const GivenSettings& given);

}  // namespace meander
