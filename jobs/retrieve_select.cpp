#include "jobs/retrieve_select.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <numeric>

#include "io/file/atomic_file.h"
#include "io/table/csv_writer.h"
#include "io/table/json_table.h"
#include "io/table/text_table.h"
#include "jobs/command_line.h"
#include "jobs/exit_status.h"
#include "jobs/inputs.h"
#include "jobs/option_words.h"
#include "jobs/output_guard.h"
#include "jobs/retrieve_base.h"
#include "jobs/store_items.h"
#include "kernels/retrieve/setting_choice.h"

namespace meander {

namespace {

constexpr std::size_t most_combinations = 1023;  // all subsets of ten

constexpr Word<SettingCriterion> criterion_words[] = {{"nn+ft", SettingCriterion::nearest_and_first_tier},
                                                      {"nn", SettingCriterion::nearest_neighbour},
                                                      {"ft", SettingCriterion::first_tier},
                                                      {"st", SettingCriterion::second_tier},
                                                      {"e", SettingCriterion::e_measure},
                                                      {"dcg", SettingCriterion::dcg},
                                                      {"map", SettingCriterion::average_precision}};

struct SelectOptions {
  std::string store, classes, criterion = "nn+ft", csv;
  std::vector<std::string> descriptors, distances;  // empty: all
  std::uint32_t most = 10, show = 20;
  bool psb_compat = false, json = false;
  StoreCheck check = StoreCheck::every_byte;
};

// What is combined: names, and the combinations as indices into them.
struct Combinations {
  std::vector<std::string> names;
  std::vector<BlockCombination> list;

  std::string text(std::size_t number) const {
    std::vector<std::string> parts;
    for (const std::uint32_t block : list[number]) parts.push_back(names[block]);
    return joined(parts);
  }
};

Combinations listed_combinations(const std::vector<std::string>& texts) {
  Combinations result;
  for (const std::string& text : texts) {
    BlockCombination& combination = result.list.emplace_back();
    for (std::size_t begin = 0; begin <= text.size();) {
      const std::size_t end = std::min(text.find('+', begin), text.size());
      const std::string name = text.substr(begin, end - begin);
      const auto at = std::find(result.names.begin(), result.names.end(), name);
      combination.push_back(static_cast<std::uint32_t>(at - result.names.begin()));
      if (at == result.names.end()) result.names.push_back(name);
      begin = end + 1;
    }
  }
  return result;
}

// All sets of up to `most` histograms, small ones first.
Combinations all_combinations(const StoreReader& store, std::uint32_t most) {
  Combinations result;
  for (const DescriptorSchema& schema : store.descriptors())
    if (schema.group == "descriptors" &&
        std::any_of(schema.attributes.begin(), schema.attributes.end(),
                    [](const auto& attribute) { return attribute.first == "bins"; }))
      result.names.push_back(schema.name);
  if (result.names.empty())
    throw UsageError("the store has no histogram descriptors: name what to compare with --descriptors");
  const auto count = static_cast<std::uint32_t>(result.names.size());
  for (std::uint32_t size = 1; size <= std::min(most, count); ++size) {
    BlockCombination combination(size);
    std::iota(combination.begin(), combination.end(), 0u);
    while (true) {
      result.list.push_back(combination);
      if (result.list.size() > most_combinations)
        throw UsageError(
            fmt::format("{} descriptors have more than {} combinations of up to {}: take a "
                        "smaller --most, or list some with --descriptors",
                        count, most_combinations, most));
      // The next one in lexicographic order: the last index that can still grow.
      std::uint32_t at = size;
      while (at > 0 && combination[at - 1] == count - size + at - 1) --at;
      if (at == 0) break;
      ++combination[at - 1];
      for (std::uint32_t i = at; i < size; ++i) combination[i] = combination[i - 1] + 1;
    }
  }
  return result;
}

// Settings, one distance after the other within a combination.
struct ScoredSettings {
  std::vector<std::string> descriptor, distance;
  std::vector<RetrievalSummary> summaries;
  SettingCriterion criterion = SettingCriterion::nearest_and_first_tier;
  std::size_t best = 0;
  LeftOutScores left_out;
  std::vector<std::size_t> chosen;  // for how many classes
};

ScoredSettings scored_settings(const SelectOptions& options, const StoreReader& store,
                               const Combinations& combinations, RetrievalBase& base, RetrievalTask& task) {
  std::vector<std::string> distances = options.distances;
  if (distances.empty())
    for (const auto& word : distance_words) distances.emplace_back(word.text);
  std::vector<std::vector<RetrievalSummary>> by_distance;
  for (std::size_t d = 0; d < distances.size(); ++d) {  // one base at a time
    base = load_labelled_base(store, joined(combinations.names), value_of(distance_words, distances[d]),
                              options.classes);
    if (d == 0) {
      task = labelled_task(base, options.psb_compat);
      if (std::count(task.scored.begin(), task.scored.end(), 1) < 2)
        throw UsageError("one class cannot be left out: only one has enough models to be scored");
    }
    by_distance.push_back(score_combinations(base.base, task, combinations.list));
  }
  ScoredSettings result;
  for (std::size_t c = 0; c < combinations.list.size(); ++c)
    for (std::size_t d = 0; d < distances.size(); ++d) {
      result.descriptor.push_back(combinations.text(c));
      result.distance.push_back(distances[d]);
      result.summaries.push_back(std::move(by_distance[d][c]));
    }
  result.criterion = value_of(criterion_words, options.criterion);
  result.best = best_setting(result.summaries, result.criterion);
  result.left_out = leave_one_class_out(task, result.summaries, result.criterion);
  result.chosen.assign(result.summaries.size(), 0);
  for (const std::size_t setting : result.left_out.setting)
    if (setting != LeftOutScores::no_setting) ++result.chosen[setting];
  return result;
}

void add_scores(std::vector<TableCell>& cells, const RetrievalScores& s) {
  cells.insert(cells.end(),
               {s.nearest_neighbour, s.first_tier, s.second_tier, s.e_measure, s.dcg, s.average_precision});
}

const std::vector<TableColumn> score_columns = {{"NN"},        {"1st tier"}, {"2nd tier"},
                                                {"E-measure"}, {"DCG"},      {"mAP"}};

// The best first; equal ones in their order.
Table settings_table(const ScoredSettings& settings) {
  Table table{{{"descriptor"}, {"distance"}}, {}};
  table.columns.insert(table.columns.end(), score_columns.begin(), score_columns.end());
  table.columns.insert(table.columns.end(), {{"criterion"}, {"classes"}});
  std::vector<std::size_t> order(settings.summaries.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto value = [&](std::size_t s) {
    return criterion_of(settings.summaries[s].micro, settings.criterion);
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return value(a) > value(b); });
  for (const std::size_t s : order) {
    std::vector<TableCell> cells{settings.descriptor[s], settings.distance[s]};
    add_scores(cells, settings.summaries[s].micro);
    cells.insert(cells.end(), {value(s), settings.chosen[s]});
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

void print_json(const SelectOptions& options, const ScoredSettings& settings, const RetrievalBase& base,
                const Table& all, const Table& left_out) {
  JsonWriter json;
  json.begin_object();
  json.member("store", options.store);
  json.member("criterion", options.criterion);
  json.member("psb_compat", options.psb_compat);
  json.member("rules", rules_text(options.psb_compat));
  json.member("models", std::uint64_t{base.rows.size()});
  json.member("queries", std::uint64_t{settings.left_out.scores.queries});
  json.member("classes", std::uint64_t{settings.left_out.scores.classes});
  write_left_out(json, base);
  json.key("settings");
  write_table(json, all);
  json.key("leaving_one_class_out");
  write_table(json, left_out);
  json.end_object();
  fmt::print("{}\n", json.text());
}

int select(const SelectOptions& options) {
  OutputGuard guard;
  guard.protect(options.store, "the store itself");
  guard.protect(options.classes);
  guard.check(options.csv, {FileKind::csv}, "--csv");
  const StoreReader store(options.store, options.check);
  const Combinations combinations = options.descriptors.empty() ? all_combinations(store, options.most)
                                                                : listed_combinations(options.descriptors);
  RetrievalBase base;
  RetrievalTask task;
  const ScoredSettings settings = scored_settings(options, store, combinations, base, task);
  Table all = settings_table(settings);
  const Table left_out = left_out_table(settings, base, task);
  if (!options.csv.empty()) replace_file(options.csv, csv_text(all));
  if (options.json) {
    print_json(options, settings, base, all, left_out);
    return exit_done;
  }
  fmt::print("{} models, {} queries of {} classes; {} settings\n", base.rows.size(),
             settings.left_out.scores.queries, settings.left_out.scores.classes, all.rows.size());
  const std::string missing = left_out_text(base);
  if (!missing.empty()) fmt::print("left out: {}\n", missing);
  fmt::print("rules: {}\n", rules_text(options.psb_compat));
  const std::size_t shown =
      options.show == 0 ? all.rows.size() : std::min<std::size_t>(options.show, all.rows.size());
  fmt::print("\nall queries, best {} first{}; classes: for how many it is chosen below\n", options.criterion,
             shown < all.rows.size() ? fmt::format(" ({} of {})", shown, all.rows.size()) : "");
  all.rows.resize(shown);
  fmt::print("{}", text_table(all));
  fmt::print("\nleaving one class out: every class with the setting that is best for the others\n{}",
             text_table(left_out));
  return exit_done;
}

}  // namespace

JobFunction add_select_command(Command& retrieve) {
  Command command = retrieve.add_subcommand(
      "select", "Evaluate combinations of descriptors and distances, and choose the best");
  auto options = std::make_shared<SelectOptions>();
  command.add_option("STORE", options->store, "The store").required();
  const Option listed = command
                            .add_option("--descriptors", options->descriptors,
                                        "Combinations, separated by commas, such as d2,d2+geodesic "
                                        "(default: all combinations of the store's histograms)")
                            .separator(',');
  command.add_option("--most", options->most, "Most descriptors in a combination of the default, 1 to 10")
      .show_default()
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
