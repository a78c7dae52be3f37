#include "jobs/tensor_options.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <filesystem>
#include <optional>
#include <string_view>

#include "jobs/option_words.h"

namespace meander {

namespace {

constexpr std::string_view kinds =
    "curvature|isotropic|attribute:NAME|face-attribute:NAME|constant:XX,XY,XZ,YY,YZ,ZZ|formula:X,Y,Z|"
    "formula:XX,XY,XZ,YY,YZ,ZZ|unit-formula:X,Y,Z|unit-formula:XX,XY,XZ,YY,YZ,ZZ|file:PATH";
constexpr Word<TensorForm> form_words[] = {{"spacing", TensorForm::spacing}, {"metric", TensorForm::metric}};
constexpr Word<AlignmentForm> parameterisation_words[] = {{"metric", AlignmentForm::metric},
                                                          {"gradient", AlignmentForm::gradient}};
constexpr Word<bool> follow_words[] = {{"keep", false}, {"follow", true}};

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

void resolve_kind(const TensorOptionTexts& texts, TensorParameters& tensor,
                  std::vector<std::string>& problems) {
  const std::string& text = texts.tensor;
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
  } else if (const std::optional<FormulaText> formula = formula_in(text)) {
    tensor.kind = formula->unit_box ? TensorKind::unit_formula : TensorKind::formula;
    tensor.formula = formula->text;
  } else if (text.starts_with(file)) {
    tensor.kind = TensorKind::table;
    tensor.attribute = text.substr(file.size());
    if (!std::filesystem::exists(std::filesystem::path(texts.folder) / tensor.attribute))
      problems.push_back("--tensor: no such file or folder: `" + tensor.attribute + "`");
  } else {
    problems.push_back(fmt::format("--tensor: `{}` is not one of {}", text, kinds));
  }
}

}  // namespace

void add_tensor_options(const Command& command, ParameterTable& table, TensorOptionTexts& texts,
                        SampleParameters& parameters) {
  Command options = command.under("Anisotropic");
  TensorParameters& tensor = parameters.tensor;
  const auto note = [&texts](const char* name) {
    return [&texts, name] {
      if (texts.given.empty()) texts.given = name;
    };
  };
  options
      .add_option("--tensor", texts.tensor, fmt::format("Wanted spacings of --method anisotropic: {}", kinds))
      .show_default()
      .on_given(note("--tensor"));
  table.compute("tensor", "--tensor", [&tensor] { return tensor_text(tensor); });
  table
      .add(options, "tensor_form", "--tensor-form", tensor.form, form_words,
           "Six numbers are spacings S, or a metric G = S^-2")
      .on_given(note("--tensor-form"));
  table
      .add(options, "tensor_ratio", "--tensor-ratio", tensor.max_ratio,
           "Largest ratio of the two spacings, 1 to 64")
      .on_given(note("--tensor-ratio"));
  table
      .add(options, "tensor_density", "--tensor-density", tensor.adaptive, follow_words,
           "curvature: keep the density (only shapes vary), or follow the curvature")
      .on_given(note("--tensor-density"));
  table
      .add(options, "tensor_smoothing", "--tensor-smoothing", tensor.smoothing,
           "curvature: rounds of smoothing, 0 to 64")
      .on_given(note("--tensor-smoothing"));
  table
      .add(options, "tensor_charts", "--parameterisation", parameters.tensor_charts.form,
           parameterisation_words,
           "Charts conformal in the tensor's metric, or along its directions (gradient)")
      .on_given(note("--parameterisation"));
  table
      .add(options, "tensor_segments", "--segments", parameters.tensor_charts.segment.count,
           "Initial number of segments (random walks), at least one per component; default: 1, gradient 16")
      .show_default("")
      .on_given([&texts, mark = note("--segments")] {
        mark();
        texts.chooses_segments = true;
      });
  table.constant("tensor_bisections", parameters.tensor_charts.max_bisections);
  table.constant("tensor_chart_ratio", parameters.tensor_charts.limits.ratio);
  table.constant("tensor_epsilon", tensor.epsilon);
  table.constant("tensor_mean_distortion", metric_mean_distortion);
}

void resolve_tensor_options(const TensorOptionTexts& texts, SampleParameters& parameters,
                            std::vector<std::string>& problems) {
  if (!method_of(parameters).follows_tensor) {
    if (!texts.given.empty()) problems.push_back(texts.given + " applies to --method anisotropic only");
    return;
  }
  TensorParameters& tensor = parameters.tensor;
  resolve_kind(texts, tensor, problems);
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
    case TensorKind::formula:
      return std::string(formula_prefix) + tensor.formula;
    case TensorKind::unit_formula:
      return std::string(unit_formula_prefix) + tensor.formula;
  }
  return "";
}

}  // namespace meander
