#include "kernels/core/setting.h"

#include <charconv>
#include <concepts>
#include <system_error>
#include <type_traits>

#include "kernels/core/check_range.h"

namespace meander {

namespace {

template <class Number>
std::string set_to(Number& number, std::string_view text, double low, double high) {
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

}  // namespace

std::string SettingTexts::long_option() const { return option.substr(option.rfind(',') + 1); }

std::string set_number(SettingNumber number, std::string_view text, double low, double high) {
  return std::visit([&](auto* at) { return set_to(*at, text, low, high); }, number);
}

void check_range(const SettingTexts& setting, const SettingValue& value, std::vector<std::string>& problems) {
  std::string words = setting.name;
  std::replace(words.begin(), words.end(), '_', ' ');
  const auto check = [&](const auto& number) {
    if constexpr (!std::same_as<std::decay_t<decltype(number)>, std::string>)
      check_range(problems, words.c_str(), static_cast<double>(number), setting.low, setting.high);
  };
  std::visit(check, value);
}

}  // namespace meander
