// The program with faults that tests can ask for (fault_program.cpp). For tests with a FAULT_PROGRAM.
#pragma once

#include <string>

namespace meander::test {

inline const std::string fault_program = MEANDER_FAULT_PROGRAM;

}  // namespace meander::test
