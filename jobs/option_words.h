// The words of options that choose one of an enum, shared by the subcommands.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/store/store.h"
#include "jobs/inputs.h"
#include "kernels/curve/curve_key.h"
#include "kernels/model/sample_parameters.h"
#include "kernels/retrieve/descriptor_distance.h"

namespace meander {

template <class Enum>
struct Word {
  const char* text;
  Enum value;
};
inline constexpr Word<MethodChoice> method_words[] = {{"auto", MethodChoice::automatic},
                                                      {"conformal", MethodChoice::conformal},
                                                      {"direct", MethodChoice::direct},
                                                      {"anisotropic", MethodChoice::anisotropic}};
inline constexpr Word<LocatorKind> locate_words[] = {{"embree", LocatorKind::embree},
                                                     {"elements", LocatorKind::elements},
                                                     {"first-hit", LocatorKind::first_hit}};
inline constexpr Word<PlaceKind> place_words[] = {{"element", PlaceKind::element},
                                                  {"vertex", PlaceKind::vertex}};
inline constexpr Word<SequenceKind> sequence_words[] = {
    {"shifted", SequenceKind::shifted}, {"stratified", SequenceKind::stratified},
    {"owen", SequenceKind::owen},       {"regular", SequenceKind::regular},
    {"random", SequenceKind::random},   {"spaced", SequenceKind::spaced}};
inline constexpr Word<SpacingKind> spacing_words[] = {
    {"fast", SpacingKind::fast}, {"default", SpacingKind::standard}, {"best", SpacingKind::best}};
inline constexpr Word<OrderKind> order_words[] = {{"progressive", OrderKind::progressive},
                                                  {"curve", OrderKind::curve}};
inline constexpr Word<ElementOrder> order_of_elements_words[] = {
    {"hilbert", ElementOrder::hilbert},
    {"peano", ElementOrder::peano},
    {"peano-meander", ElementOrder::peano_meander},
    {"balanced", ElementOrder::balanced}};
inline constexpr Word<CurveKind> curve_words[] = {{"hilbert", CurveKind::hilbert},
                                                  {"peano", CurveKind::peano},
                                                  {"peano-meander", CurveKind::peano_meander}};
inline constexpr Word<NormalizeKind> normalize_words[] = {{"none", NormalizeKind::none},
                                                          {"unit-sphere", NormalizeKind::unit_sphere},
                                                          {"unit-box", NormalizeKind::unit_box},
                                                          {"unit-diagonal", NormalizeKind::unit_diagonal},
                                                          {"pointnet", NormalizeKind::pointnet}};
inline constexpr Word<PointFrame> frame_words[] = {{"stored", PointFrame::stored},
                                                   {"file", PointFrame::file}};
inline constexpr Word<DensityKind> density_words[] = {
    {"uniform", DensityKind::uniform},   {"mean", DensityKind::mean},
    {"gaussian", DensityKind::gaussian}, {"max", DensityKind::max},
    {"texture", DensityKind::texture},   {"texture-inverse", DensityKind::texture_inverse}};
// Densities and tensor fields by formula are given as "formula:TEXT", in lengths of the file, or
// "unit-formula:TEXT".
struct FormulaText {
  bool unit_box;
  std::string text;
};
inline constexpr std::string_view formula_prefix = "formula:", unit_formula_prefix = "unit-formula:";
// Not compiled here; none for other texts.
inline std::optional<FormulaText> formula_in(std::string_view text) {
  for (const std::string_view prefix : {formula_prefix, unit_formula_prefix})
    if (text.starts_with(prefix))
      return FormulaText{prefix == unit_formula_prefix, std::string(text.substr(prefix.size()))};
  return std::nullopt;
}
// False, nothing changed, for texts that are no formula.
inline bool take_formula(std::string_view text, DensityParameters& density) {
  const std::optional<FormulaText> formula = formula_in(text);
  if (!formula) return false;
  density.kind = formula->unit_box ? DensityKind::unit_formula : DensityKind::formula;
  density.formula = formula->text;
  return true;
}

inline constexpr Word<Compression> compression_words[] = {{"default", Compression::standard},
                                                          {"none", Compression::none}};
inline constexpr Word<DistanceKind> distance_words[] = {{"l1", DistanceKind::l1},
                                                        {"l2", DistanceKind::l2},
                                                        {"emd", DistanceKind::emd},
                                                        {"chi2", DistanceKind::chi2},
                                                        {"cosine", DistanceKind::cosine}};

template <class Enum, std::size_t N>
std::vector<std::string> all_words(const Word<Enum> (&words)[N]) {
  std::vector<std::string> texts;
  for (const auto& word : words) texts.push_back(word.text);
  return texts;
}

template <class Enum, std::size_t N>
Enum value_of(const Word<Enum> (&words)[N], const std::string& text) {
  for (const auto& word : words)
    if (text == word.text) return word.value;
  throw UsageError("`" + text + "` is not known here");
}

template <class Enum, std::size_t N>
const char* text_of(const Word<Enum> (&words)[N], Enum value) {
  for (const auto& word : words)
    if (word.value == value) return word.text;
  return "";
}

}  // namespace meander
