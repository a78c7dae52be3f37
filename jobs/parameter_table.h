// The parameters that a store records as JSON. Most of them are options: one line gives the option (names,
// help, checks), the variable that holds its default and later its value, and its name in the JSON.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "io/json_writer.h"
#include "jobs/command_line.h"
#include "jobs/option_words.h"

namespace meander {

class ParameterTable {
 public:
  // Adds an option to `command`, its default shown in the help, and records its value under `name`. Variables
  // must live as long as the table.
  template <class Value>
  Option add(Command& command, const char* name, const char* option, Value& variable,
             const std::string& help) {
    constant(name, variable);
    set_by(name, option);
    return command.add_option(option, variable, help).show_default();
  }
  // A flag.
  Option add(Command& command, const char* name, const char* option, bool& variable, const std::string& help);
  // One of several words for the values of an enum.
  template <class Enum, std::size_t N>
  Option add(Command& command, const char* name, const char* option, Enum& variable,
             const Word<Enum> (&words)[N], const std::string& help) {
    compute(name, option, [&variable, &words] { return text_of(words, variable); });
    return command
        .add_option(
            option, [&variable, &words](const std::string& text) { variable = value_of(words, text); }, help)
        .show_default(text_of(words, variable))
        .one_of(all_words(words));
  }

  // Records a value that no option sets.
  template <class Value>
  void constant(const char* name, const Value& variable) {
    derive(name, [&variable]() -> const Value& { return variable; });
  }
  template <class Value>
  void constant(const char* name, const Value&& temporary) = delete;
  // Records a value that follows from other members when the JSON is written: who repeats those has it.
  template <class Function>
  void derive(const char* name, Function value) {
    members_.push_back(
        {name, [name, value = std::move(value)](JsonWriter& json) { json.member(name, value()); }, {}});
  }
  // Records a value that an option added elsewhere sets, computed when the JSON is written; where `recorded`
  // is given and false it is left out.
  template <class Function>
  void compute(const char* name, const char* option, Function value, std::function<bool()> recorded = {}) {
    derive(name, std::move(value));
    members_.back().recorded = std::move(recorded);
    set_by(name, option);
  }
  // Adds the members of another table.
  void append(const ParameterTable& other);

  // The arguments of a command line that give these members (names and values as in the JSON) by their
  // options; members that no option sets are left out. Throws RunError(unusable) for a text that is not JSON.
  std::vector<std::string> arguments(const std::map<std::string, std::string>& members) const;

  // One line, the members in the order that stores have had so far: by name, `_` after the letters.
  std::string json() const;

 private:
  struct Member {
    std::string name;
    std::function<void(JsonWriter&)> write;
    std::function<bool()> recorded;  // empty: always
  };
  void set_by(const char* name, std::string_view option);

  std::vector<Member> members_;
  std::map<std::string, std::string> options_;  // by member
};

}  // namespace meander
