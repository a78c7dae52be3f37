// What each node of the graph did: items, busy time, bytes.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string_view>

namespace meander {

// Counters of one node; updated by many threads at once.
struct NodeStatistics {
  std::string_view name;
  std::atomic<std::uint64_t> items{0};
  std::atomic<std::uint64_t> busy_nanoseconds{0};
  std::atomic<std::uint64_t> bytes{
      0};  // of the result that the node hands on, where that is the point of the node
};

// Adds the life time of the object to a node's busy time, and one item.
class NodeTimer {
 public:
  explicit NodeTimer(NodeStatistics& node) : node_(node), start_(std::chrono::steady_clock::now()) {}
  ~NodeTimer();
  NodeTimer(const NodeTimer&) = delete;
  NodeTimer& operator=(const NodeTimer&) = delete;

 private:
  NodeStatistics& node_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace meander
