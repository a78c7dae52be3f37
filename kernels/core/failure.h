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

// The failure that the exception in flight is: ItemError with its own status and sentence, std::bad_alloc as
// out_of_memory, anything else as internal, naming `stage` where the work was done. To be called in a catch
// clause. RunCancelled is no failure of the item and must be caught before.
Failure current_failure(std::string_view stage);

}  // namespace meander
