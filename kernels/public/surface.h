// <meander/surface.h>: samples parametric surfaces f: [0, 1]^2 -> R^3 without meshing them.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include "samples.h"
#include "settings.h"
#include "status.h"

namespace meander {

// Writes the positions of n parameters (u, v) in [0, 1]^2, both ends included, to 3 n numbers x, y, z. May be
// called from several threads at once, so it must be a pure function.
using SurfaceFunction =
    std::function<void(std::span<const double> u, std::span<const double> v, std::span<double> positions)>;

// The surfaces that have a name:
//   plane            the unit square
//   sphere           radius 1; u longitude, v from the north to the south pole
//   torus            radii 1 and 0.5; u around the axis, v around the tube
//   eight            (cos a sin 2b, sin a sin 2b, sin b), a in [0, 2 pi], b in [-pi/2, pi/2]: pinched at 0
//   monkey-saddle    z = x^3 - 3 x y^2 over [-1, 1]^2
//   klein-bottle     the figure-8 immersion, radius 2
//   stretched-plane  the unit square with x = u^8: extreme stretch in u
std::span<const std::string_view> surface_names();

// shape: one of these names, or three formulas in u and v with commas between them, as "u, v, sin(6*u)".
//
// A surface that cannot be sampled does not throw: see SampleReport::status. Throws std::invalid_argument for
// other shapes and, as Sampler does, for settings; RunCanceled when `cancel` is set. About 20 evaluations a
// patch (a few thousand patches on smooth surfaces) and 1.5 a sample.
SampledModel sample_surface(std::string_view shape, const Settings& settings = {},
                            const CancelToken& cancel = {});

// The same of a function, whose derivatives are differences: about 1e-9 of the size for the first, 1e-6 for
// the second; some 10 calls for each that a formula takes. content: names the surface, see Sampler::sample;
// empty: a digest of 17 x 17 positions. What the function throws ends the work and passes through.
SampledModel sample_surface(const SurfaceFunction& function, const Settings& settings = {},
                            std::span<const std::uint8_t> content = {}, const CancelToken& cancel = {});

}  // namespace meander
