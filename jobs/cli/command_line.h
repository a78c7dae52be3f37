// The command line: subcommands, and the variables that their options set. Every mistake is an error with a
// suggestion. Only command_line.cpp includes CLI11, whose header takes seconds to compile.
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

// An option or a positional argument as manual pages and completions show it.
struct OptionDescription {
  std::vector<std::string> flags;  // "-o", "--output"; empty for a positional argument
  std::string value;  // the placeholder of its value: its name (positional), N, X or TEXT; empty: a flag
  std::vector<std::string> words;  // the values that it accepts; empty: any
  std::string initial;             // the default as the help shows it; may be empty
  std::string help, heading;
  std::vector<std::string> needs, excludes;  // names of other options
  bool required = false, repeated = false, common = false;
};

// A command line that a help shows, and what it does.
struct CommandExample {
  std::string line, purpose;
};

// The program or a subcommand with its options and subcommands, in the order of the help and without those
// that the help does not show.
struct CommandDescription {
  std::string name, help, footer;
  std::vector<CommandExample> examples;
  std::vector<OptionDescription> options;
  std::vector<CommandDescription> subcommands;
};

// What the handles know of options and commands beside CLI11.
struct CommandMarks;

// A handle of an option or a positional argument, valid as long as its CommandLine. Checks and the functions
// of `on_given` run in the order in which they were added; all else may be set in any order.
class Option {
 public:
  Option(CLI::Option* option, CommandMarks* marks) : option_(option), marks_(marks) {}

  // Marks the option as one that the short help shows. A command without such options shows all of them.
  Option& common();
  // Shows the present value of the variable, or `text`, as the default in the help.
  Option& show_default();
  Option& show_default(const std::string& text);
  Option& required();
  // The two options cannot be given together.
  Option& excludes(const Option& other);
  // The option can be given only together with the other.
  Option& needs(const Option& other);
  // The members of a list may also be given in one argument, separated by this character.
  Option& separator(char character);
  // A list takes one argument each time its option is given, so that positional arguments may follow.
  Option& one_at_a_time();

  // The checks apply to each value. one_of: the error names all words, and the nearest one.
  Option& one_of(const std::vector<std::string>& words);
  // range: of a number, `low` to `high`, both included.
  Option& range(int low, int high);
  Option& range(std::uint64_t low, std::uint64_t high);
  Option& range(double low, double high);

  // An amount as a text, for parse_bytes and parse_seconds (units.h).
  Option& bytes();
  Option& seconds();

  // The function is called for each value that is given, not for the default.
  Option& on_given(std::function<void()> function);

 private:
  CLI::Option* option_;
  CommandMarks* marks_;
};

// A handle of the program or of a subcommand, valid as long as its CommandLine.
class Command {
 public:
  Command(CLI::App* command, CommandMarks* marks, std::string heading = "Options")
      : command_(command), marks_(marks), heading_(std::move(heading)) {}

  Command add_subcommand(const std::string& name, const std::string& help);
  // A subcommand that the help does not show and that accepts any arguments.
  Command add_hidden_subcommand(const std::string& name);
  // A subcommand that the help does not show.
  Command add_unlisted_subcommand(const std::string& name, const std::string& help);
  // The same command: options that are added by the returned handle stand under this heading of the help.
  Command under(const std::string& heading) const;
  // Adds a command line that the help begins with.
  void example(const std::string& line, const std::string& purpose);
  // Exactly one subcommand must be given.
  void require_subcommand();

  // An option ("-o,--output") or a positional argument ("STORE") with a value. Value is std::string, int,
  // std::uint32_t, std::uint64_t, double, or std::vector<std::string> for several. Whole numbers take
  // exponents and units (plain_count); the error of a number names the option as it was given and the form it
  // takes.
  template <class Value>
  Option add_option(const std::string& names, Value& variable, const std::string& help);
  // The same with a function that is called with the value, after the checks.
  Option add_option(const std::string& names, std::function<void(const std::string&)> function,
                    const std::string& help);
  // An option without a value: it sets the variable or calls the function.
  Option add_flag(const std::string& names, bool& variable, const std::string& help);
  Option add_flag(const std::string& names, std::function<void()> function, const std::string& help);

  // After parsing: whether this subcommand, or this option of the command, was given.
  bool chose(const std::string& subcommand) const;
  bool given(const std::string& option) const;
  // The options and positional arguments that were given, by their longest name.
  std::vector<std::string> all_given() const;

  // Everything that has been added so far.
  CommandDescription description() const;

 private:
  CLI::App* command_;
  CommandMarks* marks_;
  std::string heading_;
};

class CommandLine {
 public:
  // `version` is what --version prints; the help of the program and of its subcommands ends with `footer`.
  CommandLine(const std::string& name, const std::string& help, const std::string& version,
              const std::string& footer);
  ~CommandLine();

  Command program();
  // True: the variables are set. False: the help or the version was printed, and nothing is left to do.
  // Throws UsageError with one sentence; for an unknown option it names the nearest option of the subcommand.
  // Options may have their British spelling (--colour).
  bool parse(int argc, char** argv);

 private:
  std::unique_ptr<CommandMarks> marks_;  // outlives the options that refer to it
  std::unique_ptr<CLI::App> app_;
};

}  // namespace meander
