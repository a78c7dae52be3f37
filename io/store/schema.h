// The one table of the store's datasets: names, HDF5 types, shapes, fills, units and meanings. Writer,
// reader, verify, the layout table of docs/STORE.md and the tests are all driven by it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/store/store.h"

namespace meander::store {

// One line of valid UTF-8 of at most so many bytes.
std::string clean_line(std::string_view text, std::size_t max_bytes);

// Where the values of a dataset live in a Row.
enum class Role : std::uint8_t { samples, descriptor, label, id, split, reason, item };

struct DatasetSpec {
  std::string path;
  Role role = Role::item;
  ElementType type = ElementType::f32;
  std::uint32_t width = 0;                             // extent of the last axis; 0: there is no such axis
  std::uint64_t fill = 0;                              // bit pattern of the fill value
  std::string unit;                                    // of one value; "1" for counts, numbers and ratios
  std::string doc;                                     // one line
  std::string link;                                    // a second name (hard link); empty: none
  std::span<const std::string_view> words = {};        // of the values of an enum
  std::span<const std::string_view> value_names = {};  // what each of the `width` values counts; older stores
                                                       // have fewer
  const SampleColumn* column = nullptr;                // role samples; null: an attribute
  std::size_t attribute = 0;                           // its place in Samples::attributes
  std::optional<std::uint32_t> lacks_bit = {};  // of ItemReport::lacks; none: every ok row has all values
  const ItemColumn* item = nullptr;             // role item
  std::uint32_t since = 1;                      // the first format version that has the dataset
  PointSet set = PointSet::samples;             // role samples: whose points

  // The dataset as stores of this format version name it.
  std::string path_in(std::uint32_t version) const;

  // Role samples: the array, the same resized to `count` elements, and freed. What stands in memory is what
  // the dataset holds, but for f16, of which memory has the float values.
  std::span<const std::byte> view(const Samples& samples) const;
  // How many values the array has; those from `begin` to `end` as the dataset holds them, valid as long as
  // samples and `scratch`; and the array of `count` values with these, as the dataset holds them, at `begin`.
  std::size_t count(const Samples& samples) const;
  std::span<const std::byte> stored(const Samples& samples, std::size_t begin, std::size_t end,
                                    std::vector<std::byte>& scratch) const;
  void put(std::span<const std::byte> values, std::size_t begin, std::size_t count, Samples& samples) const;
  std::span<std::byte> room(Samples& samples, std::size_t count) const;
  void free(Samples& samples) const;
  // Role item: the value (value_bytes) to and from a report.
  void put_item(const ItemReport& report, std::byte* out) const;
  void get_item(const std::byte* in, ItemReport& report) const;
};

// The item columns of a journal record: byte offset of every item dataset, and the sum.
struct ItemRecord {
  std::vector<std::pair<const DatasetSpec*, std::size_t>> columns;
  std::size_t bytes = 0;
  std::size_t status_offset = 0;
  std::optional<std::size_t> names_offset = {};  // of stores that have names

  // The length of the names of the row with these item columns.
  std::uint32_t names_bytes(std::span<const std::byte> items) const;
};

// What follows from the columns of a store.
struct ColumnTable {
  StoreColumns columns;
  std::vector<DatasetSpec> datasets;
  ItemRecord items;
};

// The datasets of the current format version in file order, descriptors excepted.
inline const std::vector<DatasetSpec>& datasets_of(const StoredColumns& columns) {
  return columns.table().datasets;
}
const std::vector<DatasetSpec>& datasets_of(StoredColumns&& temporary) = delete;  // which the table ends with
inline const ItemRecord& item_record(const StoredColumns& columns) { return columns.table().items; }

// The root attribute `content`, which names columns as format version 3 knows them, and back; empty for any
// other text.
std::string_view content_name(const StoreColumns& columns);
std::optional<StoreColumns> columns_of_content(std::string_view name);
// The root attribute `columns` of stores whose columns are chosen: the datasets of samples in file order,
// without the leading `/`, as stores of this format version name them.
std::vector<std::string> column_list(const StoredColumns& columns,
                                     std::uint32_t version = store_format_version);
// Bytes of a row of so many samples in all columns of points, before they are compressed.
std::uint64_t row_bytes(const StoredColumns& columns, std::uint32_t samples);

// The names behind the classes of all rows, one behind the other, are one dataset of bytes, in chunks of this
// length; item columns have their lengths.
inline constexpr const char* names_path = "/names";
inline constexpr const char* status_path = "/items/status";
inline constexpr const char* names_bytes_path = "/items/names_bytes";
inline constexpr const char* names_doc =
    "with --attribute group, object, material or part only: what the classes of the models are called, by "
    "row "
    "as long as /items/names_bytes says: JSON, by attribute a list";
inline constexpr std::size_t names_chunk = 65536;
static_assert(names_chunk >= most_name_bytes);

DatasetSpec descriptor_dataset(const DescriptorSchema& descriptor);

std::size_t element_size(ElementType type);  // bytes; 1 for text
std::string_view element_name(ElementType type);
std::size_t value_bytes(const DatasetSpec& spec);  // element_size * max(width, 1)
bool per_sample(const DatasetSpec& spec);          // shape (M, N, ...) rather than (M, ...)
// Whether the values of one row, or sample, are along an axis of their own; the bytes of a text are not.
inline bool has_value_axis(const DatasetSpec& spec) {
  return spec.width > 0 && spec.type != ElementType::text;
}
void write_fill(const DatasetSpec& spec, std::span<std::byte> values);
std::string fill_text(const DatasetSpec& spec);

// Rows of a chunk and samples of a chunk.
struct ChunkShape {
  std::uint64_t rows = 1;
  std::uint32_t samples = 0;         // 0 for datasets without a sample axis
  std::uint32_t chunks_per_row = 1;  // along the sample axis
  friend bool operator==(const ChunkShape&, const ChunkShape&) = default;
};

// Rows of a chunk of item columns: every other chunk divides it.
inline constexpr std::uint64_t column_chunk_rows = 4096;
// The largest number of rows in a chunk of samples or descriptors.
inline constexpr std::uint64_t sample_chunk_rows = 256;

// r rows, the smallest power of two <= 256 with r N 12 bytes >= 16 KiB, at most M; cut along N into equal
// parts of at most 65536 samples when N 12 bytes > 1 MiB.
ChunkShape sample_chunk(std::uint64_t rows, std::uint32_t samples);
// The chunks of one of the sets of points of a store with so many samples. Those of all sets hold equally
// many rows, as many as those of the largest set.
ChunkShape set_chunk(const StoredColumns& columns, std::uint64_t rows, std::uint32_t samples, PointSet set);
// The number of chunks of a row of the set that has the most.
std::uint32_t most_chunks_per_row(const StoredColumns& columns, std::uint64_t rows, std::uint32_t samples);

// The largest power of two <= 256 of rows with at most 1 MiB, at most M.
ChunkShape descriptor_chunk(std::uint64_t rows, std::uint32_t width);

// One dataset of one store.
struct DatasetLayout {
  DatasetSpec spec;
  std::uint32_t text_width = 0;  // role id and reason
  std::uint32_t points = 0;      // role samples: of a row
  std::uint64_t row_bytes = 0;
  std::uint64_t element_bytes = 0;  // of the HDF5 type
  ChunkShape chunk;
  std::uint64_t chunk_bytes = 0;  // unfiltered
};

// All datasets of one store: samples, label, descriptors, items.
struct StoreLayout {
  StoredColumns columns;
  std::uint64_t rows = 0;
  std::uint32_t samples = 0;
  Compression compression = Compression::standard;
  std::uint32_t id_width = 1;
  std::vector<DatasetLayout> datasets;

  std::size_t index_of(Role role) const;  // the first dataset of that role
  std::size_t index_of(std::string_view path) const;
};

StoreLayout make_layout(const StoreHeader& header);
StoreLayout make_layout(const StoredColumns& columns, std::uint64_t rows, std::uint32_t samples,
                        Compression compression, const std::vector<DescriptorSchema>& descriptors,
                        std::uint32_t id_width, std::uint32_t reason_width);
// Rows whose samples stand together in a store, column after column: whole chunks, a power of two of at most
// sample_chunk_rows, of about 4 MiB. One row where a row has several chunks: these stand part after part.
std::uint64_t sample_group_rows(const StoreLayout& layout);
// Reasons are as wide as the longest of a file.
void set_text_width(DatasetLayout& dataset, std::uint32_t width);

// The table of docs/STORE.md: one line of Markdown per dataset.
std::string layout_markdown();

}  // namespace meander::store
