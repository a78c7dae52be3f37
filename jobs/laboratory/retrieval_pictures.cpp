#include "jobs/laboratory/retrieval_pictures.h"

#include <fmt/format.h>
#include <oneapi/tbb/info.h>

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/file/atomic_file.h"
#include "io/json_writer.h"
#include "io/plot/html_page.h"
#include "io/plot/picture_sheet.h"
#include "io/plot/png_writer.h"
#include "jobs/cli/usage_error.h"
#include "jobs/laboratory/model_pictures.h"
#include "jobs/laboratory/python_program.h"

namespace meander {

namespace {

struct Curve {
  std::string name;
  const RetrievalScores* scores;
  bool thin = false;
};

void add_texts(JsonWriter& json, const char* name, const std::vector<std::string>& texts) {
  json.list(name, texts);
}

void add_numbers(JsonWriter& json, const char* name, std::span<const double> numbers) {
  json.list(name, numbers);
}

// A plot as SVG.
std::string precision_plot(const std::string& title, const std::vector<Curve>& curves) {
  std::vector<double> recall;
  for (std::size_t i = 0; i < recall_levels; ++i) recall.push_back(recall_level(i));
  JsonWriter json;
  json.begin_object();
  json.member("kind", "curves");
  json.member("title", title);
  json.member("x", "recall");
  json.member("y", "precision");
  add_numbers(json, "limits", std::array{0.0, 1.0, 0.0, 1.0});
  json.member("format", "svg");
  json.list("series", curves, [&](const Curve& curve) {
    json.member("name", curve.name);
    json.member("thin", curve.thin);
    add_numbers(json, "x", recall);
    add_numbers(json, "y", std::span(curve.scores->precision).first(recall_levels));
  });
  json.end_object();
  return draw_plot(json.text());
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
      cell.note_color = {90, 90, 90};
    }
    for (std::size_t i = row.size(); i < sheet.columns; ++i) cells.emplace_back();
  }
  SheetLegend legend{"", false, "", "", {{query_frame, "query"}}};
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
  std::vector<Curve> curves = {{"mean over queries", &summary.micro}, {"mean over classes", &summary.macro}};
  if (per_class)
    for (std::size_t c = 0; c < base.classes.size(); ++c)
      if (task.scored[c]) curves.push_back({base.classes[c], &summary.by_class[c], true});
  replace_file(file, precision_plot(title, curves));
}

namespace {

// The table of shares: scored classes are its rows, all classes with models its columns.
std::string confusion_plot(const RetrievalBase& base, const RetrievalTask& task,
                           const RetrievalSummary& summary, const char* format) {
  const std::size_t classes = base.classes.size();
  std::vector<std::size_t> across;
  std::vector<std::string> rows, columns;
  std::vector<double> values;
  for (std::size_t c = 0; c < classes; ++c)
    if (!task.members[c].empty()) {
      across.push_back(c);
      columns.push_back(base.classes[c]);
    }
  for (std::size_t c = 0; c < classes; ++c) {
    if (!task.scored[c]) continue;
    rows.push_back(base.classes[c]);
    for (const std::size_t other : across) values.push_back(summary.confusion[c * classes + other]);
  }
  JsonWriter json;
  json.begin_object();
  json.member("kind", "matrix");
  json.member("title", "Class of the nearest model, %");
  json.member("x", "class of the nearest");
  json.member("y", "class of the query");
  json.member("format", format);
  add_texts(json, "rows", rows);
  add_texts(json, "columns", columns);
  add_numbers(json, "values", values);
  json.end_object();
  return draw_plot(json.text());
}

}  // namespace

void draw_confusion_matrix(const std::filesystem::path& file, const RetrievalBase& base,
                           const RetrievalTask& task, const RetrievalSummary& summary) {
  replace_file(file, confusion_plot(base, task, summary, file.string().ends_with(".svg") ? "svg" : "png"));
}

void write_evaluation_page(const std::filesystem::path& file, const EvaluationPage& page,
                           const RetrievalBase& base, const RetrievalTask& task,
                           const RetrievalSummary& summary) {
  FigurePage html{.title = page.title};
  for (const std::string& note : page.notes) html.introduction.push_back({"", note});
  html.introduction.push_back({"Rules", page.rules});
  html.figures.push_back({.heading = "Scores", .tables = {{"means over queries", page.settings, true}}});

  std::vector<Curve> curves;
  for (const auto& [name, scores] : page.curves) curves.push_back({name, &scores});
  html.figures.push_back({.heading = "Precision over recall",
                          .images = {{.text = "Precision over recall of every setting, means over queries",
                                      .svg = precision_plot("", curves)}}});
  PageFigure confusion{.heading = "Confusion of classes"};
  if (summary.confusion.empty())
    confusion.paragraphs = {{"", fmt::format("Not drawn: there are {} classes.", base.classes.size())}};
  else
    confusion.images = {{.text = "Shares of the classes of the nearest models, by class of the query",
                         .svg = confusion_plot(base, task, summary, "svg")}};
  html.figures.push_back(std::move(confusion));
  html.figures.push_back(
      {.heading = "Classes", .tables = {{"means over the queries of a class", page.classes, true}}});
  html.figures.push_back(
      {.heading = "Worst confusions",
       .paragraphs = {{"",
                       "Queries whose nearest model is of another class, the most decided first: by the "
                       "distance to it over the distance to the nearest model of their own class."}},
       .tables = {{"", page.confusions, true}}});
  replace_file(file, html_page(html));
}

}  // namespace meander
