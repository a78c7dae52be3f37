#include "jobs/rows/local_codes.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "io/file/read_file.h"
#include "io/file_kind.h"
#include "io/sealed_file.h"
#include "jobs/cli/usage_error.h"
#include "kernels/core/parallel.h"

namespace meander {

namespace {

constexpr SealedKind words_kind = {words_magic, "a file of words that this program can use",
                                   "; `meander retrieve words --replace` makes it anew"};

// What codes depend on.
void put_words(ValueBytes& bytes, const LocalCodes& codes) {
  bytes.put(local_words_version);
  bytes.put(static_cast<std::uint32_t>(codes.pairs.sense));
  bytes.put(codes.pairs.centers);
  bytes.put(codes.pairs.radius);
  bytes.put(static_cast<std::uint32_t>(codes.pairs.unit));
  bytes.put(codes.words.width);
  bytes.put(codes.words.axes);
  bytes.put(codes.words.words);
  bytes.put(codes.learnt_from);
  bytes.put(codes.learnt_models);
  for (const std::vector<float>* const values : {&codes.words.mean, &codes.words.turn, &codes.words.centers})
    bytes.put_all(std::span<const float>(*values));
}

std::optional<SamplesKey> key_of_row(const StoreReader& store, std::uint64_t row) {
  const ItemReport report = store.report(row);
  if (report.status != Status::ok) return std::nullopt;
  return SamplesKey{report.content_sha256, report.points_crc32c};
}

// The models that words are learnt from, each with a row, in the order of their keys: equal models once.
std::vector<std::pair<SamplesKey, std::uint64_t>> models_to_learn_from(const StoreReader& store) {
  std::map<SamplesKey, std::uint64_t> rows;
  for (std::uint64_t row = 0; row < store.rows(); ++row)
    if (const auto key = key_of_row(store, row)) rows.try_emplace(*key, row);
  std::vector<std::pair<SamplesKey, std::uint64_t>> models(rows.begin(), rows.end());
  models.resize(std::min(models.size(), max_learnt_models));
  return models;
}

Seal seal_of_models(std::span<const std::pair<SamplesKey, std::uint64_t>> models) {
  ValueBytes bytes;
  for (const auto& [key, row] : models) {
    bytes.put(key.content);
    bytes.put(key.points);
  }
  return bytes.seal();
}

std::vector<float> histograms_of(const LocalPairParameters& pairs, const Samples& samples) {
  return local_pair_histograms(samples.points, samples.normals, pairs);
}

void require_samples(const StoreReader& store) {
  store.require(&Samples::normals, "the descriptor local-pairs");
  if (store.samples() < 2)
    throw UsageError("the descriptor local-pairs needs two samples of a model or more");
}

}  // namespace

std::string LocalCodes::checksum() const {
  ValueBytes bytes;
  put_words(bytes, *this);
  std::string hexadecimal;
  for (const std::uint8_t byte : bytes.seal()) hexadecimal += fmt::format("{:02x}", byte);
  return hexadecimal;
}

std::filesystem::path words_path(const std::string& store) { return store + ".words"; }

LocalCodes learn_local_codes(const StoreReader& store, const LocalPairParameters& pairs) {
  require_samples(store);
  const std::vector<std::pair<SamplesKey, std::uint64_t>> taken = models_to_learn_from(store);
  if (taken.empty()) throw UsageError("no row of the store is ok: there is nothing to learn words from");
  LocalCodes codes;
  codes.pairs = pairs;
  const std::size_t models = taken.size();
  codes.learnt_from = static_cast<std::uint32_t>(models);
  codes.learnt_models = seal_of_models(taken);
  LocalPairParameters few = codes.pairs;
  few.centers = static_cast<std::uint32_t>(
      std::clamp<std::size_t>(learnt_histograms / models, std::min(8u, pairs.centers), pairs.centers));
  few.centers = std::min(few.centers, store.samples());
  const std::size_t each = std::size_t{few.centers} * local_pair_bins;
  std::vector<float> histograms(models * each);
  parallel_tasks(models, [&](std::size_t i) {
    const std::vector<float> made =
        histograms_of(few, store.read_samples(taken[i].second, 0, store.samples()));
    std::copy(made.begin(), made.end(), histograms.begin() + static_cast<std::ptrdiff_t>(i * each));
  });
  // A word that one model alone comes near to says nothing of the others.
  LocalWordParameters wanted;
  wanted.words = static_cast<std::uint32_t>(
      std::clamp<std::size_t>(models / models_of_a_word, 1, std::size_t{wanted.words}));
  codes.words = learn_local_words(histograms, local_pair_bins, wanted);
  return codes;
}

bool are_words_of(const StoreReader& store, const LocalCodes& codes) {
  return codes.learnt_models == seal_of_models(models_to_learn_from(store));
}

std::uint64_t code_rows(const StoreReader& store, LocalCodes& codes) {
  require_samples(store);
  std::map<SamplesKey, std::vector<float>> kept;
  std::vector<std::pair<SamplesKey, std::uint64_t>> lacking;
  for (std::uint64_t row = 0; row < store.rows(); ++row) {
    const auto key = key_of_row(store, row);
    if (!key || kept.contains(*key)) continue;
    const auto at = codes.codes.find(*key);
    if (at == codes.codes.end()) lacking.emplace_back(*key, row);
    kept.emplace(*key, at == codes.codes.end() ? std::vector<float>() : std::move(at->second));
  }
  std::vector<std::vector<float>> made(lacking.size());
  parallel_tasks(lacking.size(), [&](std::size_t i) {
    made[i] = local_code_of(codes, store.read_samples(lacking[i].second, 0, store.samples()));
  });
  for (std::size_t i = 0; i < lacking.size(); ++i) kept[lacking[i].first] = std::move(made[i]);
  codes.codes = std::move(kept);
  return lacking.size();
}

std::vector<float> local_code_of(const LocalCodes& codes, const Samples& samples) {
  return local_code(codes.words, histograms_of(codes.pairs, samples));
}

void write_local_codes(const std::filesystem::path& path, const LocalCodes& codes) {
  ValueBytes bytes(words_magic);
  put_words(bytes, codes);
  bytes.put(std::uint64_t{codes.codes.size()});
  for (const auto& [key, code] : codes.codes) {
    bytes.put(key.content);
    bytes.put(key.points);
    bytes.put_all(std::span<const float>(code));
  }
  bytes.write_sealed(path);
}

std::optional<LocalCodes> read_local_codes(const std::filesystem::path& path) {
  const std::optional<std::string> content = content_if_exists(path);
  if (!content) return std::nullopt;
  SealedBytes bytes(path, words_kind, *content);
  if (bytes.take<std::uint32_t>() != local_words_version) bytes.refuse("its words are of another version");
  LocalCodes codes;
  const auto sense = bytes.take<std::uint32_t>();
  if (sense > static_cast<std::uint32_t>(NormalSense::either_side)) bytes.refuse("its settings are unknown");
  codes.pairs.sense = static_cast<NormalSense>(sense);
  codes.pairs.centers = bytes.take<std::uint32_t>();
  codes.pairs.radius = bytes.take<double>();
  const auto unit = bytes.take<std::uint32_t>();
  if (unit > static_cast<std::uint32_t>(RadiusUnit::spacing)) bytes.refuse("its settings are unknown");
  codes.pairs.unit = static_cast<RadiusUnit>(unit);
  LocalWords& words = codes.words;
  words.width = bytes.take<std::uint32_t>();
  words.axes = bytes.take<std::uint32_t>();
  words.words = bytes.take<std::uint32_t>();
  codes.learnt_from = bytes.take<std::uint32_t>();
  codes.learnt_models = bytes.take<Seal>();
  if (words.width != local_pair_bins || words.axes == 0 || words.axes > words.width || words.words == 0 ||
      words.words > 4096)
    bytes.refuse("its settings are unknown");
  words.mean = bytes.take_all<float>(words.width);
  words.turn = bytes.take_all<float>(std::uint64_t{words.width} * words.axes);
  words.centers = bytes.take_all<float>(words.values());
  const auto count = bytes.take<std::uint64_t>();
  for (std::uint64_t i = 0; i < count; ++i) {
    SamplesKey key;
    key.content = bytes.take<std::array<std::uint8_t, 32>>();
    key.points = bytes.take<std::uint32_t>();
    codes.codes.emplace(key, bytes.take_all<float>(words.values()));
  }
  bytes.end("code");
  return codes;
}

SideVectorsList named_side_vectors(const StoreReader& store, const std::string& path,
                                   const std::string& descriptor) {
  if (descriptor.empty()) return {};
  const std::vector<NamedTerm> terms = parse_terms(descriptor);
  if (std::none_of(terms.begin(), terms.end(),
                   [](const NamedTerm& term) { return term.name == local_pairs_name; }))
    return {};
  std::optional<LocalCodes> codes = read_local_codes(words_path(path));
  if (!codes)
    throw UsageError(fmt::format("there is no `{}`: `meander retrieve words {}` learns the words of {}",
                                 words_path(path).string(), path, local_pairs_name));
  return {side_vectors_of(store, words_path(path), std::move(*codes))};
}

std::shared_ptr<const SideVectors> side_vectors_of(const StoreReader& store,
                                                   const std::filesystem::path& path, LocalCodes codes) {
  auto vectors = std::make_shared<SideVectors>();
  const std::uint32_t width = codes.words.values();
  vectors->schema = {
      local_pairs_name,
      width,
      {{"value", "codes of local pairs by the words of the store"}, {"words", codes.checksum()}},
      vectors_group};
  vectors->values.assign(store.rows() * width, std::numeric_limits<float>::quiet_NaN());
  std::uint64_t lacking = 0;
  for (std::uint64_t row = 0; row < store.rows(); ++row) {
    const auto key = key_of_row(store, row);
    if (!key) continue;
    const auto at = codes.codes.find(*key);
    if (at == codes.codes.end())
      ++lacking;
    else
      std::copy(at->second.begin(), at->second.end(),
                vectors->values.begin() + static_cast<std::ptrdiff_t>(row * width));
  }
  if (lacking > 0)
    throw UsageError(fmt::format("`{}` lacks {} models of the store: `meander retrieve words` adds them",
                                 path.string(), lacking));
  codes.codes.clear();
  vectors->local = std::make_shared<const LocalCodes>(std::move(codes));
  return vectors;
}

}  // namespace meander
