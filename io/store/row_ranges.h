// What the values of an ok row can be, whoever wrote them: the checks of verify that go beyond checksums.
#pragma once

#include <functional>
#include <span>
#include <string>

#include "io/store/schema.h"

namespace meander::store {

// Takes one sentence without its subject, as "has the scale 0, which must be above 0".
using Complain = std::function<void(std::string)>;

// The columns of an ok row: area, measure, scale and distortions positive and finite, loc and box finite, the
// box not turned inside out, shares within [0, 1], counts and method such as the kind of rows allows; no
// components where the run did not look for the topology.
void check_item_ranges(const ItemReport& report, RowKind rows, bool topology, const Complain& complain);

// The samples of an ok row in one dataset, all of them of the type f32 (value_bytes of the row each): finite,
// weights and parameters within [0, 1], normals and directions of unit length, densities not negative,
// spacings positive, points (in file coordinates) at the box of the item. Attributes and texture coordinates
// have NaN where, and only where, the item says that it lacks some. One report for every dataset at most.
void check_sample_ranges(const DatasetSpec& spec, std::span<const float> values, const ItemReport& report,
                         RowKind rows, const Complain& complain);
// The same of a column of classes, where the fill may also be a class of the model: it is there where the
// item says that it lacks some.
void check_class_ranges(const DatasetSpec& spec, std::span<const std::int32_t> values,
                        const ItemReport& report, const Complain& complain);

}  // namespace meander::store
