#include "io/parameters_text.h"

#include <fmt/format.h>

#include <set>

#include "io/store/store.h"

namespace meander {

namespace {

[[noreturn]] void refuse(std::string_view json) {
  throw RunError(RunError::Kind::unusable,
                 "the parameters of the store are not a JSON object: " + std::string(json));
}

// The position behind the text that begins with a quotation mark at `at`.
std::size_t end_of_text(std::string_view json, std::size_t at) {
  for (++at; at < json.size(); ++at) {
    if (json[at] == '\\')
      ++at;
    else if (json[at] == '"')
      return at + 1;
  }
  refuse(json);
}

// The position of the comma or bracket that ends the value which begins at `at`.
std::size_t end_of_value(std::string_view json, std::size_t at) {
  int depth = 0;
  while (at < json.size()) {
    const char c = json[at];
    if (c == '"') {
      at = end_of_text(json, at);
      continue;
    }
    if (depth == 0 && (c == ',' || c == '}')) return at;
    depth += c == '{' || c == '[' ? 1 : c == '}' || c == ']' ? -1 : 0;
    ++at;
  }
  refuse(json);
}

}  // namespace

std::map<std::string, std::string> split_members(std::string_view json) {
  std::map<std::string, std::string> members;
  if (json.size() < 2 || json.front() != '{' || json.back() != '}') refuse(json);
  for (std::size_t at = 1; at + 1 < json.size();) {
    if (json[at] != '"') refuse(json);
    const std::size_t name_end = end_of_text(json, at);
    if (name_end >= json.size() || json[name_end] != ':') refuse(json);
    const std::size_t end = end_of_value(json, name_end + 1);
    members[std::string(json.substr(at + 1, name_end - at - 2))] =
        json.substr(name_end + 1, end - name_end - 1);
    at = end + 1;
  }
  return members;
}

std::string join_members(const std::map<std::string, std::string>& members) {
  std::string text = "{";
  for (const auto& [name, value] : members) text += (text.size() > 1 ? ",\"" : "\"") + name + "\":" + value;
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
