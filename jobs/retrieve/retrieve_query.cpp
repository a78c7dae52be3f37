#include "jobs/retrieve/retrieve_commands.h"

#include <fmt/format.h>
#include <oneapi/tbb/info.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <memory>
#include <optional>
#include <utility>

#include "io/file/atomic_file.h"
#include "io/json_writer.h"
#include "io/mesh/mesh_reader.h"
#include "io/table/table.h"
#include "jobs/cli/allow_failures.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/output_guard.h"
#include "jobs/cli/units.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/input_options.h"
#include "jobs/inputs/store_items.h"
#include "jobs/rows/described_meshes.h"
#include "jobs/rows/laboratory.h"
#include "jobs/rows/local_codes.h"
#include "jobs/rows/planned_run.h"
#include "jobs/rows/rank_option.h"
#include "jobs/rows/retrieve_base.h"
#include "jobs/rows/run_header.h"
#include "jobs/rows/stored_parameters.h"
#include "kernels/core/parallel.h"
#include "kernels/describe/describe_samples.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/retrieve/nearest_rows.h"
#include "pipeline/sampling_graph.h"

namespace meander {

namespace {

struct QueryOptions : CompareOptions {
  std::vector<std::string> items, meshes;
  std::uint32_t k = 10;
  std::string picture;
  std::vector<std::string> inputs;
  InputOptions collect;
  HitPictureLook look;
};

// A query and the rows of the store that it found, nearest first.
struct Answer {
  std::string query;
  Status status = Status::ok;
  std::string reason{};                // empty when ok
  std::optional<std::uint64_t> row{};  // of a query that is in the store
  std::optional<PlanItem> file{};      // of a mesh
  std::vector<NearRow> found{};
};

// ---- meshes as queries ------------------------------------------------------------------------------------

struct MeshQuery {
  std::string id;
  PlanItem file;
  Status status = Status::internal;
  std::string reason;         // empty when ok
  std::vector<float> values;  // of the wanted descriptors; empty unless ok
};

constexpr double query_seconds = 120;

// The values of the wanted descriptors, one after the other. parameters: of those of the store, in their
// order.
std::vector<float> described(Model& model, const StoredParameters& parameters,
                             std::span<const DescriptorTerm> wanted) {
  Samples& samples = model.row.samples;
  // Samples are located on the mesh, as for the rows of a store.
  if (!model.surface.has_topology()) model.surface = prepare_mesh(model.file, model.cancel);
  locate_on_mesh(model.file, model.surface, samples);
  std::vector<float> values;
  std::size_t stored = 0;
  for (const DescriptorTerm& term : wanted) {
    if (term.side) {
      const std::vector<float> code = local_code_of(*term.side->local, samples);
      values.insert(values.end(), code.begin(), code.end());
      continue;
    }
    for (const DescriptorRow& row :
         describe_samples(model.surface, samples, model.key, parameters.describe[stored], model.cancel))
      if (row.name == term.schema.name) {
        if (row.values.size() != term.schema.width)
          throw ItemError(Status::internal, fmt::format("{} has {} values, and {} in the store", row.name,
                                                        row.values.size(), term.schema.width));
        values.insert(values.end(), row.values.begin(), row.values.end());
      }
    ++stored;
  }
  return values;
}

StoreHeader header_of(const SampleParameters& sample, const Inputs& inputs) {
  RunOptions options;
  options.sample = sample;
  options.parameters_json = "{}";
  return run_header(options, inputs, nullptr);
}

// One query for each mesh that the arguments name or contain (like the INPUT of `run`), in the order of their
// ids. A mesh that cannot be read, sampled or described has its status and reason; folders that cannot be
// read are named on standard error. `path` is that of the store. Models wait while those in work need more
// than `memory` bytes; each may take 120 s. Throws UsageError as stored_parameters and collect_inputs do, and
// when there is no mesh.
std::vector<MeshQuery> describe_queries(const StoreReader& store, const std::string& path,
                                        std::span<const DescriptorTerm> wanted,
                                        const std::vector<std::string>& arguments, std::uint64_t memory) {
  std::vector<DescriptorSchema> of_store;
  for (const DescriptorTerm& term : wanted)
    if (!term.side) of_store.push_back(term.schema);
  StoredParameters stored = stored_parameters(store, path, of_store);
  if (of_store.size() < wanted.size()) stored.sample.columns[&Samples::normals] = true;
  Inputs inputs = collect_inputs(arguments);
  print_unread(inputs.notes);
  if (inputs.items.empty()) throw UsageError("--mesh: no mesh file (" + mesh_extensions() + ") in the input");
  GraphParameters graph;
  graph.sample = stored.sample;
  for (const DescribeParameters& describe : stored.describe)  // counts in the estimate of memory
    graph.sample.describe.descriptors.push_back(describe.descriptors.front());
  graph.threads = std::max(1, oneapi::tbb::info::default_concurrency());
  graph.memory_bytes = memory;
  graph.timeout_seconds = query_seconds;
  estimate_items(inputs.items, graph.sample, graph.threads, graph.memory_bytes);

  std::vector<MeshQuery> queries(inputs.items.size());
  std::optional<EmbreeDevice> device;
  if (casts_rays(stored.sample)) device.emplace();
  GraphStages stages = sampling_stages(stored.sample, device ? &*device : nullptr);
  stages.push_back({"describe_shape", [&](GraphItem& item) {
                      release_charts(item.model);
                      queries[item.plan->row].values = described(item.model, stored, wanted);
                    }});
  NoRows rows;
  std::atomic<bool> stopped = false;
  std::vector<NodeStatistics> statistics;
  const StoreHeader header = header_of(stored.sample, inputs);
  run_sampling_graph(inputs.items, graph, stages, header, rows, stopped, statistics,
                     [&](const FinishedItem& item) {
                       MeshQuery& query = queries[item.plan.row];
                       query.id = item.plan.id;
                       query.file = item.plan;
                       query.status = item.report.status;
                       query.reason = item.report.reason;
                       if (query.status != Status::ok) query.values.clear();
                     });
  return queries;
}

// ---- the search -------------------------------------------------------------------------------------------

// The queries of a search.
struct Asked {
  std::vector<Answer> answers;
  std::vector<DescriptorQuery> queries;  // for the answers that are ok, in their order

  void add(Answer answer, std::optional<DescriptorQuery> query) {
    if (answer.status == Status::ok && !query) {
      answer.status = Status::internal;
      answer.reason = "its descriptor could not be computed: its values are not finite";
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
      throw UsageError(fmt::format("`{}` lacks {}, which could not be computed: see `meander describe`", item,
                                   joined(base.terms)));
    asked.add({.query = store.id(row), .row = row}, std::move(query));
  }
}

void ask_meshes(const StoreReader& store, const RetrievalBase& base, const QueryOptions& options,
                std::uint64_t memory, Asked& asked) {
  if (options.meshes.empty()) return;
  for (const DescriptorTerm& term : base.terms)
    if (term.side && !term.side->local)
      throw UsageError(
          fmt::format("--mesh: `{}` has no vectors of other meshes: query by items, or by other "
                      "descriptors",
                      options.vectors));
  if (store.method_version() != store_method_version)
    fmt::print(stderr,
               "`{}` was sampled by method version {}, but the queries by version {}: the distance of a "
               "model to itself is small, not 0\n",
               options.store, store.method_version(), store_method_version);
  for (MeshQuery& mesh : describe_queries(store, options.store, base.terms, options.meshes, memory)) {
    std::optional<DescriptorQuery> query;
    if (mesh.status == Status::ok) query = query_of(base, mesh.values);
    asked.add({.query = std::move(mesh.id),
               .status = mesh.status,
               .reason = std::move(mesh.reason),
               .file = std::move(mesh.file)},
              std::move(query));
  }
}

constexpr std::size_t max_pictures = 400;

// Called before the search, once the number of queries is known.
void check_picture_size(const QueryOptions& options, std::size_t queries, std::uint64_t rows) {
  const std::uint64_t across = 1 + std::min<std::uint64_t>(options.k, rows);
  if (!options.picture.empty() && queries * across > max_pictures)
    throw UsageError(
        fmt::format("--picture: {} queries with up to {} models each are more than {} pictures: give a "
                    "smaller -k or fewer queries",
                    queries, across - 1, max_pictures));
}

// Answers the queries from a base in memory, whose rows are ranked anew for each.
void answer_ranked(const RetrievalBase& base, const QueryOptions& options, Asked& asked) {
  std::vector<std::pair<Answer*, const DescriptorQuery*>> queries;
  for (Answer& answer : asked.answers)
    if (answer.status == Status::ok) queries.emplace_back(&answer, &asked.queries[queries.size()]);
  parallel_tasks(queries.size(), [&](std::size_t q) {
    Answer* const answer = queries[q].first;
    const DescriptorQuery& query = *queries[q].second;
    std::vector<float> distances(base.base.rows);
    parallel_blocks(distances.size(), 4096, [&](std::size_t begin, std::size_t end) {
      descriptor_distances(base.base, query, begin, std::span(distances).subspan(begin, end - begin));
    });
    std::size_t own = NearestSearch::no_row;
    if (answer->row) {
      own = static_cast<std::size_t>(std::lower_bound(base.rows.begin(), base.rows.end(), *answer->row) -
                                     base.rows.begin());
      rank_row(base.ranking, own, distances);
    } else {
      rank_outside(base.ranking, distances);
    }
    answer->found = nearest_of(distances, own, options.k);
    for (NearRow& near : answer->found) near.row = static_cast<std::uint32_t>(base.rows[near.row]);
  });
}

// Answers all queries; where they are ranked by distance, by one pass over the store.
std::vector<Answer> answered(const StoreReader& store, RetrievalBase& base, const QueryOptions& options,
                             std::uint64_t memory) {
  Asked asked;
  ask_items(store, base, options, asked);
  ask_meshes(store, base, options, memory, asked);
  check_picture_size(options, asked.answers.size(), store.rows());
  if (base.ranking.kind != RankKind::plain) {
    answer_ranked(base, options, asked);
    return std::move(asked.answers);
  }
  const std::uint64_t kept = std::min<std::uint64_t>(options.k, store.rows());
  std::uint64_t held = asked.queries.size() * kept * sizeof(NearRow);
  for (const DescriptorQuery& query : asked.queries)
    for (const std::vector<float>& block : query.blocks) held += block.size() * sizeof(float);
  for (const DescriptorTerm& term : base.terms)
    if (term.side) held += term.side->values.size() * sizeof(float);
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

// The table of all answers; the column of queries is left out if there is only one.
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
  fmt::print("{}\n", json_object([&](JsonWriter& json) {
               json.member("store", options.store);
               if (one) json.member("item", answers.front().query);
               json.member("descriptor", joined(base.terms));
               json.member("distance", options.distance);
               json.member("rank", rank_word(base.ranking));
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
             }));
}

// ---- the picture -----------------------------------------------------------------------------------------

std::string class_of(const StoreReader& store, std::uint64_t row) {
  const std::int32_t label = store.label(row);
  return label < 0 ? "" : store.label_names().at(static_cast<std::size_t>(label));
}

PicturedHit hit_of(const StoreReader& store, const DescribedMeshes& meshes, std::uint64_t row) {
  PlanItem item;
  item.row = row;
  PicturedHit hit{.row = row, .title = store.id(row)};
  if (meshes.add_file(item)) hit.file = std::move(item);
  return hit;
}

std::vector<PicturedHit> hits_of(const StoreReader& store, const DescribedMeshes& meshes,
                                 const Answer& answer) {
  std::vector<PicturedHit> hits;
  std::string own_class;
  if (answer.row) {
    hits.push_back(hit_of(store, meshes, *answer.row));
    own_class = class_of(store, *answer.row);
  } else {
    hits.push_back({.file = answer.file, .title = answer.query});
  }
  hits.front().note = own_class.empty() ? "query" : "query, " + own_class;
  if (answer.status != Status::ok)
    hits.front().failure = fmt::format("{}: {}", name_of(answer.status), answer.reason);
  for (std::size_t i = 0; i < answer.found.size(); ++i) {
    PicturedHit& hit = hits.emplace_back(hit_of(store, meshes, answer.found[i].row));
    const std::string its_class = class_of(store, answer.found[i].row);
    hit.note = fmt::format("{}: {:.4g}{}{}", i + 1, answer.found[i].distance, its_class.empty() ? "" : ", ",
                           its_class);
    if (!own_class.empty() && !its_class.empty()) hit.right_class = own_class == its_class;
  }
  return hits;
}

DescribedMeshes meshes_of(const StoreReader& store, const QueryOptions& options, OutputGuard& guard) {
  if (options.inputs.empty()) return {};
  std::vector<std::string> ids;
  for (std::uint64_t row = 0; row < store.rows(); ++row) ids.push_back(store.id(row));
  DescribedMeshes meshes(options.store, ids, options.inputs, options.collect);
  guard.protect(meshes.files_read());
  return meshes;
}

void check_picture(const QueryOptions& options, const Laboratory* laboratory) {
  if (options.picture.empty()) return;
  require_laboratory(laboratory, "--picture");
  if (!options.picture.ends_with(".png"))
    throw UsageError("--picture draws PNG: `" + options.picture + "` should end in .png");
}

int query(const QueryOptions& options, const Laboratory* laboratory) {
  if (options.items.empty() && options.meshes.empty())
    throw UsageError("a query is missing: name items of the store, or meshes with --mesh");
  OutputGuard guard;
  guard.protect(options.store, "the store itself");
  check_picture(options, laboratory);
  const StoreReader store(options.store, options.check);
  const std::uint64_t memory = parse_bytes(options.memory);
  const DescribedMeshes meshes = meshes_of(store, options, guard);
  guard.check(options.csv, {FileKind::csv}, "--csv");
  guard.check(options.picture, {FileKind::png}, "--picture");
  const BaseRequest request = request_of(store, options);
  RetrievalBase base = request.rank.kind == RankKind::plain ? load_searched_base(store, request)
                                                            : load_ranked_base(store, request);
  const std::vector<Answer> answers = answered(store, base, options, memory);
  const Table table = table_of(store, answers);
  if (!options.csv.empty()) replace_file(options.csv, csv_text(table));
  if (!options.picture.empty()) {
    std::vector<std::vector<PicturedHit>> rows;
    for (const Answer& answer : answers) rows.push_back(hits_of(store, meshes, answer));
    HitPictureLook look = options.look;
    look.surfaces = !options.inputs.empty();
    look.memory = memory;
    laboratory->draw_hits(options.picture, store, rows, look);
  }
  if (options.json)
    print_json(options, store, base, answers);
  else
    fmt::print("descriptor {}, distance {}, {}\n{}", joined(base.terms), options.distance,
               rank_text(base.ranking), text_table(table));
  int status = exit_done;
  for (const Answer& answer : answers) {
    if (answer.status == Status::ok) continue;
    fmt::print(stderr, "{}: {}: {}\n", answer.query, name_of(answer.status), answer.reason);
    status = exit_some_failed;
  }
  return status;
}

}  // namespace

JobFunction add_query_command(Command& retrieve, const Laboratory* laboratory) {
  auto options = std::make_shared<QueryOptions>();
  Command command = retrieve.add_subcommand(
      "query", "List the models of a store that are most similar to its own, or to any mesh");
  command.example("meander retrieve query store.h5 chair/m12.off -k 10",
                  "The ten models that are most similar to one of the store");
  command.example("meander retrieve query store.h5 --mesh mine.stl", "The same for a mesh of your own");
  add_compare_options(command, *options);
  command.add_option("ITEM", options->items, "Ids or row numbers of models of the store");
  command
      .add_option("--mesh", options->meshes,
                  "Mesh files, folders or lists as queries: sampled and described as the store was")
      .common();
  command.add_option("-k,--count", options->k, "Number of models to list for each query, 1 to 1000000")
      .common()
      .show_default()
      .range(1, 1000000);
  Command pictures = command.under("Picture");
  const Option picture =
      pictures
          .add_option("--picture", options->picture,
                      "Draw every query beside the models that were found to this PNG file")
          .common();
  pictures
      .add_option("--input", options->inputs,
                  "Inputs of the run of the store, to draw its models as surfaces (default: as points)")
      .needs(picture);
  pictures.add_option("--size", options->look.size, "Pixels of a model's picture, 64 to 1024")
      .show_default()
      .range(64, 1024)
      .needs(picture);
  pictures.add_option("--up", options->look.up, "The axis of the models that points up")
      .show_default()
      .one_of({"x", "y", "z"})
      .needs(picture);
  return with_failures_option(command, [options, laboratory] { return query(*options, laboratory); });
}

}  // namespace meander
