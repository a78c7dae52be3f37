#include "jobs/laboratory/retrieval_pictures.h"

#include <fmt/format.h>
#include <oneapi/tbb/info.h>

#include <algorithm>
#include <utility>

#include "io/file/atomic_file.h"
#include "io/plot/html_page.h"
#include "io/plot/picture_sheet.h"
#include "io/plot/png_writer.h"
#include "io/plot/svg_matrix.h"
#include "io/plot/svg_plot.h"
#include "jobs/inputs.h"
#include "jobs/laboratory/model_pictures.h"

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

constexpr Rgb right_frame{0, 140, 90}, wrong_frame{213, 94, 0}, query_frame{40, 40, 40},
    unknown_frame{190, 190, 190};

Rgb frame_of(const PicturedHit& hit, bool is_query) {
  if (is_query) return query_frame;
  if (!hit.right_class) return unknown_frame;
  return *hit.right_class ? right_frame : wrong_frame;
}

}  // namespace

void draw_hit_rows(const std::filesystem::path& file, const StoreReader& store,
                   std::span<const std::vector<PicturedHit>> rows, const HitPictureLook& hit_look) {
  ModelLook look;
  look.size = hit_look.size;
  look.samples = false;
  look.surfaces = hit_look.surfaces;
  look_along(hit_look.up, look);
  SheetLook sheet;
  sheet.cell = hit_look.size;
  sheet.text_size = 13;
  for (const std::vector<PicturedHit>& row : rows)
    sheet.columns = std::max(sheet.columns, static_cast<std::uint32_t>(row.size()));
  std::vector<PicturedModel> models;
  for (const std::vector<PicturedHit>& row : rows)
    for (const PicturedHit& hit : row)
      if (hit.failure.empty()) models.push_back({hit.row.value_or(0), hit.file, {}, hit.row.has_value()});
  const std::uint64_t whole = sheet_bytes(sheet, rows.size() * sheet.columns),
                      least = whole + picture_bytes(store, {}, look);
  if (hit_look.memory < least)
    throw UsageError(fmt::format("--memory: a picture of {} rows of {} models needs {}M", rows.size(),
                                 sheet.columns, (least >> 20) + 1));
  std::vector<SheetCell> drawn =
      model_cells(store, std::move(models), {}, look, hit_look.memory - whole,
                  static_cast<std::size_t>(oneapi::tbb::info::default_concurrency()));
  std::vector<SheetCell> cells;
  auto next = drawn.begin();
  for (const std::vector<PicturedHit>& row : rows) {
    for (const PicturedHit& hit : row) {
      SheetCell& cell = cells.emplace_back();
      if (hit.failure.empty())
        cell = std::move(*next++);
      else
        cell.failure = hit.failure;
      cell.frame = frame_of(hit, &hit == row.data());
      cell.title = hit.title;
      cell.note = hit.note + (cell.note.starts_with("points only") ? "; " + cell.note : "");
      cell.note_colour = {90, 90, 90};
    }
    for (std::size_t i = row.size(); i < sheet.columns; ++i) cells.emplace_back();
  }
  SheetLegend legend{"", {}, "", "", {{query_frame, "query"}}};
  const auto any = [&](std::optional<bool> right) {
    return std::any_of(rows.begin(), rows.end(), [&](const std::vector<PicturedHit>& row) {
      return std::any_of(row.begin() + 1, row.end(),
                         [&](const PicturedHit& hit) { return hit.right_class == right; });
    });
  };
  if (any(true)) legend.keys.push_back({right_frame, "found, of its class"});
  if (any(false)) legend.keys.push_back({wrong_frame, "found, of another class"});
  if (any({})) legend.keys.push_back({unknown_frame, "found, no class known"});
  write_png(file, picture_sheet(cells, legend, sheet));
}

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

namespace {

NamedMatrix confusion_matrix(const RetrievalBase& base, const RetrievalTask& task,
                             const RetrievalSummary& summary) {
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
  return matrix;
}

}  // namespace

void draw_confusion_matrix(const std::filesystem::path& file, const RetrievalBase& base,
                           const RetrievalTask& task, const RetrievalSummary& summary) {
  const NamedMatrix matrix = confusion_matrix(base, task, summary);
  if (file.string().ends_with(".svg")) {
    replace_file(file, svg_matrix(matrix));
    return;
  }
  write_png(file, matrix_image(matrix));
}

void write_evaluation_page(const std::filesystem::path& file, const EvaluationPage& page,
                           const RetrievalBase& base, const RetrievalTask& task,
                           const RetrievalSummary& summary) {
  FigurePage html{.title = page.title};
  for (const std::string& note : page.notes) html.introduction.push_back({"", note});
  html.introduction.push_back({"Rules", page.rules});
  html.figures.push_back({.heading = "Scores", .tables = {{"means over queries", page.settings, true}}});

  Plot plot{.x = {.label = "recall", .lower = 0, .upper = 1},
            .y = {.label = "precision", .lower = 0, .upper = 1},
            .legend = LegendPlace::right,
            .width = 860};
  for (const auto& [name, scores] : page.curves) plot.series.push_back(precision_series(name, scores));
  html.figures.push_back({.heading = "Precision over recall",
                          .images = {{.text = "Precision over recall of every setting, means over queries",
                                      .svg = svg_plot(plot)}}});
  PageFigure confusion{.heading = "Confusion of classes"};
  if (summary.confusion.empty())
    confusion.paragraphs = {{"", fmt::format("Not drawn: there are {} classes.", base.classes.size())}};
  else
    confusion.images = {{.text = "Shares of the classes of the nearest models, by class of the query",
                         .svg = svg_matrix(confusion_matrix(base, task, summary))}};
  html.figures.push_back(std::move(confusion));
  html.figures.push_back(
      {.heading = "Classes", .tables = {{"means over the queries of a class", page.classes, true}}});
  html.figures.push_back(
      {.heading = "Worst confusions",
       .paragraphs =
           {{"",
             "Queries whose nearest model is of another class, the most decided first: by the distance "
             "to it over the distance to the nearest model of their own class."}},
       .tables = {{"", page.confusions, true}}});
  replace_file(file, html_page(html));
}

}  // namespace meander
