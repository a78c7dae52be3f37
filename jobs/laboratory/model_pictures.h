// Pictures of the rows of a store: the surface with the samples on it if its mesh is available; or the
// samples alone, as splats or points.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/plot/picture_sheet.h"
#include "io/store/store_reader.h"
#include "jobs/laboratory/colored_samples.h"
#include "jobs/laboratory/splat_models.h"
#include "kernels/core/vector3.h"
#include "kernels/render/default_view.h"
#include "pipeline/sampling_graph.h"

namespace meander {

enum class SampleStyle : std::uint8_t {
  surface,  // discs on the mesh
  splats,   // splats that cover the surface; the white space is measured with the mesh
  points    // the middle of each splat, whose rest hides the samples behind it
};

struct ModelLook {
  SampleStyle style = SampleStyle::surface;
  bool both_sides = false;    // of the same: splats of closed meshes that face away are drawn too
  SplatSizes splats;          // of the styles splats and points
  std::uint32_t size = 360;   // pixels, width and height; 32..4096
  std::uint32_t points = 0;   // how many of the first samples of every model are drawn; 0: all
  bool surfaces = true;       // the command names meshes: the note names missing ones
  bool samples = true;        // samples are drawn on the surface; without a surface they always are
  SampleColoring color = {};  // what the color of a sample means
  double disc = 0.26;  // radius of a sample's disc, parts of sqrt(area / (samples drawn x density)); 0.05..1
  double sharp_angle =
      0;  // degrees; edges of surfaces that are as sharp are drawn (find_sharp_edges); 0: none
  Vector3 view = default_view;  // from the model towards the eye
  Vector3 up = {0, 1, 0};
};

// A row and the file that may hold its mesh.
struct PicturedModel {
  std::uint64_t row = 0;
  std::optional<PlanItem> file;
  std::string lacking{};  // the reason why no file is used, shown below the name
  bool in_store = true;   // false: the file alone, without samples
};

// An upper bound of the memory for the picture of one model, in bytes.
std::uint64_t picture_bytes(const StoreReader& store, const PicturedModel& model, const ModelLook& look);

// Draws complete cells. The mesh is used if the SHA-256 of its file is that of the row; else the samples are
// drawn alone, and the note says why. A row that is not ok shows its status and reason instead. Reads the
// store in one thread, then reads and draws the meshes in parallel. Throws RunError.
std::vector<SheetCell> model_cells(const StoreReader& store, std::span<const PicturedModel> models,
                                   const ColorScale& scale, const ModelLook& look);

// The same for any number of models, as many at once as `threads` and `memory` bytes allow; a model that is
// too large is drawn by its points alone. sheet_bytes: the finished pictures and their sheet.
std::vector<SheetCell> model_cells(const StoreReader& store, std::vector<PicturedModel> models,
                                   const ColorScale& scale, const ModelLook& look, std::uint64_t memory,
                                   std::size_t threads);
std::uint64_t sheet_bytes(const SheetLook& sheet, std::size_t models);

// The direction towards an eye in front, to the right and above, for the axis ("x", "y", "z") that points up.
void look_along(const std::string& up, ModelLook& look);

}  // namespace meander
