// Settings with one home each: a list has each setting's name, option, range or words, help and member of a
// struct. The command line, stored parameters, Python and the pages of help are made from the list by loops.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "kernels/core/joined_texts.h"
#include "kernels/core/spelling.h"
#include "kernels/core/words.h"

namespace meander {

// Calls take(word) for each text between commas, in order.
template <class Take>
void for_each_word(std::string_view text, const Take& take) {
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find(','));
    text.remove_prefix(std::min(text.size(), word.size() + 1));
    take(word);
  }
}

using SettingValue = std::variant<bool, int, std::uint32_t, std::uint64_t, double, std::string>;
// A number or a flag of a struct.
using SettingNumber = std::variant<bool*, int*, std::uint32_t*, std::uint64_t*, double*>;

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

  // The option in the form "--samples".
  std::string long_option() const;
};

// A setting has a number (or flag), a text, or a value that follows from others and no option sets.
template <class Settings>
struct Setting : SettingTexts {
  std::function<SettingNumber(Settings&)> number;
  std::function<SettingValue(const Settings&)> value;
  std::function<std::string(Settings&, std::string_view)> set;  // returns what is wrong with the text, or ""
  std::function<bool(const Settings&)> recorded;                // empty: always
  std::function<bool(const Settings&)> acts;                    // whether it acts; empty: always

  Setting& in_python(std::string_view as) { return keyword = as, *this; }
  Setting& as_truth(std::string yes, std::string no) {
    return truth = {std::move(yes), std::move(no)}, *this;
  }
  Setting& list() { return is_list = true, *this; }
  Setting& common() { return is_common = true, *this; }
  Setting& without_default() { return shows_default = false, *this; }
  Setting& only_recorded(std::function<bool(const Settings&)> when) {
    return recorded = std::move(when), *this;
  }
  Setting& acting(std::function<bool(const Settings&)> when, std::string_view where) {
    return acts = std::move(when), applies_to = where, *this;
  }
};

// Sets a number or a flag from a text, for flags "true" or "false". The limits hold for numbers if low <
// high. Returns what is wrong with the text, or "".
std::string set_number(SettingNumber number, std::string_view text, double low, double high);

template <class Settings>
class SettingList {
 public:
  using Item = Setting<Settings>;

  // Puts the settings that follow under this heading of the help.
  void under(std::string_view heading) { heading_ = heading; }

  // Adds a number. `at` maps Settings to a reference to the number or flag, and const Settings likewise.
  template <class At>
  Item& number(std::string_view name, std::string_view option, At at, double low, double high,
               std::string_view help) {
    Item& item = add(name, option, help);
    item.low = low;
    item.high = high;
    item.number = [at](Settings& settings) { return SettingNumber(&at(settings)); };
    item.value = [at](const Settings& settings) { return SettingValue(at(settings)); };
    item.set = setter(item.number, low, high);
    return item;
  }
  template <class At>
  Item& flag(std::string_view name, std::string_view option, At at, std::string_view help) {
    return number(name, option, at, 0, 0, help);
  }
  // Adds a choice among the words for the values of an enum (words.h); the words must live as long as the
  // list.
  template <class At, class Words>
  Item& word(std::string_view name, std::string_view option, At at, const Words& words,
             std::string_view help) {
    Item& item = text(
        name, option,
        [at, &words](const Settings& settings) { return std::string(text_of(words, at(settings))); },
        [at, &words](Settings& settings, std::string_view text) {
          return take_word(words, text, at(settings)) ? std::string() : none_of(text, all_words(words));
        },
        help);
    item.words = all_words(words);
    return item;
  }
  Item& text(std::string_view name, std::string_view option, std::function<std::string(const Settings&)> get,
             std::function<std::string(Settings&, std::string_view)> set, std::string_view help) {
    Item& item = add(name, option, help);
    item.value = [get = std::move(get)](const Settings& settings) { return SettingValue(get(settings)); };
    item.set = std::move(set);
    return item;
  }
  // Adds a value that follows from others, or that no option changes: it is only recorded.
  template <class Get>
  Item& constant(std::string_view name, Get get) {
    Item& item = add(name, "", "");
    item.value = [get](const Settings& settings) { return SettingValue(get(settings)); };
    return item;
  }
  // Adds the settings of a part, which must live as long as this list.
  template <class Part>
  void append(const SettingList<Part>& of_part, Part Settings::*part) {
    for (const Setting<Part>& from : of_part.items()) {
      Item& item = items_.emplace_back();
      static_cast<SettingTexts&>(item) = from;
      item.heading = heading_;
      item.value = [&from, part](const Settings& s) { return from.value(s.*part); };
      if (from.number) item.number = [&from, part](Settings& s) { return from.number(s.*part); };
      if (from.set)
        item.set = [&from, part](Settings& s, std::string_view text) { return from.set(s.*part, text); };
      if (from.recorded) item.recorded = [&from, part](const Settings& s) { return from.recorded(s.*part); };
      if (from.acts) item.acts = [&from, part](const Settings& s) { return from.acts(s.*part); };
    }
  }

  std::span<const Item> items() const { return items_; }

 private:
  Item& add(std::string_view name, std::string_view option, std::string_view help) {
    Item& item = items_.emplace_back();
    item.name = name;
    item.option = option;
    item.help = help;
    item.heading = heading_;
    return item;
  }
  static auto setter(std::function<SettingNumber(Settings&)> number, double low, double high) {
    return [number = std::move(number), low, high](Settings& settings, std::string_view text) {
      return set_number(number(settings), text, low, high);
    };
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

// Adds a sentence when the number is out of the setting's range.
void check_range(const SettingTexts& setting, const SettingValue& value, std::vector<std::string>& problems);

// Adds a sentence for every number out of its range.
template <class Settings>
void check_ranges(const SettingList<Settings>& list, const Settings& settings,
                  std::vector<std::string>& problems) {
  for (const Setting<Settings>& setting : list.items())
    if (setting.low < setting.high) check_range(setting, setting.value(settings), problems);
}

}  // namespace meander
