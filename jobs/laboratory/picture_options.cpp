#include "jobs/laboratory/picture_options.h"

#include "jobs/cli/usage_error.h"
#include "jobs/rows/sample_colorings.h"
#include "kernels/render/default_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace meander {

Vector3 parse_direction(const std::string& option, const std::string& text) {
  std::array<double, 3> value{};
  std::size_t at = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    std::size_t used = 0;
    try {
      value[k] = std::stod(text.substr(at), &used);
    } catch (const std::exception&) {
      used = 0;
    }
    at += used;
    const bool ends = k == 2 ? at == text.size() : at < text.size() && text[at] == ',';
    if (used == 0 || !ends || !std::isfinite(value[k]))
      throw UsageError(
          fmt::format("{}: `{}` is not a direction: give three numbers, like 0.55,0.42,1", option, text));
    ++at;
  }
  const double largest = std::max({std::abs(value[0]), std::abs(value[1]), std::abs(value[2]), 1e-300});
  return {value[0] / largest, value[1] / largest, value[2] / largest};
}

Vector3 axis_of(const std::string& name) {
  return {name == "x" ? 1.0 : 0.0, name == "y" ? 1.0 : 0.0, name == "z" ? 1.0 : 0.0};
}

Vector3 view_of(const std::string& text, const std::string& up) {
  const Vector3 view = text.empty() ? default_view_of(up.front()) : parse_direction("--view", text);
  if (!(norm(cross(view, axis_of(up))) > 1e-6 * norm(view)))
    throw UsageError("--view must not lie along the axis of --up, nor be 0,0,0");
  return view;
}

void add_view_options(Command& command, std::string& up, std::string& view) {
  command.add_option("--up", up, "The axis of the models that points up")
      .show_default()
      .one_of({"x", "y", "z"});
  command.add_option(
      "--view", view,
      "Direction from the model towards the eye, X,Y,Z (default: in front, to the right and above)");
}

void add_color_option(Command& command, std::string& color) {
  command
      .add_option(
          "--color", color,
          fmt::format("Meaning of the color of a sample: {}, or an attribute of the store by its name",
                      coloring_words()))
      .show_default();
}

void add_drawing_options(Command& command, std::string& memory, int& threads) {
  command.add_option("--memory", memory, "Limit of the memory for models and pictures")
      .show_default()
      .bytes();
  command.add_option("-j,--threads", threads, "Threads, up to 1024 (0: all available)")
      .show_default()
      .range(0, 1024);
}

}  // namespace meander
