// The journal record of one finished row: what encode_row makes, what the journal appends in one write, or
// part by part, and what writing the store takes apart again.
//
//   header (32 bytes) | item columns | u32 length + reason | descriptors | samples | names
//
// Names are as long as their item column says. Descriptors and samples are there when the status is ok:
// descriptors as raw float32 in the order of the header; samples dataset by dataset as raw arrays when a
// chunk holds several rows, else as filtered chunks, each after its u32 length: the first chunk of every
// dataset, then the second ones, and so on. So a row of many chunks can be written while its samples are
// made, and taken apart again chunk by chunk.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/store/schema.h"

namespace meander {

// Makes the samples [begin, end) of a row: arrays of end - begin entries. Called by several threads at a
// time.
using SampleBlocks = std::function<Samples(std::uint64_t begin, std::uint64_t end)>;

// A row ready to be written: filtered chunks where a chunk holds one row, raw arrays otherwise. Opaque bytes;
// or, of a set that need not fit into memory, what its chunks are made of while the row is written.
struct EncodedRow {
  std::uint64_t row = 0;
  std::vector<std::byte> bytes;
  SampleBlocks blocks = {};               // in place of `bytes`, with
  std::optional<ItemReport> report = {};  // the rest of the row,
  std::string names = {};                 // and its names
};

// Encodes one row (compression included). Pure and thread-safe: workers call it. The row's sample arrays must
// hold header.samples entries when the status is ok and nothing otherwise. Fills report.points_crc32c of the
// stored row.
EncodedRow encode_row(const StoreHeader& header, std::uint64_t row_number, const Row& row);
// The same; each sample array is freed once its last chunk is encoded.
EncodedRow encode_row(const StoreHeader& header, std::uint64_t row_number, Row&& row);
// A row whose samples are made and encoded while it is written. Of stores whose chunks hold one row, without
// descriptors; throws ItemError(internal) for others.
EncodedRow encode_row_in_blocks(const StoreHeader& header, std::uint64_t row_number, const ItemReport& report,
                                SampleBlocks blocks, std::string names = {});
// Rows of more samples than this are copied in blocks; the few blocks of others would be encoded by few
// threads.
inline constexpr std::uint32_t most_copied_samples = 1 << 18;

// A row that is read to be written again: its samples, or blocks of them where it has many. What it was read
// from must outlive it.
struct CopiedRow {
  Row row;
  SampleBlocks blocks = {};
};
EncodedRow encode_row(const StoreHeader& header, std::uint64_t row_number, CopiedRow copied);
// The inverse of encode_row, for tests.
Row decode_row(const StoreHeader& header, const EncodedRow& encoded);

}  // namespace meander

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
  std::vector<std::span<const std::byte>> samples;  // of every dataset in turn, chunk by chunk
  std::string_view names;
};
RecordParts split_record(const StoreHeader& header, std::span<const std::byte> payload);
// Items, reason and descriptors only: works on the first payload_head_bytes of a payload.
RecordParts split_record_head(const StoreHeader& header, std::span<const std::byte> payload);
std::size_t payload_head_bytes(const StoreHeader& header);  // an upper bound

// The record of a row that is ok, whose samples are encoded part by part (see EncodedRow): one chunk of every
// dataset a part. The header must outlive it.
class RecordInParts {
 public:
  // Throws ItemError(internal) when chunks hold several rows, or there are descriptors.
  RecordInParts(const StoreHeader& header, std::uint64_t row, const ItemReport& report,
                std::string_view names = {});
  std::uint32_t parts() const { return chunk_.chunks_per_row; }
  // The samples [begin, end) of a part.
  std::uint64_t begin_of(std::uint32_t part) const;
  std::uint64_t end_of(std::uint32_t part) const { return begin_of(part + 1); }
  struct Part {
    std::vector<std::byte> bytes;
    std::uint32_t crc32c = 0, points_crc32c = 0;
    std::uint64_t points_bytes = 0;
  };
  // Pure: parts may be encoded in any order, by any thread. Throws ItemError(internal) when the arrays have
  // other lengths.
  Part encode(std::uint32_t part, const Samples& samples) const;
  // Takes note of the next part, in order.
  void add(const Part& part);
  // The bytes behind all parts, once; empty from then on. The names must outlive them.
  std::span<const std::byte> take_names();
  std::size_t head_bytes() const;       // of what stands before the parts
  std::vector<std::byte> head() const;  // once all are added
  std::uint64_t payload_bytes() const;  // likewise

 private:
  const StoreHeader& header_;
  std::uint64_t row_;
  ItemReport report_;
  std::string_view names_;
  ChunkShape chunk_;
  std::uint32_t added_ = 0, crc32c_ = 0, points_crc32c_ = 0;
  std::uint64_t bytes_ = 0;
};

}  // namespace meander::store
