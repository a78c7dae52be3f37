#include "io/mesh/texture_images.h"

#include "io/image/color_image.h"

namespace meander {

ColorImage image_of_file(std::span<const CompanionFile> companions, const std::string& path,
                         const CancelToken& cancel) {
  ColorImage lost;
  lost.problem = path.empty() ? "leads out of the model's folder" : "is not there";
  for (const CompanionFile& file : companions) {
    if (!file.is_image || file.path != path) continue;
    if (file.problem.empty()) return decode_color_image(file.bytes, cancel);
    lost.problem = file.problem;
  }
  return lost;
}

}  // namespace meander
