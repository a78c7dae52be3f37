#include "jobs/retrieve/score_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "io/digest.h"
#include "io/file/atomic_file.h"
#include "io/file/read_file.h"
#include "io/file_kind.h"
#include "io/run_error.h"
#include "io/store/crc32c.h"
#include "jobs/rows/rank_option.h"

namespace meander {

namespace {

static_assert(std::is_trivially_copyable_v<RetrievalScores> &&
              sizeof(RetrievalScores) == (6 + recall_levels) * sizeof(double));

constexpr std::size_t digest_bytes = 32;

template <class Value>
void put(std::string& bytes, const Value& value) {
  static_assert(std::is_trivially_copyable_v<Value>);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::array<std::uint8_t, digest_bytes> digest_of(std::string_view bytes) {
  return sha256(std::as_bytes(std::span(bytes.data(), bytes.size())));
}

// Takes values from the front of the bytes of a file.
class ScoreBytes {
 public:
  ScoreBytes(const std::string& path, std::string_view bytes) : path_(path), rest_(bytes) {}

  template <class Value>
  Value take() {
    if (rest_.size() < sizeof(Value)) refuse("it ends too early");
    Value value;
    std::memcpy(&value, rest_.data(), sizeof value);
    rest_.remove_prefix(sizeof value);
    return value;
  }
  bool at_end() const { return rest_.empty(); }

  [[noreturn]] void refuse(const std::string& why) const {
    throw RunError(RunError::Kind::unusable,
                   fmt::format("`{}` is not a file of scores of this evaluation: {}", path_, why));
  }

 private:
  const std::string& path_;
  std::string_view rest_;
};

// Reads the queries of one file into `scores`; `taken` becomes 1 for each.
void read_file_of_scores(const std::string& path, const ScoreOrigin& origin, std::size_t classes,
                         std::vector<QueryScores>& scores, std::vector<std::uint8_t>& taken) {
  const std::string bytes = content_of_file(path);
  const std::string_view all(bytes);
  ScoreBytes damaged(path, all);
  if (!all.starts_with(scores_magic) || all.size() < scores_magic.size() + digest_bytes)
    damaged.refuse("it does not begin like one");
  const std::string_view content = all.substr(0, all.size() - digest_bytes);
  const auto digest = digest_of(content);
  if (std::memcmp(digest.data(), all.data() + content.size(), digest_bytes) != 0)
    damaged.refuse("it is damaged: its digest does not match");
  ScoreBytes rest(path, content.substr(scores_magic.size()));
  if (rest.take<std::array<std::uint8_t, digest_bytes>>() != origin.digest ||
      rest.take<std::uint64_t>() != origin.queries)
    rest.refuse("its store, descriptors, distance, classes or rules differ");
  const auto begin = rest.take<std::uint64_t>(), end = rest.take<std::uint64_t>();
  if (begin > end || end > origin.queries) rest.refuse("its range of queries is invalid");
  for (std::uint64_t q = begin; q < end; ++q) {
    if (taken[q] != 0) rest.refuse(fmt::format("query {} is in an earlier file, too", q));
    taken[q] = 1;
    scores[q].scores = rest.take<RetrievalScores>();
    const auto count = rest.take<std::uint32_t>();
    for (std::uint32_t c = 0; c < count; ++c) {
      const auto nearest = rest.take<std::uint32_t>();
      const auto share = rest.take<double>();
      if (nearest >= classes) rest.refuse(fmt::format("it has class {} of {}", nearest, classes));
      scores[q].nearest_classes.emplace_back(nearest, share);
    }
  }
  if (!rest.at_end()) rest.refuse("something follows its last query");
}

}  // namespace

ScoreOrigin origin_of_scores(const std::string& store, const RetrievalBase& base, const std::string& distance,
                             bool psb_compat) {
  std::string text = fmt::format("{:08x}\n{}\n{}\n{}\n", stated_checksum(store), joined(base.terms), distance,
                                 rules_text(psb_compat));
  for (const DescriptorTerm& term : base.terms)
    if (term.side) text += fmt::format("{:08x}\n", crc32c(std::span<const float>(term.side->values)));
  if (base.ranking.kind != RankKind::plain) text += rank_word(base.ranking) + '\n';
  for (const std::string& name : base.classes) text += name + '\0';
  for (const std::uint64_t row : base.rows) put(text, row);
  for (const std::uint32_t label : base.labels) put(text, label);
  return {digest_of(text), base.rows.size()};
}

void write_scores(const std::filesystem::path& path, const ScoreOrigin& origin, std::uint64_t begin,
                  std::span<const QueryScores> scores) {
  std::string bytes(scores_magic);
  put(bytes, origin.digest);
  put(bytes, origin.queries);
  put(bytes, begin);
  put(bytes, begin + scores.size());
  for (const QueryScores& query : scores) {
    put(bytes, query.scores);
    put(bytes, static_cast<std::uint32_t>(query.nearest_classes.size()));
    for (const auto& [nearest, share] : query.nearest_classes) {
      put(bytes, nearest);
      put(bytes, share);
    }
  }
  put(bytes, digest_of(bytes));
  replace_file(path, bytes);
}

std::vector<QueryScores> read_scores(std::span<const std::string> paths, const ScoreOrigin& origin,
                                     std::size_t classes) {
  std::vector<QueryScores> scores(origin.queries);
  std::vector<std::uint8_t> taken(origin.queries, 0);
  for (const std::string& path : paths) read_file_of_scores(path, origin, classes, scores, taken);
  const auto missing = std::find(taken.begin(), taken.end(), 0);
  if (missing != taken.end())
    throw RunError(
        RunError::Kind::unusable,
        fmt::format("{0} of {1} queries are missing from the files of scores: the first is in shard i/n with "
                    "i = ({2} n - 1) / {1}, rounded down",
                    std::count(taken.begin(), taken.end(), 0), taken.size(), missing - taken.begin() + 1));
  return scores;
}

}  // namespace meander
