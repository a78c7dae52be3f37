#include "jobs/cli/settings.h"

#include <algorithm>

#include "io/json/json_reader.h"
#include "io/json_writer.h"

namespace meander {

void SettingOptions::finish(std::vector<std::string>& problems) const {
  for (const auto& finisher : finishers_) finisher();
  problems.insert(problems.end(), problems_->begin(), problems_->end());
  for (const auto& check : checks_)
    if (const std::string problem = check(); !problem.empty()) problems.push_back(problem);
}

std::string json_of(RecordedSettings recorded) {
  const auto rank = [](char c) { return c == '_' ? '\x7f' : c; };
  const auto before = [&](char a, char b) { return rank(a) < rank(b); };
  std::sort(recorded.begin(), recorded.end(), [&](const auto& a, const auto& b) {
    return std::lexicographical_compare(a.first.begin(), a.first.end(), b.first.begin(), b.first.end(),
                                        before);
  });
  return json_object([&](JsonWriter& json) {
    for (const auto& [name, value] : recorded)
      std::visit([&, &name = name](const auto& content) { json.member(name, content); }, value);
  });
}

std::string json_of(const SettingValue& value) {
  JsonWriter json;
  std::visit([&](const auto& content) { json.value(content); }, value);
  return json.text();
}

std::string text_of_json(const std::string& written) {
  if (!written.starts_with('"')) return written;
  return *JsonObject("{\"value\":" + written + "}", "the parameters").text("value");
}

}  // namespace meander
