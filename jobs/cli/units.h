// Amounts with units, as options take them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/store/store_reader.h"

namespace meander {

// The digits of a whole number that is written as "1e3", "2k" or "1.5M": powers of 1000, an exponent, or both
// as in "1e3k". Exact for any length; every other text is returned as it is.
std::string plain_count(const std::string& text);
// Bytes from "512M", "4G", "1.5GiB", "100000": powers of 1024. Throws UsageError.
std::uint64_t parse_bytes(const std::string& text);
// Seconds from "120", "120s", "2m", "1.5h". Throws UsageError.
double parse_seconds(const std::string& text);

// Both for the options --memory and --timeout; what cannot be read is added to the problems.
struct Budgets {
  std::uint64_t memory_bytes = 0;
  double timeout_seconds = 0;
};
Budgets parse_budgets(const std::string& memory, const std::string& timeout,
                      std::vector<std::string>& problems);

// The number that the text is, decimal digits alone.
std::optional<std::uint64_t> number_in(std::string_view text);
// "3/64": the fourth of 64 shards. Throws UsageError for any other text, and for "64/64".
StoreShard parse_shard(const std::string& text);

}  // namespace meander
