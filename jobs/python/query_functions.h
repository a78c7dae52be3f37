// Distances, sides and winding numbers of points, which the C interface calls by name.
#pragma once

#include "jobs/python/laboratory_call.h"

namespace meander {

// Takes a mesh, points (n, 3), sign (one of sign_choice_words), threads, and timeout (seconds, 0:
// none). Returns distance (n,), negative inside; face (n,); corners (n, 3) and weights (n, 2), of the corners
// 1 and 2, of the nearest triangle; inside and certain (n,), 0 or 1; winding (n,) by the rules closed and
// winding; sign, the word of the rule in bytes; and the number open_edges.
LaboratoryResult signed_distance(const LaboratoryArguments& given);

// Takes a mesh, points (n, 3), error (0: exact, else above 0), threads and timeout. Returns winding (n,): of
// the faces as they are wound.
LaboratoryResult winding_number(const LaboratoryArguments& given);

}  // namespace meander
