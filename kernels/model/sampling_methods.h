// The registry of the methods: one row has everything that names a method or depends on it.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "kernels/core/words.h"
#include "kernels/partition/elements.h"

namespace meander {

class EmbreeDevice;
struct ModelStage;
struct SampleParameters;
using ModelStages = std::vector<ModelStage>;

enum class MethodChoice : std::uint8_t { automatic, conformal, direct, anisotropic };

// The stages of a method: up to the charts, from there to the samples, and its descriptors (stages_of.cpp).
struct MethodStages {
  ModelStages (*charting)(const SampleParameters& parameters);
  ModelStages (*placing)(const SampleParameters& parameters, const EmbreeDevice* device);
  ModelStages (*describing)(const SampleParameters& parameters);
};
extern const MethodStages direct_stages, conformal_stages, anisotropic_stages;

struct SamplingMethod : Word<MethodChoice> {  // its word on the command line and in stores
  std::string_view help;
  const MethodStages* stages;
  ElementOrder order;           // of its elements, unless another one is asked for
  bool takes_curve = true;      // another one may be asked for
  bool makes_charts = false;    // cuts and flattens the surface: has a curve and a locator to choose
  bool follows_tensor = false;  // samples under a tensor field: has segments, and rows of AnisotropyReport
};
inline constexpr auto sampling_methods = std::to_array<SamplingMethod>(
    {{{"auto", MethodChoice::automatic},
      "auto, the order that measures best (balanced bisection in space)",
      &direct_stages,
      ElementOrder::balanced,
      false},
     {{"conformal", MethodChoice::conformal},
      "a curve over a conformal chart",
      &conformal_stages,
      ElementOrder::hilbert,
      true,
      true},
     {{"direct", MethodChoice::direct}, "a curve in space", &direct_stages, ElementOrder::hilbert},
     {{"anisotropic", MethodChoice::anisotropic},
      "a curve over a chart conformal in the metric of a tensor field",
      &anisotropic_stages,
      ElementOrder::hilbert,
      true,
      true,
      true}});
static_assert(is_in_order(sampling_methods));

}  // namespace meander
