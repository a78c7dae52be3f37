// The one mapping from exceptions to statuses of an item.
#pragma once

#include <string>
#include <string_view>

#include "kernels/core/status.h"

namespace meander {

// Why an item has no result, or only part of it.
struct Failure {
  Status status = Status::internal;
  std::string reason;  // one sentence
};

// Maps the exception being handled: ItemError to its own status and sentence, std::bad_alloc to
// out_of_memory, anything else to internal with the name of `stage`. Call it in a catch clause. RunCanceled
// is not a failure of the item and must be caught before.
Failure current_failure(std::string_view stage);

}  // namespace meander
