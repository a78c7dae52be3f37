// <meander/settings.h>: settings by name, {"samples", 4096}, and the list of those that there are.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace meander {

// The value of a setting as text: given as a text, a number or a truth value.
class SettingText {
 public:
  SettingText(const char* text) : text_(text) {}
  SettingText(std::string_view text) : text_(text) {}
  SettingText(std::string text) : text_(std::move(text)) {}
  template <class Number>
  requires std::is_arithmetic_v<Number> SettingText(Number number) {
    if constexpr (std::is_same_v<Number, bool>)
      text_ = number ? "true" : "false";
    else if constexpr (std::is_integral_v<Number>)
      text_ = std::to_string(number);
    else
      text_ = written(number);
  }

  const std::string& text() const { return text_; }

 private:
  static std::string written(double number);  // the shortest text that reads as this number

  std::string text_;
};

// Settings by name. The names are those of the parameters that a store records; words and defaults are those
// of the options of `meander run` and `meander surface`.
using Settings = std::map<std::string, SettingText, std::less<>>;

struct SettingInfo {
  std::string name;
  std::string initial;             // its default; empty: follows from other settings
  std::vector<std::string> words;  // the only texts that it takes; empty: any text, or a number
  double low = 0, high = 0;        // the range of a number; equal: any
  std::string help;                // what it does, as the help of the program says it
};

// The settings of Sampler, and those of sample_surface.
std::vector<SettingInfo> list_sampler_settings();
std::vector<SettingInfo> list_surface_settings();

}  // namespace meander
