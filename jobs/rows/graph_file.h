// The file beside a store with the local scales and the graph of its rows: STORE.graph.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "jobs/rows/retrieve_base.h"
#include "kernels/retrieve/row_ranking.h"

namespace meander {

std::filesystem::path graph_path(const std::string& store);

// What a graph depends on: the bytes of the store, the rows that are compared, their descriptors, vectors
// beside the store, distance and ranking.
using GraphOrigin = std::array<std::uint8_t, 32>;
GraphOrigin origin_of_graph(const std::string& store, const RetrievalBase& base, const BaseRequest& request);

// Little-endian: graph_magic, the origin, the ranking, the SHA-256 of all before it. Throws FileError.
void write_graph(const std::filesystem::path& path, const GraphOrigin& origin, const RowRanking& ranking);
// Empty where there is no such file, or it is of another origin. Throws RunError(unusable) for a damaged
// file.
std::optional<RowRanking> read_graph(const std::filesystem::path& path, const GraphOrigin& origin);

}  // namespace meander
