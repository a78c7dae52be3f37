#include "kernels/model/setting_texts.h"

#include <charconv>
#include <stdexcept>

#include "kernels/model/sample_settings.h"
#include "kernels/surface/surface_settings.h"

namespace meander {

namespace {

template <class Parameters>
using Lists = std::span<const SettingList<Parameters>* const>;

Lists<SurfaceSampleParameters> surface_lists() {
  static const SurfaceSettings* const lists[] = {&surface_settings()};
  return lists;
}

template <class Parameters>
std::string no_setting(const std::string& name, Lists<Parameters> lists) {
  std::vector<std::string> names;
  for (const auto* const list : lists)
    for (const auto& setting : list->items()) names.push_back(setting.name);
  const std::string near = nearest(name, names);
  return "there is no setting `" + name + "`" + (near.empty() ? "" : "; did you mean `" + near + "`?");
}

void throw_problems(const std::vector<std::string>& problems) {
  if (!problems.empty()) throw std::invalid_argument(joined_texts(problems, "; "));
}

// The parameters before they are settled and validated.
template <class Parameters>
Parameters taken(const Settings& given, Lists<Parameters> lists, std::vector<std::string>& problems) {
  Parameters parameters;
  const auto take = [&](const Setting<Parameters>& setting, const SettingText& value) {
    if (const std::string problem = setting.set(parameters, value.text()); !problem.empty())
      problems.push_back(setting.name + ": " + problem);
    return true;
  };
  const std::string unknown =
      take_named(lists, &Setting<Parameters>::name, given, parameters, problems, take);
  if (!unknown.empty()) problems.push_back(no_setting(unknown, lists));
  return parameters;
}

template <class Parameters>
std::vector<SettingInfo> all_settings(Lists<Parameters> lists) {
  const Parameters defaults;
  std::vector<SettingInfo> all;
  for (const auto* const list : lists)
    for (const Setting<Parameters>& setting : list->items()) {
      if (!setting.set) continue;
      const auto text = [](const auto& value) { return SettingText(value).text(); };
      all.push_back({setting.name,
                     setting.shows_default ? std::visit(text, setting.value(defaults)) : std::string(),
                     setting.words, setting.low, setting.high, setting.help});
    }
  return all;
}

}  // namespace

std::string SettingText::written(double number) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, number).ptr};
}

std::vector<SettingInfo> list_sampler_settings() { return all_settings(sample_settings()); }
std::vector<SettingInfo> list_surface_settings() { return all_settings(surface_lists()); }

SampleParameters parameters_of(const Settings& settings) {
  std::vector<std::string> problems;
  SampleParameters parameters = taken(settings, sample_settings(), problems);
  GivenSettings given;
  for (const auto& [name, value] : settings) given.insert(name);
  settle(parameters, given);
  if (problems.empty()) problems = validate(parameters);
  throw_problems(problems);
  return parameters;
}

SurfaceSampleParameters surface_parameters_of(const Settings& settings) {
  std::vector<std::string> problems;
  SurfaceSampleParameters parameters = taken(settings, surface_lists(), problems);
  if (problems.empty()) problems = validate(parameters);
  throw_problems(problems);
  return parameters;
}

}  // namespace meander
