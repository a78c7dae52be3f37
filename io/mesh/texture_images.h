// Internal to io/mesh: the images that textures of a model show.
#pragma once

#include <span>
#include <string>

#include "io/mesh/mesh_reader.h"
#include "kernels/mesh/surface_textures.h"

namespace meander {

// The image in this file (CompanionFile::path), or none, with the reason: see decode_color_image.
ColorImage image_of_file(std::span<const CompanionFile> companions, const std::string& path,
                         const CancelToken& cancel);

// What is said of an image that is lost: the name, and the problem that it has, or that it is.
std::string text_of_loss(const std::string& name, const std::string& problem);
// Takes note of an image that is lost; `name` as the file has it.
void note_lost_image(const ColorImage& image, const std::string& name, Notes& notes);

}  // namespace meander
