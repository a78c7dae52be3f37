#include "jobs/python/sample_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "io/json/json_reader.h"
#include "jobs/cli/settings.h"
#include "kernels/core/joined_texts.h"
#include "kernels/density/density_text.h"
#include "kernels/density/formula_density.h"
#include "kernels/model/remesh_model.h"
#include "kernels/model/sample_settings.h"
#include "kernels/surface/surface_settings.h"

namespace meander {

namespace {

using Members = std::map<std::string, std::string>;  // values as JSON writes them

// False where the value is of another type or range.
template <class Number>
bool read(const std::string& written, Number& value) {
  const char* end = written.data() + written.size();
  const auto [read_to, error] = std::from_chars(written.data(), end, value);
  return error == std::errc() && read_to == end;
}
bool read(const std::string& written, double& value) {
  for (const double special : {std::nan(""), HUGE_VAL, -HUGE_VAL})
    if (written == fmt::format("\"{}\"", special)) {
      value = special;
      return true;
    }
  return read<double>(written, value);
}
bool read(const std::string& written, bool& value) {
  value = written == "true" || written == "1";
  return value || written == "false" || written == "0";
}

template <class Settings>
void take(const Setting<Settings>& setting, const std::string& written, Settings& settings,
          std::vector<std::string>& problems) {
  if (setting.number) {
    if (!std::visit([&](auto* number) { return read(written, *number); }, setting.number(settings)))
      throw OptionRefused(setting.keyword);
    return;
  }
  std::string text;
  bool yes = false;
  if (!setting.truth.first.empty() && read(written, yes))
    text = yes ? setting.truth.first : setting.truth.second;
  else if (setting.truth.first.empty() && written.starts_with('"'))
    text = text_of_json(written);
  else
    throw OptionRefused(setting.keyword);
  if (const std::string problem = setting.set(settings, text); !problem.empty())
    problems.push_back(setting.keyword + ": " + problem);
}

// Sets what the members say by keyword. Settings that changed and do not act are problems.
template <class Settings>
void take_keywords(const Members& members, std::span<const SettingList<Settings>* const> lists,
                   Settings& settings, std::vector<std::string>& problems) {
  const auto take_member = [&](const Setting<Settings>& setting, const std::string& written) {
    if (written == "null" && !setting.shows_default) return false;
    take(setting, written, settings, problems);
    return true;
  };
  const std::string unknown =
      take_named(lists, &Setting<Settings>::keyword, members, settings, problems, take_member);
  if (!unknown.empty()) throw OptionRefused(unknown);
}

void throw_problems(const std::vector<std::string>& problems) {
  if (!problems.empty()) throw std::invalid_argument(joined_texts(problems, "\n"));
}

// Numbers that the mesh has itself. True where the density is that.
bool take_own_density(Members& members, DensityParameters& density) {
  const auto given = members.find("density");
  if (given == members.end() || (given->second != "\"vertices\"" && given->second != "\"faces\""))
    return false;
  density.kind =
      given->second == "\"vertices\"" ? DensityKind::vertex_attribute : DensityKind::face_attribute;
  density.attribute = density_attribute;
  members.erase(given);
  return true;
}

// What meshes that are given as arrays do not have.
void check_density(const DensityParameters& density, std::vector<std::string>& problems) {
  if (is_formula(density.kind) && uses_coordinates(density))
    problems.emplace_back("density: `u` and `v` are texture coordinates, which meshes here do not have");
  if (reads_textures(density.kind))
    problems.push_back("density: `" + density_text(density) +
                       "` is read from the images of models; meshes here have none");
  if (form_of(density).text_member == &DensityParameters::attribute)
    problems.emplace_back("density: meshes here have no attributes: give the numbers themselves");
}

}  // namespace

SampleParameters sample_parameters(std::string_view json, bool of_files) {
  std::vector<std::string> problems;
  SampleParameters parameters;
  Members members = JsonObject(json, "options").members();
  const bool has_numbers = take_own_density(members, parameters.density);
  take_keywords<SampleParameters>(members, sample_settings(), parameters, problems);
  if (!has_numbers && !of_files) check_density(parameters.density, problems);
  // As in stores: what the images are is then in the samples too.
  if (reads_textures(parameters.density.kind)) parameters.columns[&Samples::rgb] = true;
  if (problems.empty()) problems = validate(parameters);
  throw_problems(problems);
  return parameters;
}

RemeshParameters remesh_parameters(std::string_view json) {
  std::vector<std::string> problems;
  RemeshParameters parameters;
  const SettingList<RemeshParameters>* const lists[] = {&remesh_settings()};
  take_keywords<RemeshParameters>(JsonObject(json, "options").members(), lists, parameters, problems);
  check_ranges(remesh_settings(), parameters, problems);
  throw_problems(problems);
  return parameters;
}

SurfaceSampleParameters surface_parameters(std::string_view json, double tolerance) {
  std::vector<std::string> problems;
  SurfaceSampleParameters parameters;
  parameters.tolerance = tolerance;
  const SurfaceSettings* const lists[] = {&surface_settings()};
  take_keywords<SurfaceSampleParameters>(JsonObject(json, "options").members(), lists, parameters, problems);
  if (problems.empty()) problems = validate(parameters);
  throw_problems(problems);
  return parameters;
}

}  // namespace meander
