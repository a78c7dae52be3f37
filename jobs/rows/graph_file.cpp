#include "jobs/rows/graph_file.h"

#include <fmt/format.h>

#include <span>
#include <vector>

#include "io/file/read_file.h"
#include "io/file_kind.h"
#include "io/sealed_file.h"
#include "io/store/file_checksum.h"

namespace meander {

namespace {

constexpr std::uint32_t graph_version = 2;
constexpr SealedKind graph_kind = {graph_magic, "a graph that this program can use",
                                   "; `meander retrieve graph` makes it anew"};

template <class Value>
void put_list(ValueBytes& bytes, const std::vector<Value>& values) {
  bytes.put(std::uint64_t{values.size()});
  bytes.put_all(std::span<const Value>(values));
}

template <class Value>
void take_list(SealedBytes& bytes, std::vector<Value>& values) {
  values = bytes.take_all<Value>(bytes.take<std::uint64_t>());
}

}  // namespace

std::filesystem::path graph_path(const std::string& store) { return store + ".graph"; }

GraphOrigin origin_of_graph(const std::string& store, const RetrievalBase& base, const BaseRequest& request) {
  ValueBytes bytes;
  bytes.put_text(fmt::format("{:08x}\n{}\n{} {} {} {}\n", stated_checksum(store), joined(base.terms),
                             static_cast<int>(request.distance), static_cast<int>(request.rank.kind),
                             request.rank.neighbors, request.rank.alpha));
  bytes.put_text(side_checksums(base.terms));
  bytes.put_all(std::span<const std::uint64_t>(base.rows));
  return bytes.seal();
}

void write_graph(const std::filesystem::path& path, const GraphOrigin& origin, const RowRanking& ranking) {
  ValueBytes bytes(graph_magic);
  bytes.put(graph_version);
  bytes.put(origin);
  bytes.put(static_cast<std::uint32_t>(ranking.kind));
  bytes.put(ranking.neighbors);
  bytes.put(ranking.alpha);
  bytes.put(ranking.mutual_share);
  bytes.put(ranking.diffusion_weight);
  bytes.put(ranking.mean);
  put_list(bytes, ranking.factors);
  put_list(bytes, ranking.reach);
  put_list(bytes, ranking.nearest);
  put_list(bytes, ranking.least);
  put_list(bytes, ranking.begin);
  put_list(bytes, ranking.rows);
  put_list(bytes, ranking.weights);
  put_list(bytes, ranking.degrees);
  bytes.write_sealed(path);
}

std::optional<RowRanking> read_graph(const std::filesystem::path& path, const GraphOrigin& origin) {
  const std::optional<std::string> content = content_if_exists(path);
  if (!content) return std::nullopt;
  SealedBytes bytes(path, graph_kind, *content);
  if (bytes.take<std::uint32_t>() != graph_version) bytes.refuse("it is of another version");
  if (bytes.take<GraphOrigin>() != origin) return std::nullopt;
  RowRanking ranking;
  ranking.kind = static_cast<RankKind>(bytes.take<std::uint32_t>());
  ranking.neighbors = bytes.take<std::uint32_t>();
  ranking.alpha = bytes.take<double>();
  ranking.mutual_share = bytes.take<double>();
  ranking.diffusion_weight = bytes.take<double>();
  ranking.mean = bytes.take<double>();
  take_list(bytes, ranking.factors);
  take_list(bytes, ranking.reach);
  take_list(bytes, ranking.nearest);
  take_list(bytes, ranking.least);
  take_list(bytes, ranking.begin);
  take_list(bytes, ranking.rows);
  take_list(bytes, ranking.weights);
  take_list(bytes, ranking.degrees);
  bytes.end("value");
  return ranking;
}

}  // namespace meander
