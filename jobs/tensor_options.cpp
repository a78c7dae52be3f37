#include "jobs/tensor_options.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <filesystem>
#include <string_view>

#include "jobs/command_line.h"
#include "jobs/option_words.h"

namespace meander {

namespace {

constexpr std::string_view kinds =
    "curvature|isotropic|attribute:NAME|face-attribute:NAME|constant:XX,XY,XZ,YY,YZ,ZZ|file:PATH";
constexpr Word<TensorForm> form_words[] = {{"spacing", TensorForm::spacing}, {"metric", TensorForm::metric}};
constexpr Word<AlignmentForm> parameterisation_words[] = {{"metric", AlignmentForm::metric},
                                                          {"gradient", AlignmentForm::gradient}};

bool parse_six(std::string_view text, std::array<double, 6>& numbers) {
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::string_view number = text.substr(0, text.find(','));
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), numbers[i]);
    if (error != std::errc{} || end != number.data() + number.size()) return false;
    if (number.size() == text.size()) return i + 1 == numbers.size();
    text.remove_prefix(number.size() + 1);
  }
  return false;
}

void resolve_kind(const std::string& text, TensorParameters& tensor, std::vector<std::string>& problems) {
  constexpr std::string_view vertex = "attribute:", face = "face-attribute:", constant = "constant:",
                             file = "file:";
  if (text == "curvature") {
    tensor.kind = TensorKind::curvature;
  } else if (text == "isotropic") {
    tensor.kind = TensorKind::isotropic;
  } else if (text.starts_with(vertex)) {
    tensor.kind = TensorKind::vertex_attribute;
    tensor.attribute = text.substr(vertex.size());
  } else if (text.starts_with(face)) {
    tensor.kind = TensorKind::face_attribute;
    tensor.attribute = text.substr(face.size());
  } else if (text.starts_with(constant)) {
    tensor.kind = TensorKind::constant;
    if (!parse_six(std::string_view(text).substr(constant.size()), tensor.constant)) {
      problems.push_back("--tensor: `" + text + "` needs six numbers XX,XY,XZ,YY,YZ,ZZ");
      tensor.constant = TensorParameters{}.constant;  // half of it would be found indefinite as well
    }
  } else if (text.starts_with(file)) {
    tensor.kind = TensorKind::table;
    tensor.attribute = text.substr(file.size());
    if (!std::filesystem::exists(tensor.attribute))
      problems.push_back("--tensor: no such file or folder: `" + tensor.attribute + "`");
  } else {
    problems.push_back(fmt::format("--tensor: `{}` is not one of {}", text, kinds));
  }
}

}  // namespace

void add_tensor_options(Command& command, TensorOptionTexts& texts, SampleParameters& parameters) {
  const char* const group = "Anisotropic";
  const auto note = [&texts](const char* name) {
    return [&texts, name] {
      if (texts.given.empty()) texts.given = name;
    };
  };
  command
      .add_option("--tensor", texts.tensor, fmt::format("Wanted spacings of --method anisotropic: {}", kinds))
      .show_default()
      .on_given(note("--tensor"))
      .group(group);
  command.add_option("--tensor-form", texts.form, "Six numbers are spacings S, or a metric G = S^-2")
      .show_default()
      .one_of(all_words(form_words))
      .on_given(note("--tensor-form"))
      .group(group);
  command
      .add_option("--tensor-ratio", parameters.tensor.max_ratio, "Largest ratio of the two spacings, 1 to 64")
      .show_default()
      .on_given(note("--tensor-ratio"))
      .group(group);
  command
      .add_option("--tensor-density", texts.density,
                  "curvature: keep the density (only shapes vary), or follow the curvature")
      .show_default()
      .one_of({"keep", "follow"})
      .on_given(note("--tensor-density"))
      .group(group);
  command
      .add_option("--tensor-smoothing", parameters.tensor.smoothing,
                  "curvature: rounds of smoothing, 0 to 64")
      .show_default()
      .on_given(note("--tensor-smoothing"))
      .group(group);
  command
      .add_option("--parameterisation", texts.parameterisation,
                  "Charts conformal in the tensor's metric, or along its directions (gradient)")
      .show_default()
      .one_of(all_words(parameterisation_words))
      .on_given(note("--parameterisation"))
      .group(group);
  command
      .add_option(
          "--segments", parameters.tensor_charts.segment.count,
          "Initial number of segments (random walks), at least one per component; default: 1, gradient 16")
      .on_given([&texts, mark = note("--segments")] {
        mark();
        texts.chooses_segments = true;
      })
      .group(group);
}

void resolve_tensor_options(const TensorOptionTexts& texts, SampleParameters& parameters,
                            std::vector<std::string>& problems) {
  if (parameters.method != MethodChoice::anisotropic) {
    if (!texts.given.empty()) problems.push_back(texts.given + " applies to --method anisotropic only");
    return;
  }
  TensorParameters& tensor = parameters.tensor;
  resolve_kind(texts.tensor, tensor, problems);
  tensor.form = value_of(form_words, texts.form);
  tensor.adaptive = texts.density == "follow";
  parameters.tensor_charts.form = value_of(parameterisation_words, texts.parameterisation);
  if (!texts.chooses_segments && parameters.tensor_charts.form == AlignmentForm::gradient)
    parameters.tensor_charts.segment.count = 16;
  const bool curved = tensor.kind == TensorKind::curvature;
  if (!curved && (tensor.adaptive || tensor.smoothing != TensorParameters{}.smoothing))
    problems.push_back("--tensor-density and --tensor-smoothing apply to --tensor curvature only");
  const bool isotropic = tensor.kind == TensorKind::isotropic;
  if ((curved || isotropic) && tensor.form != TensorForm::spacing)
    problems.push_back("--tensor-form applies to given tensors; " + texts.tensor + " has none");
}

void plan_tensor_files(const TensorParameters& tensor, std::vector<PlanItem>& items) {
  if (tensor.kind != TensorKind::table) return;
  namespace fs = std::filesystem;
  const fs::path path = tensor.attribute;
  const bool folder = fs::is_directory(path);
  const bool hdf5 = path.extension() == ".h5" || path.extension() == ".hdf5";
  for (PlanItem& item : items) {
    item.tensor_path = folder ? path / (item.id + ".txt") : path;
    if (folder && !fs::exists(item.tensor_path))
      item.tensor_path = path / fs::path(item.id).replace_extension(".txt");
    if (hdf5 && !folder) item.tensor_dataset = item.id;
  }
}

std::string tensor_text(const TensorParameters& tensor) {
  switch (tensor.kind) {
    case TensorKind::curvature:
      return "curvature";
    case TensorKind::isotropic:
      return "isotropic";
    case TensorKind::vertex_attribute:
      return "attribute:" + tensor.attribute;
    case TensorKind::face_attribute:
      return "face-attribute:" + tensor.attribute;
    case TensorKind::constant:
      return fmt::format("constant:{}", fmt::join(tensor.constant, ","));
    case TensorKind::table:
      return "file:" + tensor.attribute;
  }
  return "";
}

}  // namespace meander
