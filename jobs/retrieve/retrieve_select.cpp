#include "jobs/retrieve/retrieve_commands.h"

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
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/store_items.h"
#include "jobs/rows/retrieve_base.h"
#include "kernels/retrieve/setting_choice.h"

namespace meander {

namespace {

constexpr Word<SettingCriterion> criterion_words[] = {{"nn+ft", SettingCriterion::nearest_and_first_tier},
                                                      {"nn", SettingCriterion::nearest_neighbor},
                                                      {"ft", SettingCriterion::first_tier},
                                                      {"st", SettingCriterion::second_tier},
                                                      {"e", SettingCriterion::e_measure},
                                                      {"dcg", SettingCriterion::dcg},
                                                      {"map", SettingCriterion::average_precision}};

struct SelectOptions {
  std::string store, classes, criterion = "nn+ft", csv, weights = "learnt", memory = "4G";
  std::vector<std::string> descriptors, distances;  // empty: all
  std::uint32_t most = 0, show = 20;                // most: 0: as many as leave max_combinations
  bool psb_compat = false, json = false;
  StoreCheck check = StoreCheck::every_byte;
};

// Settings with their scores, the best of them, and the setting that the other classes choose for each class.
struct ScoredSettings {
  std::vector<std::string> descriptor, distance;
  std::vector<RetrievalSummary> summaries;
  std::size_t best = 0;
  LeftOutScores left_out;

  std::size_t add(std::string of_descriptor, std::string of_distance, RetrievalSummary summary) {
    descriptor.push_back(std::move(of_descriptor));
    distance.push_back(std::move(of_distance));
    summaries.push_back(std::move(summary));
    return summaries.size() - 1;
  }
};

struct Selection {
  SettingCriterion criterion = SettingCriterion::nearest_and_first_tier;
  ScoredSettings given;                  // by combination, then by distance
  std::vector<std::size_t> chosen;       // for each of these, by how many classes it is chosen
  std::size_t skipped = 0;               // combinations with a distance that does not fit
  std::optional<ScoredSettings> learnt;  // with weights
  // Whether learned weights find classes that had no part in the choice at least as well as given.best.
  bool recommends_learnt() const {
    return learnt && criterion_of(learnt->left_out.scores.micro, criterion) >=
                         criterion_of(given.left_out.scores.micro, criterion);
  }
};

// ---- the trials -------------------------------------------------------------------------------------------

constexpr std::size_t max_combinations = 1023;       // all subsets of ten
constexpr std::size_t scored_at_once = 256;          // for the memory of their scores
constexpr std::uint64_t setting_bytes = 100 * 1024;  // of the scores of a combination, see score_combinations

// The names of descriptors, and their combinations as indices into the names.
struct Combinations {
  std::vector<std::string> names;
  std::vector<BlockCombination> list;

  std::string text(const BlockCombination& combination) const {
    std::vector<NamedTerm> terms;
    for (const WeightedBlock& part : combination) terms.push_back({names[part.block], part.weight});
    return joined(terms);
  }
};

Combinations listed_combinations(const std::vector<std::string>& texts) {
  Combinations result;
  for (const std::string& text : texts) {
    BlockCombination& combination = result.list.emplace_back();
    for (const NamedTerm& term : parse_terms(text)) {
      const auto at = std::find(result.names.begin(), result.names.end(), term.name);
      combination.emplace_back(static_cast<std::uint32_t>(at - result.names.begin()), term.weight);
      if (at == result.names.end()) result.names.push_back(term.name);
    }
  }
  return result;
}

// The maximum number of the `count` histograms in a combination: `most`, or, if that is 0, the largest number
// with no more than max_combinations.
std::uint32_t largest_combination(std::uint32_t count, std::uint32_t most) {
  std::size_t all = 0, of_size = 1;
  for (std::uint32_t size = 1; size <= count && (most == 0 || size <= most); ++size) {
    of_size = of_size * (count - size + 1) / size;
    all += of_size;
    if (all <= max_combinations) continue;
    if (most == 0 && size > 1) return size - 1;
    throw UsageError(
        fmt::format("{} descriptors have more than {} combinations of up to {}: give a smaller --most, or "
                    "list some with --descriptors",
                    count, max_combinations, size));
  }
  return most == 0 ? count : std::min(most, count);
}

// All sets of up to `most` histograms, smaller sets first.
Combinations all_combinations(const StoreReader& store, std::uint32_t most) {
  Combinations result;
  for (const DescriptorSchema& schema : store.descriptors())
    if (schema.group == "descriptors" &&
        std::any_of(schema.attributes.begin(), schema.attributes.end(),
                    [](const auto& attribute) { return attribute.first == "bins"; }))
      result.names.push_back(schema.name);
  if (result.names.empty())
    throw UsageError(
        "the store has no histogram descriptors: name the descriptors to compare with --descriptors");
  const auto count = static_cast<std::uint32_t>(result.names.size());
  const std::uint32_t largest = largest_combination(count, most);
  for (std::uint32_t size = 1; size <= largest; ++size) {
    BlockCombination combination;
    for (std::uint32_t i = 0; i < size; ++i) combination.emplace_back(i);
    while (true) {
      result.list.push_back(combination);
      // The next one in lexicographic order: the last index that can still grow.
      std::uint32_t at = size;
      while (at > 0 && combination[at - 1].block == count - size + at - 1) --at;
      if (at == 0) break;
      ++combination[at - 1].block;
      for (std::uint32_t i = at; i < size; ++i) combination[i].block = combination[i - 1].block + 1;
    }
  }
  return result;
}

// The settings that are tried with one distance; blocks are names of the combinations.
struct DistanceTrial {
  std::string distance;
  std::vector<std::size_t> tried;           // the combinations that fit the distance
  std::vector<RetrievalSummary> summaries;  // of each of these
  std::vector<RatedSetting> rated;          // of each of these
  LearntWeights learnt;
  std::vector<BlockCombination> visited;  // the distinct combinations with learned weights
  std::vector<RetrievalSummary> of_visited;
};

// Translates between names and the blocks of one base, which are those of the names that fit its distance.
class DistanceBlocks {
 public:
  DistanceBlocks(const StoreReader& store, const Combinations& combinations, DistanceKind kind) {
    for (std::uint32_t n = 0; n < combinations.names.size(); ++n) {
      const DescriptorSchema schema = chosen_descriptors(store, combinations.names[n]).front().schema;
      const std::string why = misfit(schema, kind);
      if (why.empty()) {
        block_of_.push_back(static_cast<std::uint32_t>(name_of_.size()));
        name_of_.push_back(n);
        text_ += (text_.empty() ? "" : "+") + combinations.names[n];
      } else {
        block_of_.push_back(none);
        why_ = why;
      }
    }
  }
  const std::string& text() const { return text_; }
  const std::string& why_not() const { return why_; }
  bool fit(const BlockCombination& combination) const {
    return std::none_of(combination.begin(), combination.end(),
                        [&](const WeightedBlock& part) { return block_of_[part.block] == none; });
  }
  BlockCombination to_blocks(BlockCombination combination) const {
    for (WeightedBlock& part : combination) part.block = block_of_[part.block];
    return combination;
  }
  BlockCombination to_names(BlockCombination combination) const {
    for (WeightedBlock& part : combination) part.block = name_of_[part.block];
    return combination;
  }

 private:
  static constexpr std::uint32_t none = ~std::uint32_t{0};
  std::vector<std::uint32_t> block_of_, name_of_;
  std::string text_, why_;
};

void learn(const RetrievalBase& base, const RetrievalTask& task, SettingCriterion criterion,
           const std::vector<BlockCombination>& combinations, const DistanceBlocks& blocks,
           DistanceTrial& trial) {
  WeightSearch search;
  search.criterion = criterion;
  trial.learnt = learn_weights(base.base, task, combinations, trial.summaries, search);
  const auto each_course = [&](const auto& visit) {
    visit(trial.learnt.all);
    for (LearntCourse& course : trial.learnt.without) visit(course);
  };
  each_course([&](const LearntCourse& course) {
    for (const LearntSetting& setting : course)
      if (std::find(trial.visited.begin(), trial.visited.end(), setting.combination) == trial.visited.end())
        trial.visited.push_back(setting.combination);
  });
  for (std::size_t begin = 0; begin < trial.visited.size(); begin += scored_at_once) {
    const std::size_t count = std::min(scored_at_once, trial.visited.size() - begin);
    for (RetrievalSummary& summary :
         score_combinations(base.base, task, std::span(trial.visited).subspan(begin, count)))
      trial.of_visited.push_back(std::move(summary));
  }
  for (BlockCombination& combination : trial.visited) combination = blocks.to_names(combination);
  each_course([&](LearntCourse& course) {
    for (LearntSetting& setting : course) setting.combination = blocks.to_names(setting.combination);
  });
}

// Tries one distance, and one base, after the other. `base` and `task` are left as those of the last
// distance; the rows are the same for all.
std::vector<DistanceTrial> tried_distances(const SelectOptions& options, const StoreReader& store,
                                           const Combinations& combinations, RetrievalBase& base,
                                           RetrievalTask& task) {
  std::vector<std::string> distances = options.distances;
  if (distances.empty())
    for (const auto& word : distance_words) distances.emplace_back(word.text);
  std::vector<NamedTerm> all;
  for (const std::string& name : combinations.names) all.push_back({name});
  const SettingCriterion criterion = value_of(criterion_words, options.criterion);
  std::vector<DistanceTrial> trials;
  std::string why_not;
  for (const std::string& distance : distances) {
    const DistanceKind kind = value_of(distance_words, distance);
    const DistanceBlocks blocks(store, combinations, kind);
    DistanceTrial trial;
    trial.distance = distance;
    std::vector<BlockCombination> fitting;
    for (std::size_t c = 0; c < combinations.list.size(); ++c) {
      if (!blocks.fit(combinations.list[c])) continue;
      trial.tried.push_back(c);
      fitting.push_back(blocks.to_blocks(combinations.list[c]));
    }
    if (fitting.empty()) {
      why_not = blocks.why_not();
      continue;
    }
    base = {};
    base = load_labeled_base(store,
                             {.descriptor = blocks.text(),
                              .distance = kind,
                              .memory = parse_bytes(options.memory),
                              .held = (fitting.size() + scored_at_once) * setting_bytes,
                              .also_described = joined(all)},
                             options.classes);
    task = labeled_task(base, options.psb_compat);
    if (std::count(task.scored.begin(), task.scored.end(), 1) < 2)
      throw UsageError(
          "leaving one class out needs two classes with enough models to be scored: there is one");
    trial.summaries = score_combinations(base.base, task, fitting);
    for (std::size_t s = 0; s < fitting.size(); ++s)
      trial.rated.push_back({fitting[s].size(), criterion_by_class(trial.summaries[s], criterion)});
    if (options.weights == "learnt") learn(base, task, criterion, fitting, blocks, trial);
    trials.push_back(std::move(trial));
  }
  if (trials.empty()) throw UsageError(why_not);
  return trials;
}

// Chooses among all combinations with every distance and those with learned weights: the simplest setting
// that is as good as the best (simplest_setting).
class LearntChoice {
 public:
  LearntChoice(const Combinations& combinations, const RetrievalTask& task,
               const std::vector<DistanceTrial>& trials)
      : combinations_(combinations), task_(task), trials_(trials) {}

  ScoredSettings settings() {
    result_.best = choose(no_class, [](const LearntWeights& w) { return &w.all; });
    std::vector<std::size_t> setting(task_.members.size(), LeftOutScores::no_setting);
    for (std::size_t c = 0; c < setting.size(); ++c)
      if (task_.scored[c] != 0) setting[c] = choose(c, [c](const LearntWeights& w) { return &w.without[c]; });
    result_.left_out = left_out_scores(task_, result_.summaries, std::move(setting));
    return std::move(result_);
  }

 private:
  template <class CourseOf>
  std::size_t choose(std::size_t without, const CourseOf& course_of) {
    std::vector<const RatedSetting*> rated;
    // Numbers beyond those of the tried combinations are those of the course.
    std::vector<std::pair<const DistanceTrial*, std::size_t>> from;
    for (const DistanceTrial& trial : trials_) {
      for (std::size_t s = 0; s < trial.rated.size(); ++s) {
        rated.push_back(&trial.rated[s]);
        from.emplace_back(&trial, s);
      }
      if (trial.visited.empty()) continue;
      const LearntCourse& course = *course_of(trial.learnt);
      for (std::size_t v = 0; v < course.size(); ++v) {
        rated.push_back(&course[v].rated);
        from.emplace_back(&trial, trial.rated.size() + v);
      }
    }
    const auto& [trial, number] = from[simplest_setting(task_, rated, without)];
    if (number < trial->rated.size())
      return taken(*trial, combinations_.list[trial->tried[number]], trial->summaries[number]);
    const BlockCombination& learnt = (*course_of(trial->learnt))[number - trial->rated.size()].combination;
    const auto at = std::find(trial->visited.begin(), trial->visited.end(), learnt);
    return taken(*trial, learnt, trial->of_visited[static_cast<std::size_t>(at - trial->visited.begin())]);
  }

  // The number of the setting in the result.
  std::size_t taken(const DistanceTrial& trial, const BlockCombination& combination,
                    const RetrievalSummary& summary) {
    const std::string descriptor = combinations_.text(combination);
    for (std::size_t s = 0; s < result_.summaries.size(); ++s)
      if (result_.descriptor[s] == descriptor && result_.distance[s] == trial.distance) return s;
    return result_.add(descriptor, trial.distance, summary);
  }

  const Combinations& combinations_;
  const RetrievalTask& task_;
  const std::vector<DistanceTrial>& trials_;
  ScoredSettings result_;
};

// Scores all combinations of the options with all their distances, and searches weights if they ask for it.
// Fills in the rows and classes of the base and the task. Throws UsageError and RunError. Memory: one base at
// a time, see load_labeled_base.
Selection selection_of(const SelectOptions& options, const StoreReader& store, RetrievalBase& base,
                       RetrievalTask& task) {
  const Combinations combinations = options.descriptors.empty() ? all_combinations(store, options.most)
                                                                : listed_combinations(options.descriptors);
  Selection result;
  result.criterion = value_of(criterion_words, options.criterion);
  const std::vector<DistanceTrial> trials = tried_distances(options, store, combinations, base, task);
  for (std::size_t c = 0; c < combinations.list.size(); ++c)
    for (const DistanceTrial& trial : trials) {
      const auto at = std::find(trial.tried.begin(), trial.tried.end(), c);
      if (at == trial.tried.end())
        ++result.skipped;
      else
        result.given.add(combinations.text(combinations.list[c]), trial.distance,
                         trial.summaries[static_cast<std::size_t>(at - trial.tried.begin())]);
    }
  result.given.best = best_setting(result.given.summaries, result.criterion);
  result.given.left_out = leave_one_class_out(task, result.given.summaries, result.criterion);
  result.chosen.assign(result.given.summaries.size(), 0);
  for (const std::size_t setting : result.given.left_out.setting)
    if (setting != LeftOutScores::no_setting) ++result.chosen[setting];
  if (options.weights == "learnt") result.learnt = LearntChoice(combinations, task, trials).settings();
  return result;
}

// ---- the tables -------------------------------------------------------------------------------------------

// All settings, the best first; equal ones keep their order.
Table settings_table(const Selection& selection) {
  const ScoredSettings& settings = selection.given;
  Table table{{{"descriptor"}, {"distance"}}, {}};
  add_score_columns(table.columns);
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
  add_score_columns(table.columns);
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

// The setting that all classes choose, and the scores of classes with the setting that the others choose.
Table choice_table(const Selection& selection) {
  Table table{{{"weights"}, {"chosen by"}, {"descriptor"}, {"distance"}}, {}};
  add_score_columns(table.columns);
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
  fmt::print("{}\n", json_object([&](JsonWriter& json) {
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
               const ScoredSettings& recommended =
                   selection.recommends_learnt() ? *selection.learnt : selection.given;
               json.object("recommended", [&] {
                 json.member("descriptor", recommended.descriptor[recommended.best]);
                 json.member("distance", recommended.distance[recommended.best]);
               });
             }));
}

void print_text(const SelectOptions& options, const Selection& selection, const RetrievalBase& base,
                const RetrievalTask& task, Table all) {
  const RetrievalSummary& scores = selection.given.left_out.scores;
  fmt::print("{} models, {} queries of {} classes; {} settings", base.rows.size(), scores.queries,
             scores.classes, all.rows.size());
  if (selection.skipped > 0) fmt::print(" ({} more skipped: their distance does not fit)", selection.skipped);
  const std::string missing = left_out_text(base);
  fmt::print("\n{}", missing.empty() ? "" : "left out: " + missing + "\n");
  fmt::print("rules: {}\n", rules_text(options.psb_compat));
  const std::size_t shown =
      options.show == 0 ? all.rows.size() : std::min<std::size_t>(options.show, all.rows.size());
  fmt::print("\nall queries, best {} first{}; classes: how many classes choose it below\n", options.criterion,
             shown < all.rows.size() ? fmt::format(" ({} of {})", shown, all.rows.size()) : "");
  all.rows.resize(shown);
  fmt::print("{}", text_table(all));
  fmt::print(
      "\nleaving one class out: every class is scored with the setting that is best for the others\n{}",
      text_table(left_out_table(selection.given, base, task)));
  if (selection.learnt)
    fmt::print(
        "\nthe same with weights learned from the others: the fewest descriptors as good as the best\n{}",
        text_table(left_out_table(*selection.learnt, base, task)));
  fmt::print("\nchoices, scored over all queries; a class has no part in a choice by the other classes\n{}",
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
  command.example("meander retrieve select store.h5", "All combinations of the descriptors of the store");
  command.example("meander retrieve select store.h5 --descriptors d2,d2+pairs --distances l1,emd",
                  "Two combinations by two distances");
  auto options = std::make_shared<SelectOptions>();
  command.add_option("STORE", options->store, "The store").required();
  const Option listed =
      command
          .add_option("--descriptors", options->descriptors,
                      "Combinations, separated by commas, such as d2,d2+geodesic,pairs=2+d2 (default: all "
                      "combinations of the store's histograms)")
          .common()
          .separator(',');
  command
      .add_option("--most", options->most,
                  "Maximum number of descriptors in a combination, 1 to 10, without --descriptors (default: "
                  "as many as give 1,023 combinations or fewer)")
      .range(1, 10)
      .excludes(listed);
  command
      .add_option("--distances", options->distances,
                  "Distances, separated by commas (default: l1,l2,emd,chi2,cosine)")
      .common()
      .separator(',')
      .one_of(all_words(distance_words));
  command
      .add_option("--criterion", options->criterion, "Score to choose by; nn+ft: mean of NN and first tier")
      .common()
      .show_default()
      .one_of(all_words(criterion_words));
  command
      .add_option("--weights", options->weights,
                  "learnt: also search weights of the descriptors, on classes that are not scored with them")
      .show_default()
      .one_of({"given", "learnt"});
  command.add_option("--memory", options->memory, "Limit of the memory of the whole process")
      .show_default()
      .bytes();
  add_scoring_options(command, options->classes, options->psb_compat);
  command.add_option("--show", options->show, "Settings to print (0: all); files always contain all")
      .show_default();
  command.add_flag("--json", options->json, "Print the results as JSON");
  command.add_option("--csv", options->csv, "Also write the table of settings to this CSV file");
  add_trust_option(command, options->check);
  return [options] { return select(*options); };
}

}  // namespace meander