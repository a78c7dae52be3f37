#include "kernels/surface/formula_surface.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "kernels/core/expression.h"
#include "kernels/core/status.h"
#include "kernels/surface/digest_bytes.h"

namespace meander {

namespace {

constexpr std::array<std::string_view, 2> formula_parameters = {"u", "v"};

std::string without_blanks(std::string_view text) {
  std::string rest(text);
  std::erase_if(rest, [](char c) { return c == ' ' || c == '\t'; });
  return rest;
}

template <class Jet>
std::vector<Jet> with_derivatives(std::span<const double> parameter, double by_u, double by_v) {
  std::vector<Jet> jets;
  jets.reserve(parameter.size());
  for (const double value : parameter) jets.emplace_back(value, by_u, by_v);
  return jets;
}

class FormulaSurface final : public ParametricSurface {
 public:
  FormulaSurface(std::string name, std::vector<Expression> axes)
      : name_(std::move(name)), axes_(std::move(axes)) {}

  std::string_view name() const override { return name_; }

  std::array<std::uint8_t, 16> content() const override {
    DigestBytes digest;
    for (const char c : name_) digest.add(std::uint64_t{static_cast<unsigned char>(c)});
    return digest.bytes();
  }

  void positions(std::span<const double> u, std::span<const double> v,
                 std::span<Vector3> result) const override {
    const auto [x, y, z] = values<double>(u, v);
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = finite({x[i], y[i], z[i]}, u[i], v[i]);
  }

  void tangents(std::span<const double> u, std::span<const double> v,
                std::span<SurfaceTangents> result) const override {
    const auto [x, y, z] = values<Jet1>(with_derivatives<Jet1>(u, 1, 0), with_derivatives<Jet1>(v, 0, 1));
    for (std::size_t i = 0; i < result.size(); ++i)
      result[i] = {finite({x[i].f, y[i].f, z[i].f}, u[i], v[i]), slope({x[i].u, y[i].u, z[i].u}, u[i], v[i]),
                   slope({x[i].v, y[i].v, z[i].v}, u[i], v[i])};
  }

  void jets(std::span<const double> u, std::span<const double> v,
            std::span<SurfaceJet> result) const override {
    const auto [x, y, z] = values<Jet2>(with_derivatives<Jet2>(u, 1, 0), with_derivatives<Jet2>(v, 0, 1));
    for (std::size_t i = 0; i < result.size(); ++i)
      result[i] = {finite({x[i].f, y[i].f, z[i].f}, u[i], v[i]),
                   slope({x[i].u, y[i].u, z[i].u}, u[i], v[i]),
                   slope({x[i].v, y[i].v, z[i].v}, u[i], v[i]),
                   {x[i].uu, y[i].uu, z[i].uu},
                   {x[i].uv, y[i].uv, z[i].uv},
                   {x[i].vv, y[i].vv, z[i].vv}};
  }

 private:
  template <class Scalar>
  std::array<std::vector<Scalar>, 3> values(std::span<const Scalar> u, std::span<const Scalar> v) const {
    const std::array<std::span<const Scalar>, 2> inputs = {u, v};
    std::array<std::vector<Scalar>, 3> result;
    for (std::size_t k = 0; k < 3; ++k) {
      result[k].resize(u.size());
      axes_[k].evaluate(ExpressionInputs<Scalar>(inputs), std::span(result[k]));
    }
    return result;
  }

  [[noreturn]] void fail(const char* what, double u, double v) const {
    char place[64];
    std::snprintf(place, sizeof place, "u = %.6g, v = %.6g", u, v);
    throw ItemError(Status::non_finite, "the surface `" + name_ + "` has no " + what + " at " + place +
                                            ": its formulas must be finite for all u and v from 0 to 1");
  }

  Vector3 finite(const Vector3& p, double u, double v) const {
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) fail("position", u, v);
    return p;
  }
  // Infinite derivatives occur at borders such as that of a dome. Where there is no derivative, an area would
  // be lost silently.
  Vector3 slope(const Vector3& d, double u, double v) const {
    if (std::isnan(d.x) || std::isnan(d.y) || std::isnan(d.z)) fail("derivative", u, v);
    return d;
  }

  std::string name_;
  std::vector<Expression> axes_;
};

}  // namespace

bool is_surface_formula(std::string_view text) { return split_formulas(text).size() > 1; }

std::unique_ptr<ParametricSurface> make_formula_surface(std::string_view text) {
  const std::vector<std::string_view> parts = split_formulas(text);
  if (parts.size() != 3)
    throw std::invalid_argument("the surface \"" + std::string(text) + "\" has " +
                                std::to_string(parts.size()) +
                                " formulas: it needs three, for x, y and z, separated by commas");
  std::vector<Expression> axes;
  for (const std::string_view part : parts) axes.emplace_back(part, formula_parameters);
  return std::make_unique<FormulaSurface>(without_blanks(text), std::move(axes));
}

}  // namespace meander
