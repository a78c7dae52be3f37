#include "jobs/rows/laboratory.h"

#include "jobs/cli/usage_error.h"


#include <fmt/format.h>


namespace meander {

const Laboratory& require_laboratory(const Laboratory* laboratory, std::string_view wish) {
  if (laboratory == nullptr)
    throw UsageError(
        fmt::format("`{}` needs the laboratory, and this meander was built without it: configure with "
                    "-DMEANDER_LABORATORY=ON and build again",
                    wish));
  return *laboratory;
}

}  // namespace meander
