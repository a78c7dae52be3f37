// What the laboratory (measures, comparators, figures, pictures) adds to the program. The product knows it by
// this interface alone and works without it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/store/store_reader.h"
#include "io/table/table.h"
#include "jobs/cli/jobs.h"
#include "jobs/rows/retrieve_base.h"
#include "kernels/model/sample_parameters.h"
#include "pipeline/sampling_graph.h"

namespace meander {

// A model of `retrieve query --picture`: a row of the store, whose mesh may be at hand, or a mesh alone.
struct PicturedHit {
  std::optional<std::uint64_t> row{};
  std::optional<PlanItem> file{};
  std::string title{}, note{};
  std::string failure{};              // of a query without an answer: the reason
  std::optional<bool> right_class{};  // of a model that was found, where both classes are known
};
struct HitPictureLook {
  std::uint32_t size = 240;  // pixels of a model's picture
  std::string up = "y";      // the axis that points up
  bool surfaces = false;     // meshes were asked for
  std::uint64_t memory = std::uint64_t{4} << 30;
};

// `retrieve evaluate --html`, beside the setting that is evaluated.
struct EvaluationPage {
  std::string title, rules;
  std::vector<std::string> notes;                               // sentences below the title
  Table settings;                                               // scores of all that were compared
  std::vector<std::pair<std::string, RetrievalScores>> curves;  // of these, for precision over recall
  Table classes, confusions;                                    // of the setting
};

class Laboratory {
 public:
  virtual ~Laboratory() = default;

  // Subcommands, as in jobs.h.
  virtual JobFunction add_measure_job(Command& program) const = 0;
  virtual JobFunction add_figures_job(Command& program) const = 0;
  virtual JobFunction add_render_job(Command& program) const = 0;

  // `run --certify`: why these parameters rule it out (one sentence each), its columns, and its stage, which
  // goes behind all others.
  virtual std::vector<std::string> certificate_problems(const SampleParameters& parameters) const = 0;
  virtual std::vector<DescriptorSchema> certificate_columns() const = 0;
  virtual void add_certificate_stage(GraphStages& stages) const = 0;

  // Pictures. A file that is there is replaced; callers have checked that it may be.
  // PNG: a row for each query, which comes first. Throws UsageError where the pictures need more memory.
  virtual void draw_hits(const std::filesystem::path& file, const StoreReader& store,
                         std::span<const std::vector<PicturedHit>> rows,
                         const HitPictureLook& look) const = 0;
  // SVG: precision over recall, means and (per_class) every scored class.
  virtual void draw_precision(const std::filesystem::path& file, const std::string& title,
                              const RetrievalBase& base, const RetrievalTask& task,
                              const RetrievalSummary& summary, bool per_class) const = 0;
  // HTML, one file that needs no other.
  virtual void write_page(const std::filesystem::path& file, const EvaluationPage& page,
                          const RetrievalBase& base, const RetrievalTask& task,
                          const RetrievalSummary& summary) const = 0;
  // SVG or PNG by the extension: classes of the nearest models (summary.confusion) by scored class.
  virtual void draw_confusion(const std::filesystem::path& file, const RetrievalBase& base,
                              const RetrievalTask& task, const RetrievalSummary& summary) const = 0;
};

// The laboratory of this program, null when it was built without. Defined in the library that is linked:
// jobs/laboratory or without_laboratory.cpp.
const Laboratory* program_laboratory();

// Throws UsageError when there is no laboratory. `wish`: the command or option that needs one.
const Laboratory& require_laboratory(const Laboratory* laboratory, std::string_view wish);

}  // namespace meander
