// The flow graph: from a plan of files to rows in a sink.
//
//   admit_items -> read_mesh -> the stages of the method (stages_of) -> encode_row -> write_row (serial)
//   -> admit_items ...
//
// admit_items (serial) owns the queue, the bytes in flight and one work slot per thread. An item is admitted
// only when a slot is free, so what was admitted is worked on at once and no item waits behind later ones;
// encode_row gives the slot back, write_row the bytes. admit_items is woken by its own first message and by
// those two, never blocks and never polls. A node body lets no exception out: a failed item keeps its status
// and sentence, skips the remaining stages and still reaches the writer. In the end in == written + dropped
// and nothing is in flight; anything else is reported as an internal error.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/archive/model_bytes.h"
#include "io/mesh/mesh_reader.h"
#include "io/store/store.h"
#include "kernels/model/model.h"
#include "pipeline/statistics.h"

namespace meander {

// One input of the plan.
struct PlanItem : ModelPlace {
  std::uint64_t row = 0;
  std::string id;
  bool known_format = true;  // false: the row says unsupported_format
  std::int32_t label = -1;   // this and the next one: as inputs are collected; the header has them afterwards
  Split split = Split::none;
  std::uint64_t reserved_bytes = 0;  // from estimate_bytes of a header peek
  // Where the tensors of the kind `table` are: a text file, or an HDF5 file with the dataset's path in it.
  std::filesystem::path tensor_path;
  std::string tensor_dataset;
};

// The file on disk that the bytes of an item are in.
inline const std::filesystem::path& file_of(const PlanItem& item) {
  return item.packed ? item.packed.archive->path() : item.path;
}

struct GraphParameters {
  SampleParameters sample;
  int threads = 1;                                      // >= 1
  std::uint64_t memory_bytes = std::uint64_t{4} << 30;  // budget of everything in flight
  bool allow_oversize = false;                          // run an item alone that is larger than the budget
  double timeout_seconds = 0;                           // of work on one model, waiting excluded; 0: none
  std::uint64_t max_failures = ~std::uint64_t{0};  // stop taking items once more than this many have failed
  std::uint64_t earlier_failures = 0;              // of earlier starts of the same run; they count, too
};

// One model inside the graph.
struct GraphItem {
  const PlanItem* plan = nullptr;
  Model model;
  EncodedRow encoded;
  bool dropped = false;              // the run is being stopped: no record
  bool reused = false;               // the row came from an older store,
  SampleBlocks reused_blocks;        // and, where it has many, its samples
  std::uint64_t reserved_bytes = 0;  // what the admission holds for it
  std::uint64_t file_bytes = 0;
  std::string_view failed_in;  // the node that the item failed in
  std::chrono::steady_clock::time_point start;
  std::chrono::steady_clock::duration worked{};  // in the stages so far
};

// What happened to an item; reported once, by the serial writer.
struct FinishedItem {
  const PlanItem& plan;
  const ItemReport& report;
  std::string_view failed_in;
  std::uint64_t file_bytes = 0;
  double seconds = 0;         // from its admission to its row
  double waited_seconds = 0;  // of those, outside the stages
  bool reused = false;
};

// Where rows go. write is called from the serial writer, begin from the serial admission (possibly at the
// same time).
class RowSink {
 public:
  virtual ~RowSink() = default;
  virtual void begin(std::uint64_t row) = 0;
  virtual void write(EncodedRow row) = 0;
};

// Where rows are not wanted: what is made of an item, its own stages keep.
class NoRows final : public RowSink {
 public:
  void begin(std::uint64_t) override {}
  void write(EncodedRow) override {}
};

// The bodies of the nodes, by name; tests inject failures into them. Each works on one item and may throw
// ItemError, RunCancelled or anything else.
struct GraphStage {
  std::string_view name;
  std::function<void(GraphItem&)> body;
};
using GraphStages = std::vector<GraphStage>;

// A row of an older store for content with this digest; called from many threads.
using ReuseLookup =
    std::function<std::optional<CopiedRow>(const std::array<std::uint8_t, 32>& content, MeshFormat format)>;

// read_mesh and the stages of the method. The parameters and the device (null unless they cast
// rays) must outlive the graph.
GraphStages sampling_stages(const SampleParameters& parameters, const EmbreeDevice* device,
                            ReuseLookup reuse = {});

// Thrown by a read stage whose file is larger than was reserved for it: the item goes back to the queue.
class NeedsMoreMemory : public std::runtime_error {
 public:
  explicit NeedsMoreMemory(std::uint64_t bytes)
      : std::runtime_error("more memory is needed"), bytes_(bytes) {}
  std::uint64_t bytes() const { return bytes_; }

 private:
  std::uint64_t bytes_;
};

struct GraphResult {
  std::uint64_t taken = 0, written = 0, dropped = 0, failed = 0, requeued = 0;
  std::uint64_t peak_reserved_bytes = 0;
  double longest_wait_seconds = 0;  // of one item, between its admission and its row
  bool stopped = false;             // not every item of the plan was written
  bool too_many_failures = false;   // stopped for GraphParameters::max_failures
};

// Runs the plan to its end, or until `cancelled` is set (by the caller at any time; by the graph itself when
// the sink fails or too many items failed). Rethrows the sink's exception after everything in flight has
// ended. Throws std::logic_error when its counts do not add up. `statistics` gets one entry per node.
// observer may be empty.
GraphResult run_sampling_graph(const std::vector<PlanItem>& plan, const GraphParameters& parameters,
                               const GraphStages& stages, const StoreHeader& header, RowSink& sink,
                               std::atomic<bool>& cancelled, std::vector<NodeStatistics>& statistics,
                               const std::function<void(const FinishedItem&)>& observer = {});

// The same stages on one item in the calling thread, outside any graph (for the retry of an item that was in
// flight when an earlier process died). `entered` is called with the name of each stage before it starts.
void run_item_alone(const PlanItem& plan, const GraphParameters& parameters, const GraphStages& stages,
                    const std::function<void(std::string_view)>& entered);

}  // namespace meander
