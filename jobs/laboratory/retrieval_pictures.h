// The pictures of `meander retrieve evaluate`.
#pragma once

#include <filesystem>
#include <string>

#include "jobs/retrieve_base.h"

namespace meander {

// SVG: precision over recall, means over queries and classes, and (per_class) every scored class.
void draw_precision_over_recall(const std::filesystem::path& file, const std::string& title,
                                const RetrievalBase& base, const RetrievalTask& task,
                                const RetrievalSummary& summary, bool per_class);

// SVG or PNG by the extension: classes of the nearest models (summary.confusion) by class of the query.
void draw_confusion_matrix(const std::filesystem::path& file, const RetrievalBase& base,
                           const RetrievalTask& task, const RetrievalSummary& summary);

}  // namespace meander
