#include "jobs/cli/settings.h"

#include <algorithm>

#include "io/json/json_reader.h"
#include "io/json_writer.h"

namespace meander {

namespace {

template <class Number>
Option add_number(Command& command, const std::string& names, Number& number, const std::string& help) {
  return command.add_option(names, number, help).show_default();
}
Option add_number(Command& command, const std::string& names, bool& flag, const std::string& help) {
  return command.add_flag(names, flag, help);
}

}  // namespace

void SettingOptions::add(Command command, const Member& member) {
  const SettingTexts& texts = *member.texts;
  const auto note = [given = given_, name = texts.name] { given->insert(name); };
  const auto wrong = [problems = problems_, option = texts.long_option()](const std::string& problem) {
    if (!problem.empty()) problems->push_back(option + ": " + problem);
  };
  if (member.acts)
    checks_.push_back([&texts, acts = member.acts, given = given_]() -> std::string {
      if (!given->contains(texts.name) || acts()) return "";
      return texts.long_option() + " " + texts.applies_to;
    });
  const auto add_option = [&]() -> Option {
    if (member.number) {
      Option option =
          std::visit([&](auto* number) { return add_number(command, texts.option, *number, texts.help); },
                     *member.number);
      if (texts.low < texts.high) option.range(texts.low, texts.high);
      if (!texts.shows_default) option.show_default("");
      return option;
    }
    if (texts.is_list) {
      const auto words = std::make_shared<std::vector<std::string>>();
      finishers_.push_back([words, wrong, set = member.set] {
        std::string text;
        for (const std::string& word : *words) text += (text.empty() ? "" : ",") + word;
        if (!words->empty()) wrong(set(text));
      });
      return command.add_option(texts.option, *words, texts.help).separator(',').one_at_a_time();
    }
    Option option = command.add_option(
        texts.option, [wrong, set = member.set](const std::string& text) { wrong(set(text)); }, texts.help);
    if (texts.shows_default) option.show_default(member.text);
    if (!texts.words.empty()) option.one_of(texts.words);
    return option;
  };
  Option option = add_option();
  if (texts.is_common) option.common();
  option.on_given(note);
}

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
