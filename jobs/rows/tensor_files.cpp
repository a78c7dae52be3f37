#include "jobs/rows/tensor_files.h"

#include <filesystem>

namespace meander {

void plan_tensor_files(const TensorParameters& tensor, std::vector<PlanItem>& items) {
  if (tensor.kind != TensorKind::table) return;
  namespace fs = std::filesystem;
  const fs::path path = tensor.attribute;
  const bool folder = fs::is_directory(path);
  const bool hdf5 = path.extension() == ".h5" || path.extension() == ".hdf5";
  for (PlanItem& item : items) {
    item.tensor_path = folder ? path / (item.id + ".txt") : path;
    if (folder && !fs::exists(item.tensor_path))
      item.tensor_path = path / fs::path(item.id).replace_extension(".txt");
    if (hdf5 && !folder) item.tensor_dataset = item.id;
  }
}

}  // namespace meander
