// The stages of `meander describe`, which adds descriptors to rows of a finished store.
#pragma once

#include <functional>
#include <string_view>

#include "io/store/run_directory.h"
#include "io/store/store_reader.h"
#include "kernels/core/failure.h"
#include "pipeline/sampling_graph.h"

namespace meander {

// The parameters of all rows, shared by all threads.
struct Describer {
  const StoreHeader* header = nullptr;
  SampleParameters points, meshes;  // with the descriptors that need only samples, and with the others
  std::uint64_t memory_bytes = 0;   // for models
  double timeout_seconds = 0;       // for the descriptors of one row; 0: none
  bool allow_oversize = false;

  bool uses_meshes() const { return !meshes.describe.descriptors.empty(); }
  // The parameters with all descriptors.
  SampleParameters all() const;
  // Whether this job makes a column of that name.
  bool makes(std::string_view name) const;
};

// The header must outlive the describer. Throws UsageError when the parameters are not valid.
Describer make_describer(const StoreHeader& header, const DescribeParameters& describe);

// Called from many threads with a row that lacks descriptors, which are NaN, and the reason. The status is ok
// if nothing failed but the surface has no such descriptor.
using DescribeFailed = std::function<void(const GraphItem&, Failure)>;

// The stages from a row of `store` and its mesh to the row with all descriptors of the header. A stage that
// throws ends the item, which is then tried again without its mesh.
GraphStages stages_with_meshes(const Describer& describer, const StoreReader& store, DescribeFailed failed);

// The same with the descriptors of the samples alone; no failure keeps the row from getting through.
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
