#include "jobs/python/laboratory_call.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "kernels/model/model_sampler.h"

namespace meander {

namespace {

[[noreturn]] void refuse(std::string_view name, const char* what) {
  throw std::invalid_argument(fmt::format("{} {}", name, what));
}

template <class Value>
Value given(std::string_view name, const std::optional<Value>& value, const char* what) {
  if (!value) refuse(name, what);
  return *value;
}

}  // namespace

LaboratoryArguments::LaboratoryArguments(std::string_view options, std::vector<GivenArray> arrays,
                                         LaboratorySubject subject)
    : options_(options), arrays_(std::move(arrays)), subject_(std::move(subject)) {}

bool LaboratoryArguments::has(std::string_view name) const {
  return options_.root().member(name) ||
         std::any_of(arrays_.begin(), arrays_.end(), [&](const GivenArray& a) { return a.name == name; });
}

double LaboratoryArguments::real(std::string_view name) const {
  return given(name, options_.root().member(name).number(), "must be a number");
}

double LaboratoryArguments::real(std::string_view name, double otherwise) const {
  return has(name) ? real(name) : otherwise;
}

std::uint64_t LaboratoryArguments::whole(std::string_view name) const {
  return given(name, options_.root().member(name).count(), "must be a whole number from 0 to 2^53");
}

std::uint64_t LaboratoryArguments::whole(std::string_view name, std::uint64_t otherwise) const {
  return has(name) ? whole(name) : otherwise;
}

std::string LaboratoryArguments::text(std::string_view name) const {
  return std::string(given(name, options_.root().member(name).text(), "must be a text"));
}

std::string LaboratoryArguments::text(std::string_view name, const std::string& otherwise) const {
  return has(name) ? text(name) : otherwise;
}

bool LaboratoryArguments::flag(std::string_view name) const {
  return has(name) && given(name, options_.root().member(name).truth(), "must be true or false");
}

std::vector<std::string> LaboratoryArguments::words(std::string_view name) const {
  std::vector<std::string> result;
  for (const JsonValue& word : options_.root().member(name).items())
    result.emplace_back(given(name, word.text(), "must be a list of texts"));
  return result;
}

const GivenArray& LaboratoryArguments::array(std::string_view name) const {
  const auto found =
      std::find_if(arrays_.begin(), arrays_.end(), [&](const GivenArray& a) { return a.name == name; });
  if (found == arrays_.end()) refuse(name, "must be an array");
  return *found;
}

const GivenArray& LaboratoryArguments::array(std::string_view name, std::uint64_t columns) const {
  const GivenArray& found = array(name);
  if (found.columns != columns)
    throw std::invalid_argument(
        fmt::format("{} has {} columns where {} are needed", name, found.columns, columns));
  return found;
}

std::uint64_t LaboratoryArguments::columns(std::string_view name) const { return array(name).columns; }

namespace {

template <class Value>
std::span<const Value> values_of(const GivenArray& array, const char* what) {
  const auto* const values = std::get_if<std::span<const Value>>(&array.values);
  if (values == nullptr) refuse(array.name, what);
  return *values;
}

}  // namespace

std::span<const double> LaboratoryArguments::reals(std::string_view name, std::uint64_t columns) const {
  return values_of<double>(array(name, columns), "must be real numbers");
}

std::span<const float> LaboratoryArguments::floats(std::string_view name, std::uint64_t columns) const {
  return values_of<float>(array(name, columns), "must be of the type float32");
}

std::span<const std::uint32_t> LaboratoryArguments::numbers(std::string_view name,
                                                            std::uint64_t columns) const {
  return values_of<std::uint32_t>(array(name, columns), "must be whole numbers from 0 to 2^32 - 1");
}

std::span<const std::uint8_t> LaboratoryArguments::bytes(std::string_view name, std::uint64_t columns) const {
  return values_of<std::uint8_t>(array(name, columns), "must be of the type uint8");
}

std::vector<double> LaboratoryArguments::column(std::string_view name, std::uint64_t columns,
                                                std::uint64_t number) const {
  const std::span<const double> all = reals(name, columns);
  std::vector<double> values;
  for (std::size_t i = number; i < all.size(); i += columns) values.push_back(all[i]);
  return values;
}

PolygonMesh LaboratoryArguments::mesh() const {
  if (subject_.mesh) return *subject_.mesh;
  return polygon_mesh_of({reals("vertices", 3), numbers("faces", 3)});
}

const Model& LaboratoryArguments::staged() const {
  if (!subject_.staged) throw std::invalid_argument("a model that was staged is needed");
  return *subject_.staged;
}

}  // namespace meander
