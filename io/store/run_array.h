// STORE.run/ of a run that many processes share, one shard of its rows each (docs/SCALE.md).
//
//   array.json                      the shards and how they were planned; its presence says that all is there
//   shards/000/shard-000012/        the plan of shard 12, and the lock of the process that works on it
//   shards/000/shard-000012.h5      its rows, a finished store
//   shards/000/shard-000012.h5.run  the run that makes it
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/store/run_plan.h"

namespace meander {

struct ArrayShard {
  std::uint64_t begin = 0, end = 0;  // rows of the store; a shard may have none
  double cost = 0;                   // estimated, seconds of one processor

  std::uint64_t rows() const { return end - begin; }
};

struct RunArray {
  std::vector<std::string> arguments;  // of the command that planned it
  std::string folder;                  // that it was called in
  std::int64_t inputs_listed_unix_ns = 0;
  std::uint64_t rows = 0;
  std::vector<ArrayShard> shards;  // by number: those that cost most come first
  // Task t of an array works on the shards t K .. t K + K - 1, unless it is told another K.
  std::uint64_t shards_per_task = 1;
};

inline constexpr std::uint64_t max_shards = 1000000;

std::filesystem::path array_folder(const std::filesystem::path& store);  // STORE.run
std::filesystem::path shard_folder(const std::filesystem::path& store, std::size_t shard);
std::filesystem::path shard_store(const std::filesystem::path& store, std::size_t shard);

// Makes STORE.run/ with the plans of all shards. `add` puts more into the folder of a shard, which is not yet
// on disk for good. A folder that a killed set-up left is replaced. Throws RunError: unusable when there is a
// run of another kind, or an array already; FileError.
void create_run_array(const std::filesystem::path& store, const RunArray& array, const RunPlan& plan,
                      const std::function<void(std::size_t shard, const std::filesystem::path& folder)>& add);

// Empty where there is no array, or none that was completely set up. Throws RunError(unusable) when its
// description is damaged.
std::optional<RunArray> read_run_array(const std::filesystem::path& store);
RunPlan read_shard_plan(const std::filesystem::path& store, std::size_t shard);

// Shards without a result: ascending.
std::vector<std::size_t> missing_shards(const std::filesystem::path& store, const RunArray& array);

// As many rows as a pack of at most `bytes` has, uncompressed and without ids and reasons: a multiple of
// 4096, at least that many. It depends on the columns, descriptors and samples of the header alone, not on
// its rows.
std::uint64_t rows_of_pack(const StoreHeader& header, std::uint64_t bytes);
// STORE without its extension, ".pack-00012", and the extension.
std::filesystem::path pack_path(const std::filesystem::path& store, std::size_t number);

// Removes what an unfinished merge has written, while STORE.run/ is being discarded.
void discard_packs_in_work(const std::filesystem::path& store);

// Puts the rows of all shards into STORE, which has the bytes of a store that one process made, calls
// `merged`, which writes what else belongs to the store, and removes STORE.run/. A store of more than
// pack_rows rows, a multiple of 4096, becomes packs of so many and an index under its name; 0: one file.
// The bytes of each depend on the rows and pack_rows alone. Throws RunError: stopped when another process
// merges, or the disk is full; unusable when a shard is missing, damaged, or of another plan, when a pack
// would replace a file that belongs to no store, or when a merge into other packs was begun.
void merge_run_array(const std::filesystem::path& store, const RunArray& array, std::uint64_t pack_rows = 0,
                     const std::function<void()>& merged = {});

}  // namespace meander
