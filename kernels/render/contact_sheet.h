// Many sampled models in one picture.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "kernels/render/rgb_image.h"
#include "kernels/render/splat_picture.h"

namespace meander {

// One model of a sheet; see splat_picture for points, normals and area.
struct SheetModel {
  std::span<const float> points, normals;
  double area = 0;
  std::string label;  // below the picture, shortened to its width; UTF-8
};

struct ContactSheetParameters {
  SplatParameters splat;          // splat.size: pixels of one cell
  std::uint32_t columns = 0;      // 0: as many as make the sheet about 4 : 3
  std::uint32_t gap = 16;         // pixels between cells and at the border
  std::uint32_t label_scale = 2;  // size of the font: 7 pixels x this; 0: no labels
};

// Models row by row from the upper left, white background. No model gives one empty cell. Deterministic for
// every thread count. O(sum of splat_picture).
RgbImage contact_sheet(std::span<const SheetModel> models, const ContactSheetParameters& parameters = {});

}  // namespace meander
