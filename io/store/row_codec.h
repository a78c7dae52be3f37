// The journal record of one finished row: what encode_row makes, what the journal appends in one write, and
// what sealing takes apart again.
//
//   header (32 bytes) | item columns | u32 length + reason | descriptors | samples
//
// Descriptors and samples are there when the status is ok: descriptors as raw float32 in the order of the
// header; samples dataset by dataset, as raw arrays when a chunk holds several rows, else as filtered chunks,
// each after its u32 length.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/store/store.h"

namespace meander::store {

inline constexpr std::size_t record_header_bytes = 32;
inline constexpr std::size_t longest_reason = 500;  // bytes; longer ones are cut

struct RecordHeader {
  std::uint64_t row = 0;
  std::uint64_t payload_bytes = 0;
  std::uint32_t payload_crc32c = 0;
  Status status = Status::internal;
};

// The header when the first bytes are one (magic, own checksum, known status).
std::optional<RecordHeader> read_record_header(std::span<const std::byte> bytes);

// The parts of a payload; views into it. Throws ItemError(internal) when the lengths do not add up.
struct RecordParts {
  Status status = Status::internal;
  std::span<const std::byte> items;
  std::string_view reason;
  std::vector<std::span<const std::byte>> descriptors;
  std::vector<std::span<const std::byte>> samples;  // per dataset, or per chunk of every dataset in turn
};
RecordParts split_record(const StoreHeader& header, std::span<const std::byte> payload);
// Items, reason and descriptors only: works on the first payload_head_bytes of a payload.
RecordParts split_record_head(const StoreHeader& header, std::span<const std::byte> payload);
std::size_t payload_head_bytes(const StoreHeader& header);  // an upper bound

// One line of valid UTF-8 of at most longest_reason bytes.
std::string clean_reason(std::string_view reason);

}  // namespace meander::store
