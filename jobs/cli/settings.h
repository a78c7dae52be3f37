// Lists of settings (kernels/core/setting.h) as options of a command, as parameters that a store records, and
// as keywords of Python.
#pragma once

#include <fmt/format.h>

#include <functional>
#include <map>
#include <memory>
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
    for (const Setting<Settings>& setting : list.items())
      if (!setting.option.empty()) add(command.under(setting.heading), setting, settings);
  }
  // Called after parsing: sets the settings that take several values. Adds one sentence for every invalid
  // text, and for every setting that was given and has no effect.
  void finish(std::vector<std::string>& problems) const;
  const GivenSettings& given() const { return *given_; }

 private:
  template <class Settings>
  void add(Command command, const Setting<Settings>& setting, Settings& settings) {
    const auto note = [given = given_, name = setting.name] { given->insert(name); };
    const auto wrong = [problems = problems_, option = setting.long_option()](const std::string& problem) {
      if (!problem.empty()) problems->push_back(option + ": " + problem);
    };
    if (setting.acts)
      checks_.push_back([&setting, &settings, given = given_]() -> std::string {
        if (!given->contains(setting.name) || setting.acts(settings)) return "";
        return setting.long_option() + " " + setting.applies_to;
      });
    if (setting.number) {
      std::visit(
          [&](auto* number) {
            Option option = add_number(command, setting.option, *number, setting.help);
            if (setting.low < setting.high) option.range(setting.low, setting.high);
            if (!setting.shows_default) option.show_default("");
            if (setting.is_common) option.common();
            option.on_given(note);
          },
          setting.number(settings));
    } else if (setting.is_list) {
      const auto texts = std::make_shared<std::vector<std::string>>();
      Option option = command.add_option(setting.option, *texts, setting.help);
      option.separator(',').one_at_a_time().on_given(note);
      if (setting.is_common) option.common();
      finishers_.push_back([texts, wrong, &setting, &settings] {
        if (!texts->empty()) wrong(setting.set(settings, joined_texts(*texts, ",")));
      });
    } else {
      Option option = command.add_option(
          setting.option,
          [wrong, &setting, &settings](const std::string& text) { wrong(setting.set(settings, text)); },
          setting.help);
      if (setting.shows_default) option.show_default(std::get<std::string>(setting.value(settings)));
      if (!setting.words.empty()) option.one_of(setting.words);
      if (setting.is_common) option.common();
      option.on_given(note);
    }
  }
  template <class Number>
  static Option add_number(Command& command, const std::string& names, Number& number,
                           const std::string& help) {
    return command.add_option(names, number, help).show_default();
  }
  static Option add_number(Command& command, const std::string& names, bool& flag, const std::string& help) {
    return command.add_flag(names, flag, help);
  }

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
