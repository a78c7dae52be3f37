// How the sides of points were decided.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace meander {

// See kernels/query/surface_sides.h. The numbers are part of the store format.
enum class SignRule : std::uint8_t { none = 0, shell = 1, winding = 2, closed = 3 };
inline constexpr std::array<std::string_view, 4> sign_rule_names = {"none", "shell", "winding", "closed"};
constexpr std::string_view name_of(SignRule rule) { return sign_rule_names[static_cast<std::size_t>(rule)]; }

}  // namespace meander
