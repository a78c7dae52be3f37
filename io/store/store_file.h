// One HDF5 file of the schema: a store. In front of the HDF5 superblock stands a user block of 512 bytes with
// the length and the CRC32C of everything behind it, so that one flipped bit anywhere is found.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/file/file_descriptor.h"
#include "io/store/hdf5_handles.h"
#include "io/store/schema.h"
#include "io/store/store.h"

namespace meander::store {

inline constexpr std::size_t user_block_bytes = 512;

struct RowRange {
  std::uint64_t begin = 0, end = 0;
  std::uint64_t size() const { return end - begin; }
};

// Calls body(part) for parts of `size` rows, the last of which may be shorter.
template <class Body>
void for_each_part(RowRange rows, std::uint64_t size, const Body& body) {
  for (std::uint64_t begin = rows.begin; begin < rows.end; begin += size)
    body(RowRange{begin, std::min(begin + size, rows.end)});
}

std::string tool_version();

// The user block of a file with this many bytes in all and this checksum behind the block.
std::string user_block_text(std::uint64_t file_bytes, std::uint32_t checksum);
// Reads the whole file; empty when its bytes are what its user block says, else what is wrong with "it".
std::string check_whole_file(const std::filesystem::path& path);

// One of the files that a large store is divided into. The store itself is then an index: an HDF5 file whose
// datasets are virtual ones over those of the packs, which stand in /packs with what is known of them.
struct StorePack {
  std::string file;  // its name; it lies beside the index
  std::string first_id;
  std::uint64_t rows = 0;
  std::uint64_t bytes = 0;        // of the file, and
  std::uint32_t crc32c = 0;       // the checksum, both as in its user block
  std::uint64_t names_bytes = 0;  // of its /names; not in /packs
};

// Empty when the first block of the file is that of the pack, else a sentence. Reads that block alone.
std::string difference_to_pack(const std::filesystem::path& path, const StorePack& pack);
// The pack that the file is, by its first block; file, first_id and rows are left to the caller.
StorePack sealed_pack(const std::filesystem::path& path);

// The packs that an index names and that are there; none when `store` is no index, or damaged.
std::vector<std::filesystem::path> packs_of_store(const std::filesystem::path& store);
void remove_packs(const std::vector<std::filesystem::path>& packs);  // as far as it can

// Creates a file of the schema and takes filtered chunks for it. Datasets are named by their index in the
// layout, chunks by their first row in the file and their part along N. Failures are RunError(stopped), the
// file then being removed; so is a file that was not sealed.
class StoreFileWriter {
 public:
  // `reserve` bytes of the disk are reserved: an upper bound of the length of the file.
  StoreFileWriter(const std::filesystem::path& path, const StoreLayout& layout, const StoreHeader& header,
                  std::uint64_t reserve);
  ~StoreFileWriter();
  StoreFileWriter(const StoreFileWriter&) = delete;
  StoreFileWriter& operator=(const StoreFileWriter&) = delete;

  // An index: nothing but seal() is called then.
  StoreFileWriter(const std::filesystem::path& path, const StoreLayout& layout, const StoreHeader& header,
                  std::span<const StorePack> packs);

  void write_chunk(std::size_t dataset, std::uint64_t row, std::uint32_t part,
                   std::span<const std::byte> filtered);
  // The names of the next row that has any.
  void append_names(std::span<const std::byte> names);
  void seal();  // closes, writes the user block, syncs

 private:
  void begin(const StoreHeader& header, std::span<const StorePack> packs, std::uint64_t reserve);
  void create(const StoreHeader& header, std::span<const StorePack> packs);
  void create_names(std::span<const StorePack> packs);
  void write_names_chunk();
  void abandon();

  std::filesystem::path path_;
  const StoreLayout& layout_;
  Hdf5File file_;
  std::vector<Hdf5Dataset> datasets_;
  Hdf5Dataset names_dataset_;
  std::vector<std::byte> names_;     // of the chunk that is not full
  std::uint64_t names_begin_ = 0;    // of that chunk
  FileDescriptor written_;           // the same file
  std::uint64_t written_bytes_ = 0;  // since the system was last asked to write
  bool sealed_ = false;
};

// What the root attributes of a file say.
struct StoreFacts : StoreHeader {  // without ids, labels and splits
  std::uint32_t format_version = 0;
  std::uint64_t rows = 0;
  std::vector<StorePack> packs;  // of an index; empty: the rows are in the file itself
};

// Opens a file of the schema for reading. Not thread-safe: callers hold an Hdf5Lock. Hdf5Error when the file
// cannot be read as one at all; what differs from the schema stands in problems().
class StoreFileReader {
 public:
  explicit StoreFileReader(const std::filesystem::path& path);

  const StoreFacts& facts() const { return facts_; }
  const StoreLayout& layout() const { return layout_; }
  const std::vector<std::string>& problems() const { return problems_; }

  // Decodes `count` rows from row `row` on into `values`, count * row_bytes of the dataset.
  void read_rows(std::size_t dataset, std::uint64_t row, std::uint64_t count,
                 std::span<std::byte> values) const;
  // Samples [begin, begin + count) of one row of a dataset of samples.
  void read_samples(std::size_t dataset, std::uint64_t row, std::uint64_t begin, std::uint64_t count,
                    std::span<std::byte> values) const;
  // Whether the chunk was written.
  bool has_chunk(std::size_t dataset, std::uint64_t row, std::uint32_t part) const;
  // The stored bytes of one chunk. One that was never written is an error (Hdf5Error): libraries differ in
  // how they answer, so callers ask only for chunks with a row that is ok, for item columns, and for what
  // has_chunk knows.
  void read_chunk(std::size_t dataset, std::uint64_t row, std::uint32_t part,
                  std::vector<std::byte>& filtered) const;
  // The names of all rows: how long they are, and a part of them. Of stores without names 0.
  std::uint64_t names_bytes() const { return names_bytes_; }
  void read_names(std::uint64_t begin, std::span<std::byte> names) const;
  // Where the names of each row end, from row 0 on: (row + 1) of them.
  std::vector<std::uint64_t> read_name_ends() const;

 private:
  void open_names();
  void read_facts();
  StoredColumns read_columns(hid_t root) const;
  void read_query_facts(const std::function<bool(std::string_view)>& lists, StoreColumns& columns) const;
  void read_descriptors();
  void read_block(std::size_t dataset, std::initializer_list<std::uint64_t> first,
                  std::initializer_list<std::uint64_t> counts, std::uint64_t bytes,
                  std::span<std::byte> values) const;
  void read_descriptors(const std::string& folder);
  void open_dataset(DatasetLayout& dataset);

  std::filesystem::path path_;
  Hdf5File file_;
  StoreFacts facts_;
  StoreLayout layout_;
  std::vector<Hdf5Dataset> datasets_;
  std::vector<Hdf5Type> types_;
  Hdf5Dataset names_dataset_;
  std::uint64_t names_bytes_ = 0;
  std::vector<std::string> problems_;
};

// Shared by both sides (store_types.cpp).
Hdf5Type make_type(const DatasetLayout& dataset);
std::vector<hsize_t> make_extents(const DatasetLayout& dataset, const StoreLayout& layout);
std::vector<hsize_t> make_chunk_extents(const DatasetLayout& dataset);
Hdf5Properties make_creation(const DatasetLayout& dataset, Compression compression);
// The layout of a dataset that joins the rows of the same dataset of all packs.
Hdf5Properties make_virtual_creation(const DatasetLayout& dataset, const StoreLayout& layout,
                                     std::span<const StorePack> packs);
void write_packs(hid_t file, std::span<const StorePack> packs);
std::vector<StorePack> read_packs(hid_t file);  // empty where there are none; Hdf5Error when they are damaged
// The same of /names: without packs of a chunk's length each and of no fixed length in all.
Hdf5Properties make_names_creation(Compression compression);
Hdf5Properties make_virtual_names(std::span<const StorePack> packs);
std::vector<hsize_t> chunk_offset(const DatasetLayout& dataset, std::uint64_t row, std::uint32_t part);

void write_attribute(hid_t object, const char* name, std::string_view text);
void write_attribute(hid_t object, const char* name, std::uint32_t number);
void write_attribute(hid_t object, const char* name, std::uint64_t number);
void write_attribute(hid_t object, const char* name, const std::vector<std::string>& texts);
std::vector<std::string> read_texts(hid_t object, const char* name);
std::string read_text_attribute(hid_t object, const char* name);
std::uint64_t read_number(hid_t object, const char* name);
bool has_attribute(hid_t object, const char* name);

}  // namespace meander::store
