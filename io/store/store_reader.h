// Reading a finished store. No HDF5 type leaves io/store.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/run_error.h"
#include "io/store/row_codec.h"
#include "io/store/store.h"

namespace meander {

// The CRC32C of the bytes of a store, of all its packs for an index of them, as its first block says: it
// tells stores apart. Throws RunError(unusable) when the file does not begin as a store does.
std::uint32_t stated_checksum(const std::filesystem::path& store);

// What is asked of a store before its contents are believed. HDF5 keeps no checksum of the tables by which it
// finds the values, so one flipped bit there can make it give other values without a word, or crash it.
enum class StoreCheck : std::uint8_t {
  every_byte,  // the length and the CRC32C of the whole file: it is read once, about 5 GB/s from the page
               // cache
  none         // for a file that this process has just sealed or checked, and where the user asks for it
};

// One of `count` parts of the rows of a store, of about equal numbers of rows: parts begin at multiples of a
// power of two, 256 at most, that leaves at least sixteen such blocks a part. Some parts of few rows are
// empty.
struct StoreShard {
  std::uint64_t number = 0, count = 1;  // number < count

  // The first row of part `part` of a store of this many rows; that of part `count` is the end.
  std::uint64_t begin_of(std::uint64_t part, std::uint64_t rows) const;
};

// Reading a finished store; after the check only what is asked for is read. A store may be an index of packs
// that lie beside it (docs/STORE.md): its rows are theirs, and each pack is checked when the first of its
// rows is read, which then throws RunError(unusable) where it is missing, damaged or another file.
class StoreReader {
 public:
  // Throws RunError(unusable): there is no such file, it is no store, or its bytes are not those that were
  // written; with StoreCheck::none damage may go unnoticed.
  explicit StoreReader(const std::filesystem::path& store, StoreCheck check = StoreCheck::every_byte);
  // The rows of a shard alone, as a store of its own: row 0 is the first of them.
  StoreReader(const std::filesystem::path& store, StoreCheck check, const StoreShard& shard);
  ~StoreReader();
  StoreReader(const StoreReader&) = delete;
  StoreReader& operator=(const StoreReader&) = delete;

  std::uint64_t rows() const;
  // Throws RunError(unusable) when the store is without the column; `user` needs it ("the format page").
  void require(std::size_t column, std::string_view user) const;
  template <class Value>
  void require(std::vector<Value> Samples::*array, std::string_view user) const {
    require(column_of(array), user);
  }
  std::uint32_t format_version() const;
  // The header without ids, labels and splits, and what it says.
  const StoreHeader& stated() const;
  const StoreColumns& columns() const { return *stated().columns; }
  std::uint32_t samples() const { return stated().samples; }
  std::uint32_t method_version() const { return stated().method_version; }
  const std::string& tool_version() const { return stated().tool_version; }
  std::uint64_t seed() const { return stated().seed; }
  const std::string& order() const { return stated().order; }
  Compression compression() const { return stated().compression; }
  const std::string& parameters_json() const { return stated().parameters_json; }
  const std::vector<std::string>& label_names() const { return stated().label_names; }
  const std::vector<DescriptorSchema>& descriptors() const { return stated().descriptors; }
  // Everything of the header, ids, labels and splits of all rows included: what a store made from this one
  // begins with.
  StoreHeader header() const;
  std::string id(std::uint64_t row) const;
  std::optional<std::uint64_t> find(std::string_view id) const;  // binary search
  ItemReport report(std::uint64_t row) const;
  std::int32_t label(std::uint64_t row) const;
  Split split(std::uint64_t row) const;   // none in a store of format version 1
  Row read_row(std::uint64_t row) const;  // with samples, descriptors and names
  // Row::names of a row; empty where it has none.
  std::string names(std::uint64_t row) const;
  // Samples [begin, end) of a row that is ok, without its other sets of points.
  Samples read_samples(std::uint64_t row, std::uint64_t begin, std::uint64_t end) const;
  // The row, to be written to a store of the same columns and descriptors.
  CopiedRow copy_row(std::uint64_t row) const;
  // All rows of a descriptor, M x width, NaN in rows that are not ok. Throws RunError(unusable) when the
  // store has no descriptor of that name.
  std::vector<float> read_descriptor(std::string_view name) const;
  // The same of `count` rows from `row` on: count x width.
  std::vector<float> read_descriptor(std::string_view name, std::uint64_t row, std::uint64_t count) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace meander
