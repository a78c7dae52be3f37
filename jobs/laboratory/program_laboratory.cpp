// The interface of the laboratory to the program.
#include "jobs/laboratory/commands.h"
#include "jobs/laboratory/retrieval_pictures.h"
#include "jobs/rows/laboratory.h"
#include "kernels/analyse/certify_samples.h"

namespace meander {

namespace {

class WholeLaboratory final : public Laboratory {
 public:
  JobFunction add_measure_job(Command& program) const override { return meander::add_measure_job(program); }
  JobFunction add_figures_job(Command& program) const override { return meander::add_figures_job(program); }
  JobFunction add_render_job(Command& program) const override { return meander::add_render_job(program); }

  std::vector<std::string> certificate_problems(const SampleParameters& parameters) const override {
    return meander::certificate_problems(parameters);
  }

  std::vector<DescriptorSchema> certificate_columns() const override {
    return {
        {certificate_box_error,
         1,
         {{"meaning",
           "root mean square error over 1000 random rotated boxes with exact areas, relative to random "
           "points; smaller is better"}},
         "certificate"},
        {certificate_box_limit,
         1,
         {{"meaning",
           "the smallest such error that is known to be possible for so many samples of this surface"}},
         "certificate"},
        {certificate_over_limit, 1, {{"meaning", "box_rms_ratio over box_limit; 1 at best"}}, "certificate"},
        {certificate_rho,
         1,
         {{"meaning",
           "smallest distance between samples over that of a hexagonal lattice of the same density"}},
         "certificate"}};
  }

  void add_certificate_stage(GraphStages& stages) const override {
    stages.push_back({"certify_samples", [](GraphItem& item) {
                        release_charts(item.model);
                        certify_samples(item.model.row, item.model.surface, item.model.cancel);
                      }});
  }

  void draw_hits(const std::filesystem::path& file, const StoreReader& store,
                 std::span<const std::vector<PicturedHit>> rows, const HitPictureLook& look) const override {
    draw_hit_rows(file, store, rows, look);
  }

  void draw_precision(const std::filesystem::path& file, const std::string& title, const RetrievalBase& base,
                      const RetrievalTask& task, const RetrievalSummary& summary,
                      bool per_class) const override {
    draw_precision_over_recall(file, title, base, task, summary, per_class);
  }

  void write_page(const std::filesystem::path& file, const EvaluationPage& page, const RetrievalBase& base,
                  const RetrievalTask& task, const RetrievalSummary& summary) const override {
    write_evaluation_page(file, page, base, task, summary);
  }

  void draw_confusion(const std::filesystem::path& file, const RetrievalBase& base, const RetrievalTask& task,
                      const RetrievalSummary& summary) const override {
    draw_confusion_matrix(file, base, task, summary);
  }
};

}  // namespace

const Laboratory* program_laboratory() {
  static const WholeLaboratory laboratory;
  return &laboratory;
}

}  // namespace meander
