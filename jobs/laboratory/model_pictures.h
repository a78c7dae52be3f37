// Pictures of the rows of a store: the surface where its mesh is there, with the samples on it; or the
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
#include "jobs/laboratory/splat_models.h"
#include "kernels/core/vector3.h"
#include "pipeline/sampling_graph.h"

namespace meander {

enum class SampleColour : std::uint8_t { plain, density, rank, normal, label };
inline constexpr std::string_view sample_colour_names[] = {"plain", "density", "rank", "normal", "label"};

enum class SampleStyle : std::uint8_t {
  surface,  // discs on the mesh
  splats,   // splats that cover the surface; the mesh tells what they leave white
  points    // the middle of each splat, the rest of it hides what is behind
};

struct ModelLook {
  SampleStyle style = SampleStyle::surface;
  bool both_sides = false;   // of the same: also splats of closed meshes that face away
  SplatSizes splats;         // of the styles splats and points
  std::uint32_t size = 360;  // pixels, width and height; 32..4096
  std::uint32_t points = 0;  // the first so many samples of every model; 0: all
  bool surfaces = true;      // meshes were asked for: the note names those that are missing
  bool samples = true;       // drawn on the surface; where there is none they always are
  SampleColour colour = SampleColour::plain;
  double disc = 0.26;  // radius of a sample's disc, parts of sqrt(area / (samples drawn x density)); 0.05..1
  Vector3 view = {0.55, 0.42, 1};  // from the model towards the eye
  Vector3 up = {0, 1, 0};
};

// One row and the file that may hold its mesh.
struct PicturedModel {
  std::uint64_t row = 0;
  std::optional<PlanItem> file;
  std::string lacking{};  // why no file is used; the line below the name
  bool in_store = true;   // false: the file alone, without samples
};

// The least and the largest density of the rows that are ok: what `SampleColour::density` is relative to.
struct DensityRange {
  double least = 1, largest = 1;
};
DensityRange density_range(const StoreReader& store, std::span<const PicturedModel> models,
                           const ModelLook& look);

// Upper bound of the memory that the picture of one model takes, in bytes.
std::uint64_t picture_bytes(const StoreReader& store, const PicturedModel& model, const ModelLook& look);

// Whole cells. The mesh is used when the SHA-256 of its file is that of the row; without one the samples are
// drawn alone, and the note says why. A row that is not ok has its status and reason instead of a picture.
// Reads the store from one thread, then reads and draws the meshes in parallel. Throws RunError.
std::vector<SheetCell> model_cells(const StoreReader& store, std::span<const PicturedModel> models,
                                   const DensityRange& range, const ModelLook& look);

// The same for any number of models, as many at once as `threads` and `memory` bytes allow: of a model that
// is too large for it the points alone. sheet_bytes: the finished pictures and the sheet that they are put
// on.
std::vector<SheetCell> model_cells(const StoreReader& store, std::vector<PicturedModel> models,
                                   const DensityRange& range, const ModelLook& look, std::uint64_t memory,
                                   std::size_t threads);
std::uint64_t sheet_bytes(const SheetLook& sheet, std::size_t models);

// Towards the eye from the front, the right and above, whatever axis ("x", "y", "z") points up.
void look_along(const std::string& up, ModelLook& look);

std::optional<SheetLegend> legend_of(const DensityRange& range, const ModelLook& look);

}  // namespace meander
