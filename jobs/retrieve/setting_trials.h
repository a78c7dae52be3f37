// Settings of `retrieve select`: combinations of descriptors under distances, scored, and the choice among
// them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "jobs/cli/option_words.h"
#include "jobs/rows/retrieve_base.h"
#include "kernels/retrieve/setting_choice.h"

namespace meander {

inline constexpr Word<SettingCriterion> criterion_words[] = {
    {"nn+ft", SettingCriterion::nearest_and_first_tier},
    {"nn", SettingCriterion::nearest_neighbour},
    {"ft", SettingCriterion::first_tier},
    {"st", SettingCriterion::second_tier},
    {"e", SettingCriterion::e_measure},
    {"dcg", SettingCriterion::dcg},
    {"map", SettingCriterion::average_precision}};

struct SelectOptions {
  std::string store, classes, criterion = "nn+ft", csv, weights = "learnt", memory = "4G";
  std::vector<std::string> descriptors, distances;  // empty: all
  std::uint32_t most = 0, show = 20;                // most: 0: as many as are bearable
  bool psb_compat = false, json = false;
  StoreCheck check = StoreCheck::every_byte;
};

// Settings with their scores, the best of them, and the choice of each class by the others.
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
  ScoredSettings given;                  // one distance after the other within a combination
  std::vector<std::size_t> chosen;       // of these, for how many classes
  std::size_t skipped = 0;               // combinations under distances that do not fit them
  std::optional<ScoredSettings> learnt;  // with weights
  // Where a class that had no say is found better with learnt weights, or as well, those; else given.best.
  bool recommends_learnt() const {
    return learnt && criterion_of(learnt->left_out.scores.micro, criterion) >=
                         criterion_of(given.left_out.scores.micro, criterion);
  }
};

// Scores all combinations that the options name under all their distances, and searches weights if they ask
// for that. Fills in the base, without what is compared, and the task: rows and classes. Throws UsageError
// and RunError. Memory: one base at a time, see load_labelled_base.
Selection selection_of(const SelectOptions& options, const StoreReader& store, RetrievalBase& base,
                       RetrievalTask& task);

}  // namespace meander
