#include "pipeline/sampling_graph.h"

#include <oneapi/tbb/flow_graph.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <exception>
#include <memory>
#include <mutex>
#include <queue>
#include <stdexcept>
#include <tuple>

#include "io/mesh/tensor_table.h"
#include "io/run_error.h"
#include "io/store/tensor_dataset.h"
#include "kernels/core/failure.h"
#include "kernels/core/parallel.h"
#include "kernels/core/tsan_annotations.h"
#include "kernels/sample/column_makers.h"
#include "pipeline/admission.h"
#include "pipeline/memory_estimate.h"

namespace meander {

namespace {

namespace flow = oneapi::tbb::flow;

void fail(GraphItem& item, std::string_view stage, Status status, std::string reason) {
  ItemReport& report = item.model.row.report;
  report.status = status;
  report.reason = std::move(reason);
  item.model.row.samples = {};
  item.model.sites = {};
  item.model.row.descriptors.clear();
  item.failed_in = stage;
}

bool is_open(const GraphItem& item) { return item.failed_in.empty() && !item.dropped && !item.reused; }

using Clock = std::chrono::steady_clock;

// Adds one item, and the time for which the object lives, to the counters of a node.
class NodeTimer {
 public:
  explicit NodeTimer(NodeStatistics& node) : node_(node), start_(Clock::now()) {}
  ~NodeTimer() {
    const std::chrono::nanoseconds busy = Clock::now() - start_;
    node_.items.fetch_add(1, std::memory_order_relaxed);
    node_.busy_nanoseconds.fetch_add(static_cast<std::uint64_t>(busy.count()), std::memory_order_relaxed);
  }
  NodeTimer(const NodeTimer&) = delete;
  NodeTimer& operator=(const NodeTimer&) = delete;

 private:
  NodeStatistics& node_;
  Clock::time_point start_;
};

// The clock of one item: it runs while a stage works on the item and stops while the item waits.
class WorkClock {
 public:
  WorkClock(GraphItem& item, double limit_seconds) : item_(item), start_(Clock::now()) {
    if (limit_seconds > 0)
      item.model.cancel.deadline =
          start_ + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(limit_seconds)) -
          item.worked;
  }
  ~WorkClock() { item_.worked += Clock::now() - start_; }
  WorkClock(const WorkClock&) = delete;
  WorkClock& operator=(const WorkClock&) = delete;

 private:
  GraphItem& item_;
  Clock::time_point start_;
};

// Runs one stage on one item; only NeedsMoreMemory is rethrown.
void run_stage(const GraphStage& stage, GraphItem& item, double timeout_seconds) {
  if (!is_open(item)) return;
  const WorkClock clock(item, timeout_seconds);
  try {
    item.model.cancel.check();
    stage.body(item);
  } catch (const NeedsMoreMemory&) {
    throw;
  } catch (const RunCanceled&) {
    item.dropped = true;
  } catch (...) {
    Failure failure = current_failure(stage.name);
    fail(item, stage.name, failure.status, std::move(failure.reason));
  }
}

// Frees everything but the row, once the points are known.
void release_model(Model& model) {
  Row row = std::move(model.row);
  model = Model{};
  model.row = std::move(row);
}

// A message through the graph: the item, which the graph owns until it is written, and its admission ticket.
struct Envelope {
  GraphItem* item = nullptr;
  Admission::Ticket ticket;
  std::uint64_t needed_bytes = 0;  // > 0: the item goes back to the queue with this reservation
  bool frees_slot = false;         // no item, only the signal that a work slot is free again
};

// The items between their admission and their row, for how long they have been there.
class InFlight {
 public:
  void add(Clock::time_point start) {
    const std::lock_guard lock(mutex_);
    ++items_;
    starts_ += start - origin_;
  }
  void remove(Clock::time_point start) {
    const std::lock_guard lock(mutex_);
    --items_;
    starts_ -= start - origin_;
  }
  double seconds() const {
    const std::lock_guard lock(mutex_);
    return std::chrono::duration<double>(items_ * (Clock::now() - origin_) - starts_).count();
  }

 private:
  const Clock::time_point origin_ = Clock::now();
  mutable std::mutex mutex_;
  int items_ = 0;
  Clock::duration starts_{};
};

// The graph with its counters. Lives for one call of run_sampling_graph.
class SamplingGraph {
 public:
  SamplingGraph(const std::vector<PlanItem>& plan, const GraphParameters& parameters,
                const GraphStages& stages, const StoreHeader& header, RowSink& sink,
                std::atomic<bool>& canceled, std::vector<NodeStatistics>& statistics,
                const std::function<void(const FinishedItem&)>& observer)
      : plan_(plan),
        parameters_(parameters),
        header_(header),
        sink_(sink),
        canceled_(canceled),
        statistics_(statistics),
        observer_(observer),
        admission_(parameters.memory_bytes, items_in_flight(parameters.threads), parameters.allow_oversize),
        admit_items_(graph_, flow::serial,
                     [this](Envelope back, AdmitNode::output_ports_type& out)
                         MEANDER_CALLED_BY_TBB { admit(back, out); }),
        encode_row_(graph_, flow::unlimited,
                    [this](Envelope e, EncodeNode::output_ports_type& out)
                        MEANDER_CALLED_BY_TBB { encode(e, out); }),
        write_row_(graph_, flow::serial, [this](Envelope e) MEANDER_CALLED_BY_TBB { return write(e); }),
        items_(plan.size()) {
    statistics_ = std::vector<NodeStatistics>(stages.size() + 3);
    statistics_.front().name = "admit_items";
    flow::sender<Envelope>* last = &flow::output_port<0>(admit_items_);
    for (std::size_t i = 0; i < stages.size(); ++i) {
      statistics_[i + 1].name = stages[i].name;
      stage_nodes_.push_back(std::make_unique<StageNode>(
          graph_, flow::unlimited,
          [this, &stage = stages[i], &node = statistics_[i + 1], first = i == 0](Envelope e)
              MEANDER_CALLED_BY_TBB { return work(stage, node, first ? take_admitted() : e); }));
      flow::make_edge(*last, *stage_nodes_.back());
      last = stage_nodes_.back().get();
    }
    statistics_[stages.size() + 1].name = "encode_row";
    flow::make_edge(*last, encode_row_);
    flow::make_edge(flow::output_port<1>(admit_items_), encode_row_);
    flow::make_edge(flow::output_port<0>(encode_row_), write_row_);
    flow::make_edge(flow::output_port<1>(encode_row_), admit_items_);
    statistics_.back().name = "write_row";
    flow::make_edge(write_row_, admit_items_);
  }

  GraphResult run() {
    tsan_release(&admit_items_);
    admit_items_.try_put(Envelope{});
    graph_.wait_for_all();
    tsan_acquire(&admit_items_);
    tsan_acquire(&write_row_);
    tsan_acquire_all(this, sizeof *this);
    if (sink_error_) std::rethrow_exception(sink_error_);
    result_.peak_reserved_bytes = admission_.peak_bytes();
    result_.stopped = result_.written != plan_.size();
    if (result_.taken != result_.written + result_.dropped || admission_.items_in_flight() != 0 ||
        admission_.bytes_in_flight() != 0 || working_ != 0 || (!canceled_ && result_.stopped))
      throw std::logic_error("the counts of the graph do not add up: " + std::to_string(result_.taken) +
                             " taken, " + std::to_string(result_.written) + " written, " +
                             std::to_string(result_.dropped) + " dropped, " +
                             std::to_string(admission_.items_in_flight()) + " items and " +
                             std::to_string(admission_.bytes_in_flight()) + " bytes in flight, of " +
                             std::to_string(plan_.size()));
    return result_;
  }

 private:
  // Its outputs lead to the first stage, and to encode_row for items that failed before any stage.
  using AdmitNode = flow::multifunction_node<Envelope, std::tuple<Envelope, Envelope>>;
  // Its outputs lead to write_row, and with the free slot to admit_items.
  using EncodeNode = flow::multifunction_node<Envelope, std::tuple<Envelope, Envelope>>;
  using StageNode = flow::function_node<Envelope, Envelope>;

  // One item per thread in work, and one more that may wait for the writer while it syncs a journal. After a
  // crash all of these are retried one by one.
  static std::size_t items_in_flight(int threads) { return 2 * static_cast<std::size_t>(threads); }

  void admit(const Envelope& back, AdmitNode::output_ports_type& out) {
    const TsanTurn turn(&admit_items_);
    const NodeTimer timer(statistics_.front());
    if (back.frees_slot)
      --working_;
    else if (back.ticket.bytes > 0)
      admission_.release(back.ticket);
    if (back.needed_bytes > 0) {
      ++result_.requeued;
      --result_.taken;
      enqueue(back.ticket.item, back.needed_bytes, out);
    } else if (!started_) {
      started_ = true;
      for (std::size_t i = 0; i < plan_.size(); ++i)
        enqueue(i, std::max<std::uint64_t>(1, plan_[i].reserved_bytes), out);
    }
    if (canceled_) admission_.drop_waiting();
    while (working_ < parameters_.threads) {
      const auto ticket = admission_.next();
      if (!ticket) break;
      ++working_;
      send(*ticket, out);
    }
  }

  void enqueue(std::size_t index, std::uint64_t bytes, AdmitNode::output_ports_type& out) {
    if (!admission_.too_large(bytes)) {
      admission_.add(index, bytes);
      return;
    }
    const Envelope envelope = open_item(index);
    fail(*envelope.item, "admit_items", Status::too_large,
         "needs about " + std::to_string(bytes >> 20) + " MiB, --memory leaves " +
             std::to_string(parameters_.memory_bytes >> 20) +
             " MiB for models (raise it, or --allow-oversize)");
    tsan_release(envelope.item);
    std::get<1>(out).try_put(envelope);
  }

  Envelope open_item(std::size_t index) {
    Envelope envelope;
    tsan_acquire(&items_[index]);
    items_[index] = std::make_unique<GraphItem>();
    envelope.item = items_[index].get();
    envelope.ticket.item = index;
    envelope.item->plan = &plan_[index];
    envelope.item->start = Clock::now();
    in_flight_.add(envelope.item->start);
    ++result_.taken;
    return envelope;
  }

  void send(const Admission::Ticket& ticket, AdmitNode::output_ports_type& out) {
    Envelope envelope = open_item(ticket.item);
    envelope.ticket = ticket;
    envelope.item->reserved_bytes = ticket.bytes;
    envelope.item->model.cancel.canceled = &canceled_;
    try {
      sink_.begin(plan_[ticket.item].row);
    } catch (...) {
      stop_for(std::current_exception());
      envelope.item->dropped = true;
    }
    {
      const std::lock_guard lock(admitted_mutex_);
      admitted_.push(std::move(envelope));
    }
    std::get<0>(out).try_put(Envelope{});
  }

  // The item that was admitted first, for whichever task of the first stage runs first: threads run their own
  // newest task before any other.
  Envelope take_admitted() {
    const std::lock_guard lock(admitted_mutex_);
    Envelope envelope = std::move(admitted_.front());
    admitted_.pop();
    return envelope;
  }

  Envelope work(const GraphStage& stage, NodeStatistics& node, Envelope envelope) {
    const TsanTurn turn(envelope.item);
    if (envelope.needed_bytes > 0 || !is_open(*envelope.item)) return envelope;
    const NodeTimer timer(node);
    try {
      run_stage(stage, *envelope.item, parameters_.timeout_seconds);
    } catch (const NeedsMoreMemory& more) {
      envelope.needed_bytes = std::max(more.bytes(), envelope.ticket.bytes + 1);
    }
    return envelope;
  }

  // Frees the slot whatever the outcome, so that the next item may start while this one is written.
  void encode(Envelope envelope, EncodeNode::output_ports_type& out) {
    {
      const TsanTurn turn(envelope.item);
      if (envelope.needed_bytes == 0 && !envelope.item->dropped) encode(*envelope.item);
    }
    Envelope slot;
    slot.frees_slot = true;
    // The row is sent last, since this thread processes the last message first: rows must not wait behind new
    // items.
    if (envelope.ticket.bytes > 0) std::get<1>(out).try_put(slot);
    std::get<0>(out).try_put(envelope);
  }

  void encode(GraphItem& item) {
    NodeStatistics& node = statistics_[statistics_.size() - 2];
    const NodeTimer timer(node);
    const WorkClock clock(item, 0);
    try {
      if (item.model.sites.count() > 0) {
        encode_sites(item);
        return;
      }
      release_model(item.model);
      if (item.reused_blocks) {
        item.encoded = encode_row_in_blocks(
            header_, item.plan->row, item.model.row.report,
            [this, blocks = std::move(item.reused_blocks)](std::uint64_t begin, std::uint64_t end) {
              if (canceled_) throw RunCanceled();
              return blocks(begin, end);
            },
            std::move(item.model.row.names));
        return;
      }
      item.encoded = encode_row(header_, item.plan->row, std::move(item.model.row));
    } catch (...) {
      Failure failure = current_failure("encode_row");
      fail(item, "encode_row", failure.status, std::move(failure.reason));
      item.encoded = encode_row(header_, item.plan->row, item.model.row);
    }
    item.model.row.samples = {};
    node.bytes.fetch_add(item.encoded.bytes.size(), std::memory_order_relaxed);
  }

  // The samples are made and encoded while the row is written.
  void encode_sites(GraphItem& item) {
    const Model& model = item.model;
    item.encoded = encode_row_in_blocks(
        header_, item.plan->row, model.row.report,
        [&model, place = place_parameters(parameters_.sample)](std::uint64_t begin, std::uint64_t end) {
          model.cancel.check();
          return samples_at(model, place, begin, end);
        });
  }

  // A failure while the blocks of a row are made is a failure of the item, which its row then states.
  void write(GraphItem& item) {
    if (!item.encoded.blocks) {
      sink_.write(std::move(item.encoded));
      return;
    }
    const WorkClock clock(item, parameters_.timeout_seconds);
    try {
      sink_.write(std::move(item.encoded));
      return;
    } catch (const RunError&) {
      throw;
    } catch (const RunCanceled&) {
      item.dropped = true;
      return;
    } catch (...) {
      Failure failure = current_failure("write_row");
      fail(item, "write_row", failure.status, std::move(failure.reason));
    }
    sink_.write(encode_row(header_, item.plan->row, item.model.row));
  }

  Envelope write(Envelope envelope) {
    const TsanTurn turn(&write_row_);
    tsan_acquire(envelope.item);
    const NodeTimer timer(statistics_.back());
    GraphItem& item = *envelope.item;
    in_flight_.remove(item.start);
    if (envelope.needed_bytes == 0) {
      if (item.dropped || sink_failed_) {
        ++result_.dropped;
      } else {
        try {
          write(item);
          ++(item.dropped ? result_.dropped : result_.written);
          if (!item.dropped) finished(item);
        } catch (...) {
          ++result_.dropped;
          stop_for(std::current_exception());
        }
      }
    }
    items_[envelope.ticket.item].reset();
    tsan_release(&items_[envelope.ticket.item]);  // to another try with more memory
    return envelope;
  }

  void finished(const GraphItem& item) {
    const ItemReport& report = item.model.row.report;
    if (report.status != Status::ok &&
        ++result_.failed + parameters_.earlier_failures > parameters_.max_failures) {
      result_.too_many_failures = true;
      canceled_ = true;
    }
    const std::chrono::duration<double> seconds = Clock::now() - item.start, worked = item.worked;
    const double waited = std::max(0.0, seconds.count() - worked.count());
    result_.longest_wait_seconds = std::max(result_.longest_wait_seconds, waited);
    if (observer_)
      observer_({*item.plan, report, item.failed_in, item.file_bytes, seconds.count(), waited, item.reused,
                 in_flight_.seconds()});
  }

  // Called when the sink fails: all items in flight are dropped, and the caller gets the exception at the
  // end.
  void stop_for(std::exception_ptr error) {
    if (!sink_failed_.exchange(true)) sink_error_ = std::move(error);
    canceled_ = true;
  }

  const std::vector<PlanItem>& plan_;
  const GraphParameters& parameters_;
  const StoreHeader& header_;
  RowSink& sink_;
  std::atomic<bool>& canceled_;
  std::vector<NodeStatistics>& statistics_;
  const std::function<void(const FinishedItem&)>& observer_;
  flow::graph graph_;
  Admission admission_;
  AdmitNode admit_items_;
  std::vector<std::unique_ptr<StageNode>> stage_nodes_;
  EncodeNode encode_row_;
  StageNode write_row_;
  std::vector<std::unique_ptr<GraphItem>> items_;  // those in flight, by their index in the plan
  InFlight in_flight_;
  GraphResult result_;
  std::mutex admitted_mutex_;
  std::queue<Envelope> admitted_;  // items that the first stage has not yet taken
  bool started_ = false;
  int working_ = 0;  // items between admit_items and encode_row; only admit_items uses it
  std::atomic<bool> sink_failed_{false};
  std::exception_ptr sink_error_;
};

// Reads the tensors of an item. Errors name their file, since the mesh itself is valid.
TensorTable read_tensors(const PlanItem& plan, const Model& model) {
  if (!plan.tensor_dataset.empty())
    return read_tensor_dataset(plan.tensor_path, plan.tensor_dataset, model.file.vertex_count());
  try {
    return read_tensor_table(plan.tensor_path, model.cancel);
  } catch (const ItemError& error) {
    throw ItemError(Status::unreadable, "the tensors of " + plan.tensor_path.string() + ": " + error.what());
  }
}

// Every estimate with colors includes this much for small libraries of materials.
constexpr std::uint64_t max_unreserved_color_bytes = 1 << 20;

// Opens a model; one that unpacks to more than is reserved needs a larger reservation first.
ModelBytes open_model(const PlanItem& plan, std::uint64_t reserved_bytes, bool colors) {
  try {
    return ModelBytes(plan, reserved_bytes, colors);
  } catch (const ItemError& error) {
    if (error.status() != Status::too_large) throw;
    throw NeedsMoreMemory(2 * reserved_bytes);
  }
}

void read_item(GraphItem& item, const SampleParameters& parameters, const ReuseLookup& reuse) {
  const PlanItem& plan = *item.plan;
  if (plan.path.empty())
    throw ItemError(Status::unreadable, "the run was begun with this item, and no input has its id any more");
  if (!plan.known_format)
    throw ItemError(Status::unsupported_format,
                    "the extension `" + plan.path.extension().string() + "` is none of " + mesh_extensions());
  const ModelBytes file =
      open_model(plan, item.reserved_bytes, any_reads(parameters.columns, &ColumnReads::colors));
  // What its images take is in no estimate that was made before they were opened.
  const std::uint64_t color_bytes = file.color_bytes();
  if (plan.reserved_bytes + color_bytes > item.reserved_bytes && color_bytes > max_unreserved_color_bytes)
    throw NeedsMoreMemory(plan.reserved_bytes + color_bytes);
  item.file_bytes = file.file_bytes();
  Row& row = item.model.row;
  row.report.file_bytes = item.file_bytes;
  const auto digest = [&] {
    row.report.content_sha256 = file.content_sha256();
    row.report.color_sha256 = file.color_sha256();
  };
  // The digest of a large file is computed while it is read.
  constexpr std::uint64_t large = std::uint64_t{16} << 20;
  const bool digests_later = !reuse && item.file_bytes >= large;
  if (!digests_later) digest();
  std::optional<CopiedRow> found;
  if (reuse) found = reuse(row.report.content_sha256, plan.format);
  if (found && found->row.report.color_sha256 == row.report.color_sha256) {
    row = std::move(found->row);
    row.report.file_bytes = item.file_bytes;  // absent from stores of format version 1
    item.reused = true;
    item.reused_blocks = std::move(found->blocks);
    return;
  }
  const auto admit = [&](MeshEstimate needs) {
    needs.file_bytes = item.file_bytes;
    needs.packed_bytes = file.packed_bytes();
    if (color_bytes > max_unreserved_color_bytes) needs.decoding_bytes += color_bytes;
    const std::uint64_t needed =
        estimate_bytes(needs, parameters, oneapi::tbb::this_task_arena::max_concurrency());
    if (needed > item.reserved_bytes) throw NeedsMoreMemory(needed);
  };
  std::exception_ptr failure;  // rethrown after the digest, which the row of an unreadable file has, too
  const auto read = [&]() noexcept {
    try {
      item.model.file =
          file.mesh(item.model.cancel, admit, {reads_coordinates(parameters), parameters.attributes});
    } catch (...) {
      failure = std::current_exception();
    }
  };
  if (digests_later)
    parallel_tasks(2, [&](std::size_t task) { task == 0 ? read() : digest(); });
  else
    read();
  if (failure) std::rethrow_exception(failure);
  item.model.key = make_random_key(parameters.seed, row.report.content_sha256);
  MeshEstimate actual;
  actual.vertices = item.model.file.vertex_count();
  const std::size_t corners = item.model.file.corners.size(), polygons = item.model.file.polygon_count();
  actual.triangles = corners > 2 * polygons ? corners - 2 * polygons : 0;
  actual.decoding_bytes = item.model.file.attribute_bytes();
  admit(actual);
  if (!plan.tensor_path.empty())
    item.model.tensor_table = std::make_shared<const TensorTable>(read_tensors(plan, item.model));
}

}  // namespace

GraphStages sampling_stages(const SampleParameters& parameters, const EmbreeDevice* device,
                            ReuseLookup reuse) {
  GraphStages stages = {{"read_mesh", [&parameters, reuse = std::move(reuse)](GraphItem& item) {
                           read_item(item, parameters, reuse);
                         }}};
  for (ModelStage& stage : stages_of(parameters, device))
    stages.push_back({stage.name, [run = std::move(stage.run)](GraphItem& item) { run(item.model); }});
  return stages;
}

GraphResult run_sampling_graph(const std::vector<PlanItem>& plan, const GraphParameters& parameters,
                               const GraphStages& stages, const StoreHeader& header, RowSink& sink,
                               std::atomic<bool>& canceled, std::vector<NodeStatistics>& statistics,
                               const std::function<void(const FinishedItem&)>& observer) {
  const oneapi::tbb::global_control threads(oneapi::tbb::global_control::max_allowed_parallelism,
                                            static_cast<std::size_t>(parameters.threads));
  require_task_memory();
  oneapi::tbb::task_arena arena(parameters.threads);
  GraphResult result;
  const TsanLoop loop;
  arena.execute([&]() MEANDER_CALLED_BY_TBB {
    const TsanLoop::Task task(loop);
    SamplingGraph graph(plan, parameters, stages, header, sink, canceled, statistics, observer);
    result = graph.run();
  });
  return result;
}

void run_item_alone(const PlanItem& plan, const GraphParameters& parameters, const GraphStages& stages,
                    const std::function<void(std::string_view)>& entered) {
  GraphItem item;
  item.plan = &plan;
  item.reserved_bytes = ~std::uint64_t{0};
  for (const GraphStage& stage : stages) {
    entered(stage.name);
    run_stage(stage, item, parameters.timeout_seconds);
  }
  if (!is_open(item) || item.model.sites.count() == 0) return;
  entered("write_row");
  constexpr std::size_t at_once = 65536;
  const PlaceParameters place = place_parameters(parameters.sample);
  for (std::size_t begin = 0; begin < item.model.sites.count(); begin += at_once)
    samples_at(item.model, place, begin, std::min(begin + at_once, item.model.sites.count()));
}

}  // namespace meander
