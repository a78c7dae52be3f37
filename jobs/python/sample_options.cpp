#include "jobs/python/sample_options.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "io/json/json_reader.h"
#include "jobs/descriptor_choice.h"
#include "jobs/inputs.h"
#include "jobs/option_words.h"
#include "jobs/surface_sources.h"
#include "kernels/core/spelling.h"
#include "kernels/density/formula_density.h"

namespace meander {

namespace {

template <class Enum, std::size_t N>
void choose(const char* argument, const Word<Enum> (&words)[N], const std::string& text, Enum& value,
            std::vector<std::string>& problems) {
  for (const auto& word : words)
    if (text == word.text) {
      value = word.value;
      return;
    }
  const std::vector<std::string> all = all_words(words);
  const std::string near = nearest(text, all);
  problems.push_back(fmt::format("{}: `{}` is none of {}{}", argument, text, fmt::join(all, ", "),
                                 near.empty() ? "" : "; did you mean `" + near + "`?"));
}

void check_spacing(const SampleOptions& options, SequenceKind sequence, std::vector<std::string>& problems) {
  if (options.spacing != "default" && sequence != SequenceKind::spaced)
    problems.emplace_back("spacing applies to sequence=\"spaced\" only");
}

void throw_problems(const std::vector<std::string>& problems) {
  if (!problems.empty()) throw std::invalid_argument(fmt::format("{}", fmt::join(problems, "\n")));
}

void choose_density(const SampleOptions& options, DensityParameters& density,
                    std::vector<std::string>& problems) {
  density.floor = options.density_floor;
  density.exponent = options.density_exponent;
  if (options.density == "vertices" || options.density == "faces") {
    density.kind =
        options.density == "vertices" ? DensityKind::vertex_attribute : DensityKind::face_attribute;
    density.attribute = density_attribute;
    return;
  }
  if (take_formula(options.density, density)) {
    if (uses_coordinates(density))
      problems.push_back("density: `u` and `v` are texture coordinates, which meshes here do not have");
    if (options.density_floor != SampleOptions{}.density_floor ||
        options.density_exponent != SampleOptions{}.density_exponent)
      problems.push_back(
          "density_floor and density_exponent apply to densities of curvature, not to formulas");
    return;
  }
  choose("density", density_words, options.density, density.kind, problems);
  if (reads_textures(density.kind))
    problems.push_back("density: `" + options.density +
                       "` is read from the images of models; meshes here have none");
}

// The value of an option, as JSON writes it. False where it is of another type or range.
template <class Number>
bool read(const std::string& written, Number& value) {
  const char* end = written.data() + written.size();
  const auto [read_to, error] = std::from_chars(written.data(), end, value);
  return error == std::errc() && read_to == end;
}
bool read(const std::string& written, double& value) {
  for (const double special : {std::nan(""), HUGE_VAL, -HUGE_VAL})
    if (written == fmt::format("\"{}\"", special)) {
      value = special;
      return true;
    }
  return read<double>(written, value);
}
bool read(const std::string& written, bool& value) {
  value = written == "true" || written == "1";
  return value || written == "false" || written == "0";
}

}  // namespace

SampleOptions sample_options(std::string_view json) {
  SampleOptions options;
  const JsonObject given(json, "options");
  for (const auto& option : given.members()) {
    const std::string &name = option.first, &written = option.second;
    const auto set = [&](auto& member) {
      using Value = std::decay_t<decltype(member)>;
      if constexpr (std::is_same_v<Value, std::string>) {
        if (!written.starts_with('"')) throw OptionRefused(name);
        member = *given.text(name);
      } else if (!read(written, member)) {
        throw OptionRefused(name);
      }
    };
    if (name == "n")
      set(options.samples);
    else if (name == "seed")
      set(options.seed);
    else if (name == "method")
      set(options.method);
    else if (name == "sequence")
      set(options.sequence);
    else if (name == "order")
      set(options.order);
    else if (name == "normalize")
      set(options.normalize);
    else if (name == "spacing")
      set(options.spacing);
    else if (name == "density")
      set(options.density);
    else if (name == "density_floor")
      set(options.density_floor);
    else if (name == "density_exponent")
      set(options.density_exponent);
    else if (name == "curve") {
      if (written != "null") set(options.curve.emplace());
    } else if (name == "curved")
      set(options.curved);
    else if (name == "topology")
      set(options.topology);
    else if (name == "describe")
      set(options.describe);
    else if (name == "bins")
      set(options.bins);
    else
      throw OptionRefused(name);
  }
  return options;
}

SampleParameters sample_parameters(const SampleOptions& options) {
  std::vector<std::string> problems;
  SampleParameters parameters;
  choose("method", method_words, options.method, parameters.method, problems);
  choose("sequence", sequence_words, options.sequence, parameters.place.sequence, problems);
  choose("order", order_words, options.order, parameters.place.order, problems);
  choose("normalize", normalize_words, options.normalize, parameters.place.normalize, problems);
  choose("spacing", spacing_words, options.spacing, parameters.place.spacing, problems);
  if (options.curve) {
    ElementOrder order{};
    choose("curve", order_of_elements_words, *options.curve, order, problems);
    parameters.order = order;
  }
  choose_density(options, parameters.density, problems);
  check_spacing(options, parameters.place.sequence, problems);
  parameters.describe.descriptors = parse_descriptors("describe", options.describe, problems);
  parameters.describe.bins = options.bins;
  parameters.seed = options.seed;
  parameters.curved = options.curved;
  parameters.topology = options.topology;
  set_samples(parameters, options.samples);
  if (problems.empty()) problems = validate(parameters);
  throw_problems(problems);
  return parameters;
}

SurfaceSampleParameters surface_parameters(const SampleOptions& options, double tolerance) {
  std::vector<std::string> problems;
  SurfaceSampleParameters parameters;
  parameters.samples = options.samples;
  parameters.seed = options.seed;
  parameters.tolerance = tolerance;
  choose("sequence", sequence_words, options.sequence, parameters.sequence, problems);
  choose("order", order_words, options.order, parameters.order, problems);
  choose("spacing", spacing_words, options.spacing, parameters.spacing, problems);
  if (options.curve) choose("curve", curve_words, *options.curve, parameters.curve, problems);
  check_spacing(options, parameters.sequence, problems);
  parameters.density.floor = options.density_floor;
  parameters.density.exponent = options.density_exponent;
  try {
    set_surface_density(options.density, parameters.density);
  } catch (const UsageError& error) {
    problems.push_back(std::string("density: ") + error.what());
  }
  if (problems.empty()) problems = validate(parameters);
  throw_problems(problems);
  return parameters;
}

}  // namespace meander
