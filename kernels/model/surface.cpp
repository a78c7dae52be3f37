#include "kernels/public/surface.h"

#include <stdexcept>
#include <string>
#include <utility>

#include "kernels/core/setting.h"
#include "kernels/data/row_or_failure.h"
#include "kernels/model/setting_texts.h"
#include "kernels/surface/formula_surface.h"
#include "kernels/surface/function_surface.h"
#include "kernels/surface/surface_row.h"

namespace meander {

namespace {

std::unique_ptr<ParametricSurface> surface_of(std::string_view shape) {
  if (is_surface_formula(shape)) return make_formula_surface(shape);
  std::unique_ptr<ParametricSurface> surface = make_surface(shape);
  if (!surface) throw std::invalid_argument("surface: " + none_of(shape, surface_names()));
  return surface;
}

template <class Make>
SampledModel sampled(const Make& make, const Settings& settings, const CancelToken& cancel) {
  const SurfaceSampleParameters parameters = surface_parameters_of(settings);
  Row row = row_or_failure("sample_surface", [&] {
    const auto& surface = make();
    return surface_row(*surface, sample_surface(*surface, parameters, cancel));
  });
  return {std::move(static_cast<SampleReport&>(row.report)), std::move(row.samples), {}};
}

}  // namespace

SampledModel sample_surface(std::string_view shape, const Settings& settings, const CancelToken& cancel) {
  return sampled([&] { return surface_of(shape); }, settings, cancel);
}

SampledModel sample_surface(const SurfaceFunction& function, const Settings& settings,
                            std::span<const std::uint8_t> content, const CancelToken& cancel) {
  return sampled([&] { return std::make_unique<FunctionSurface>(function, content); }, settings, cancel);
}

}  // namespace meander
