// The words for what decides the places of samples.
#pragma once

#include "kernels/core/setting.h"
#include "kernels/sample/place_samples.h"

namespace meander {

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
inline constexpr Word<NormalizeKind> normalize_words[] = {{"none", NormalizeKind::none},
                                                          {"unit-sphere", NormalizeKind::unit_sphere},
                                                          {"unit-box", NormalizeKind::unit_box},
                                                          {"unit-diagonal", NormalizeKind::unit_diagonal},
                                                          {"pointnet", NormalizeKind::pointnet}};

inline constexpr const char* sequence_help =
    "The sample set: 1-D sets along the order, or spaced, whose places in their strata keep samples apart";
inline constexpr const char* spacing_help = "Effort of the sequence spaced";
inline constexpr const char* spacing_applies_to = "applies to the sequence spaced only";

}  // namespace meander
