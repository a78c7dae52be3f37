#include "jobs/retrieve_query.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <utility>

#include "io/file/atomic_file.h"
#include "io/json_writer.h"
#include "io/table/csv_writer.h"
#include "io/table/json_table.h"
#include "io/table/text_table.h"
#include "jobs/exit_status.h"
#include "jobs/inputs.h"
#include "jobs/mesh_queries.h"
#include "jobs/output_guard.h"
#include "jobs/retrieve_base.h"
#include "jobs/store_items.h"
#include "jobs/units.h"
#include "kernels/retrieve/nearest_rows.h"

namespace meander {

namespace {

struct QueryOptions : CompareOptions {
  std::vector<std::string> items, meshes;
  std::uint32_t k = 10;
};

// One query and the rows of the store that were found, nearest first.
struct Answer {
  std::string query;
  Status status = Status::ok;
  std::string reason{};                // empty when ok
  std::optional<std::uint64_t> row{};  // of a query that the store has
  std::vector<NearRow> found{};
};

// Queries on their way into a search.
struct Asked {
  std::vector<Answer> answers;
  std::vector<DescriptorQuery> queries;  // of the answers that are ok, in their order

  void add(Answer answer, std::optional<DescriptorQuery> query) {
    if (answer.status == Status::ok && !query) {
      answer.status = Status::internal;
      answer.reason = "its descriptor could not be made: its values are not finite";
    }
    if (answer.status == Status::ok) queries.push_back(std::move(*query));
    answers.push_back(std::move(answer));
  }
};

void ask_items(const StoreReader& store, const RetrievalBase& base, const QueryOptions& options,
               Asked& asked) {
  for (const std::string& item : options.items) {
    const std::uint64_t row = find_item(store, item);
    const ItemReport report = store.report(row);
    if (report.status != Status::ok)
      throw UsageError(
          fmt::format("`{}` has no descriptors: {}: {}", item, name_of(report.status), report.reason));
    std::optional<DescriptorQuery> query = query_of(store, base, row);
    if (!query)
      throw UsageError(fmt::format("`{}` lacks {}: it could not be made, see `meander describe`", item,
                                   joined(base.terms)));
    asked.add({.query = store.id(row), .row = row}, std::move(query));
  }
}

void ask_meshes(const StoreReader& store, const RetrievalBase& base, const QueryOptions& options,
                std::uint64_t memory, Asked& asked) {
  if (options.meshes.empty()) return;
  if (store.method_version() != store_method_version)
    fmt::print(
        stderr,
        "`{}` was sampled by method version {}, the queries are by version {}: a model of the store is "
        "near itself, not equal\n",
        options.store, store.method_version(), store_method_version);
  std::vector<DescriptorSchema> schemas;
  for (const DescriptorTerm& term : base.terms) schemas.push_back(term.schema);
  for (MeshQuery& mesh : describe_queries(store, options.store, schemas, options.meshes, memory)) {
    std::optional<DescriptorQuery> query;
    if (mesh.status == Status::ok) query = query_of(base, mesh.values);
    asked.add({.query = std::move(mesh.id), .status = mesh.status, .reason = std::move(mesh.reason)},
              std::move(query));
  }
}

// All queries in one pass over the store.
std::vector<Answer> answered(const StoreReader& store, RetrievalBase& base, const QueryOptions& options,
                             std::uint64_t memory) {
  Asked asked;
  ask_items(store, base, options, asked);
  ask_meshes(store, base, options, memory, asked);
  const std::uint64_t kept = std::min<std::uint64_t>(options.k, store.rows());
  std::uint64_t held = asked.queries.size() * kept * sizeof(NearRow);
  for (const DescriptorQuery& query : asked.queries)
    for (const std::vector<float>& block : query.blocks) held += block.size() * sizeof(float);
  NearestSearch search(options.k);
  auto query = asked.queries.begin();
  for (const Answer& answer : asked.answers)
    if (answer.status == Status::ok)
      search.add_query(std::move(*query++), answer.row ? *answer.row : NearestSearch::no_row);
  search_store(store, base, search, memory, held);
  std::size_t number = 0;
  for (Answer& answer : asked.answers)
    if (answer.status == Status::ok) answer.found = search.found(number++);
  return std::move(asked.answers);
}

std::vector<TableCell> cells_of(const StoreReader& store, std::size_t rank, const NearRow& found) {
  const std::uint64_t row = found.row;
  const std::int32_t label = store.label(row);
  return {rank, row, store.id(row),
          label >= 0 ? TableCell(store.label_names().at(static_cast<std::size_t>(label))) : TableCell(),
          static_cast<double>(found.distance)};
}

// One query has no column of its own.
Table table_of(const StoreReader& store, std::span<const Answer> answers) {
  Table table{{{"rank"}, {"row"}, {"id"}, {"class"}, {"distance"}}, {}};
  if (answers.size() > 1) table.columns.insert(table.columns.begin(), {"query"});
  for (const Answer& answer : answers)
    for (std::size_t i = 0; i < answer.found.size(); ++i) {
      std::vector<TableCell> cells = cells_of(store, i + 1, answer.found[i]);
      if (answers.size() > 1) cells.insert(cells.begin(), answer.query);
      table.rows.push_back(std::move(cells));
    }
  return table;
}

void print_json(const QueryOptions& options, const StoreReader& store, const RetrievalBase& base,
                std::span<const Answer> answers) {
  const bool one = options.meshes.empty() && answers.size() == 1;
  JsonWriter json;
  json.begin_object();
  json.member("store", options.store);
  if (one) json.member("item", answers.front().query);
  json.member("descriptor", joined(base.terms));
  json.member("distance", options.distance);
  write_left_out(json, base);
  if (!one) {
    json.key("queries");
    json.begin_array();
  }
  for (const Answer& answer : answers) {
    if (!one) {
      json.begin_object();
      json.member("query", answer.query);
      json.member("status", name_of(answer.status));
      json.member("reason", answer.reason);
    }
    json.key("results");
    write_table(json, table_of(store, std::span(&answer, 1)));
    if (!one) json.end_object();
  }
  if (!one) json.end_array();
  json.end_object();
  fmt::print("{}\n", json.text());
}

int query(const QueryOptions& options) {
  if (options.items.empty() && options.meshes.empty())
    throw UsageError("nothing is asked: name items of the store, or meshes with --mesh");
  OutputGuard guard;
  guard.protect(options.store, "the store itself");
  guard.check(options.csv, {FileKind::csv}, "--csv");
  const StoreReader store(options.store, options.check);
  const std::uint64_t memory = parse_bytes(options.memory);
  RetrievalBase base = load_searched_base(
      store, {.descriptor = options.descriptor, .distance = options.kind(), .memory = memory});
  const std::vector<Answer> answers = answered(store, base, options, memory);
  const Table table = table_of(store, answers);
  if (!options.csv.empty()) replace_file(options.csv, csv_text(table));
  if (options.json)
    print_json(options, store, base, answers);
  else
    fmt::print("{}", text_table(table));
  int status = exit_done;
  for (const Answer& answer : answers) {
    if (answer.status == Status::ok) continue;
    fmt::print(stderr, "{}: {}: {}\n", answer.query, name_of(answer.status), answer.reason);
    status = exit_some_failed;
  }
  return status;
}

}  // namespace

JobFunction add_query_command(Command& retrieve) {
  auto options = std::make_shared<QueryOptions>();
  Command command = retrieve.add_subcommand(
      "query", "List the models of a store that are most similar to its own, or to any mesh");
  add_compare_options(command, *options);
  command.add_option("ITEM", options->items, "Ids or row numbers of models of the store");
  command.add_option("--mesh", options->meshes,
                     "Mesh files, folders or lists as queries: sampled and described as the store was");
  command.add_option("-k,--count", options->k, "Number of models to list for each query, 1 to 1000000")
      .show_default()
      .range(1, 1000000);
  return [options] { return query(*options); };
}

}  // namespace meander
