// Options by the names of the keyword arguments in Python, as parameters: the settings that have a keyword.
#pragma once

#include <stdexcept>
#include <string_view>

#include "kernels/model/sample_parameters.h"
#include "kernels/remesh/remesh_surface.h"
#include "kernels/surface/sample_surface.h"

namespace meander {

// Where the density of a mesh comes from when it is given as numbers: see array_mesh.h.
inline constexpr const char* density_attribute = "given density";

// An option that is not one, or whose value is of another type or range; what() is its name.
struct OptionRefused : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// From a JSON object: n, seed, method, ..., by the names of the keyword arguments of meander.sample. Numbers
// that are not finite are "nan", "inf" and "-inf"; null is the default. The density may also be "vertices" or
// "faces": numbers of the mesh. of_files: of meshes that are read from files, which may have images, texture
// coordinates and attributes. Throws OptionRefused; std::invalid_argument with everything that is wrong.
SampleParameters sample_parameters(std::string_view json, bool of_files);

// The settings of meshes (remesh_settings) in the same way.
RemeshParameters remesh_parameters(std::string_view json);

// The same of surfaces, whose density may be an expression in u, v, x, y, z.
SurfaceSampleParameters surface_parameters(std::string_view json, double tolerance);

}  // namespace meander
