#include "io/parameters_text.h"

#include <fmt/format.h>

#include <set>

#include "io/json/json_reader.h"
#include "io/json_writer.h"
#include "io/run_error.h"

namespace meander {

std::map<std::string, std::string> split_members(std::string_view json) {
  return JsonObject(json, fmt::format("the parameters of the store `{}`", json)).members();
}

std::string join_members(const std::map<std::string, std::string>& members) {
  std::string text = "{";
  for (const auto& [name, value] : members) {
    JsonWriter quoted;
    quoted.value(name);
    text += (text.size() > 1 ? "," : "") + quoted.text() + ":" + value;
  }
  return text + "}";
}

std::string parameter_differences(std::string_view before, std::string_view now) {
  if (before == now) return {};
  std::map<std::string, std::string> was, is;
  try {
    was = split_members(before);
    is = split_members(now);
  } catch (const RunError&) {
    return fmt::format("the parameters were {}, now they are {}", before, now);
  }
  std::set<std::string> names;
  for (const auto* const members : {&was, &is})
    for (const auto& [name, value] : *members) names.insert(name);
  std::string text;
  for (const std::string& name : names) {
    const auto a = was.find(name), b = is.find(name);
    if (a != was.end() && b != is.end() && a->second == b->second) continue;
    text += fmt::format("{}parameter \"{}\" was {}", text.empty() ? "" : "; ", name,
                        a == was.end() ? "not given" : a->second);
    text += b == is.end() ? " and is not given now" : ", now it is " + b->second;
  }
  return text;
}

}  // namespace meander
