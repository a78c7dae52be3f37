// Lists of settings (kernels/core/setting.h) as options of a command, as parameters that a store records, and
// as keywords of Python.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "jobs/cli/command_line.h"
#include "kernels/core/setting.h"

namespace meander {

// ---- options

// The options of a command that set settings. The object, the lists and the settings must live as long as the
// command line.
class SettingOptions {
 public:
  // Adds an option for every setting that has one. The present values are the defaults.
  template <class Settings>
  void add(const Command& command, const SettingList<Settings>& list, Settings& settings) {
    for (const Setting<Settings>& setting : list.items()) {
      if (setting.option.empty()) continue;
      Member member{.texts = &setting, .set = [&setting, &settings](std::string_view text) {
                      return setting.set(settings, text);
                    }};
      if (setting.number)
        member.number = setting.number(settings);
      else
        member.text = std::get<std::string>(setting.value(settings));
      if (setting.acts) member.acts = [&setting, &settings] { return setting.acts(settings); };
      add(command.under(setting.heading), member);
    }
  }
  // Called after parsing: sets the settings that take several values. Adds one sentence for every invalid
  // text, and for every setting that was given and has no effect.
  void finish(std::vector<std::string>& problems) const;
  const GivenSettings& given() const { return *given_; }

 private:
  // A setting of one object.
  struct Member {
    const SettingTexts* texts;
    std::optional<SettingNumber> number = {};
    std::string text = {};  // the present value of one that is no number
    std::function<std::string(std::string_view)> set;
    std::function<bool()> acts = {};
  };
  void add(Command command, const Member& member);

  std::shared_ptr<GivenSettings> given_ = std::make_shared<GivenSettings>();
  std::shared_ptr<std::vector<std::string>> problems_ = std::make_shared<std::vector<std::string>>();
  std::vector<std::function<void()>> finishers_;
  std::vector<std::function<std::string()>> checks_;  // a problem, or ""
};

// ---- stored parameters

using RecordedSettings = std::vector<std::pair<std::string, SettingValue>>;

// Adds the values that the settings record.
template <class Settings>
void record(const SettingList<Settings>& list, const Settings& settings, RecordedSettings& recorded) {
  for (const Setting<Settings>& setting : list.items())
    if (!setting.recorded || setting.recorded(settings))
      recorded.emplace_back(setting.name, setting.value(settings));
}

// One line of JSON with the members in the order of all stores: by name, `_` after the letters.
std::string json_of(RecordedSettings recorded);

// A value as JSON: 2048, true, "auto".
std::string json_of(const SettingValue& value);
// The text of such a value, without quotes. Throws RunError(unusable).
std::string text_of_json(const std::string& written);

// Sets every setting whose recorded value differs from its present one, and adds its name to `given`.
// members: see split_members (io/parameters_text.h). Returns what is wrong with the first invalid one, or "".
template <class Settings>
std::string take_recorded(const SettingList<Settings>& list,
                          const std::map<std::string, std::string>& members, Settings& settings,
                          GivenSettings& given) {
  for (const Setting<Settings>& setting : list.items()) {
    const auto member = members.find(setting.name);
    if (!setting.set || member == members.end() || json_of(setting.value(settings)) == member->second)
      continue;
    if (const std::string problem = setting.set(settings, text_of_json(member->second)); !problem.empty())
      return "parameter \"" + setting.name + "\": " + problem;
    given.insert(setting.name);
  }
  return "";
}

}  // namespace meander
