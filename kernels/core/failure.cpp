#include "kernels/core/failure.h"

#include <exception>
#include <new>

namespace meander {

Failure current_failure(std::string_view stage) {
  try {
    throw;
  } catch (const ItemError& error) {
    return {error.status(), error.what()};
  } catch (const std::bad_alloc&) {
    return {Status::out_of_memory, "an allocation failed in " + std::string(stage)};
  } catch (const std::exception& error) {
    return {Status::internal, "in " + std::string(stage) + ": " + error.what()};
  } catch (...) {
    return {Status::internal, "in " + std::string(stage) + ": an unknown exception"};
  }
}

}  // namespace meander
