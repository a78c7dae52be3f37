// Settings with one home each: a list has each setting's name, option, range or words, help and member of a
// struct. The command line, stored parameters, Python and the pages of help are made from the list by loops.
#pragma once

#include <algorithm>
#include <charconv>
#include <concepts>
#include <cstdint>
#include <functional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include "kernels/core/check_range.h"
#include "kernels/core/spelling.h"
#include "kernels/core/words.h"

namespace meander {

// Joins the texts with `between`.
template <class Texts>
std::string joined_texts(const Texts& texts, const char* between = ", ") {
  std::string all;
  for (const auto& text : texts) all += (all.empty() ? "" : between) + std::string(text);
  return all;
}

// Calls take(word) for each text between commas, in order.
template <class Take>
void for_each_word(std::string_view text, const Take& take) {
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find(','));
    text.remove_prefix(std::min(text.size(), word.size() + 1));
    take(word);
  }
}

// Says what is wrong with a text that is none of the words: one sentence, with the nearest word.
template <class Texts>
std::string none_of(std::string_view text, const Texts& words) {
  const std::string near = nearest(text, words);
  return "`" + std::string(text) + "` is none of " + joined_texts(words, "|") +
         (near.empty() ? "" : "; did you mean `" + near + "`?");
}

using SettingValue = std::variant<bool, int, std::uint32_t, std::uint64_t, double, std::string>;

// The properties of a setting that do not depend on the struct it is in.
struct SettingTexts {
  std::string name;                           // in stored parameters
  std::string option;                         // "-n,--samples"; empty: none
  std::string heading;                        // of the option in the help
  std::string help;                           // of the option
  std::string keyword;                        // of Python; empty: none
  std::vector<std::string> words;             // the only texts that it takes; empty: any
  std::pair<std::string, std::string> truth;  // words for true and false in Python; empty: none
  double low = 0, high = 0;                   // of a number; equal: any
  bool is_list = false;       // the option may be repeated, or take several separated by commas
  bool shows_default = true;  // in the help
  bool is_common = false;     // the short help shows the option
  std::string applies_to;     // where it acts, for the error where it is given and does not
};

// A setting has a number (or flag), a text, or a value that follows from others and no option sets.
template <class Settings>
struct Setting : SettingTexts {
  using Number = std::variant<bool*, int*, std::uint32_t*, std::uint64_t*, double*>;

  std::function<Number(Settings&)> number;
  std::function<SettingValue(const Settings&)> value;
  std::function<std::string(Settings&, std::string_view)> set;  // returns what is wrong with the text, or ""
  std::function<bool(const Settings&)> recorded;                // empty: always
  std::function<bool(const Settings&)> acts;                    // whether it acts; empty: always

  // The option in the form "--samples".
  std::string long_option() const { return option.substr(option.rfind(',') + 1); }

  Setting& in_python(std::string as) { return keyword = std::move(as), *this; }
  Setting& as_truth(std::string yes, std::string no) {
    return truth = {std::move(yes), std::move(no)}, *this;
  }
  Setting& list() { return is_list = true, *this; }
  Setting& common() { return is_common = true, *this; }
  Setting& without_default() { return shows_default = false, *this; }
  Setting& only_recorded(std::function<bool(const Settings&)> when) {
    return recorded = std::move(when), *this;
  }
  Setting& acting(std::function<bool(const Settings&)> when, std::string where) {
    return acts = std::move(when), applies_to = std::move(where), *this;
  }
};

// Sets a number or a flag from a text, for flags "true" or "false". Returns what is wrong with the text, or
// "".
template <class Number>
std::string set_number(Number& number, std::string_view text, double low, double high) {
  Number value{};
  if constexpr (std::same_as<Number, bool>) {
    value = text == "true";
    if (!value && text != "false") return "`" + std::string(text) + "` is neither true nor false";
  } else {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size())
      return "`" + std::string(text) + "` is not a number that is possible here";
    std::vector<std::string> problems;
    if (low < high) check_range(problems, "it", static_cast<double>(value), low, high);
    if (!problems.empty()) return problems.front();
  }
  number = value;
  return "";
}

template <class Settings>
class SettingList {
 public:
  using Item = Setting<Settings>;

  // Puts the settings that follow under this heading of the help.
  void under(std::string heading) { heading_ = std::move(heading); }

  // Adds a number. `at` maps Settings to a reference to the number or flag, and const Settings likewise.
  template <class At>
  Item& number(std::string name, std::string option, At at, double low, double high, std::string help) {
    Item& item = add(std::move(name), std::move(option), std::move(help));
    item.low = low;
    item.high = high;
    item.number = [at](Settings& settings) { return typename Item::Number(&at(settings)); };
    item.value = [at](const Settings& settings) { return SettingValue(at(settings)); };
    item.set = [at, low, high](Settings& settings, std::string_view text) {
      return set_number(at(settings), text, low, high);
    };
    return item;
  }
  template <class At>
  Item& flag(std::string name, std::string option, At at, std::string help) {
    return number(std::move(name), std::move(option), at, 0, 0, std::move(help));
  }
  // Adds a choice among the words for the values of an enum (words.h); the words must live as long as the
  // list.
  template <class At, class Words>
  Item& word(std::string name, std::string option, At at, const Words& words, std::string help) {
    Item& item = text(
        std::move(name), std::move(option),
        [at, &words](const Settings& settings) { return std::string(text_of(words, at(settings))); },
        [at, &words](Settings& settings, std::string_view text) {
          return take_word(words, text, at(settings)) ? std::string() : none_of(text, all_words(words));
        },
        std::move(help));
    item.words = all_words(words);
    return item;
  }
  Item& text(std::string name, std::string option, std::function<std::string(const Settings&)> get,
             std::function<std::string(Settings&, std::string_view)> set, std::string help) {
    Item& item = add(std::move(name), std::move(option), std::move(help));
    item.value = [get = std::move(get)](const Settings& settings) { return SettingValue(get(settings)); };
    item.set = std::move(set);
    return item;
  }
  // Adds a value that follows from others, or that no option changes: it is only recorded.
  template <class Get>
  Item& constant(std::string name, Get get) {
    Item& item = add(std::move(name), "", "");
    item.value = [get](const Settings& settings) { return SettingValue(get(settings)); };
    return item;
  }
  // Adds the settings of a part.
  template <class Part>
  void append(const SettingList<Part>& of_part, Part Settings::*part) {
    for (const Setting<Part>& from : of_part.items()) {
      Item& item = items_.emplace_back();
      static_cast<SettingTexts&>(item) = from;
      item.heading = heading_;
      item.value = [get = from.value, part](const Settings& s) { return get(s.*part); };
      if (from.number) item.number = [at = from.number, part](Settings& s) { return at(s.*part); };
      if (from.set)
        item.set = [set = from.set, part](Settings& s, std::string_view text) { return set(s.*part, text); };
      if (from.recorded)
        item.recorded = [is = from.recorded, part](const Settings& s) { return is(s.*part); };
      if (from.acts) item.acts = [is = from.acts, part](const Settings& s) { return is(s.*part); };
    }
  }

  std::span<const Item> items() const { return items_; }

 private:
  Item& add(std::string name, std::string option, std::string help) {
    Item& item = items_.emplace_back();
    item.name = std::move(name);
    item.option = std::move(option);
    item.help = std::move(help);
    item.heading = heading_;
    return item;
  }
  std::vector<Item> items_;
  std::string heading_ = "Options";
};

// Names of the settings that the user gave.
using GivenSettings = std::set<std::string, std::less<>>;

// Sets what is given by names: take(setting, value) sets a value, or adds a problem, and returns whether the
// setting is now given. `name`: the member that names go by, Setting::name or Setting::keyword. Adds a
// sentence for every setting that was changed and does not act. Returns a name that no setting has, or "".
template <class Settings, class Given, class Take>
std::string take_named(std::span<const SettingList<Settings>* const> lists, std::string SettingTexts::*name,
                       const Given& given, const Settings& settings, std::vector<std::string>& problems,
                       const Take& take) {
  const Settings defaults = settings;
  std::vector<const Setting<Settings>*> taken;
  std::set<std::string_view> known;
  for (const SettingList<Settings>* const list : lists)
    for (const Setting<Settings>& setting : list->items()) {
      const auto found = (setting.*name).empty() ? given.end() : given.find(setting.*name);
      if (found == given.end()) continue;
      known.insert(found->first);
      if (take(setting, found->second)) taken.push_back(&setting);
    }
  for (const auto& [other, value] : given)
    if (!known.contains(other)) return other;
  for (const Setting<Settings>* const setting : taken)
    if (setting->acts && !setting->acts(settings) && setting->value(settings) != setting->value(defaults))
      problems.push_back(setting->*name + " " + setting->applies_to);
  return "";
}

// Adds a sentence for every number out of its range.
template <class Settings>
void check_ranges(const SettingList<Settings>& list, const Settings& settings,
                  std::vector<std::string>& problems) {
  for (const Setting<Settings>& setting : list.items()) {
    if (!(setting.low < setting.high)) continue;
    std::string words = setting.name;
    for (char& c : words)
      if (c == '_') c = ' ';
    std::visit(
        [&](const auto& value) {
          if constexpr (!std::same_as<std::decay_t<decltype(value)>, std::string>)
            check_range(problems, words.c_str(), static_cast<double>(value), setting.low, setting.high);
        },
        setting.value(settings));
  }
}

}  // namespace meander
