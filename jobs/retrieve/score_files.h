// Files with the scores of a part of the queries (meander retrieve evaluate --shard).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "jobs/rows/retrieve_base.h"
#include "kernels/retrieve/retrieval_scores.h"

namespace meander {

// Identifies what the scores depend on: the bytes of the store, the rows that are compared, their classes,
// descriptors, distance, ranking and rules. Scores of different origins are never joined.
struct ScoreOrigin {
  std::array<std::uint8_t, 32> digest{};
  std::uint64_t queries = 0;  // rows of the base
};
ScoreOrigin origin_of_scores(const std::string& store, const RetrievalBase& base, const std::string& distance,
                             bool psb_compat);

// Writes the scores of the queries [begin, begin + scores.size()), little-endian: "meander scores 1\n", the
// digest, the number of all queries, begin and end (u64); for each query the doubles of RetrievalScores in
// their order, the number of nearest classes (u32), and each of these (u32) with its share (f64); last the
// SHA-256 of all bytes before it. Throws FileError.
void write_scores(const std::filesystem::path& path, const ScoreOrigin& origin, std::uint64_t begin,
                  std::span<const QueryScores> scores);

// Reads the scores of all queries, each of which must be in exactly one of the files. Throws
// RunError(unusable) for a file that is damaged, of another origin, or repeats queries, and for missing
// queries, which are named. classes: the number of classes of the task.
std::vector<QueryScores> read_scores(std::span<const std::string> paths, const ScoreOrigin& origin,
                                     std::size_t classes);

}  // namespace meander
