#include "jobs/command_line.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace meander {

namespace {

// A positive number and the unit behind it.
std::pair<double, std::string> number_and_unit(const std::string& text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || !std::isfinite(number) || number < 0)
    throw CLI::ValidationError(text, "is not a number with a unit");
  std::string unit(end, text.data() + text.size());
  std::transform(unit.begin(), unit.end(), unit.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return {number, unit};
}

}  // namespace

std::uint64_t parse_bytes(const std::string& text) {
  auto [number, unit] = number_and_unit(text);
  if (unit.ends_with("ib")) unit.resize(unit.size() - 2);
  if (unit.ends_with('b')) unit.resize(unit.size() - 1);
  const std::string_view prefixes = "kmgt";
  if (!unit.empty()) {
    const std::size_t power = unit.size() == 1 ? prefixes.find(unit[0]) : std::string_view::npos;
    if (power == std::string_view::npos)
      throw CLI::ValidationError(text, "has an unknown unit; use K, M, G or T (powers of 1024)");
    number = std::ldexp(number, 10 * (static_cast<int>(power) + 1));
  }
  if (number >= 0x1p63) throw CLI::ValidationError(text, "is too large");
  return static_cast<std::uint64_t>(number);
}

double parse_seconds(const std::string& text) {
  const auto [number, unit] = number_and_unit(text);
  if (unit.empty() || unit == "s") return number;
  if (unit == "ms") return number / 1000;
  if (unit == "m" || unit == "min") return number * 60;
  if (unit == "h") return number * 3600;
  throw CLI::ValidationError(text, "has an unknown unit; use ms, s, m or h");
}

OneOf::OneOf(std::vector<std::string> words) {
  std::string list;
  for (const std::string& word : words) list += (list.empty() ? "" : "|") + word;
  desc_function_ = [list] { return list; };
  func_ = [words = std::move(words), list](std::string& input) -> std::string {
    if (std::find(words.begin(), words.end(), input) != words.end()) return {};
    const std::string near = nearest(input, words);
    return "`" + input + "` is none of " + list + (near.empty() ? "" : "; did you mean `" + near + "`?");
  };
}

WholeNumber::WholeNumber() {
  func_ = [](std::string& input) -> std::string {
    const bool digits = !input.empty() && input.find_first_not_of("0123456789") == std::string::npos;
    return digits ? std::string() : "`" + input + "` is not a whole number";
  };
}

std::string explain(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* at = &app;
  while (!at->get_subcommands().empty()) at = at->get_subcommands().front();
  if (dynamic_cast<const CLI::ExtrasError*>(&error) == nullptr) return error.what();
  std::string text;
  for (const std::string& word : app.remaining(true)) {
    if (!word.starts_with("-")) {
      text += (text.empty() ? "" : "; ") + ("`" + word + "` was not expected");
      std::vector<std::string> commands;
      for (const CLI::App* command : at->get_subcommands({})) commands.push_back(command->get_name());
      const std::string near = nearest(word, commands);
      if (!near.empty()) text += ", did you mean `" + near + "`?";
      continue;
    }
    std::vector<std::string> names;
    for (const CLI::Option* option : at->get_options())
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    const std::string bare = word.substr(0, word.find('='));
    const std::string near = nearest(bare, names);
    text += (text.empty() ? "" : "; ") + ("unknown option `" + bare + "`") +
            (near.empty() ? "" : ", did you mean `" + near + "`?");
  }
  return text.empty() ? std::string(error.what()) : text;
}

}  // namespace meander
