// Samples of a store as arrays of numpy: an .npz file a model, or the tar shards of WebDataset.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/archive/archive_writers.h"
#include "io/store/store_reader.h"
#include "jobs/export/training_schema.h"

namespace meander {

class Command;

struct ArrayExport {
  std::vector<std::string> arrays;  // names; empty: points, normals and, of a store with colors, rgb, as far
                                    // as there are such
  std::string shard_bytes = "256M";
  bool shapes_shards = false;      // --shard-bytes was given
  std::string schema;              // a word of schema_words; empty: none
  std::string uncertain = "drop";  // a word of uncertain_words
  bool chooses_uncertain = false;  // --uncertain was given
};

void add_array_export_options(const Command& command, ArrayExport& options);
// Throws UsageError when the options do not fit together.
void check_array_export(const ArrayExport& options, const std::string& format);
// The names, each once. Throws UsageError for an array that the store does not have.
std::vector<std::string> chosen_arrays(const StoreReader& store, const ArrayExport& options);

// An .npz file: the arrays, and `loc` (3 float64), `scale` (float64) and `frame` (a text). Stored points lie
// at loc + scale * points in the model's file; with the frame `file` the points are there already, as
// float64. Throws RunError(unusable) for 4 GiB and more.
void write_npz(const PutBytes& put, const StoreColumns& columns, const std::vector<std::string>& arrays,
               PointFrame frame, const Row& row, const std::string& id);

struct WebdatasetExport {
  std::string stem;  // of the names of the shards
  std::filesystem::path folder;
  std::vector<std::string> arrays;  // see chosen_arrays
  std::uint64_t most_bytes = 0;     // of a shard
  PointFrame frame = PointFrame::stored;
  std::optional<SchemaChoice> schema;  // in place of arrays and frame
};

// The rows as FOLDER/STEM-000000.tar and so on in a folder that exists, rows with a split in STEM-train-,
// STEM-test- and STEM-val-: of each KEY.NAME.npy, or the files of a schema as KEY.NAME.npz (schema_members),
// KEY.cls (the number of its class, where it has one) and KEY.json, KEY being its row number. Shards end
// before the first model that would exceed the size. Each file appears as a whole; those of an earlier export
// that are not written again are removed in the end. Says on standard output what was written. False when
// `stop` was set on the way. Memory: one row.
bool export_webdataset(const StoreReader& store, const std::vector<std::uint64_t>& rows,
                       const WebdatasetExport& wanted, const std::atomic<bool>& stop);
// Whether a file may be a shard of an export with this stem.
bool is_webdataset_file(std::string_view name, const std::string& stem);
// The shards of an earlier export, which export_webdataset would replace or remove.
std::vector<std::filesystem::path> webdataset_files(const WebdatasetExport& wanted);

}  // namespace meander
