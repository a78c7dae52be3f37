#include "jobs/retrieve/retrieve_select.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

#include "io/file/atomic_file.h"
#include "io/table/table.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/option_words.h"
#include "jobs/cli/output_guard.h"
#include "jobs/cli/units.h"
#include "jobs/inputs/store_items.h"
#include "jobs/retrieve/setting_trials.h"
#include "jobs/rows/retrieve_base.h"

namespace meander {

namespace {

void add_scores(std::vector<TableCell>& cells, const RetrievalScores& s) {
  cells.insert(cells.end(),
               {s.nearest_neighbour, s.first_tier, s.second_tier, s.e_measure, s.dcg, s.average_precision});
}

const std::vector<TableColumn> score_columns = {{"NN"},        {"1st tier"}, {"2nd tier"},
                                                {"E-measure"}, {"DCG"},      {"mAP"}};

// The best first; equal ones in their order.
Table settings_table(const Selection& selection) {
  const ScoredSettings& settings = selection.given;
  Table table{{{"descriptor"}, {"distance"}}, {}};
  table.columns.insert(table.columns.end(), score_columns.begin(), score_columns.end());
  table.columns.insert(table.columns.end(), {{"criterion"}, {"classes"}});
  std::vector<std::size_t> order(settings.summaries.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto value = [&](std::size_t s) {
    return criterion_of(settings.summaries[s].micro, selection.criterion);
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return value(a) > value(b); });
  for (const std::size_t s : order) {
    std::vector<TableCell> cells{settings.descriptor[s], settings.distance[s]};
    add_scores(cells, settings.summaries[s].micro);
    cells.insert(cells.end(), {value(s), selection.chosen[s]});
    table.rows.push_back(std::move(cells));
  }
  return table;
}

Table left_out_table(const ScoredSettings& settings, const RetrievalBase& base, const RetrievalTask& task) {
  Table table{{{"class"}, {"models"}, {"descriptor"}, {"distance"}}, {}};
  table.columns.insert(table.columns.end(), score_columns.begin(), score_columns.end());
  const LeftOutScores& left_out = settings.left_out;
  const auto add_mean = [&](const char* name, const RetrievalScores& scores) {
    table.rows.push_back({name, left_out.scores.queries, TableCell(), TableCell()});
    add_scores(table.rows.back(), scores);
  };
  add_mean("(micro)", left_out.scores.micro);
  add_mean("(macro)", left_out.scores.macro);
  for (std::size_t c = 0; c < base.classes.size(); ++c) {
    if (task.scored[c] == 0) continue;
    const std::size_t s = left_out.setting[c];
    table.rows.push_back(
        {base.classes[c], task.members[c].size(), settings.descriptor[s], settings.distance[s]});
    add_scores(table.rows.back(), left_out.scores.by_class[c]);
  }
  return table;
}

// What the choice among all classes is, and what it is worth for a class that had no say.
Table choice_table(const Selection& selection) {
  Table table{{{"weights"}, {"chosen by"}, {"descriptor"}, {"distance"}}, {}};
  table.columns.insert(table.columns.end(), score_columns.begin(), score_columns.end());
  table.columns.push_back({"criterion"});
  const auto add = [&](const char* weights, const ScoredSettings& settings) {
    const auto add_row = [&](std::vector<TableCell> cells, const RetrievalScores& scores) {
      add_scores(cells, scores);
      cells.emplace_back(criterion_of(scores, selection.criterion));
      table.rows.push_back(std::move(cells));
    };
    const std::size_t best = settings.best;
    add_row({weights, "all classes", settings.descriptor[best], settings.distance[best]},
            settings.summaries[best].micro);
    add_row({weights, "the other classes", TableCell(), TableCell()}, settings.left_out.scores.micro);
  };
  add("as given", selection.given);
  if (selection.learnt) add("learnt", *selection.learnt);
  return table;
}

void print_json(const SelectOptions& options, const Selection& selection, const RetrievalBase& base,
                const RetrievalTask& task, const Table& all) {
  const RetrievalSummary& scores = selection.given.left_out.scores;
  JsonWriter json;
  json.begin_object();
  json.member("store", options.store);
  json.member("criterion", options.criterion);
  json.member("psb_compat", options.psb_compat);
  json.member("rules", rules_text(options.psb_compat));
  json.member("models", std::uint64_t{base.rows.size()});
  json.member("queries", std::uint64_t{scores.queries});
  json.member("classes", std::uint64_t{scores.classes});
  json.member("skipped", std::uint64_t{selection.skipped});
  write_left_out(json, base);
  json.key("settings");
  write_table(json, all);
  json.key("leaving_one_class_out");
  write_table(json, left_out_table(selection.given, base, task));
  if (selection.learnt) {
    json.key("leaving_one_class_out_learnt");
    write_table(json, left_out_table(*selection.learnt, base, task));
  }
  json.key("choices");
  write_table(json, choice_table(selection));
  const ScoredSettings& recommended = selection.recommends_learnt() ? *selection.learnt : selection.given;
  json.key("recommended");
  json.begin_object();
  json.member("descriptor", recommended.descriptor[recommended.best]);
  json.member("distance", recommended.distance[recommended.best]);
  json.end_object();
  json.end_object();
  fmt::print("{}\n", json.text());
}

void print_text(const SelectOptions& options, const Selection& selection, const RetrievalBase& base,
                const RetrievalTask& task, Table all) {
  const RetrievalSummary& scores = selection.given.left_out.scores;
  fmt::print("{} models, {} queries of {} classes; {} settings", base.rows.size(), scores.queries,
             scores.classes, all.rows.size());
  if (selection.skipped > 0) fmt::print(" ({} more have a distance that does not fit)", selection.skipped);
  const std::string missing = left_out_text(base);
  fmt::print("\n{}", missing.empty() ? "" : "left out: " + missing + "\n");
  fmt::print("rules: {}\n", rules_text(options.psb_compat));
  const std::size_t shown =
      options.show == 0 ? all.rows.size() : std::min<std::size_t>(options.show, all.rows.size());
  fmt::print("\nall queries, best {} first{}; classes: for how many it is chosen below\n", options.criterion,
             shown < all.rows.size() ? fmt::format(" ({} of {})", shown, all.rows.size()) : "");
  all.rows.resize(shown);
  fmt::print("{}", text_table(all));
  fmt::print("\nleaving one class out: every class with the setting that is best for the others\n{}",
             text_table(left_out_table(selection.given, base, task)));
  if (selection.learnt)
    fmt::print(
        "\nthe same with weights that are learnt from the others: the fewest descriptors that are as good as "
        "the best\n{}",
        text_table(left_out_table(*selection.learnt, base, task)));
  fmt::print("\nchoices, scored over all queries; those by the other classes had no say in their own\n{}",
             text_table(choice_table(selection)));
  const ScoredSettings& recommended = selection.recommends_learnt() ? *selection.learnt : selection.given;
  fmt::print("\nrecommended: --descriptor {} --distance {}\n", recommended.descriptor[recommended.best],
             recommended.distance[recommended.best]);
}

int select(const SelectOptions& options) {
  OutputGuard guard;
  guard.protect(options.store, "the store itself");
  guard.protect(options.classes);
  guard.check(options.csv, {FileKind::csv}, "--csv");
  const StoreReader store(options.store, options.check);
  RetrievalBase base;
  RetrievalTask task;
  const Selection selection = selection_of(options, store, base, task);
  const Table all = settings_table(selection);
  if (!options.csv.empty()) replace_file(options.csv, csv_text(all));
  if (options.json)
    print_json(options, selection, base, task, all);
  else
    print_text(options, selection, base, task, all);
  return exit_done;
}

}  // namespace

JobFunction add_select_command(Command& retrieve) {
  Command command = retrieve.add_subcommand(
      "select", "Evaluate combinations of descriptors and distances, and choose the best");
  auto options = std::make_shared<SelectOptions>();
  command.add_option("STORE", options->store, "The store").required();
  const Option listed =
      command
          .add_option("--descriptors", options->descriptors,
                      "Combinations, separated by commas, such as d2,d2+geodesic,pairs=2+d2 "
                      "(default: all combinations of the store's histograms)")
          .separator(',');
  command
      .add_option(
          "--most", options->most,
          "Most descriptors in a combination of the default, 1 to 10 (default: as many as leave 1,023 "
          "combinations or fewer)")
      .range(1, 10)
      .excludes(listed);
  command
      .add_option("--distances", options->distances,
                  "Distances, separated by commas (default: l1,l2,emd,chi2,cosine)")
      .separator(',')
      .one_of(all_words(distance_words));
  command
      .add_option("--criterion", options->criterion, "Score that decides; nn+ft: mean of NN and first tier")
      .show_default()
      .one_of(all_words(criterion_words));
  command
      .add_option("--weights", options->weights,
                  "learnt: also search weights of the descriptors, by classes that are not scored with them")
      .show_default()
      .one_of({"given", "learnt"});
  command.add_option("--memory", options->memory, "Limit of the memory of the whole process").show_default();
  command.add_option("--classes", options->classes, "Princeton .cla file (default: the labels of the store)");
  command.add_flag(
      "--psb-compat", options->psb_compat,
      "Rules of psbTable: ties in row order; tiny and miscellaneous classes are left out of averages");
  command.add_option("--show", options->show, "Settings to print (0: all); files always contain all")
      .show_default();
  command.add_flag("--json", options->json, "Print the results as JSON");
  command.add_option("--csv", options->csv, "Also write the table of settings to this CSV file");
  add_trust_option(command, options->check);
  return [options] { return select(*options); };
}

}  // namespace meander