// The file beside a store with the words of its local pairs and the codes of its models: STORE.words.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "io/sealed_file.h"
#include "io/store/store_reader.h"
#include "jobs/rows/described_rows.h"
#include "kernels/describe/local_pairs.h"
#include "kernels/retrieve/local_words.h"

namespace meander {

inline constexpr const char* local_pairs_name = "local-pairs";

// Identifies the samples of a model: the SHA-256 of its content and the checksum of its points.
struct SamplesKey {
  std::array<std::uint8_t, 32> content{};
  std::uint32_t points = 0;
  friend auto operator<=>(const SamplesKey&, const SamplesKey&) = default;
};

struct LocalCodes {
  LocalPairParameters pairs;  // of the histograms
  LocalWords words;
  std::uint32_t learnt_from = 0;                   // models
  Seal learnt_models{};                            // the SHA-256 of their keys, ascending
  std::map<SamplesKey, std::vector<float>> codes;  // by model

  // The SHA-256 of the words and of how histograms are made, in hexadecimal: codes of different words are
  // never compared.
  std::string checksum() const;
};

// What words are learnt from: at most so many models, those whose content has the least SHA-256, and about so
// many histograms.
inline constexpr std::size_t max_learnt_models = 2000, learnt_histograms = 32768;
// Few models have fewer words than LocalWordParameters: one for so many of them.
inline constexpr std::size_t models_of_a_word = 3;

std::filesystem::path words_path(const std::string& store);

// Learns words from the rows of the store that are ok. The words depend on the set of their samples alone.
// Throws UsageError where there are none, or without normals.
LocalCodes learn_local_codes(const StoreReader& store, const LocalPairParameters& pairs = {});
// Whether learn_local_codes would learn these words from the store as it is.
bool are_words_of(const StoreReader& store, const LocalCodes& codes);
// Adds the codes of the rows that have none yet, and drops those of models that the store does not have.
// Returns how many it made.
std::uint64_t code_rows(const StoreReader& store, LocalCodes& codes);
// The code of any samples.
std::vector<float> local_code_of(const LocalCodes& codes, const Samples& samples);

// A sealed file (words_magic): the version, the settings, the words and the number of models that they were
// learnt from; the codes. Throws FileError.
void write_local_codes(const std::filesystem::path& path, const LocalCodes& codes);
// Empty where there is no such file. Throws RunError(unusable) for a file that is damaged or of another
// version.
std::optional<LocalCodes> read_local_codes(const std::filesystem::path& path);

// The descriptors beside the store that `descriptor` (see chosen_descriptors) names: the codes of
// STORE.words. Throws as read_local_codes and side_vectors_of, and UsageError where a named one is not there.
SideVectorsList named_side_vectors(const StoreReader& store, const std::string& path,
                                   const std::string& descriptor);

// The codes as a descriptor of the store. Throws UsageError, naming `path`, where a row that is ok has none.
std::shared_ptr<const SideVectors> side_vectors_of(const StoreReader& store,
                                                   const std::filesystem::path& path, LocalCodes codes);

}  // namespace meander
