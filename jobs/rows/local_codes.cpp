#include "jobs/rows/local_codes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <string_view>
#include <type_traits>
#include <utility>

#include "io/digest.h"
#include "io/file/atomic_file.h"
#include "io/file/read_file.h"
#include "io/file_kind.h"
#include "io/run_error.h"
#include "jobs/cli/usage_error.h"
#include "kernels/core/parallel.h"

namespace meander {

namespace {

constexpr std::size_t digest_length = 32;

std::array<std::uint8_t, digest_length> digest_of_text(std::string_view bytes) {
  return sha256(std::as_bytes(std::span(bytes.data(), bytes.size())));
}

template <class Value>
void append_value(std::string& bytes, const Value& value) {
  static_assert(std::is_trivially_copyable_v<Value>);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}
void append_floats(std::string& bytes, std::span<const float> values) {
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
}

// What codes depend on.
std::string text_of_words(const LocalCodes& codes) {
  std::string bytes;
  append_value(bytes, local_words_version);
  append_value(bytes, static_cast<std::uint32_t>(codes.pairs.sense));
  append_value(bytes, codes.pairs.centers);
  append_value(bytes, codes.pairs.radius);
  append_value(bytes, codes.words.width);
  append_value(bytes, codes.words.axes);
  append_value(bytes, codes.words.words);
  append_value(bytes, codes.learnt_from);
  append_floats(bytes, codes.words.mean);
  append_floats(bytes, codes.words.turn);
  append_floats(bytes, codes.words.centers);
  return bytes;
}

// Takes values from the front of the bytes of a file.
class WordBytes {
 public:
  WordBytes(const std::filesystem::path& path, std::string_view bytes) : path_(path), rest_(bytes) {}

  template <class Value>
  Value take() {
    if (rest_.size() < sizeof(Value)) refuse("it ends too early");
    Value value;
    std::memcpy(&value, rest_.data(), sizeof value);
    rest_.remove_prefix(sizeof value);
    return value;
  }
  std::vector<float> take_floats(std::uint64_t count) {
    if (rest_.size() / sizeof(float) < count) refuse("it ends too early");
    std::vector<float> values(count);
    std::memcpy(values.data(), rest_.data(), count * sizeof(float));
    rest_.remove_prefix(count * sizeof(float));
    return values;
  }
  bool at_end() const { return rest_.empty(); }
  [[noreturn]] void refuse(const std::string& why) const {
    throw RunError(RunError::Kind::unusable,
                   fmt::format("`{}` is not a file of words that this program can use: {}; `meander retrieve "
                               "words --replace` makes it anew",
                               path_.string(), why));
  }

 private:
  const std::filesystem::path& path_;
  std::string_view rest_;
};

std::optional<SamplesKey> key_of_row(const StoreReader& store, std::uint64_t row) {
  const ItemReport report = store.report(row);
  if (report.status != Status::ok) return std::nullopt;
  return SamplesKey{report.content_sha256, report.points_crc32c};
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
  std::string hexadecimal;
  for (const std::uint8_t byte : digest_of_text(text_of_words(*this)))
    hexadecimal += fmt::format("{:02x}", byte);
  return hexadecimal;
}

std::filesystem::path words_path(const std::string& store) { return store + ".words"; }

LocalCodes learn_local_codes(const StoreReader& store) {
  require_samples(store);
  std::map<SamplesKey, std::uint64_t> rows;  // equal models once
  for (std::uint64_t row = 0; row < store.rows(); ++row)
    if (const auto key = key_of_row(store, row)) rows.try_emplace(*key, row);
  if (rows.empty()) throw UsageError("no row of the store is ok: there is nothing to learn words from");
  LocalCodes codes;
  const std::size_t models = std::min(rows.size(), max_learnt_models);
  codes.learnt_from = static_cast<std::uint32_t>(models);
  std::vector<std::uint64_t> taken;
  for (const auto& [key, row] : rows)
    if (taken.size() < models) taken.push_back(row);
  LocalPairParameters few = codes.pairs;
  few.centers =
      static_cast<std::uint32_t>(std::clamp<std::size_t>(learnt_histograms / models, 8, codes.pairs.centers));
  few.centers = std::min(few.centers, store.samples());
  const std::size_t each = std::size_t{few.centers} * local_pair_bins;
  std::vector<float> histograms(models * each);
  parallel_tasks(models, [&](std::size_t i) {
    const std::vector<float> made = histograms_of(few, store.read_samples(taken[i], 0, store.samples()));
    std::copy(made.begin(), made.end(), histograms.begin() + static_cast<std::ptrdiff_t>(i * each));
  });
  codes.words = learn_local_words(histograms, local_pair_bins);
  return codes;
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
  std::string bytes(words_magic);
  bytes += text_of_words(codes);
  append_value(bytes, std::uint64_t{codes.codes.size()});
  for (const auto& [key, code] : codes.codes) {
    append_value(bytes, key.content);
    append_value(bytes, key.points);
    append_floats(bytes, code);
  }
  append_value(bytes, digest_of_text(bytes));
  replace_file(path, bytes);
}

std::optional<LocalCodes> read_local_codes(const std::filesystem::path& path) {
  const std::optional<std::string> bytes = content_if_exists(path);
  if (!bytes) return std::nullopt;
  const std::string_view all(*bytes);
  WordBytes start(path, all);
  if (!all.starts_with(words_magic) || all.size() < words_magic.size() + digest_length)
    start.refuse("it does not begin like one");
  const std::string_view content = all.substr(0, all.size() - digest_length);
  const auto digest = digest_of_text(content);
  if (std::memcmp(digest.data(), all.data() + content.size(), digest_length) != 0)
    start.refuse("it is damaged: its digest does not match");
  WordBytes rest(path, content.substr(words_magic.size()));
  if (rest.take<std::uint32_t>() != local_words_version) rest.refuse("its words are of another version");
  LocalCodes codes;
  const auto sense = rest.take<std::uint32_t>();
  if (sense > static_cast<std::uint32_t>(NormalSense::either_side)) rest.refuse("its settings are unknown");
  codes.pairs.sense = static_cast<NormalSense>(sense);
  codes.pairs.centers = rest.take<std::uint32_t>();
  codes.pairs.radius = rest.take<double>();
  LocalWords& words = codes.words;
  words.width = rest.take<std::uint32_t>();
  words.axes = rest.take<std::uint32_t>();
  words.words = rest.take<std::uint32_t>();
  codes.learnt_from = rest.take<std::uint32_t>();
  if (words.width != local_pair_bins || words.axes == 0 || words.axes > words.width || words.words == 0 ||
      words.words > 4096)
    rest.refuse("its settings are unknown");
  words.mean = rest.take_floats(words.width);
  words.turn = rest.take_floats(std::uint64_t{words.width} * words.axes);
  words.centers = rest.take_floats(words.values());
  const auto count = rest.take<std::uint64_t>();
  for (std::uint64_t i = 0; i < count; ++i) {
    SamplesKey key;
    key.content = rest.take<std::array<std::uint8_t, 32>>();
    key.points = rest.take<std::uint32_t>();
    codes.codes.emplace(key, rest.take_floats(words.values()));
  }
  if (!rest.at_end()) rest.refuse("something follows its last code");
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
