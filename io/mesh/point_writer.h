// Writing samples as files that other programs read.
#pragma once

#include <functional>
#include <string_view>

#include "kernels/sample/samples.h"

namespace meander {

enum class PointFormat : std::uint8_t { ply, off, xyz };

// PLY: binary little-endian with x y z nx ny nz, face (u v for parametric surfaces), density and, where
// there are colours, red green blue; OFF:
// vertices only (COFF-free, zero faces); XYZ: one `x y z nx ny nz` a line, shortest round-trip decimals. loc
// and scale are applied (file coordinates, double in OFF/XYZ/PLY). The bytes come in pieces of about 1 MB.
void write_points(const std::function<void(std::string_view)>& put, PointFormat format,
                  const Samples& samples, const ItemReport& report);

}  // namespace meander
