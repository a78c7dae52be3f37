#include "jobs/parameter_table.h"

#include <algorithm>

namespace meander {

Option ParameterTable::add(Command& command, const char* name, const char* option, bool& variable,
                           const std::string& help) {
  record(name, variable);
  return command.add_flag(option, variable, help);
}

void ParameterTable::append(const ParameterTable& other) {
  members_.insert(members_.end(), other.members_.begin(), other.members_.end());
}

std::string ParameterTable::json() const {
  const auto rank = [](char c) { return c == '_' ? '\x7f' : c; };
  const auto before = [&](char a, char b) { return rank(a) < rank(b); };
  std::vector<Member> sorted = members_;
  std::sort(sorted.begin(), sorted.end(), [&](const Member& a, const Member& b) {
    return std::lexicographical_compare(a.first.begin(), a.first.end(), b.first.begin(), b.first.end(),
                                        before);
  });
  JsonWriter json;
  json.begin_object();
  for (const auto& [name, write] : sorted) write(json);
  json.end_object();
  return json.text();
}

}  // namespace meander
