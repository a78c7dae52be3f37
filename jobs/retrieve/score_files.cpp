#include "jobs/retrieve/score_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "io/file/read_file.h"
#include "io/file_kind.h"
#include "io/run_error.h"
#include "io/sealed_file.h"
#include "jobs/rows/rank_option.h"

namespace meander {

namespace {

static_assert(std::is_trivially_copyable_v<RetrievalScores> &&
              sizeof(RetrievalScores) == (6 + recall_levels) * sizeof(double));

constexpr SealedKind scores_kind = {scores_magic, "a file of scores of this evaluation"};

// Reads the queries of one file into `scores`; `taken` becomes 1 for each.
void read_file_of_scores(const std::string& path, const ScoreOrigin& origin, std::size_t classes,
                         std::vector<QueryScores>& scores, std::vector<std::uint8_t>& taken) {
  const std::string content = content_of_file(path);
  SealedBytes rest(path, scores_kind, content);
  if (rest.take<Seal>() != origin.digest || rest.take<std::uint64_t>() != origin.queries)
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
  rest.end("query");
}

}  // namespace

ScoreOrigin origin_of_scores(const std::string& store, const RetrievalBase& base, const std::string& distance,
                             bool psb_compat) {
  ValueBytes bytes;
  bytes.put_text(fmt::format("{:08x}\n{}\n{}\n{}\n", stated_checksum(store), joined(base.terms), distance,
                             rules_text(psb_compat)));
  bytes.put_text(side_checksums(base.terms));
  if (base.ranking.kind != RankKind::plain) bytes.put_text(rank_word(base.ranking) + '\n');
  for (const std::string& name : base.classes) bytes.put_text(name + '\0');
  bytes.put_all(std::span<const std::uint64_t>(base.rows));
  bytes.put_all(std::span<const std::uint32_t>(base.labels));
  return {bytes.seal(), base.rows.size()};
}

void write_scores(const std::filesystem::path& path, const ScoreOrigin& origin, std::uint64_t begin,
                  std::span<const QueryScores> scores) {
  ValueBytes bytes(scores_magic);
  bytes.put(origin.digest);
  bytes.put(origin.queries);
  bytes.put(begin);
  bytes.put(begin + scores.size());
  for (const QueryScores& query : scores) {
    bytes.put(query.scores);
    bytes.put(static_cast<std::uint32_t>(query.nearest_classes.size()));
    for (const auto& [nearest, share] : query.nearest_classes) {
      bytes.put(nearest);
      bytes.put(share);
    }
  }
  bytes.write_sealed(path);
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
