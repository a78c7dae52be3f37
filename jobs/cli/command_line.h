// The command line: subcommands and the variables that their options set. Every mistake is an error with a
// suggestion. command_line.cpp is the only source that includes CLI11, whose header takes seconds to compile.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace meander {

// What an option or a positional argument looks like from outside.
struct OptionDescription {
  std::vector<std::string> flags;  // "-o", "--output"; empty for a positional argument
  std::string value;  // what stands for its value: its name (positional), N, X or TEXT; empty: a flag
  std::vector<std::string> words;  // the only values that it takes; empty: any
  std::string initial;             // the default as the help shows it; may be empty
  std::string help, heading;
  bool required = false, repeated = false;
};

// The program or a subcommand with all that belongs to it, in the order of the help; what the help does not
// show is left out.
struct CommandDescription {
  std::string name, help, footer;
  std::vector<OptionDescription> options;
  std::vector<CommandDescription> subcommands;
};

// A handle of an option or a positional argument, valid as long as its CommandLine. All functions but the
// checks may be called in any order; checks and `on_given` run in the order in which they were added.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  // Shows the present value of the variable, or `text`, as the default in the help.
  Option& show_default();
  Option& show_default(const std::string& text);
  Option& required();
  // Neither may be given together with the other.
  Option& excludes(const Option& other);
  // May be given only together with the other.
  Option& needs(const Option& other);
  // A list may also be given as one argument, its members separated by this character.
  Option& separator(char character);
  // A list takes one argument each time the option is given, so that others may follow it.
  Option& one_at_a_time();

  // Checks of each value. One of the words; the error names all words and the nearest one.
  Option& one_of(const std::vector<std::string>& words);
  // From `low` to `high`, both included.
  Option& range(int low, int high);
  Option& range(std::uint64_t low, std::uint64_t high);
  Option& range(double low, double high);
  // Digits only: with a minus sign, an unsigned number would become a huge one.
  Option& whole_number();

  // Called for each value that is given, not for the default.
  Option& on_given(std::function<void()> function);

 private:
  CLI::Option* option_;
};

// A handle of the program or of a subcommand, valid as long as its CommandLine.
class Command {
 public:
  explicit Command(CLI::App* command, std::string heading = "Options")
      : command_(command), heading_(std::move(heading)) {}

  Command add_subcommand(const std::string& name, const std::string& help);
  // A subcommand that the help does not show and that accepts any arguments.
  Command add_hidden_subcommand(const std::string& name);
  // A subcommand that the help does not show.
  Command add_unlisted_subcommand(const std::string& name, const std::string& help);
  // The same command; options added by the handle returned are under this heading of the help.
  Command under(const std::string& heading) const;
  // Exactly one subcommand must be given.
  void require_subcommand();

  // An option ("-o,--output") or a positional argument ("STORE") with a value. Value is std::string, int,
  // std::uint32_t, std::uint64_t, double, or std::vector<std::string>, which takes several.
  template <class Value>
  Option add_option(const std::string& names, Value& variable, const std::string& help);
  // The same with a function that takes the value, after the checks.
  Option add_option(const std::string& names, std::function<void(const std::string&)> function,
                    const std::string& help);
  // An option without a value, which sets the variable or calls the function.
  Option add_flag(const std::string& names, bool& variable, const std::string& help);
  Option add_flag(const std::string& names, std::function<void()> function, const std::string& help);

  // After parsing: whether this subcommand, or this option of the command, was given.
  bool chose(const std::string& subcommand) const;
  bool given(const std::string& option) const;
  // The options and positional arguments that were given, by their longest name.
  std::vector<std::string> all_given() const;

  // Everything that has been added so far, for manual pages and completions.
  CommandDescription description() const;

 private:
  CLI::App* command_;
  std::string heading_;
};

class CommandLine {
 public:
  // `version` is what --version prints; the help of the program and of its subcommands ends with `footer`.
  CommandLine(const std::string& name, const std::string& help, const std::string& version,
              const std::string& footer);
  ~CommandLine();

  Command program();
  // True: the variables are set. False: the help or the version was printed, and there is nothing else to do.
  // Throws UsageError with one sentence; for unknown options it names the nearest one of the subcommand.
  bool parse(int argc, char** argv);

 private:
  std::unique_ptr<CLI::App> app_;
};

}  // namespace meander
