// Scores of retrieval by distances between models: those of the Princeton Shape Benchmark (Shilane, Min,
// Kazhdan and Funkhouser 2004) and the mean average precision.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace meander {

// Precision is reported at these levels of recall: 1/20, 2/20, ..., 1.
inline constexpr std::size_t recall_levels = 20;
constexpr double recall_level(std::size_t i) { return static_cast<double>(i + 1) / recall_levels; }

// Scores of a ranked list of N rows with the query, which is not in its own list; C: the size of its class.
struct RetrievalScores {
  double nearest_neighbor = 0;  // share of queries whose first row is of their class
  double first_tier = 0;        // hits in the first C-1 rows / (C-1)
  double second_tier = 0;       // hits in the first min(2 (C-1), N-1) / (C-1)
  // 2 / (1/P + 1/R) over the first K = min(32, N-1) rows, that is 2 hits / (K + C - 1).
  double e_measure = 0;
  // G_1 + sum_{i >= 2} G_i / log2(i), G_i = 1 for a hit at rank i, over the same with C-1 hits in front
  // (Jarvelin and Kekalainen 2002, in the form of the PSB).
  double dcg = 0;
  double average_precision = 0;  // mean over the C-1 hits of the precision at their rank; its mean is mAP
  // Interpolated: the largest precision at any hit with at least that recall.
  std::array<double, recall_levels> precision{};

  // Change every score on its own, for sums and means.
  RetrievalScores& operator+=(const RetrievalScores& other);
  RetrievalScores& operator*=(std::size_t count);
  RetrievalScores& operator/=(std::size_t count);  // 0 divides by 1
};

// The rules of one evaluation, the same for all queries.
//
// Ties. Rows at equal distance have no order: every score is its expected value over random orders of them
// (McSherry and Najork 2008). For the precision over recall, the expected precision at each hit is taken
// first and then interpolated. A class of one model cannot be scored; its model stays in the lists of the
// others.
//
// psb_compat: the rules of the historical psbTable. Ties go to the lower row; classes of one or two models
// and those named in `left_out` (the class "miscellaneous") are in no average, not even the micro one, but
// stay in the lists. (psbTable also shifts its class numbers by the models of a miscellaneous class that is
// not the last: a slip that is not repeated.)
struct RetrievalTask {
  std::vector<std::uint32_t> label;                 // class of every row
  std::vector<std::vector<std::uint32_t>> members;  // rows of every class, ascending
  std::vector<std::uint8_t> scored;                 // 1 for classes that are scored
  bool psb_compat = false;
  std::vector<double> discount;  // at rank i + 1

  std::size_t rows() const { return label.size(); }
  bool scores(std::size_t row) const { return scored[label[row]] != 0; }
};

// labels: the class of every row, in [0, classes). left_out: the classes that psb_compat leaves out;
// otherwise unused. Throws std::invalid_argument for a label out of range.
RetrievalTask make_retrieval_task(std::span<const std::uint32_t> labels, std::size_t classes,
                                  bool psb_compat = false, std::span<const std::uint32_t> left_out = {});

struct QueryScores {
  RetrievalScores scores;
  // The classes of the nearest row with their shares: more than one only when several rows are equally near.
  std::vector<std::pair<std::uint32_t, double>> nearest_classes;
};

// The scores of one query (a row whose class is scored) from its distances to all rows (finite, not negative;
// its own does not count). O(N log C), and O(n sqrt(r)) for r hits among n rows at one distance.
QueryScores score_query(const RetrievalTask& task, std::size_t query, std::span<const float> distances);

struct RetrievalSummary {
  std::size_t queries = 0, classes = 0;   // those that were scored
  RetrievalScores micro;                  // mean over queries
  RetrievalScores macro;                  // mean over classes of their means
  std::vector<RetrievalScores> by_class;  // zero where the class is not scored
  // classes x classes, row by row: the share of the queries of class a whose nearest row is of class b; rows
  // of classes that are not scored are zero. Empty unless asked for.
  std::vector<double> confusion;
};

// Summarizes scores. queries: one entry per row of the task; those of rows that are not scored are not read.
// Sums run in the order of the rows. Everything is zero where nothing is scored. with_confusion takes memory
// for every pair of classes.
RetrievalSummary summarize(const RetrievalTask& task, std::span<const QueryScores> queries,
                           bool with_confusion = true);

}  // namespace meander
