// The pictures of `meander retrieve`.
#pragma once

#include <filesystem>
#include <string>

#include "jobs/rows/laboratory.h"
#include "jobs/rows/retrieve_base.h"

namespace meander {

// Draws a PNG with a row for each query: the query and the models that it found; see Laboratory::draw_hits.
void draw_hit_rows(const std::filesystem::path& file, const StoreReader& store,
                   std::span<const std::vector<PicturedHit>> rows, const HitPictureLook& look);

// Draws an SVG of precision over recall: means over queries and classes and, with per_class, every scored
// class.
void draw_precision_over_recall(const std::filesystem::path& file, const std::string& title,
                                const RetrievalBase& base, const RetrievalTask& task,
                                const RetrievalSummary& summary, bool per_class);

// Writes an HTML page: settings, precision over recall, confusion and scores of classes, mistakes.
void write_evaluation_page(const std::filesystem::path& file, const EvaluationPage& page,
                           const RetrievalBase& base, const RetrievalTask& task,
                           const RetrievalSummary& summary);

// Draws an SVG or a PNG, by the extension: classes of the nearest models (summary.confusion) by class of the
// query.
void draw_confusion_matrix(const std::filesystem::path& file, const RetrievalBase& base,
                           const RetrievalTask& task, const RetrievalSummary& summary);

}  // namespace meander
