// Files of the layout that PointNet-style loaders read.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "io/store/store_reader.h"

namespace meander {

// Files for PointNet-style loaders in an existing or new folder: shards ply_data_train<k>.h5 of at most
// `shard_rows` ok rows (data f32, normal f32, label u8), ply_data_test<k>.h5 and, where there are rows for
// validation, ply_data_val<k>.h5; the lists of these files, train_files.txt and so on; their ids as JSON;
// shape_names.txt. Rows without a split are for training, rows without a class are left out. Shards of an
// earlier export that are not written again are removed. Returns the rows of each part. Throws RunError:
// unusable when no row is left or there are more than 256 classes, stopped when `stop` was set on the way.
struct PointnetCounts {
  std::uint64_t train = 0, test = 0, validation = 0, unlabeled = 0;
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
