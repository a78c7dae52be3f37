#include "jobs/laboratory/retrieval_pictures.h"

#include "io/file/atomic_file.h"
#include "io/plot/png_writer.h"
#include "io/plot/svg_matrix.h"
#include "io/plot/svg_plot.h"

namespace meander {

namespace {

PlotSeries precision_series(const std::string& name, const RetrievalScores& scores) {
  PlotSeries series{.name = name};
  for (std::size_t i = 0; i < recall_levels; ++i) {
    series.x.push_back(recall_level(i));
    series.y.push_back(scores.precision[i]);
  }
  return series;
}

}  // namespace

void draw_precision_over_recall(const std::filesystem::path& file, const std::string& title,
                                const RetrievalBase& base, const RetrievalTask& task,
                                const RetrievalSummary& summary, bool per_class) {
  Plot plot{.title = title,
            .x = {.label = "recall", .lower = 0, .upper = 1},
            .y = {.label = "precision", .lower = 0, .upper = 1}};
  plot.series.push_back(precision_series("mean over queries", summary.micro));
  plot.series.push_back(precision_series("mean over classes", summary.macro));
  if (per_class)
    for (std::size_t c = 0; c < base.classes.size(); ++c) {
      if (!task.scored[c]) continue;
      plot.series.push_back(precision_series(base.classes[c], summary.by_class[c]));
      plot.series.back().style = SeriesStyle::line;
      plot.series.back().line_width = 1;
    }
  replace_file(file, svg_plot(plot));
}

void draw_confusion_matrix(const std::filesystem::path& file, const RetrievalBase& base,
                           const RetrievalTask& task, const RetrievalSummary& summary) {
  // Scored classes down, all that have models across.
  NamedMatrix matrix{.title = "Class of the nearest model, %",
                     .row_label = "class of the query",
                     .column_label = "class of the nearest"};
  const std::size_t classes = base.classes.size();
  std::vector<std::size_t> across;
  for (std::size_t c = 0; c < classes; ++c)
    if (!task.members[c].empty()) {
      across.push_back(c);
      matrix.columns.push_back(base.classes[c]);
    }
  for (std::size_t c = 0; c < classes; ++c) {
    if (!task.scored[c]) continue;
    matrix.rows.push_back(base.classes[c]);
    for (const std::size_t other : across) matrix.values.push_back(summary.confusion[c * classes + other]);
  }
  if (file.string().ends_with(".svg")) {
    replace_file(file, svg_matrix(matrix));
    return;
  }
  write_png(file, matrix_image(matrix));
}

}  // namespace meander
