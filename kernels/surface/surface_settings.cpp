#include "kernels/surface/surface_settings.h"

#include <algorithm>
#include <cctype>

#include "kernels/core/expression.h"

namespace meander {

namespace {

using P = SurfaceSampleParameters;

constexpr Word<SurfaceDensityKind> density_kinds[] = {{"uniform", SurfaceDensityKind::uniform},
                                                      {"mean", SurfaceDensityKind::mean},
                                                      {"gaussian", SurfaceDensityKind::gaussian},
                                                      {"max", SurfaceDensityKind::max}};

bool is_spaced(const P& p) { return p.sequence == SequenceKind::spaced; }
bool is_shaped(const P& p) {
  return p.density.kind != SurfaceDensityKind::uniform && p.density.kind != SurfaceDensityKind::expression;
}
constexpr const char* shaped = "applies to curvature densities: mean, gaussian or max";

SurfaceSettings make_settings() {
  std::vector<std::string_view> presets;
  for (const ExpressionPreset& preset : expression_presets()) presets.push_back(preset.name);
  SurfaceSettings list;
  list.number(
          "samples", "-n,--samples", [](auto& p) -> auto& { return p.samples; }, 1, 2147483648.0,
          "Points per surface, 1 to 2^31")
      .in_python("n")
      .common();
  list.text(
          "density", "--density",
          [](const P& p) {
            return p.density.kind == SurfaceDensityKind::expression
                       ? p.density.expression
                       : std::string(text_of(density_kinds, p.density.kind));
          },
          [](P& p, std::string_view text) { return take_surface_density(text, p.density); },
          "uniform, mean|gaussian|max curvature, or an expression in u, v, x, y, z (presets: " +
              joined_texts(presets) + ")")
      .in_python("density")
      .common();
  list.number(
          "density_floor", "--density-floor", [](auto& p) -> auto& { return p.density.floor; }, 1e-6, 1,
          "Density of flat parts for curvatures, 1e-6 to 1")
      .in_python("density_floor")
      .acting(is_shaped, shaped);
  list.number(
          "density_exponent", "--density-exponent", [](auto& p) -> auto& { return p.density.exponent; }, 0.25,
          4, "Exponent of curvatures, 0.25 to 4")
      .in_python("density_exponent")
      .acting(is_shaped, shaped);
  list.word(
          "curve", "--curve", [](auto& p) -> auto& { return p.curve; }, curve_words,
          "The space-filling curve")
      .in_python("curve");
  list.word(
          "sequence", "--sequence", [](auto& p) -> auto& { return p.sequence; }, sequence_words,
          sequence_help)
      .in_python("sequence")
      .common();
  list.word(
          "spacing", "--spacing", [](auto& p) -> auto& { return p.spacing; }, spacing_words, spacing_help)
      .in_python("spacing")
      .only_recorded(is_spaced)
      .acting(is_spaced, spacing_applies_to);
  list.word(
          "finish", "--finish", [](auto& p) -> auto& { return p.finish; }, finish_words, finish_help)
      .in_python("finish")
      .only_recorded([](const P& p) { return p.finish != FinishKind::none; });
  list.word(
          "order", "--order", [](auto& p) -> auto& { return p.order; }, order_words,
          "Order of the points: every prefix well spread, or along the curve")
      .in_python("order");
  list.word(
      "place", "--place", [](auto& p) -> auto& { return p.place; }, place_words,
      "Where samples lie: anywhere within a curve element, or at its vertex (Quinn et al. 2013)");
  list.number(
          "seed", "--seed", [](auto& p) -> auto& { return p.seed; }, 0, 0, "Seed, 0 to 2^64 - 1")
      .in_python("seed")
      .common();
  list.number(
          "tolerance", "--tolerance", [](auto& p) -> auto& { return p.tolerance; }, 1e-8, 0.1,
          "Relative error of the measures, 1e-8 to 0.1")
      .in_python("tolerance");
  list.number(
      "leaves_per_sample", "--leaves-per-sample", [](auto& p) -> auto& { return p.leaves_per_sample; }, 0,
      1024, "Curve leaves per sample, 1 to 1024 (0: 4, or 64 for --place vertex)");
  list.number(
      "max_depth", "--max-depth", [](auto& p) -> auto& { return p.max_depth; }, 5, 31,
      "Of the curve's tree, 5 to 31");
  list.flag(
      "reparameterise", "--reparameterize", [](auto& p) -> auto& { return p.reparameterize; },
      "Lay the curve over the square warped by area x density, for extreme stretch");
  list.constant("density_quantile", [](const P& p) { return p.density.quantile; });
  list.constant("jitter", [](const P& p) { return p.jitter; });
  list.constant("min_depth", [](const P& p) { return p.min_depth; });
  return list;
}

}  // namespace

const SurfaceSettings& surface_settings() {
  static const SurfaceSettings list = make_settings();
  return list;
}

std::string take_surface_density(std::string_view text, SurfaceDensity& density) {
  density.kind = SurfaceDensityKind::expression;
  if (take_word(density_kinds, text, density.kind)) return "";
  density.expression = text;
  // A single word is a name, and `maen` is not short for `tan`.
  const bool one_word =
      std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isalpha(c) != 0; });
  const std::string near = one_word && text.size() > 2 ? nearest(text, all_words(density_kinds)) : "";
  return near.empty() ? "" : "no density `" + std::string(text) + "`, did you mean `" + near + "`?";
}

}  // namespace meander
