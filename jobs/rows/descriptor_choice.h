// What stores have of descriptors.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/store/store.h"
#include "kernels/describe/describe_samples.h"

namespace meander {

// Names, widths and the attributes that explain the values, of the rows of the descriptors in their order.
std::vector<DescriptorSchema> schemas_of(const DescribeParameters& parameters);

// The version of a descriptor in a store: its attribute `version`, 1 without.
std::uint32_t version_of(const DescriptorSchema& schema);

// The attribute of descriptors that are separate values and no histogram: their names with commas.
inline constexpr const char* columns_attribute = "columns";
bool is_histogram(const DescriptorSchema& schema);

// The bins lie in a line, so that a distance between bins has a meaning: not so for those of several
// quantities at once (pairs).
bool has_bins_in_line(const DescriptorSchema& schema);

// Whether a row of an ok item has its descriptor: one that could not be made (no file, no time) is NaN as a
// whole. Before, such rows were 0; where the descriptor cannot be 0 (DescriptorGroup::may_be_zero) they are
// still told by that.
bool is_described(const DescriptorSchema& schema, std::span<const float> values);

}  // namespace meander
