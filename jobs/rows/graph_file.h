// The file beside a store with the local scales and the graph of its rows: STORE.graph.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "io/sealed_file.h"
#include "jobs/rows/retrieve_base.h"
#include "kernels/retrieve/row_ranking.h"

namespace meander {

std::filesystem::path graph_path(const std::string& store);

// What a graph depends on: the bytes of the store, the rows that are compared, their descriptors, vectors
// beside the store, distance and ranking.
using GraphOrigin = Seal;
GraphOrigin origin_of_graph(const std::string& store, const RetrievalBase& base, const BaseRequest& request);

// A sealed file (graph_magic): the version, the origin, the ranking. Throws FileError.
void write_graph(const std::filesystem::path& path, const GraphOrigin& origin, const RowRanking& ranking);
// Empty where there is no such file, or it is of another origin. Throws RunError(unusable) for a file
// that is damaged or of another version.
std::optional<RowRanking> read_graph(const std::filesystem::path& path, const GraphOrigin& origin);

}  // namespace meander
