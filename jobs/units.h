// Amounts with units, as options take them.
#pragma once

#include <cstdint>
#include <string>

namespace meander {

// Bytes from "512M", "4G", "1.5GiB", "100000": powers of 1024. Throws UsageError.
std::uint64_t parse_bytes(const std::string& text);
// Seconds from "120", "120s", "2m", "1.5h". Throws UsageError.
double parse_seconds(const std::string& text);

}  // namespace meander
