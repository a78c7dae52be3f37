#include <stdexcept>

#include "jobs/python/laboratory_call.h"
#include "jobs/python/measures.h"

namespace meander {

namespace {

[[noreturn]] void refuse() {
  throw std::runtime_error("this build of Meander has no laboratory, which measures point sets");
}

}  // namespace

double box_error(const PolygonMesh&, std::span<const double>, std::uint32_t, std::uint64_t,
                 const CancelToken&) {
  refuse();
}

LaboratoryResult call_laboratory(std::string_view, const LaboratoryArguments&) { refuse(); }

}  // namespace meander
