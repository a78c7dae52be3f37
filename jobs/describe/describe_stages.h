// The stages of `meander describe`: rows of a finished store get descriptors.
#pragma once

#include <functional>
#include <string_view>

#include "io/store/run_directory.h"
#include "io/store/store_reader.h"
#include "kernels/core/failure.h"
#include "pipeline/sampling_graph.h"

namespace meander {

// What every row is described with; shared by all threads.
struct Describer {
  const StoreHeader* header = nullptr;
  SampleParameters points, meshes;  // the descriptors that need the samples alone, and the others
  std::uint64_t memory_bytes = 0;   // for models
  double timeout_seconds = 0;       // of the descriptors of one row; 0: none
  bool allow_oversize = false;

  bool uses_meshes() const { return !meshes.describe.descriptors.empty(); }
  // The descriptors of both.
  SampleParameters all() const;
  // Whether a column of that name comes from this job.
  bool makes(std::string_view name) const;
};

// The header must outlive the describer. Throws UsageError when the parameters are not valid.
Describer make_describer(const StoreHeader& header, const DescribeParameters& describe);

// Hears of a row that lacks descriptors, which are NaN, and why; called from many threads. The status is ok
// where nothing failed: a descriptor does not exist for every surface.
using DescribeFailed = std::function<void(const GraphItem&, Failure)>;

// From a row of `store` to the row with all descriptors of the header, mesh and all. A stage that throws ends
// the item: it is to be tried again without its mesh.
GraphStages stages_with_meshes(const Describer& describer, const StoreReader& store, DescribeFailed failed);

// The same with the descriptors of the samples alone; whatever fails, the row gets through.
GraphStages stages_with_points(const Describer& describer, const StoreReader& store, DescribeFailed failed);

// Records finished rows. Rows that failed are left for another round, unless this is the last.
class DescribedRowSink final : public RowSink {
 public:
  DescribedRowSink(RunDirectory& directory, bool last_round)
      : directory_(directory), last_round_(last_round) {}
  void begin(std::uint64_t row) override { directory_.begin_item(row); }
  void write(EncodedRow row) override;

 private:
  RunDirectory& directory_;
  bool last_round_;
};

}  // namespace meander
