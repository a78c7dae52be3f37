// A row for whatever happens to its item.
#pragma once

#include <new>
#include <string_view>
#include <utility>

#include "kernels/core/failure.h"
#include "kernels/data/samples.h"

namespace meander {

// What make() returns; where it throws ItemError or std::bad_alloc, a row with that status and its sentence,
// in which `stage` names the work. Other exceptions pass.
template <class Make>
Row row_or_failure(std::string_view stage, const Make& make) {
  Failure failure;
  try {
    return make();
  } catch (const ItemError&) {
    failure = current_failure(stage);
  } catch (const std::bad_alloc&) {
    failure = current_failure(stage);
  }
  Row row;
  row.report.status = failure.status;
  row.report.reason = std::move(failure.reason);
  return row;
}

}  // namespace meander
