#include "jobs/rows/graph_file.h"

#include <fmt/format.h>

#include <cstring>
#include <string_view>
#include <type_traits>

#include "io/digest.h"
#include "io/file/atomic_file.h"
#include "io/file/read_file.h"
#include "io/file_kind.h"
#include "io/run_error.h"
#include "io/store/crc32c.h"
#include "io/store/file_checksum.h"

namespace meander {

namespace {

GraphOrigin digest_of_graph(std::string_view bytes) {
  return sha256(std::as_bytes(std::span(bytes.data(), bytes.size())));
}

template <class Value>
void put_value(std::string& bytes, const Value& value) {
  static_assert(std::is_trivially_copyable_v<Value>);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}
template <class Value>
void put_values(std::string& bytes, const std::vector<Value>& values) {
  put_value(bytes, std::uint64_t{values.size()});
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value));
}

[[noreturn]] void refuse_graph(const std::filesystem::path& path, const std::string& why) {
  throw RunError(
      RunError::Kind::unusable,
      fmt::format("`{}` is not a graph that this program can use: {}; `meander retrieve graph` makes "
                  "it anew",
                  path.string(), why));
}

// Takes values from the front of the bytes of a file.
class GraphBytes {
 public:
  GraphBytes(const std::filesystem::path& path, std::string_view bytes) : path_(path), rest_(bytes) {}

  template <class Value>
  Value take() {
    if (rest_.size() < sizeof(Value)) refuse_graph(path_, "it ends too early");
    Value value;
    std::memcpy(&value, rest_.data(), sizeof value);
    rest_.remove_prefix(sizeof value);
    return value;
  }
  template <class Value>
  void take(std::vector<Value>& values) {
    const auto count = take<std::uint64_t>();
    if (rest_.size() / sizeof(Value) < count) refuse_graph(path_, "it ends too early");
    values.resize(count);
    std::memcpy(values.data(), rest_.data(), count * sizeof(Value));
    rest_.remove_prefix(count * sizeof(Value));
  }
  bool at_end() const { return rest_.empty(); }

 private:
  const std::filesystem::path& path_;
  std::string_view rest_;
};

constexpr std::uint32_t graph_version = 1;

}  // namespace

std::filesystem::path graph_path(const std::string& store) { return store + ".graph"; }

GraphOrigin origin_of_graph(const std::string& store, const RetrievalBase& base, const BaseRequest& request) {
  std::string text = fmt::format("{:08x}\n{}\n{} {} {} {}\n", stated_checksum(store), joined(base.terms),
                                 static_cast<int>(request.distance), static_cast<int>(request.rank.kind),
                                 request.rank.neighbors, request.rank.alpha);
  for (const DescriptorTerm& term : base.terms)
    if (term.side) text += fmt::format("{:08x}\n", crc32c(std::span<const float>(term.side->values)));
  for (const std::uint64_t row : base.rows) put_value(text, row);
  return digest_of_graph(text);
}

void write_graph(const std::filesystem::path& path, const GraphOrigin& origin, const RowRanking& ranking) {
  std::string bytes(graph_magic);
  put_value(bytes, graph_version);
  put_value(bytes, origin);
  put_value(bytes, static_cast<std::uint32_t>(ranking.kind));
  put_value(bytes, ranking.neighbors);
  put_value(bytes, ranking.alpha);
  put_value(bytes, ranking.mutual_share);
  put_value(bytes, ranking.diffusion_weight);
  put_value(bytes, ranking.mean);
  put_values(bytes, ranking.factors);
  put_values(bytes, ranking.reach);
  put_values(bytes, ranking.begin);
  put_values(bytes, ranking.rows);
  put_values(bytes, ranking.weights);
  put_values(bytes, ranking.degrees);
  put_value(bytes, digest_of_graph(bytes));
  replace_file(path, bytes);
}

std::optional<RowRanking> read_graph(const std::filesystem::path& path, const GraphOrigin& origin) {
  const std::optional<std::string> bytes = content_if_exists(path);
  if (!bytes) return std::nullopt;
  const std::string_view all(*bytes);
  if (!all.starts_with(graph_magic) || all.size() < graph_magic.size() + origin.size())
    refuse_graph(path, "it does not begin like one");
  const std::string_view content = all.substr(0, all.size() - origin.size());
  const GraphOrigin digest = digest_of_graph(content);
  if (std::memcmp(digest.data(), all.data() + content.size(), digest.size()) != 0)
    refuse_graph(path, "it is damaged: its digest does not match");
  GraphBytes rest(path, content.substr(graph_magic.size()));
  if (rest.take<std::uint32_t>() != graph_version || rest.take<GraphOrigin>() != origin) return std::nullopt;
  RowRanking ranking;
  ranking.kind = static_cast<RankKind>(rest.take<std::uint32_t>());
  ranking.neighbors = rest.take<std::uint32_t>();
  ranking.alpha = rest.take<double>();
  ranking.mutual_share = rest.take<double>();
  ranking.diffusion_weight = rest.take<double>();
  ranking.mean = rest.take<double>();
  rest.take(ranking.factors);
  rest.take(ranking.reach);
  rest.take(ranking.begin);
  rest.take(ranking.rows);
  rest.take(ranking.weights);
  rest.take(ranking.degrees);
  if (!rest.at_end()) refuse_graph(path, "something follows its last value");
  return ranking;
}

}  // namespace meander
