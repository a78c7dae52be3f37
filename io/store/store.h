// What a store says of all of its rows.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "io/store/store_columns.h"

namespace meander {

enum class Compression : std::uint8_t {
  standard,
  none
};  // shuffle + deflate(1) + fletcher32; fletcher32 only

// The format version that stores are written in; older ones are read.
inline constexpr std::uint32_t store_format_version = 6;
// Raised whenever the same input gives other points.
inline constexpr std::uint32_t store_method_version = 19;

// One descriptor dataset: its width and the attributes that explain its bins. `group` is the folder of the
// file that it stands in: descriptors, anisotropy, or certificate for measures of the samples themselves.
// Names are unique over all groups.
struct DescriptorSchema {
  std::string name;
  std::uint32_t width = 0;
  std::vector<std::pair<std::string, std::string>> attributes;
  std::string group = "descriptors";
};

// Everything that must be equal for a run to be continued, and that the root attributes of the store record.
// Nothing here depends on threads, memory, shards, time or host.
struct StoreHeader {
  StoredColumns columns;
  std::uint32_t samples = 0;  // N
  Compression compression = Compression::standard;
  std::uint64_t seed = 1;
  std::string order = "progressive";     // attribute `order` of /points: progressive | curve
  std::string parameters_json;           // all effective parameters, one line of JSON, sorted keys
  std::vector<std::string> label_names;  // attribute `names` of /label
  std::vector<DescriptorSchema> descriptors;
  std::vector<std::string> ids;      // M item ids, ascending by bytes, unique
  std::vector<std::int32_t> labels;  // M, -1 where unknown
  std::vector<Split> splits;         // M, or empty: none of the items has one
  // Who sampled the rows: other than this program when an older store is written again with more descriptors.
  std::uint32_t method_version = store_method_version;
  std::string tool_version;  // empty: this program's

  Split split(std::uint64_t row) const { return splits.empty() ? Split::none : splits.at(row); }
};

}  // namespace meander
