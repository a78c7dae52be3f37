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
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/archive/model_bytes.h"
#include "io/mesh/mesh_reader.h"
#include "io/store/row_codec.h"
#include "kernels/model/model.h"

namespace meander {

// One input of the plan.
struct PlanItem : ModelPlace {
  std::uint64_t row = 0;
  std::string id;
  bool known_format = true;  // false: the row says unsupported_format
  std::int32_t label = -1;   // this and the next one: as inputs are collected; the header has them afterwards
  Split split = Split::none;
  std::uint64_t reserved_bytes = 0;  // estimate_bytes of a header peek
  double work = 0;                   // estimated_seconds of it
  // The tensors of the kind `table`: a text file, or an HDF5 file and the path of the dataset in it.
  std::filesystem::path tensor_path;
  std::string tensor_dataset;
};

// The file on disk that holds the bytes of an item: its own, or its archive.
inline const std::filesystem::path& file_of(const PlanItem& item) {
  return item.packed ? item.packed.archive->path() : item.path;
}

struct GraphParameters {
  SampleParameters sample;
  int threads = 1;                                      // >= 1
  std::uint64_t memory_bytes = std::uint64_t{4} << 30;  // budget of all items in flight
  bool allow_oversize = false;                          // an item larger than the budget runs alone
  double timeout_seconds = 0;                           // of work on one model, without waiting; 0: none
  std::uint64_t max_failures = ~std::uint64_t{0};       // with more failed items the run stops
  std::uint64_t earlier_failures = 0;                   // counted with them: of earlier starts of the run
};

// One model inside the graph.
struct GraphItem {
  const PlanItem* plan = nullptr;
  Model model;
  EncodedRow encoded;
  bool dropped = false;              // the run is being stopped: no row is written
  bool reused = false;               // the row is copied from an older store
  SampleBlocks reused_blocks;        // the samples of a reused row with many; else empty
  std::uint64_t reserved_bytes = 0;  // held by the admission
  std::uint64_t file_bytes = 0;
  std::string_view failed_in;  // the node in which the item failed; empty: it did not
  std::chrono::steady_clock::time_point start;
  std::chrono::steady_clock::duration worked{};  // in the stages so far
};

// The outcome of an item, reported once by the serial writer.
struct FinishedItem {
  const PlanItem& plan;
  const ItemReport& report;
  std::string_view failed_in;
  std::uint64_t file_bytes = 0;
  double seconds = 0;         // from its admission to its row
  double waited_seconds = 0;  // the part of these outside the stages
  bool reused = false;
  double in_flight_seconds = 0;  // since their admission, of all items that are in flight now
};

// Counters of one node of the graph, updated by many threads at once.
struct NodeStatistics {
  std::string_view name;
  std::atomic<std::uint64_t> items{0};
  std::atomic<std::uint64_t> busy_nanoseconds{0};
  std::atomic<std::uint64_t> bytes{0};  // of the results of encode_row; 0 for other nodes
};

// The destination of rows. The serial writer calls write; the serial admission calls begin, possibly at the
// same time.
class RowSink {
 public:
  virtual ~RowSink() = default;
  virtual void begin(std::uint64_t row) = 0;
  virtual void write(EncodedRow row) = 0;
};

// Discards all rows, for stages that keep their results themselves.
class NoRows final : public RowSink {
 public:
  void begin(std::uint64_t) override {}
  void write(EncodedRow) override {}
};

// The body of a node, by name; tests inject failures into it. It works on one item and may throw ItemError,
// RunCanceled or anything else.
struct GraphStage {
  std::string_view name;
  std::function<void(GraphItem&)> body;
};
using GraphStages = std::vector<GraphStage>;

// Finds the row of an older store for content with this digest and format; called from many threads.
using ReuseLookup =
    std::function<std::optional<CopiedRow>(const std::array<std::uint8_t, 32>& content, MeshFormat format)>;

// read_mesh and the stages of the method. The parameters and the device (null unless the method casts rays)
// must outlive the graph.
GraphStages sampling_stages(const SampleParameters& parameters, const EmbreeDevice* device,
                            ReuseLookup reuse = {});

// Thrown by a stage that needs more memory than is reserved: the item goes back to the queue.
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
  double longest_wait_seconds = 0;  // of an item between its admission and its row
  bool stopped = false;             // not every item of the plan was written
  bool too_many_failures = false;   // stopped for GraphParameters::max_failures
};

// Runs the plan to its end, or until `canceled` is set: by the caller at any time, or by the graph itself
// when the sink fails or too many items have failed. Rethrows an exception of the sink after all items in
// flight have ended. Throws std::logic_error when its counts do not add up. `statistics` gets one entry per
// node; `observer` may be empty.
GraphResult run_sampling_graph(const std::vector<PlanItem>& plan, const GraphParameters& parameters,
                               const GraphStages& stages, const StoreHeader& header, RowSink& sink,
                               std::atomic<bool>& canceled, std::vector<NodeStatistics>& statistics,
                               const std::function<void(const FinishedItem&)>& observer = {});

// Runs the same stages on one item in the calling thread, to retry an item that was in flight when an earlier
// process died. `entered` is called with the name of each stage before it starts.
void run_item_alone(const PlanItem& plan, const GraphParameters& parameters, const GraphStages& stages,
                    const std::function<void(std::string_view)>& entered);

}  // namespace meander
