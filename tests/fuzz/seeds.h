// Small whole files of each target, from which a fuzzer and the tests begin.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace meander::fuzz {

// Of the target with this name. Throws std::invalid_argument for any other.
std::vector<std::string> seeds_of(std::string_view target);

// Words that the grammar of the target is made of, in the form of a dictionary of libFuzzer; empty: none.
std::string dictionary_of(std::string_view target);

}  // namespace meander::fuzz
