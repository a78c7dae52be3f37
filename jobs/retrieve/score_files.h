// Scores of the queries of a shard, as one process of many hands them on (meander retrieve evaluate --shard).
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

// What the scores depend on: the store, byte by byte, its rows that are compared, their classes, descriptors,
// distance and rules. Scores of different ones are never put together.
struct ScoreOrigin {
  std::array<std::uint8_t, 32> digest{};
  std::uint64_t queries = 0;  // rows of the base
};
ScoreOrigin origin_of_scores(const std::string& store, const RetrievalBase& base, const std::string& distance,
                             bool psb_compat);

// Little-endian: "meander scores 1\n", the digest, the numbers of all queries, of the first one and of the
// one behind the last; then for each of them the eight-byte floats of RetrievalScores in its order, the
// number of nearest classes (u32), and each of these (u32) with its share (f64); then the SHA-256 of all
// this. `scores`: of the queries [begin, begin + size). Throws FileError.
void write_scores(const std::filesystem::path& path, const ScoreOrigin& origin, std::uint64_t begin,
                  std::span<const QueryScores> scores);

// The scores of all queries, each of which is in one of the files. Throws RunError(unusable): a file is
// damaged, of another origin, or has queries of another one; queries are in none, which are named.
// classes: of the task; nearest classes are smaller.
std::vector<QueryScores> read_scores(std::span<const std::string> paths, const ScoreOrigin& origin,
                                     std::size_t classes);

}  // namespace meander
