// meander retrieve searches a store for similar models by their descriptors, and evaluates the search.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>

#include "io/file/atomic_file.h"
#include "io/json_writer.h"
#include "io/table/table.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/jobs.h"
#include "jobs/cli/option_words.h"
#include "jobs/cli/output_guard.h"
#include "jobs/cli/units.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/run_report.h"
#include "jobs/retrieve/retrieve_commands.h"
#include "jobs/retrieve/score_files.h"
#include "jobs/rows/laboratory.h"
#include "jobs/rows/rank_option.h"
#include "jobs/rows/retrieve_base.h"
#include "kernels/core/parallel.h"
#include "kernels/describe/describe_samples.h"
#include "kernels/retrieve/retrieval_scores.h"

namespace meander {

namespace {

constexpr std::size_t max_drawn_classes = 1024;

struct EvaluateOptions : CompareOptions {
  std::string classes, matrix, picture, confusion, html, shard, scores_file;
  std::vector<std::string> score_files;
  bool psb_compat = false, per_class = false;
};

std::string matrix_ids_path(const std::string& matrix) { return matrix + ".ids.csv"; }

void check_outputs(const EvaluateOptions& options) {
  OutputGuard guard;
  guard.protect(options.store, "the store itself");
  guard.protect(options.classes);
  guard.check(options.csv, {FileKind::csv}, "--csv");
  guard.check(options.matrix, {FileKind::distance_matrix}, "--matrix");
  if (!options.matrix.empty()) guard.check(matrix_ids_path(options.matrix), {FileKind::csv}, "--matrix");
  guard.check(options.picture, {FileKind::svg}, "--picture");
  guard.check(options.confusion, {options.confusion.ends_with(".svg") ? FileKind::svg : FileKind::png},
              "--confusion");
  guard.check(options.html, {FileKind::html}, "--html");
  for (const std::string& path : options.score_files) guard.protect(path, "scores that are read");
  guard.check(options.scores_file, {FileKind::scores}, "--write-scores");
}

// ---- evaluate --------------------------------------------------------------------------------------------

// The models nearest to a query: of all, and of its class.
struct NearestModels {
  NearRow any, own;
  bool has_own = false;
};

NearestModels nearest_models(const RetrievalTask& task, std::size_t query, std::span<const float> distances) {
  NearestModels result;
  bool has_any = false;
  for (std::uint32_t row = 0; row < distances.size(); ++row) {
    if (row == query) continue;
    if (!has_any || distances[row] < result.any.distance) result.any = {row, distances[row]};
    has_any = true;
    if (task.label[row] != task.label[query]) continue;
    if (!result.has_own || distances[row] < result.own.distance) result.own = {row, distances[row]};
    result.has_own = true;
  }
  return result;
}

// Refuses outputs that need all distances or all scores when only a part is computed.
void check_parts(const EvaluateOptions& options) {
  const bool writes = !options.scores_file.empty(), reads = !options.score_files.empty();
  if (options.shard.empty() == writes)
    throw UsageError("--shard i/n and --write-scores FILE go together: give both, or neither");
  if (writes && reads) throw UsageError("--write-scores and --read-scores exclude each other");
  const std::vector<std::pair<const char*, bool>> given = {
      {"--matrix", !options.matrix.empty()},   {"--html", !options.html.empty()},
      {"--picture", !options.picture.empty()}, {"--confusion", !options.confusion.empty()},
      {"--csv", !options.csv.empty()},         {"--per-class", options.per_class}};
  for (std::size_t i = 0; i < given.size(); ++i)
    if (given[i].second && (writes || (reads && i < 2)))
      throw UsageError(fmt::format("{} needs {}: leave it out", given[i].first,
                                   writes ? "the scores of all queries" : "all distances"));
}

// Scores the queries [begin, end) by what they are ranked by, and appends that to `matrix` unless it is null.
// nearest: empty, or one for each row, which is filled in for scored queries.
std::vector<QueryScores> score_queries(const RetrievalBase& base, const RetrievalTask& task,
                                       std::size_t begin, std::size_t end, AtomicFile* matrix = nullptr,
                                       std::span<NearestModels> nearest = {}) {
  const std::size_t n = task.rows();
  std::vector<QueryScores> queries(end - begin);
  if (begin == end) return queries;
  std::vector<float> ranked;
  visit_distances(base.base, begin, end, [&](std::size_t first, std::span<const float> distances) {
    ranked.assign(distances.begin(), distances.end());
    parallel_tasks(distances.size() / n, [&](std::size_t q) {
      const std::size_t query = first + q;
      const std::span<float> of_query = std::span(ranked).subspan(q * n, n);
      if (matrix == nullptr && !task.scores(query)) return;
      rank_row(base.ranking, query, of_query);
      if (!task.scores(query)) return;
      queries[query - begin] = score_query(task, query, of_query);
      if (!nearest.empty()) nearest[query] = nearest_models(task, query, of_query);
    });
    if (matrix != nullptr) matrix->append(std::as_bytes(std::span<const float>(ranked)));
  });
  return queries;
}

int write_part(const EvaluateOptions& options, const RetrievalBase& base, const RetrievalTask& task) {
  const StoreShard shard = parse_shard(options.shard);
  const std::uint64_t n = task.rows(), begin = n * shard.number / shard.count,
                      end = n * (shard.number + 1) / shard.count;
  const ScoreOrigin origin = origin_of_scores(options.store, base, options.distance, options.psb_compat);
  write_scores(options.scores_file, origin, begin, score_queries(base, task, begin, end));
  if (options.json) {
    fmt::print("{}\n", json_object([&](JsonWriter& json) {
                 json.member("scores", options.scores_file);
                 json.member("queries", n);
                 json.member("begin", begin);
                 json.member("end", end);
               }));
  } else {
    fmt::print("{}: scores of {} of {} queries, from number {} on; --read-scores joins all parts\n",
               options.scores_file, end - begin, n, begin);
  }
  return exit_done;
}

RetrievalSummary evaluate_base(const RetrievalBase& base, const RetrievalTask& task,
                               const std::string& matrix, bool with_confusion,
                               std::span<NearestModels> nearest = {}) {
  std::optional<AtomicFile> file;
  if (!matrix.empty()) file.emplace(matrix);
  const std::vector<QueryScores> queries =
      score_queries(base, task, 0, task.rows(), file ? &*file : nullptr, nearest);
  if (file) file->commit();
  return summarize(task, queries, with_confusion);
}

// Writes which row of the store each line of the matrix is.
void write_matrix_ids(const std::string& path, const StoreReader& store, const RetrievalBase& base) {
  Table table{{{"position"}, {"row"}, {"id"}, {"label"}}, {}};
  for (std::size_t i = 0; i < base.rows.size(); ++i)
    table.rows.push_back({i, base.rows[i], store.id(base.rows[i]), base.classes[base.labels[i]]});
  replace_file(path, csv_text(table));
}

std::vector<TableCell> score_cells(const std::string& name, std::size_t models,
                                   const RetrievalScores& scores) {
  std::vector<TableCell> cells{name, models};
  add_scores(cells, scores);
  return cells;
}

Table score_table(const RetrievalBase& base, const RetrievalTask& task, const RetrievalSummary& summary,
                  bool per_class) {
  Table table{{{"class"}, {"models"}}, {}};
  add_score_columns(table.columns);
  if (summary.queries > 0) {
    table.rows.push_back(score_cells("(micro)", summary.queries, summary.micro));
    table.rows.push_back(score_cells("(macro)", summary.queries, summary.macro));
  }
  if (!per_class) return table;
  for (std::size_t c = 0; c < base.classes.size(); ++c) {
    const std::size_t models = task.members[c].size();
    if (models == 0) continue;
    if (task.scored[c])
      table.rows.push_back(score_cells(base.classes[c], models, summary.by_class[c]));
    else
      table.rows.push_back({base.classes[c], models});  // a class without scores
  }
  return table;
}

void print_json(const EvaluateOptions& options, const RetrievalBase& base, const RetrievalSummary& summary,
                const Table& table) {
  fmt::print("{}\n", json_object([&](JsonWriter& json) {
               json.member("store", options.store);
               json.member("descriptor", joined(base.terms));
               json.member("distance", options.distance);
               json.member("rank", rank_word(base.ranking));
               json.member("psb_compat", options.psb_compat);
               json.member("rules", rules_text(options.psb_compat));
               json.member("models", std::uint64_t{base.rows.size()});
               json.member("queries", std::uint64_t{summary.queries});
               json.member("classes", std::uint64_t{summary.classes});
               write_left_out(json, base);
               json.key("results");
               write_table(json, table);
               json.key("recall");
               json.begin_array();
               for (std::size_t i = 0; i < recall_levels; ++i) json.value(recall_level(i));
               json.end_array();
               json.list("precision_micro", summary.micro.precision);
               json.list("precision_macro", summary.macro.precision);
             }));
}

// ---- the page --------------------------------------------------------------------------------------------

constexpr std::size_t max_confusions = 50;
constexpr std::ptrdiff_t milliseconds_column = 3;

Table confusion_table(const StoreReader& store, const RetrievalBase& base, const RetrievalTask& task,
                      std::span<const NearestModels> nearest) {
  const auto ratio = [&](std::size_t row) {
    const NearestModels& models = nearest[row];
    return models.own.distance > 0 ? models.any.distance / models.own.distance : 1.0f;  // both 0
  };
  std::vector<std::size_t> mistakes;
  for (std::size_t row = 0; row < task.rows(); ++row)
    if (task.scores(row) && task.label[nearest[row].any.row] != task.label[row]) mistakes.push_back(row);
  std::stable_sort(mistakes.begin(), mistakes.end(),
                   [&](std::size_t a, std::size_t b) { return ratio(a) < ratio(b); });
  Table table{{{"query"},
               {"class"},
               {"nearest"},
               {"its class"},
               {"distance"},
               {"nearest of its own class"},
               {"distance to it"},
               {"ratio"}},
              {}};
  for (std::size_t i = 0; i < std::min(mistakes.size(), max_confusions); ++i) {
    const std::size_t row = mistakes[i];
    const auto& [any, own, has_own] = nearest[row];
    table.rows.push_back({store.id(base.rows[row]), base.classes[task.label[row]],
                          store.id(base.rows[any.row]), base.classes[task.label[any.row]],
                          static_cast<double>(any.distance), store.id(base.rows[own.row]),
                          static_cast<double>(own.distance), static_cast<double>(ratio(row))});
  }
  return table;
}

// Adds a row to the table of settings. milliseconds: known if the run of the store made only this descriptor.
void add_setting(EvaluationPage& page, const std::string& distance, const RetrievalBase& base,
                 const RetrievalSummary& summary, const TableCell& milliseconds) {
  const std::string name = joined(base.terms);
  std::vector<TableCell> cells{name, distance, base.rows.size(), milliseconds};
  add_scores(cells, summary.micro);
  page.settings.rows.push_back(std::move(cells));
  page.curves.emplace_back(distance == "l1" ? name : name + ", " + distance, summary.micro);
}

// Adds every descriptor of the store, and those beside it that are in the setting, on its own, after the
// setting that is evaluated. milliseconds: of those of the store.
void add_descriptors(const EvaluateOptions& options, const StoreReader& store, const RetrievalBase& setting,
                     const RankParameters& rank, const TableCell& milliseconds, EvaluationPage& page) {
  std::vector<DescriptorTerm> terms;
  for (const DescriptorSchema& schema : store.descriptors())
    if (schema.group == "descriptors" && !is_companion(schema.name)) terms.push_back({schema});
  for (const DescriptorTerm& term : setting.terms)
    if (term.side) terms.push_back({term.schema, 1, term.side});
  for (const DescriptorTerm& term : terms) {
    const std::string& name = term.schema.name;
    const std::string distance = misfit(term.schema, options.kind()).empty() ? options.distance : "l1";
    if (name == joined(setting.terms)) continue;
    try {
      const RetrievalBase base =
          load_labeled_base(store,
                            {.descriptor = name,
                             .distance = value_of(distance_words, distance),
                             .rank = rank,
                             .memory = parse_bytes(options.memory),
                             .side = term.side ? SideVectorsList{term.side} : SideVectorsList{}},
                            options.classes);
      const RetrievalTask task = labeled_task(base, options.psb_compat);
      add_setting(page, distance, base, evaluate_base(base, task, {}, false),
                  term.side ? TableCell() : milliseconds);
    } catch (const UsageError& error) {  // too few rows have it: the page says so
      page.notes.push_back(fmt::format("{}: {}.", name, error.what()));
    }
  }
}

void write_html(const EvaluateOptions& options, const Laboratory& laboratory, const StoreReader& store,
                const RetrievalBase& base, const RankParameters& rank, const RetrievalTask& task,
                const RetrievalSummary& summary, std::span<const NearestModels> nearest) {
  EvaluationPage page;
  page.title = "Retrieval: " + std::filesystem::path(options.store).filename().string();
  page.rules = rules_text(options.psb_compat);
  page.notes.push_back(fmt::format("{} models, {} queries of {} classes; descriptor {}, distance {}, {}.",
                                   base.rows.size(), summary.queries, summary.classes, joined(base.terms),
                                   options.distance, rank_text(base.ranking)));
  if (const std::string left_out = left_out_text(base); !left_out.empty())
    page.notes.push_back("Left out: " + left_out + ".");
  const std::optional<double> all = read_run_report(options.store).describe_milliseconds;
  std::size_t described = 0;
  for (const DescriptorSchema& schema : store.descriptors())
    described += schema.group == "descriptors" && !is_companion(schema.name);
  if (all && described > 1)
    page.notes.push_back(
        fmt::format("The run of the store took {:.3g} ms a model for its descriptors together.", *all));
  const TableCell alone = all && described == 1 ? TableCell(*all) : TableCell();
  page.settings.columns = {{"descriptor"}, {"distance"}, {"models"}, {"ms a model"}};
  add_score_columns(page.settings.columns);
  add_setting(page, options.distance, base, summary, alone);
  add_descriptors(options, store, base, rank, alone, page);
  if (alone.kind == CellKind::empty) {  // no time is known for a single descriptor
    page.settings.columns.erase(page.settings.columns.begin() + milliseconds_column);
    for (std::vector<TableCell>& row : page.settings.rows) row.erase(row.begin() + milliseconds_column);
  }
  page.classes = score_table(base, task, summary, true);
  page.confusions = confusion_table(store, base, task, nearest);
  laboratory.write_page(options.html, page, base, task, summary);
}

int evaluate(const EvaluateOptions& options, const Laboratory* laboratory) {
  if (!options.picture.empty()) require_laboratory(laboratory, "--picture");
  if (!options.confusion.empty()) require_laboratory(laboratory, "--confusion");
  if (!options.html.empty()) require_laboratory(laboratory, "--html");
  if (!options.picture.empty() && !options.picture.ends_with(".svg"))
    throw UsageError("--picture draws SVG: `" + options.picture + "` should end in .svg");
  if (!options.confusion.empty() && !options.confusion.ends_with(".svg") &&
      !options.confusion.ends_with(".png"))
    throw UsageError("--confusion draws PNG or SVG: `" + options.confusion + "` should end in .png or .svg");
  check_parts(options);
  check_outputs(options);
  const StoreReader store(options.store, options.check);
  const BaseRequest request = request_of(store, options);
  const RetrievalBase base = load_labeled_base(store, request, options.classes);
  const RetrievalTask task = labeled_task(base, options.psb_compat);
  if (!options.scores_file.empty()) return write_part(options, base, task);
  const bool draws_confusion = !options.confusion.empty(), makes_page = !options.html.empty();
  if (draws_confusion && base.classes.size() > max_drawn_classes)
    throw UsageError(fmt::format("--confusion draws up to {} classes, but there are {}", max_drawn_classes,
                                 base.classes.size()));
  std::vector<NearestModels> nearest(makes_page ? base.rows.size() : 0);
  const bool with_confusion = draws_confusion || (makes_page && base.classes.size() <= max_drawn_classes);
  const RetrievalSummary summary =
      options.score_files.empty()
          ? evaluate_base(base, task, options.matrix, with_confusion, nearest)
          : summarize(task,
                      read_scores(options.score_files,
                                  origin_of_scores(options.store, base, options.distance, options.psb_compat),
                                  base.classes.size()),
                      with_confusion);
  if (!options.matrix.empty()) write_matrix_ids(matrix_ids_path(options.matrix), store, base);
  const Table table = score_table(base, task, summary, options.per_class);
  if (!options.csv.empty()) replace_file(options.csv, csv_text(table));
  if (!options.picture.empty())
    laboratory->draw_precision(options.picture, joined(base.terms) + ", " + options.distance, base, task,
                               summary, options.per_class);
  if (!options.confusion.empty()) laboratory->draw_confusion(options.confusion, base, task, summary);
  if (makes_page) write_html(options, *laboratory, store, base, request.rank, task, summary, nearest);
  if (options.json) {
    print_json(options, base, summary, table);
    return exit_done;
  }
  fmt::print("{} models, {} queries of {} classes; descriptor {}, distance {}, {}\n", base.rows.size(),
             summary.queries, summary.classes, joined(base.terms), options.distance, rank_text(base.ranking));
  const std::string left_out = left_out_text(base);
  if (!left_out.empty()) fmt::print("left out: {}\n", left_out);
  fmt::print("rules: {}\n{}", rules_text(options.psb_compat), text_table(table));
  return exit_done;
}

}  // namespace

void add_scoring_options(Command& command, std::string& classes, bool& psb_compat) {
  command.add_option("--classes", classes, "Princeton .cla file (default: the labels of the store)").common();
  command.add_flag("--psb-compat", psb_compat,
                   "Rules of psbTable: ties in row order; averages leave tiny and miscellaneous classes out");
}

void add_score_columns(std::vector<TableColumn>& columns) {
  columns.insert(columns.end(), {{"NN"}, {"1st tier"}, {"2nd tier"}, {"E-measure"}, {"DCG"}, {"mAP"}});
}

void add_scores(std::vector<TableCell>& cells, const RetrievalScores& s) {
  cells.insert(cells.end(),
               {s.nearest_neighbor, s.first_tier, s.second_tier, s.e_measure, s.dcg, s.average_precision});
}

JobFunction add_retrieve_job(Command& program, const Laboratory* laboratory) {
  Command command = program.add_subcommand(
      "retrieve",
      "Search a store for similar models by their descriptors, and evaluate the search by classes");
  command.example("meander retrieve query store.h5 chair/m12.off -k 10",
                  "The ten models that are most similar");
  command.example("meander retrieve evaluate store.h5", "How well the descriptors find the classes");
  command.require_subcommand();
  const JobFunction query = add_query_command(command, laboratory);
  auto options = std::make_shared<EvaluateOptions>();
  Command judge = command.add_subcommand(
      "evaluate", "Use every model as a query: scores, precision over recall, confusion of classes");
  judge.example("meander retrieve evaluate store.h5 --descriptor pairs", "Scores of one descriptor");
  judge.example("meander retrieve evaluate store.h5 --html page.html", "A page with the scores of all");
  add_compare_options(judge, *options);
  add_scoring_options(judge, options->classes, options->psb_compat);
  judge
      .add_flag("--per-class", options->per_class,
                "Print the scores of every class, and draw them in the picture")
      .common();
  judge.add_option("--matrix", options->matrix,
                   "Write all distances to this file: N x N float32 in row order, no header; FILE.ids.csv "
                   "has the row and the id of each line");
  judge.add_option("--picture", options->picture, "Plot precision over recall to this SVG file").common();
  judge.add_option(
      "--confusion", options->confusion,
      "Draw the confusion matrix (class of the query, class of the nearest model) to this SVG or PNG file");
  judge
      .add_option("--html", options->html,
                  "Write a page with all of this to this file, and with every descriptor of the store on "
                  "its own and the worst confusions")
      .common();
  judge.add_option("--shard", options->shard,
                   "Score only part i of n of the queries, from 0/n, into the file of --write-scores");
  judge.add_option("--write-scores", options->scores_file, "Write the scores of --shard to this file");
  judge.add_option("--read-scores", options->score_files,
                   "Read all parts from files of --write-scores instead of computing distances");
  const JobFunction select = add_select_command(command);
  const JobFunction words = add_words_command(command);
  const JobFunction graph = add_graph_command(command);
  return [options, laboratory, command, query, select, words, graph] {
    if (command.chose("query")) return query();
    if (command.chose("graph")) return graph();
    if (command.chose("words")) return words();
    return command.chose("evaluate") ? evaluate(*options, laboratory) : select();
  };
}

}  // namespace meander
