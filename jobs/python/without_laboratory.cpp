#include <stdexcept>

#include "jobs/python/laboratory_call.h"

namespace meander {

LaboratoryResult call_laboratory(std::string_view, const LaboratoryArguments&) {
  throw std::runtime_error("this build of Meander has no laboratory, which measures point sets");
}

}  // namespace meander
