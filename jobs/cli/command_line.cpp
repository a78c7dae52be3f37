#include "jobs/cli/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <memory>
#include <set>
#include <type_traits>

#include "jobs/cli/units.h"
#include "jobs/cli/usage_error.h"
#include "kernels/core/spelling.h"

namespace meander {

namespace {

// The name of the validator of options that take one of several words; its description lists them.
constexpr const char* words_validator = "words";

// Replaces CLI::Range, whose error message differs between versions of CLI11.
template <class Value>
CLI::Validator range_validator(Value low, Value high) {
  const std::string lowest = fmt::format("{}", low), highest = fmt::format("{}", high);
  return {[=](std::string& input) -> std::string {
            Value value{};
            const bool is_inside = CLI::detail::lexical_cast(input, value) && value >= low && value <= high;
            return is_inside ? "" : "Value " + input + " not in range " + lowest + " to " + highest;
          },
          fmt::format("{} in [{} - {}]", CLI::detail::type_name<Value>(), lowest, highest), ""};
}

// Writes what follows the names of an option in the help, the same for every version of CLI11.
class OptionFormatter : public CLI::Formatter {
 public:
  std::string make_option_opts(const CLI::Option* option) const override {
    std::string text;
    if (option->get_type_size() != 0) {
      if (!option->get_type_name().empty()) text += " " + option->get_type_name();
      if (!option->get_default_str().empty()) text += "=" + option->get_default_str();
      if (option->get_expected_max() == CLI::detail::expected_max_vector_size) text += " ...";
      if (option->get_required()) text += " REQUIRED";
    }
    const auto names_of = [](const std::set<CLI::Option*>& others) {
      std::string names;
      for (const CLI::Option* other : others) names += " " + other->get_name();
      return names;
    };
    if (!option->get_needs().empty()) text += " Needs:" + names_of(option->get_needs());
    if (!option->get_excludes().empty()) text += " Excludes:" + names_of(option->get_excludes());
    return text;
  }
};

}  // namespace

// ---- Option ----------------------------------------------------------------------------------------------

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

Option& Option::one_of(const std::vector<std::string>& words, const std::vector<std::string>& also) {
  std::string list;
  for (const std::string& word : words) list += (list.empty() ? "" : "|") + word;
  const auto problem = [words, also, list](const std::string& input) -> std::string {
    for (const std::vector<std::string>* known : {&words, &also})
      if (std::find(known->begin(), known->end(), input) != known->end()) return {};
    const std::string near = nearest(input, words);
    return "`" + input + "` is none of " + list + (near.empty() ? "" : "; did you mean `" + near + "`?");
  };
  option_->check(problem, list, words_validator);
  return *this;
}

Option& Option::range(int low, int high) {
  option_->check(range_validator(low, high));
  return *this;
}

Option& Option::range(std::uint64_t low, std::uint64_t high) {
  option_->check(range_validator(low, high));
  return *this;
}

Option& Option::range(double low, double high) {
  option_->check(range_validator(low, high));
  return *this;
}

Option& Option::whole_number() {
  option_->check([](const std::string& input) -> std::string {
    const bool digits = !input.empty() && input.find_first_not_of("0123456789") == std::string::npos;
    if (!digits) return "`" + input + "` is not a whole number";
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(input.data(), input.data() + input.size(), value);
    return error == std::errc() ? std::string() : "`" + input + "` is larger than 2^64 - 1";
  });
  return *this;
}

Option& Option::on_given(std::function<void()> function) {
  option_->each([function = std::move(function)](const std::string&) { function(); });
  return *this;
}

// ---- Command ---------------------------------------------------------------------------------------------

Command Command::add_subcommand(const std::string& name, const std::string& help) {
  return Command(command_->add_subcommand(name, help));
}

Command Command::add_hidden_subcommand(const std::string& name) {
  CLI::App* command = command_->add_subcommand(name)->group("");
  command->set_help_flag();
  command->prefix_command();
  return Command(command);
}

Command Command::add_unlisted_subcommand(const std::string& name, const std::string& help) {
  return Command(command_->add_subcommand(name, help)->group(""));
}

Command Command::under(const std::string& heading) const { return Command(command_, heading); }

void Command::require_subcommand() { command_->require_subcommand(1); }

template <class Value>
Option Command::add_option(const std::string& names, Value& variable, const std::string& help) {
  CLI::Option* const option = command_->add_option(names, variable, help)->group(heading_);
  if constexpr (std::is_integral_v<Value>)  // before the checks
    option->transform([](const std::string& text) { return plain_count(text); }, "");
  return Option(option);
}

template Option Command::add_option(const std::string&, std::string&, const std::string&);
template Option Command::add_option(const std::string&, int&, const std::string&);
template Option Command::add_option(const std::string&, std::uint32_t&, const std::string&);
template Option Command::add_option(const std::string&, std::uint64_t&, const std::string&);
template Option Command::add_option(const std::string&, double&, const std::string&);
template Option Command::add_option(const std::string&, std::vector<std::string>&, const std::string&);

Option Command::add_option(const std::string& names, std::function<void(const std::string&)> function,
                           const std::string& help) {
  return Option(command_->add_option_function<std::string>(names, function, help)->group(heading_));
}

Option Command::add_flag(const std::string& names, bool& variable, const std::string& help) {
  return Option(command_->add_flag(names, variable, help)->group(heading_));
}

Option Command::add_flag(const std::string& names, std::function<void()> function, const std::string& help) {
  return Option(command_->add_flag_callback(names, std::move(function), help)->group(heading_));
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

OptionDescription description_of(CLI::Option& option) {
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
  return description;
}

CommandDescription description_of(CLI::App& command) {
  CommandDescription description{command.get_name(), command.get_description(), command.get_footer(), {}, {}};
  for (CLI::Option* option : command.get_options())
    if (!option->get_group().empty()) description.options.push_back(description_of(*option));
  for (CLI::App* subcommand : command.get_subcommands({}))
    if (!subcommand->get_group().empty()) description.subcommands.push_back(description_of(*subcommand));
  return description;
}

}  // namespace

CommandDescription Command::description() const { return description_of(*command_); }

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

CommandLine::CommandLine(const std::string& name, const std::string& help, const std::string& version,
                         const std::string& footer)
    : app_(std::make_unique<CLI::App>(help, name)) {
  app_->formatter(std::make_shared<OptionFormatter>());
  app_->set_version_flag("--version", version);
  app_->footer(footer);
}

CommandLine::~CommandLine() = default;

Command CommandLine::program() { return Command(app_.get()); }

bool CommandLine::parse(int argc, char** argv) {
  try {
    app_->parse(argc, argv);
  } catch (const CLI::Success& help) {
    app_->exit(help);  // prints it
    return false;
  } catch (const CLI::ParseError& error) {
    throw UsageError(explain(*app_, error));
  }
  return true;
}

}  // namespace meander
