#include "io/json/json_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <utility>

#include "io/run_error.h"

namespace meander {

namespace {

constexpr std::string_view blanks = " \t\r\n";

std::string_view without_blanks(std::string_view text) {
  text.remove_prefix(std::min(text.size(), text.find_first_not_of(blanks)));
  return text.substr(0, text.find_last_not_of(blanks) + 1);
}

// Cuts the text of one object, which is valid JSON, into its members.
std::map<std::string, std::string> members_of(std::string_view text) {
  std::map<std::string, std::string> members;
  std::string name;
  std::size_t depth = 0, begin = 0;
  bool is_quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (is_quoted) {
      if (c == '\\') ++i;
      is_quoted = c != '"';
      continue;
    }
    is_quoted = c == '"';
    if (depth == 1 && (c == ':' || c == ',' || c == '}')) {
      const std::string_view part = without_blanks(text.substr(begin, i - begin));
      if (c == ':')
        name = nlohmann::json::parse(part).get<std::string>();
      else if (!part.empty())
        members[name] = part;
      begin = i + 1;
    }
    if ((c == '{' || c == '[') && depth++ == 0) begin = i + 1;
    if (c == '}' || c == ']') --depth;
  }
  return members;
}

// Where the text stops being JSON, as the end of a sentence; empty where it does not.
std::string mistake_in(std::string_view text) {
  try {
    [[maybe_unused]] const nlohmann::json whole = nlohmann::json::parse(text);
  } catch (const nlohmann::json::parse_error& error) {
    return fmt::format(" (wrong at byte {} of {})", std::min(error.byte, text.size()), text.size());
  } catch (const nlohmann::json::out_of_range&) {
    return " (a number is too large)";
  }
  return {};
}

}  // namespace

JsonObject::JsonObject(std::string_view text, std::string source) : source_(std::move(source)) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  if (!nlohmann::json::accept(text) || !without_blanks(text).starts_with('{'))
    throw RunError(RunError::Kind::unusable,
                   fmt::format("{}: not a JSON object{}", source_, mistake_in(text)));
  members_ = members_of(text);
}

std::optional<std::string> JsonObject::text(const std::string& name) const {
  if (!members_.contains(name)) return std::nullopt;
  const auto value = nlohmann::json::parse(members_.at(name), nullptr, false);
  if (!value.is_string())
    throw RunError(RunError::Kind::unusable, fmt::format("{}: \"{}\" is not a text", source_, name));
  return value.get<std::string>();
}

std::optional<std::int64_t> JsonObject::integer(const std::string& name) const {
  if (!members_.contains(name)) return std::nullopt;
  const auto value = nlohmann::json::parse(members_.at(name), nullptr, false);
  // Whole numbers from 2^63 on are the unsigned type of the library.
  if (!value.is_number_integer() || (value.is_number_unsigned() && value.get<std::uint64_t>() > INT64_MAX))
    throw RunError(RunError::Kind::unusable,
                   fmt::format("{}: \"{}\" is not a whole number of 64 bits", source_, name));
  return value.get<std::int64_t>();
}

}  // namespace meander
