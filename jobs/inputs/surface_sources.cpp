#include "jobs/inputs/surface_sources.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "io/digest.h"
#include "io/file/file_bytes.h"
#include "io/image/png_reader.h"
#include "io/utf8.h"
#include "io/word_list.h"
#include "jobs/cli/option_words.h"
#include "jobs/cli/usage_error.h"
#include "kernels/core/spelling.h"
#include "kernels/surface/formula_surface.h"
#include "kernels/surface/height_field.h"
#include "kernels/surface/nurbs_patch.h"

namespace meander {

namespace fs = std::filesystem;

SurfaceKind surface_kind(const std::string& argument) {
  const std::string extension = lower_ascii(fs::path(argument).extension().string());
  if (extension == ".nurbs") return SurfaceKind::nurbs;
  return extension == ".png" ? SurfaceKind::height_field : SurfaceKind::formula;
}

void check_surface_name(const std::string& argument) {
  const auto names = surface_names();
  if (surface_kind(argument) != SurfaceKind::formula ||
      std::find(names.begin(), names.end(), argument) != names.end())
    return;
  if (is_surface_formula(argument)) {
    try {
      make_formula_surface(argument);
    } catch (const std::invalid_argument& error) {
      throw UsageError(error.what());
    }
    return;
  }
  const std::string near = nearest(argument, names);
  throw UsageError("no surface `" + argument + "`" +
                   (near.empty()
                        ? "; give a name, a .nurbs or .png file, or three formulas such as \"u, v, sin(6*u)\""
                        : ", did you mean `" + near + "`?"));
}

SurfaceSource open_surface(const std::string& argument, const HeightFieldOptions& height_field) {
  SurfaceSource source;
  if (surface_kind(argument) != SurfaceKind::formula) {
    const FileBytes file(argument);
    source.content_sha256 = sha256(file.bytes());
    if (surface_kind(argument) == SurfaceKind::nurbs) {
      source.surface = parse_nurbs_patch(text_of(file.bytes()));
      return source;
    }
    const GrayImage image = read_gray_png(argument);
    // The top row of the picture is the far side of the surface, v = 1.
    std::vector<float> heights;
    heights.reserve(image.values.size());
    for (std::size_t row = image.height; row-- > 0;)
      heights.insert(heights.end(), image.values.begin() + static_cast<std::ptrdiff_t>(row * image.width),
                     image.values.begin() + static_cast<std::ptrdiff_t>((row + 1) * image.width));
    HeightFieldParameters parameters;
    parameters.extent_x = height_field.extent_x;
    parameters.extent_y = height_field.extent_y;
    parameters.scale = height_field.scale;
    source.surface = make_height_field(heights, image.width, image.height, parameters);
    return source;
  }
  source.surface = is_surface_formula(argument) ? make_formula_surface(argument) : make_surface(argument);
  source.content_sha256 = sha256(std::as_bytes(std::span(source.surface->name())));
  return source;
}

std::string surface_id(const std::string& argument) {
  if (surface_kind(argument) != SurfaceKind::formula) return fs::path(argument).filename().string();
  if (!is_surface_formula(argument)) return argument;
  // The slash of a quotient would be a folder for `export`.
  const std::unique_ptr<ParametricSurface> surface = make_formula_surface(argument);
  std::string id;
  for (const char c : surface->name()) id += c == '/' ? std::string("%2F") : std::string(1, c);
  return id;
}

}  // namespace meander
