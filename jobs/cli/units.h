// Numbers and amounts with units, as options take them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "io/store/store_reader.h"

namespace meander {

// The digits of a whole number written as "1e3", "2k" or "1.5M": powers of 1000, an exponent, or both as in
// "1e3k". Exact for any length; any other text is returned unchanged.
std::string plain_count(const std::string& text);
// Bytes from "512M", "4G", "1.5GiB", "100000": powers of 1024. Throws UsageError.
std::uint64_t parse_bytes(const std::string& text);
// Seconds from "120", "120s", "2m", "1.5h". Throws UsageError.
double parse_seconds(const std::string& text);

// "1 model", "2 models", "2 meshes": the number and the noun that fits it; `many` is by default `one` and an
// s.
std::string counted(std::uint64_t count, std::string_view one, std::string_view many = {});

// The number of a text of decimal digits alone; empty for any other text.
std::optional<std::uint64_t> number_in(std::string_view text);
// "3/64": the fourth of 64 shards. Throws UsageError for any other text, and for "64/64".
StoreShard parse_shard(const std::string& text);

}  // namespace meander
