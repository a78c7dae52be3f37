#include "io/mesh/texture_images.h"

#include "io/image/color_image.h"

namespace meander {

ColorImage image_of_file(std::span<const CompanionFile> companions, const std::string& path,
                         const CancelToken& cancel) {
  using Loss = CompanionFile::Loss;
  ColorImage lost;
  lost.problem = "is not there";
  lost.loss = Note::image_missing;
  for (const CompanionFile& file : companions) {
    if (!file.is_image || file.path != path) continue;
    if (file.problem.empty()) return decode_color_image(file.bytes, cancel);
    if (file.loss == Loss::missing) break;
    lost.problem = file.loss == Loss::outside ? file.problem : "cannot be read";
    lost.loss = file.loss == Loss::outside ? Note::image_outside : Note::image_unreadable;
  }
  return lost;
}

std::string text_of_loss(const std::string& name, const std::string& problem) {
  for (const std::string_view verb : {"is ", "leads ", "cannot "})
    if (problem.starts_with(verb)) return name + " " + problem;
  return name + ": " + problem;
}

void note_lost_image(const ColorImage& image, const std::string& name, Notes& notes) {
  if (image.is_lost()) notes.add(image.loss, text_of_loss("`" + name + "`", image.problem));
}

}  // namespace meander
