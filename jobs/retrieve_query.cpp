#include "jobs/retrieve_query.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>
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
#include "kernels/retrieve/nearest_rows.h"

namespace meander {

namespace {

struct QueryOptions : CompareOptions {
  std::vector<std::string> items, meshes;
  std::uint32_t k = 10;
};

// One query and the rows of the base that were found, nearest first.
struct Answer {
  std::string query;
  Status status = Status::ok;
  std::string reason;  // empty when ok
  std::vector<NearRow> found;
};

std::vector<Answer> answers_to_items(const StoreReader& store, const RetrievalBase& base,
                                     const QueryOptions& options) {
  std::vector<Answer> answers;
  for (const std::string& item : options.items) {
    const std::uint64_t row = find_item(store, item);
    const ItemReport report = store.report(row);
    if (report.status != Status::ok)
      throw UsageError(
          fmt::format("`{}` has no descriptors: {}: {}", item, name_of(report.status), report.reason));
    const auto at = std::lower_bound(base.rows.begin(), base.rows.end(), row);
    if (at == base.rows.end() || *at != row)
      throw UsageError(
          fmt::format("`{}` has no usable descriptor: its values are not finite or all 0", item));
    const auto number = static_cast<std::size_t>(at - base.rows.begin());
    answers.push_back({store.id(row), Status::ok, {}, nearest_rows(base.base, number, options.k)});
  }
  return answers;
}

std::vector<Answer> answers_to_meshes(const StoreReader& store, const RetrievalBase& base,
                                      const QueryOptions& options) {
  if (store.method_version() != store_method_version)
    fmt::print(
        stderr,
        "`{}` was sampled by method version {}, the queries are by version {}: a model of the store is "
        "near itself, not equal\n",
        options.store, store.method_version(), store_method_version);
  std::vector<Answer> answers;
  for (MeshQuery& mesh : describe_queries(store, options.store, base.schemas, options.meshes)) {
    Answer& answer = answers.emplace_back();
    answer.query = std::move(mesh.id);
    answer.status = mesh.status;
    answer.reason = std::move(mesh.reason);
    if (answer.status != Status::ok) continue;
    if (const std::optional<DescriptorQuery> query = query_of(base, mesh.values)) {
      answer.found = nearest_rows(base.base, *query, options.k);
    } else {
      answer.status = Status::internal;
      answer.reason = "its descriptor could not be made: its values are not finite or all 0";
    }
  }
  return answers;
}

std::vector<TableCell> cells_of(const StoreReader& store, const RetrievalBase& base, std::size_t rank,
                                const NearRow& found) {
  const std::uint64_t row = base.rows[found.row];
  const std::int32_t label = store.label(row);
  return {rank, row, store.id(row),
          label >= 0 ? TableCell(store.label_names().at(static_cast<std::size_t>(label))) : TableCell(),
          static_cast<double>(found.distance)};
}

// One query has no column of its own.
Table table_of(const StoreReader& store, const RetrievalBase& base, std::span<const Answer> answers) {
  Table table{{{"rank"}, {"row"}, {"id"}, {"class"}, {"distance"}}, {}};
  if (answers.size() > 1) table.columns.insert(table.columns.begin(), {"query"});
  for (const Answer& answer : answers)
    for (std::size_t i = 0; i < answer.found.size(); ++i) {
      std::vector<TableCell> cells = cells_of(store, base, i + 1, answer.found[i]);
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
  json.member("descriptor", joined(base.descriptors));
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
    write_table(json, table_of(store, base, std::span(&answer, 1)));
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
  const RetrievalBase base = load_base(store, options.descriptor, options.kind());
  std::vector<Answer> answers = answers_to_items(store, base, options);
  if (!options.meshes.empty())
    for (Answer& answer : answers_to_meshes(store, base, options)) answers.push_back(std::move(answer));
  const Table table = table_of(store, base, answers);
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
