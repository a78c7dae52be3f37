#include "targets.h"

#include <array>

namespace meander::fuzz {

std::span<const Target> targets() {
  static constexpr std::array<Target, 23> all = {
      {{"array", run_array},   {"bmp", run_bmp},         {"gif", run_gif},   {"gltf", run_gltf},
       {"gz", run_gz},         {"journal", run_journal}, {"json", run_json}, {"labels", run_labels},
       {"mtl", run_mtl},       {"npy", run_npy},         {"npz", run_npz},   {"obj", run_obj},
       {"off", run_off},       {"plan", run_plan},       {"ply", run_ply},   {"png", run_png},
       {"points", run_points}, {"stl", run_stl},         {"tar", run_tar},   {"tensor", run_tensor},
       {"tga", run_tga},       {"webp", run_webp},       {"zip", run_zip}}};
  return all;
}

}  // namespace meander::fuzz
