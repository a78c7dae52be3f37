// The store: one HDF5 file of M rows (models) by N samples, and the crash-safe run directory beside it while
// a run is under way. No HDF5 type leaves io/store.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/run_error.h"
#include "io/store/store_columns.h"

namespace meander {

enum class Compression : std::uint8_t {
  standard,
  none
};  // shuffle + deflate(1) + fletcher32; fletcher32 only

// The format version that stores are written in; older ones are read.
inline constexpr std::uint32_t store_format_version = 5;
// Raised whenever the same input gives other points.
inline constexpr std::uint32_t store_method_version = 18;

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

// Bytes that writing such a store from the journals of its run takes at most.
std::uint64_t store_writing_bytes(const StoreHeader& header);

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

// What a run is begun for. The numbers are part of the format of plans.
enum class RunPurpose : std::uint8_t { sample, replace, update, describe, merge, surfaces };

// What the run of a STORE.run/ was begun with. Only the same plan is continued.
struct RunPlan {
  StoreHeader header;
  RunPurpose purpose = RunPurpose::sample;
  std::string root = {};   // what the ids of lists are relative to; remembered for the next process
  std::string retry = {};  // of an update: the words of --retry, with commas between them
};

// The purpose of a plan, completing "it was begun to ...".
std::string purpose_text(const RunPlan& plan);

// The plan of STORE.run/; empty when there is no run that was completely set up. Throws RunError(unusable)
// when the plan is damaged or of another version of the program.
std::optional<RunPlan> read_run_plan(const std::filesystem::path& store);

// STORE.run/: journals of finished rows, 4096 rows each, the log of begun ones, a lock. kill -9 at any moment
// loses only the rows in flight.
// begin_item may be called from one thread while end_item is called from another; otherwise not thread-safe.
class RunDirectory {
 public:
  // Opens STORE.run/ (creating it, or continuing what is there after replaying its journals). Throws
  // RunError: stopped when another process holds it or the disk is full; unusable when it was begun with
  // other parameters or other items (the message names the first difference), or is damaged beyond replay.
  RunDirectory(const std::filesystem::path& store, const RunPlan& plan);
  RunDirectory(const std::filesystem::path& store, const StoreHeader& header)
      : RunDirectory(store, RunPlan{header}) {}
  ~RunDirectory();
  RunDirectory(const RunDirectory&) = delete;
  RunDirectory& operator=(const RunDirectory&) = delete;

  bool done(std::uint64_t row) const;
  std::uint64_t done_count() const;
  Status status(std::uint64_t row) const;       // of a done row
  std::vector<std::uint64_t> suspects() const;  // begun by an earlier process but never ended, ascending
  void begin_item(std::uint64_t row);
  // Appends the row to its journal, and brings that to the disk when no row of it is missing, unless it is
  // the last of all rows: then the store is. What the blocks of a row throw is rethrown: nothing has changed
  // then, and the row may be ended with another status.
  void end_item(EncodedRow encoded);
  // In a forked child: closes its copy of the lock, which then ends with the parent, however that ends.
  void leave_lock_to_parent();
  // No row is in work: rows begun but not ended are not suspects for the next process.
  void forget_begun();
  void sync();  // fdatasync of the journals that have changed
  // Writes STORE from the journals, whose chunks of one row are copied: temporary name, fsync, rename, fsync
  // of the folder; calls `finished`, which writes what else belongs to the store; then removes STORE.run/. A
  // process that dies in between leaves a run whose next process does all of this again. Requires
  // done_count() == M.
  void finish(const std::function<void()>& finished = {});

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Removes STORE.run/ and what killed processes left beside it (for --fresh); a finished STORE stays until
// another is renamed over it. Throws RunError(stopped) when another process holds the run, or a shard of it.
void discard_run(const std::filesystem::path& store);

// Removes what killed processes left beside a store: one half written, a run half removed. Does nothing while
// there is a STORE.run/, which is continued or discarded.
void tidy_store(const std::filesystem::path& store);

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
  const StoreColumns& columns() const;
  // Throws RunError(unusable) when the store is without the column; `user` needs it ("the format page").
  void require(std::size_t column, std::string_view user) const;
  template <class Value>
  void require(std::vector<Value> Samples::*array, std::string_view user) const {
    require(column_of(array), user);
  }
  std::uint32_t samples() const;
  std::uint32_t format_version() const;
  std::uint32_t method_version() const;
  std::string tool_version() const;
  std::uint64_t seed() const;
  const std::string& order() const;
  Compression compression() const;
  const std::string& parameters_json() const;
  const std::vector<std::string>& label_names() const;
  const std::vector<DescriptorSchema>& descriptors() const;
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
  // Samples [begin, end) of a row that is ok.
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

// Everything wrong with a store, one sentence each, at most `limit`; empty when it is whole. Checks: the
// digest over every byte of the file, the schema, every chunk's checksum, points_crc32c and content of every
// row (an ok row is finite but for descriptors that are NaN as a whole, every column of it and every sample
// within the range that its meaning allows; any other row is all fill), ids ascending and unique, statuses
// known. Of an index of packs the same of every pack, and that they are those that it names. progress(done,
// total rows) may be empty.
struct VerifyResult {
  std::uint64_t rows = 0, ok_rows = 0;
  std::vector<std::string> problems;
};
VerifyResult verify_store(const std::filesystem::path& store, std::size_t limit = 100,
                          const std::function<void(std::uint64_t, std::uint64_t)>& progress = {});

// Files for PointNet-style loaders in an existing or new folder: shards ply_data_train<k>.h5 of at most
// `shard_rows` ok rows (data f32, normal f32, label u8), ply_data_test<k>.h5 and, where there are rows for
// validation, ply_data_val<k>.h5; the lists of these files, train_files.txt and so on; their ids as JSON;
// shape_names.txt. Rows without a split are for training, rows without a class are left out. Shards of an
// earlier export that are not written again are removed. Returns the rows of each part. Throws RunError:
// unusable when no row is left or there are more than 256 classes, stopped when `stop` was set on the way.
struct PointnetCounts {
  std::uint64_t train = 0, test = 0, validation = 0, unlabelled = 0;
};
PointnetCounts export_pointnet(const StoreReader& store, const std::filesystem::path& folder,
                               std::uint32_t shard_rows = 2048, const std::atomic<bool>* stop = nullptr,
                               PointFrame frame = PointFrame::stored);
// Throws as export_pointnet does where the store has nothing for such files, or too many classes.
void require_pointnet_rows(const StoreReader& store);
// Whether a file may be one of such an export.
bool is_pointnet_file(const std::string& name);
// The files of an earlier export in a folder, which export_pointnet would replace or remove.
std::vector<std::filesystem::path> pointnet_files(const std::filesystem::path& folder);

}  // namespace meander
