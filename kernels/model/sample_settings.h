// The settings of samples: the one list behind the options of `run` and `remesh`, stored parameters, the
// keywords of Python, the ranges that validate checks, and the tables of the documents.
#pragma once

#include <string>

#include "kernels/core/setting.h"
#include "kernels/model/sample_parameters.h"

namespace meander {

using SampleSettings = SettingList<SampleParameters>;

// What samples are: number, method, density, sequence, order, and the tensor field of the method anisotropic.
const SampleSettings& point_settings();
// What samples take over from the models.
const SampleSettings& value_settings();
// What samples are given from the surface beside what they are.
const SampleSettings& column_settings();
// What else is found and stored of a collection.
const SampleSettings& collection_settings();
// What no option changes, but is recorded: of sampling, and of charts where the method has such.
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
