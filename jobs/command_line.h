// Parsing options: every mistake is an error with a suggestion.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "kernels/core/spelling.h"  // nearest: the candidate that was meant

namespace meander {

// Bytes from "512M", "4G", "1.5GiB", "100000": powers of 1024. Throws CLI::ValidationError.
std::uint64_t parse_bytes(const std::string& text);
// Seconds from "120", "120s", "2m", "1.5h". Throws CLI::ValidationError.
double parse_seconds(const std::string& text);

// Accepts one of a list of words; anything else is an error that names the nearest word and all of them.
class OneOf : public CLI::Validator {
 public:
  explicit OneOf(std::vector<std::string> words);
};

// Accepts digits alone: a minus sign before a number without sign would be read as a huge one.
class WholeNumber : public CLI::Validator {
 public:
  WholeNumber();
};

// The sentence for an error of the parser; for unknown options it names the nearest known one of the
// subcommand.
std::string explain(const CLI::App& app, const CLI::ParseError& error);

}  // namespace meander
