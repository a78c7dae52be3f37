// The error that ends a command: not of one item (ItemError), not a bug.
#pragma once

#include <stdexcept>
#include <string>

namespace meander {

// The run cannot start or go on. kind decides the exit code of a job: unusable 2, stopped 75 (resumable).
class RunError : public std::runtime_error {
 public:
  enum class Kind { unusable, stopped };  // stopped: disk full, or another process holds the store
  RunError(Kind kind, const std::string& what) : std::runtime_error(what), kind_(kind) {}
  Kind kind() const { return kind_; }

 private:
  Kind kind_;
};

}  // namespace meander
