// Options by the names of the keyword arguments in Python, as parameters, by the words of the command line.
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "kernels/model/sample_parameters.h"
#include "kernels/surface/sample_surface.h"

namespace meander {

// Where the density of a mesh comes from when it is given as numbers: see array_mesh.h.
inline constexpr const char* density_attribute = "density";

struct SampleOptions {
  std::uint32_t samples = 2048;
  std::uint64_t seed = 1;
  std::string method = "auto";
  std::string sequence = "shifted";
  std::string order = "progressive";
  std::string normalize = "none";
  std::string spacing = "default";
  std::string density =
      "uniform";  // a word of `run --density`, or "vertices" or "faces": numbers of the mesh
  double density_floor = 0.02, density_exponent = 1;
  std::optional<std::string> curve;  // of the method where it is not given
  bool curved = false;
  bool topology = true;
  std::string describe;  // "d2,pairs"
  std::uint32_t bins = 32;
};

// An option that is not one, or whose value is of another type or range; what() is its name.
struct OptionRefused : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// From a JSON object: n, seed, method, ..., by the names of the keyword arguments of meander.sample;
// `describe` is one text with commas, numbers that are not finite are "nan", "inf" and "-inf". Throws
// OptionRefused.
SampleOptions sample_options(std::string_view json);

// Throws std::invalid_argument with everything that is wrong.
SampleParameters sample_parameters(const SampleOptions& options);

// The options that surfaces have; the density may be an expression in u, v, x, y, z too. Throws as above.
SurfaceSampleParameters surface_parameters(const SampleOptions& options, double tolerance);

}  // namespace meander
