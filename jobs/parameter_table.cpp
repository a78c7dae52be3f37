#include "jobs/parameter_table.h"

#include <algorithm>

#include "io/json/json_reader.h"

namespace meander {

Option ParameterTable::add(Command& command, const char* name, const char* option, bool& variable,
                           const std::string& help) {
  constant(name, variable);
  set_by(name, option);
  return command.add_flag(option, variable, help);
}

void ParameterTable::set_by(const char* name, std::string_view option) {
  options_[name] = option.substr(option.rfind(',') + 1);  // of "-n,--samples" the long one
}

std::vector<std::string> ParameterTable::arguments(const std::map<std::string, std::string>& members) const {
  std::vector<std::string> arguments;
  for (const auto& [name, value] : members) {
    const auto option = options_.find(name);
    if (option == options_.end() || value == "false") continue;
    arguments.push_back(option->second);
    if (value == "true") continue;
    arguments.push_back(value.starts_with('"')
                            ? *JsonObject("{\"value\":" + value + "}", "the parameters").text("value")
                            : value);
  }
  return arguments;
}

void ParameterTable::append(const ParameterTable& other) {
  members_.insert(members_.end(), other.members_.begin(), other.members_.end());
  options_.insert(other.options_.begin(), other.options_.end());
}

std::string ParameterTable::json() const {
  const auto rank = [](char c) { return c == '_' ? '\x7f' : c; };
  const auto before = [&](char a, char b) { return rank(a) < rank(b); };
  std::vector<Member> sorted = members_;
  std::sort(sorted.begin(), sorted.end(), [&](const Member& a, const Member& b) {
    return std::lexicographical_compare(a.name.begin(), a.name.end(), b.name.begin(), b.name.end(), before);
  });
  JsonWriter json;
  json.begin_object();
  for (const Member& member : sorted)
    if (!member.recorded || member.recorded()) member.write(json);
  json.end_object();
  return json.text();
}

}  // namespace meander
