// The functions of the laboratory by name (jobs/python/laboratory_call.h).
#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>

#include <memory>
#include <stdexcept>

#include "jobs/laboratory/functions/laboratory_functions.h"

namespace meander {

namespace {

// Sets the threads, 1 to 1024, of all later calls of the process.
LaboratoryResult limit_threads(const LaboratoryArguments& given) {
  using oneapi::tbb::global_control;
  static std::unique_ptr<global_control> limit;
  const std::uint64_t threads = given.whole("threads");
  if (threads < 1 || threads > 1024) throw std::invalid_argument("threads must be 1 to 1024");
  limit.reset();
  limit = std::make_unique<global_control>(global_control::max_allowed_parallelism, threads);
  return {};
}

constexpr LaboratoryFunction own_functions[] = {{"limit_threads", limit_threads}};

}  // namespace

LaboratoryResult call_laboratory(std::string_view name, const LaboratoryArguments& arguments) {
  for (const std::span<const LaboratoryFunction> functions :
       {std::span<const LaboratoryFunction>(own_functions), histogram_functions, measure_functions,
        model_functions, picture_functions, plane_functions, splat_functions, surface_functions,
        tensor_functions})
    for (const LaboratoryFunction& function : functions)
      if (name == function.name) return function.call(arguments);
  throw std::invalid_argument(fmt::format("the laboratory has no function `{}`", name));
}

}  // namespace meander
