// The words of options that choose a value of an enum, shared by the subcommands.
#pragma once

#include <string>

#include "io/store/store.h"
#include "jobs/cli/usage_error.h"
#include "kernels/model/sample_settings.h"
#include "kernels/retrieve/descriptor_distance.h"
#include "kernels/surface/surface_settings.h"

namespace meander {

inline constexpr Word<PointFrame> frame_words[] = {{"stored", PointFrame::stored},
                                                   {"file", PointFrame::file}};
inline constexpr Word<Compression> compression_words[] = {{"default", Compression::standard},
                                                          {"none", Compression::none}};
inline constexpr Word<DistanceKind> distance_words[] = {{"l1", DistanceKind::l1},
                                                        {"l2", DistanceKind::l2},
                                                        {"emd", DistanceKind::emd},
                                                        {"chi2", DistanceKind::chi2},
                                                        {"cosine", DistanceKind::cosine}};

template <class Enum, std::size_t N>
Enum value_of(const Word<Enum> (&words)[N], const std::string& text) {
  Enum value{};
  if (!take_word(words, text, value)) throw UsageError("`" + text + "` is not a known word");
  return value;
}

}  // namespace meander
