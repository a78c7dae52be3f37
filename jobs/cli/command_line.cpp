#include "jobs/cli/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string_view>
#include <type_traits>
#include <utility>

#include "jobs/cli/command_help.h"
#include "jobs/cli/terminal.h"
#include "jobs/cli/units.h"
#include "jobs/cli/usage_error.h"
#include "kernels/core/spelling.h"

namespace meander {

struct CommandMarks {
  struct Range {
    std::string low, high;  // as messages show them
    long double from = 0, to = 0;
  };
  std::set<const CLI::Option*> common;
  std::map<const CLI::Option*, Range> ranges;
  std::map<const CLI::App*, std::vector<CommandExample>> examples;
  std::vector<std::string> arguments;  // that are being parsed
};

namespace {

// The name of the validator of options that take one of several words; its description lists them.
constexpr const char* words_validator = "words";

// The name of the option as it was given, else its longest one.
std::string given_name(const CLI::Option& option, const std::vector<std::string>& arguments) {
  for (const std::string& argument : arguments) {
    for (const std::string& name : option.get_lnames())
      if (argument == "--" + name || argument.starts_with("--" + name + "=")) return "--" + name;
    for (const std::string& name : option.get_snames())
      if (argument.starts_with("-" + name)) return "-" + name;
  }
  return option.get_name();
}

// "a whole number from 1 to 9"
template <class Value>
std::string form_of(const std::optional<CommandMarks::Range>& range) {
  std::string form = std::is_integral_v<Value> ? "a whole number" : "a number";
  if (range) form += " from " + range->low + " to " + range->high;
  if (!std::is_integral_v<Value>) return form + (range ? "" : " such as 0.5");
  if (range && (range->from > 2048 || range->to < 10000)) return form;
  return form + (range ? ", such as 2048 or 10k" : " such as 2048 or 10k");
}

// The text of a number without exponent and unit. Throws UsageError for any that the option does not take.
template <class Value>
std::string number_text(const std::string& text, const CLI::Option& option, const CommandMarks& marks) {
  const std::string plain = std::is_integral_v<Value> ? plain_count(text) : text;
  const auto found = marks.ranges.find(&option);
  const auto range = found == marks.ranges.end() ? std::nullopt : std::optional(found->second);
  Value value{};
  const auto [end, error] = std::from_chars(plain.data(), plain.data() + plain.size(), value);
  const auto exact = static_cast<long double>(value);
  const bool is_number = end == plain.data() + plain.size() && !plain.empty() && std::isfinite(exact);
  if (is_number && error == std::errc() && (!range || (exact >= range->from && exact <= range->to)))
    return plain;
  std::string form = form_of<Value>(range);
  if (is_number && !range && error == std::errc::result_out_of_range && std::is_integral_v<Value>)
    form = fmt::format("a whole number up to {}", std::numeric_limits<Value>::max());
  throw UsageError(fmt::format("{} takes {}, not `{}`", given_name(option, marks.arguments), form, text));
}

}  // namespace

// ---- Option ----------------------------------------------------------------------------------------------

Option& Option::common() {
  marks_->common.insert(option_);
  return *this;
}

Option& Option::show_default() {
  option_->capture_default_str();
  return *this;
}

Option& Option::show_default(const std::string& text) {
  option_->default_str(text);
  return *this;
}

Option& Option::required() {
  option_->required();
  return *this;
}

Option& Option::excludes(const Option& other) {
  option_->excludes(other.option_);
  return *this;
}

Option& Option::needs(const Option& other) {
  option_->needs(other.option_);
  return *this;
}

Option& Option::separator(char character) {
  option_->delimiter(character);
  return *this;
}

Option& Option::one_at_a_time() {
  option_->allow_extra_args(false);
  return *this;
}

Option& Option::one_of(const std::vector<std::string>& words) {
  std::string list;
  for (const std::string& word : words) list += (list.empty() ? "" : "|") + word;
  const auto problem = [words, list](const std::string& input) -> std::string {
    if (std::find(words.begin(), words.end(), input) != words.end()) return {};
    const std::string near = nearest(input, words);
    return "`" + input + "` is none of " + list + (near.empty() ? "" : "; did you mean `" + near + "`?");
  };
  option_->check(problem, list, words_validator);
  return *this;
}

namespace {

template <class Value>
void set_range(CommandMarks& marks, const CLI::Option* option, Value low, Value high) {
  marks.ranges[option] = {fmt::format("{}", low), fmt::format("{}", high), static_cast<long double>(low),
                          static_cast<long double>(high)};
}

}  // namespace

Option& Option::range(int low, int high) { return set_range(*marks_, option_, low, high), *this; }

Option& Option::range(std::uint64_t low, std::uint64_t high) {
  return set_range(*marks_, option_, low, high), *this;
}

Option& Option::range(double low, double high) { return set_range(*marks_, option_, low, high), *this; }

namespace {

// Checks that take(text) accepts the text; `form` is what the option takes.
template <class Take>
void check_amount(CLI::Option* option, const CommandMarks* marks, const char* form, const Take& take) {
  option->check([=](const std::string& text) -> std::string {
    try {
      take(text);
    } catch (const UsageError&) {
      throw UsageError(
          fmt::format("{} takes {}, not `{}`", given_name(*option, marks->arguments), form, text));
    }
    return {};
  });
}

}  // namespace

Option& Option::bytes() {
  check_amount(option_, marks_, "a size such as 4G or 512M (K, M, G, T)", parse_bytes);
  return *this;
}

Option& Option::seconds() {
  check_amount(option_, marks_, "a time such as 90s or 2m (ms, s, m, h)", parse_seconds);
  return *this;
}

Option& Option::on_given(std::function<void()> function) {
  option_->each([function = std::move(function)](const std::string&) { function(); });
  return *this;
}

// ---- Command ---------------------------------------------------------------------------------------------

Command Command::add_subcommand(const std::string& name, const std::string& help) {
  return Command(command_->add_subcommand(name, help), marks_);
}

Command Command::add_hidden_subcommand(const std::string& name) {
  CLI::App* command = command_->add_subcommand(name)->group("");
  command->set_help_flag();
  command->set_help_all_flag();
  command->prefix_command();
  return Command(command, marks_);
}

Command Command::add_unlisted_subcommand(const std::string& name, const std::string& help) {
  return Command(command_->add_subcommand(name, help)->group(""), marks_);
}

Command Command::under(const std::string& heading) const { return Command(command_, marks_, heading); }

void Command::example(const std::string& line, const std::string& purpose) {
  marks_->examples[command_].push_back({line, purpose});
}

void Command::require_subcommand() { command_->require_subcommand(1); }

template <class Value>
Option Command::add_option(const std::string& names, Value& variable, const std::string& help) {
  CLI::Option* const option = command_->add_option(names, variable, help)->group(heading_);
  if constexpr (std::is_arithmetic_v<Value>)  // before the checks
    option->transform([option, marks = marks_](
                          const std::string& text) { return number_text<Value>(text, *option, *marks); },
                      "");
  return Option(option, marks_);
}

template Option Command::add_option(const std::string&, std::string&, const std::string&);
template Option Command::add_option(const std::string&, int&, const std::string&);
template Option Command::add_option(const std::string&, std::uint32_t&, const std::string&);
template Option Command::add_option(const std::string&, std::uint64_t&, const std::string&);
template Option Command::add_option(const std::string&, double&, const std::string&);
template Option Command::add_option(const std::string&, std::vector<std::string>&, const std::string&);

Option Command::add_option(const std::string& names, std::function<void(const std::string&)> function,
                           const std::string& help) {
  return Option(command_->add_option_function<std::string>(names, function, help)->group(heading_), marks_);
}

Option Command::add_flag(const std::string& names, bool& variable, const std::string& help) {
  return Option(command_->add_flag(names, variable, help)->group(heading_), marks_);
}

Option Command::add_flag(const std::string& names, std::function<void()> function, const std::string& help) {
  return Option(command_->add_flag_callback(names, std::move(function), help)->group(heading_), marks_);
}

bool Command::chose(const std::string& subcommand) const { return command_->got_subcommand(subcommand); }

bool Command::given(const std::string& option) const { return command_->count(option) > 0; }

std::vector<std::string> Command::all_given() const {
  std::vector<std::string> names;
  for (const CLI::Option* option : command_->get_options())
    if (option->count() > 0) names.push_back(option->get_name());
  return names;
}

namespace {

std::vector<std::string> words_of(CLI::Option& option) {
  std::vector<std::string> words;
  try {
    std::string list = option.get_validator(words_validator)->get_description();
    for (std::size_t bar = 0; !list.empty(); list.erase(0, bar == std::string::npos ? bar : bar + 1)) {
      bar = list.find('|');
      words.push_back(list.substr(0, bar));
    }
  } catch (const CLI::OptionNotFound&) {
    // The option accepts any value.
  }
  return words;
}

OptionDescription description_of(CLI::Option& option, const CommandMarks& marks) {
  OptionDescription description;
  for (const std::string& name : option.get_snames()) description.flags.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) description.flags.push_back("--" + name);
  const bool takes_value = option.get_items_expected_max() > 0;
  if (description.flags.empty())
    description.value = option.get_single_name();
  else if (takes_value)
    description.value = option.get_type_name().starts_with("TEXT")    ? "TEXT"
                        : option.get_type_name().starts_with("FLOAT") ? "X"
                                                                      : "N";
  description.words = words_of(option);
  description.initial = option.get_default_str();
  description.help = option.get_description();
  description.heading = option.get_group();
  description.required = option.get_required();
  description.repeated = option.get_items_expected_max() > 1;
  description.common = marks.common.contains(&option);
  // In the order of their names: the sets of CLI11 are in the order of addresses.
  const auto names_of = [](const std::set<CLI::Option*>& others) {
    std::vector<std::string> names;
    for (const CLI::Option* other : others) names.push_back(other->get_name());
    std::sort(names.begin(), names.end());
    return names;
  };
  description.needs = names_of(option.get_needs());
  description.excludes = names_of(option.get_excludes());
  return description;
}

CommandDescription description_of(CLI::App& command, const CommandMarks& marks) {
  CommandDescription description;
  description.name = command.get_name();
  description.help = command.get_description();
  description.footer = command.get_footer();
  if (const auto shown = marks.examples.find(&command); shown != marks.examples.end())
    description.examples = shown->second;
  for (CLI::Option* option : command.get_options())
    if (!option->get_group().empty()) description.options.push_back(description_of(*option, marks));
  for (CLI::App* subcommand : command.get_subcommands({}))
    if (!subcommand->get_group().empty())
      description.subcommands.push_back(description_of(*subcommand, marks));
  return description;
}

}  // namespace

CommandDescription Command::description() const { return description_of(*command_, *marks_); }

// ---- CommandLine -----------------------------------------------------------------------------------------

namespace {

// The message for one argument that the subcommand does not take.
std::string explain_extra(const CLI::App& command, const std::string& word) {
  std::vector<std::string> candidates;
  if (!word.starts_with("-")) {
    for (const CLI::App* subcommand : command.get_subcommands({}))
      candidates.push_back(subcommand->get_name());
    const std::string near = nearest(word, candidates);
    return "`" + word + "` was not expected" + (near.empty() ? "" : ", did you mean `" + near + "`?");
  }
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) candidates.push_back("--" + name);
  const std::string bare = word.substr(0, word.find('='));
  const std::string near = nearest(bare, candidates);
  if (!word.starts_with("--") && word.find(',') != std::string::npos)
    return "unknown option `" + word + "`; write a formula that begins with a minus as 0 - x instead of -x";
  return "unknown option `" + bare + "`" + (near.empty() ? "" : ", did you mean `" + near + "`?");
}

// The message for a missing or misspelled command.
std::string explain_missing_command(const CLI::App& command) {
  std::vector<std::string> names;
  std::string list;
  for (const CLI::App* subcommand : command.get_subcommands({})) {
    if (subcommand->get_group().empty()) continue;  // hidden
    names.push_back(subcommand->get_name());
    list += (list.empty() ? "" : ", ") + names.back();
  }
  const std::vector<std::string> words = command.remaining();
  const auto word =
      std::find_if(words.begin(), words.end(), [](const std::string& w) { return !w.starts_with("-"); });
  if (word == words.end()) return "a command is missing: " + list;
  const std::string near = nearest(*word, names);
  return "`" + *word + "` is not a command" +
         (near.empty() ? ": the commands are " + list : ", did you mean `" + near + "`?");
}

std::string explain(const CLI::App& program, const CLI::ParseError& error) {
  const CLI::App* command = &program;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
  if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr && command->get_require_subcommand_min() > 0)
    return explain_missing_command(*command);
  // The option that is missing may be a misspelled one.
  const bool misses = dynamic_cast<const CLI::RequiredError*>(&error) != nullptr;
  if (!misses && dynamic_cast<const CLI::ExtrasError*>(&error) == nullptr) return error.what();
  std::string text = misses ? error.what() : "";
  for (const std::string& word : program.remaining(true))
    text += (text.empty() ? "" : "; ") + explain_extra(*command, word);
  return text.empty() ? std::string(error.what()) : text;
}

}  // namespace

namespace {

// The option in American spelling, which all options have.
std::string american(std::string argument) {
  constexpr std::pair<std::string_view, std::string_view> spellings[] = {{"colour", "color"},
                                                                         {"neighbour", "neighbor"},
                                                                         {"normalis", "normaliz"},
                                                                         {"parameteris", "parameteriz"}};
  for (const auto& [british, spelled] : spellings) {
    const std::size_t at = argument.find(british);
    if (at < argument.find('=')) argument.replace(at, british.size(), spelled);
  }
  return argument;
}

void print_help(CLI::App& program, const CommandMarks& marks, HelpScope scope) {
  CLI::App* command = &program;
  std::string words = program.get_name();
  while (!command->get_subcommands().empty()) {
    command = command->get_subcommands().front();
    words += " " + command->get_name();
  }
  fmt::print("{}",
             command_help(description_of(*command, marks), words, scope, terminal_width(STDOUT_FILENO)));
}

}  // namespace

CommandLine::CommandLine(const std::string& name, const std::string& help, const std::string& version,
                         const std::string& footer)
    : marks_(std::make_unique<CommandMarks>()), app_(std::make_unique<CLI::App>(help, name)) {
  app_->set_help_flag("-h,--help", "Show examples and the common options");
  app_->set_help_all_flag("--help-all", "Show all options");
  app_->set_version_flag("--version", version);
  app_->footer(footer);
}

CommandLine::~CommandLine() = default;

Command CommandLine::program() { return Command(app_.get(), marks_.get()); }

bool CommandLine::parse(int argc, char** argv) {
  std::vector<std::string>& arguments = marks_->arguments;
  arguments.assign(argv, argv + argc);
  const auto options_end = std::find(arguments.begin(), arguments.end(), "--");
  for (auto argument = arguments.begin(); argument != options_end; ++argument)
    if (argument->starts_with("--")) *argument = american(*argument);
  std::vector<const char*> pointers;
  for (const std::string& argument : arguments) pointers.push_back(argument.c_str());
  try {
    app_->parse(argc, pointers.data());
  } catch (const CLI::CallForHelp&) {
    print_help(*app_, *marks_, HelpScope::common);
    return false;
  } catch (const CLI::CallForAllHelp&) {
    print_help(*app_, *marks_, HelpScope::all);
    return false;
  } catch (const CLI::Success& version) {
    app_->exit(version);  // prints it
    return false;
  } catch (const CLI::ParseError& error) {
    throw UsageError(explain(*app_, error));
  }
  return true;
}

}  // namespace meander
