// The analytic surfaces with names. To add one, put its formula here and its type into the list at the end.
#include <algorithm>
#include <numbers>

#include "kernels/surface/analytic_surface.h"

namespace meander {

std::array<std::uint8_t, 16> ParametricSurface::content() const {
  std::array<std::uint8_t, 16> bytes{};
  const std::string_view text = name().substr(0, bytes.size());
  std::copy(text.begin(), text.end(), bytes.begin());
  return bytes;
}

namespace {

using std::numbers::pi;

struct Plane {
  static constexpr std::string_view name = "plane";
  template <class Scalar>
  std::array<Scalar, 3> operator()(const Scalar& u, const Scalar& v) const {
    return {u, v, Scalar(0.0)};
  }
};

struct Sphere {
  static constexpr std::string_view name = "sphere";
  template <class Scalar>
  std::array<Scalar, 3> operator()(const Scalar& u, const Scalar& v) const {
    const auto [cos_u, sin_u] = cosine_sine(2 * pi * u);
    const auto [cos_v, sin_v] = cosine_sine(pi * v);
    return {cos_u * sin_v, sin_u * sin_v, -cos_v};
  }
};

struct Torus {
  static constexpr std::string_view name = "torus";
  template <class Scalar>
  std::array<Scalar, 3> operator()(const Scalar& u, const Scalar& v) const {
    const auto [cos_u, sin_u] = cosine_sine(2 * pi * u);
    const auto [cos_v, sin_v] = cosine_sine(2 * pi * v);
    const Scalar radius = Scalar(1.0) + 0.5 * cos_v;
    return {radius * cos_u, radius * sin_u, 0.5 * sin_v};
  }
};

struct Eight {
  static constexpr std::string_view name = "eight";
  template <class Scalar>
  std::array<Scalar, 3> operator()(const Scalar& u, const Scalar& v) const {
    const auto [cos_a, sin_a] = cosine_sine(2 * pi * u);
    const Scalar b = pi * (v - Scalar(0.5));
    const Scalar sin_2b = cosine_sine(2 * b).sine;
    return {cos_a * sin_2b, sin_a * sin_2b, cosine_sine(b).sine};
  }
};

struct MonkeySaddle {
  static constexpr std::string_view name = "monkey-saddle";
  template <class Scalar>
  std::array<Scalar, 3> operator()(const Scalar& u, const Scalar& v) const {
    const Scalar x = 2 * u - Scalar(1.0), y = 2 * v - Scalar(1.0);
    return {x, y, x * (x * x - 3 * (y * y))};
  }
};

struct KleinBottle {
  static constexpr std::string_view name = "klein-bottle";
  template <class Scalar>
  std::array<Scalar, 3> operator()(const Scalar& u, const Scalar& v) const {
    const auto [cos_u, sin_u] = cosine_sine(2 * pi * u);
    const auto [cos_half, sin_half] = cosine_sine(pi * u);
    const Scalar sin_v = cosine_sine(2 * pi * v).sine, sin_2v = cosine_sine(4 * pi * v).sine;
    const Scalar radius = Scalar(2.0) + cos_half * sin_v - sin_half * sin_2v;
    return {radius * cos_u, radius * sin_u, sin_half * sin_v + cos_half * sin_2v};
  }
};

struct StretchedPlane {
  static constexpr std::string_view name = "stretched-plane";
  template <class Scalar>
  std::array<Scalar, 3> operator()(const Scalar& u, const Scalar& v) const {
    return {integer_power(u, 8), v, Scalar(0.0)};
  }
};

template <class... Formulas>
struct Registry {
  static constexpr std::array<std::string_view, sizeof...(Formulas)> names = {Formulas::name...};
  static std::unique_ptr<ParametricSurface> make(std::string_view name) {
    std::unique_ptr<ParametricSurface> result;
    const auto try_one = [&]<class Formula>(const Formula&) {
      if (Formula::name == name) result = std::make_unique<AnalyticSurface<Formula>>();
    };
    (try_one(Formulas{}), ...);
    return result;
  }
};

using NamedSurfaces = Registry<Plane, Sphere, Torus, Eight, MonkeySaddle, KleinBottle, StretchedPlane>;

}  // namespace

std::unique_ptr<ParametricSurface> make_surface(std::string_view name) { return NamedSurfaces::make(name); }

std::span<const std::string_view> surface_names() { return NamedSurfaces::names; }

}  // namespace meander
