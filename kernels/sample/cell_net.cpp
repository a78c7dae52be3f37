#include "kernels/sample/cell_net.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>
#include <utility>

#include "kernels/core/random.h"
#include "kernels/order/node_items.h"
#include "kernels/order/weighted_selection.h"

namespace meander {

namespace {

// What is left of a cell's entries while it is divided along an axis.
class CellPart {
 public:
  CellPart(std::span<const CellEntry> entries, CellNetScratch& scratch)
      : entries_(entries), end_(entries.size()) {
    if (scratch.row.size() < entries.size())
      for (std::vector<std::uint64_t>* const array : {&scratch.mass, &scratch.row})
        array->resize(entries.size());
    mass_ = scratch.mass.data();
    row_ = scratch.row.data();
    ItemBox box;
    for (std::size_t i = 0; i < entries.size(); ++i) {
      mass_[i] = entries[i].mass;
      total_ += entries[i].mass;
      box.hold(entries[i]);
    }
    axis_ = largest_extent(box).axis;
    for (std::size_t i = 0; i < entries.size(); ++i) row_[i] = row_entry(entries[i].at[axis_], i);
  }
  std::uint64_t mass() const { return total_; }
  // What is done is along this axis: the largest extent of all entries, or of what is left.
  std::size_t axis() const { return axis_; }
  void turn_to_largest_extent() {
    ItemBox box;
    for (std::size_t i = begin_; i < end_; ++i) box.hold(entries_[number_of(row_[i])]);
    const std::size_t axis = largest_extent(box).axis;
    if (axis == axis_) return;
    axis_ = axis;
    for (std::size_t i = begin_; i < end_; ++i) {
      const std::uint32_t number = number_of(row_[i]);
      row_[i] = row_entry(entries_[number].at[axis], number);
    }
  }

  // Keeps the upper or the lower half of the mass; of the entry between the two its part.
  void keep_half(bool upper) {
    const std::uint64_t target = total_ / 2;
    const auto [i, below] = find(target);
    std::uint64_t& divided = mass_[number_of(row_[i])];
    const std::uint64_t lower = std::min(target - below, divided);
    divided = upper ? divided - lower : lower;
    if (upper) {
      begin_ = divided > 0 || i + 1 == end_ ? i : i + 1;
      total_ -= target;
    } else {
      end_ = divided > 0 || i == begin_ ? i + 1 : i;
      total_ = target;
    }
  }

  // The number of the entry that `target` of the mass falls into.
  std::uint32_t entry_at(std::uint64_t target) { return number_of(row_[find(target).first]); }

 private:
  // The place of the entry that `target` of the mass falls into, and the mass before it. All entries before
  // that place are below, all behind it above.
  std::pair<std::size_t, std::uint64_t> find(std::uint64_t target) {
    const SelectedEntry found =
        select_by_mass(std::span(row_ + begin_, end_ - begin_), target,
                       [this](std::uint64_t entry) { return mass_[number_of(entry)]; });
    return {begin_ + found.place, found.below};
  }

  std::span<const CellEntry> entries_;
  std::uint64_t *mass_, *row_;
  std::size_t axis_ = 0;
  std::size_t begin_ = 0, end_ = 0;
  std::uint64_t total_ = 0;
};

}  // namespace

const CellEntry& entry_in_net(const BalancedCells& cells, const Cell& cell, const DigitalShift& shift,
                              double choice, CellNetScratch& scratch) {
  const std::span<const CellEntry> entries = cells.entries(cell);
  CellPart part(entries, scratch);
  const std::size_t first = part.axis();
  const CellDigits digits(cell.history, shift, first);
  for (std::uint32_t j = 0; j < net_digits_in_cell; ++j) part.keep_half(digits(j) != 0);
  part.turn_to_largest_extent();
  const std::size_t second = part.axis();
  const double share =
      CellDigits(cell.history, shift, second, second == first ? net_digits_in_cell : 0).share(choice);
  const auto target = static_cast<std::uint64_t>(share * static_cast<double>(part.mass()));
  return entries[part.entry_at(std::min(target, std::max<std::uint64_t>(part.mass(), 1) - 1))];
}

namespace {

// Sums of the centres of cells, in the order of the tree.
class CentreSums {
 public:
  CentreSums(std::span<const Cell> cells, std::span<const std::uint32_t> rank) : sums_(cells.size() + 1) {
    for (std::size_t r = 0; r < cells.size(); ++r)
      for (std::size_t k = 0; k < 3; ++k)
        sums_[r + 1][k] = sums_[r][k] + static_cast<double>(cells[rank[r]].centre[k]);
  }
  std::uint32_t count() const { return static_cast<std::uint32_t>(sums_.size() - 1); }
  // From the mean centre of [begin, middle) to that of [middle, end), times their numbers.
  std::array<double, 3> way(std::size_t begin, std::size_t middle, std::size_t end) const {
    const auto first = static_cast<double>(middle - begin), second = static_cast<double>(end - middle);
    std::array<double, 3> way{};
    for (std::size_t k = 0; k < 3; ++k)
      way[k] = (sums_[end][k] - sums_[middle][k]) * first - (sums_[middle][k] - sums_[begin][k]) * second;
    return way;
  }

 private:
  std::vector<std::array<double, 3>> sums_;
};

std::size_t longest(const std::array<double, 3>& way) {
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (std::abs(way[k]) > std::abs(way[axis])) axis = k;
  return axis;
}

// A range of leaves that one sample of a prefix stands for.
struct Node {
  static constexpr std::size_t none = ~std::size_t{0};
  std::uint32_t first, leaves;
  std::size_t tree_node;     // whose leaves these are, or none
  CutHistory history;        // of the cuts between the halves of those above
  std::uint32_t parted = 0;  // how often it was parted otherwise than across an axis
};

// Halves of nodes, down to single leaves: as the tree is cut where that is in halves, else by numbers, as one
// level of samples follows the other.
class NodeHalves {
 public:
  NodeHalves(const BalancedCells& cells, const CentreSums& centres, RandomKey key)
      : cells_(cells),
        centres_(centres),
        key_(key),
        shift_(digital_shift(key)),
        other_shift_(digital_shift(key, 1)),
        part_shift_(digital_shift(key, 2)) {}

  // The half that the sample which represents the node lies in, and the other one.
  std::array<Node, 2> of(const Node& node) const {
    // The digits of a sample in its cell follow those of the cuts above it: no other cuts may take theirs
    // from the same shift, and no two of them the same bit.
    if (node.tree_node != Node::none) {
      const TreeCut cut = cells_.cut[node.tree_node];
      if (cut.axis != TreeCut::between_parts) return across(node, cut.axis, cut.low_leaves, true, shift_);
      if (cut.low_leaves == node.leaves / 2 || cut.low_leaves == node.leaves - node.leaves / 2) {
        // Parts are one more direction, which all others are across.
        Node parted = node;
        ++parted.parted;
        const bool upper = (net_digit(node.history.side, 0) ^ part_shift_.digit(0, node.parted)) != 0;
        const bool second = takes_second(node, cut.low_leaves, upper);
        return {half(parted, cut.low_leaves, second), half(parted, cut.low_leaves, !second)};
      }
    }
    Node range = node;
    range.tree_node = Node::none;
    const std::uint32_t end = node.first + node.leaves;
    std::uint32_t low = node.leaves / 2;
    std::array<double, 3> way = centres_.way(node.first, node.first + low, end);
    const std::size_t axis = longest(way);
    low = lower_leaves(node.leaves, node.history, axis, centres_.count());
    way = centres_.way(node.first, node.first + low, end);
    return across(range, axis, low, way[axis] >= 0, other_shift_);
  }

 private:
  std::array<Node, 2> across(const Node& node, std::size_t axis, std::uint32_t low_leaves, bool ascends,
                             const DigitalShift& shift) const {
    const bool upper = (net_digit(node.history.side_across_others[axis], 0) ^
                        shift.digit(axis, node.history.cuts[axis])) != 0;
    const bool second = takes_second(node, low_leaves, upper == ascends);
    const auto child = [&](bool is_second) {
      Node n = half(node, low_leaves, is_second);
      n.history.cut(axis, is_second == ascends);
      return n;
    };
    return {child(second), child(!second)};
  }

  // Of halves that are one leaf apart the larger one is taken so much more often that all leaves are equally
  // likely.
  bool takes_second(const Node& node, std::uint32_t low_leaves, bool second) const {
    if (node.leaves % 2 == 0) return second;
    const PhiloxBlock words = random_words(key_, Stream::digital_shift, node.first, node.leaves);
    const bool decides = std::uint64_t{words[0]} * node.leaves < std::uint64_t{1} << 32;
    return decides ? low_leaves < node.leaves - low_leaves : second;
  }

  static Node half(const Node& node, std::uint32_t low_leaves, bool is_second) {
    Node n = node;
    if (is_second) {
      n.first += low_leaves;
      n.leaves -= low_leaves;
    } else {
      n.leaves = low_leaves;
    }
    if (n.tree_node != Node::none)
      n.tree_node = is_second ? CutTree::high(n.tree_node, low_leaves) : CutTree::low(n.tree_node);
    return n;
  }

  const BalancedCells& cells_;
  const CentreSums& centres_;
  RandomKey key_;
  DigitalShift shift_, other_shift_, part_shift_;
};

// A node before the last level: the sample that represents it, and the leaf that then gets one.
struct LastNode {
  static constexpr std::uint32_t none = ~std::uint32_t{0};
  std::uint32_t sample = none, leaf = none;
};

// Of neighbouring nodes: the leaves that no sample lies in before the last level, by their range in a list.
struct LastLeaves {
  std::uint32_t sample;  // the first in these nodes
  std::uint32_t begin, end;
};

// The leaves of all nodes (2^k of them), evenly spread: of two halves of a node first the one with the
// earlier sample, then from both in turn, in proportion to their numbers. O(n log n).
std::vector<std::uint32_t> spread(std::vector<LastLeaves> nodes, std::vector<std::uint32_t> leaf) {
  std::vector<std::uint32_t> merged(leaf.size());
  for (; nodes.size() > 1; nodes.resize(nodes.size() / 2)) {
    for (std::size_t i = 0; i < nodes.size() / 2; ++i) {
      LastLeaves first = nodes[2 * i], second = nodes[2 * i + 1];
      const LastLeaves both{std::min(first.sample, second.sample), first.begin, second.end};
      if (second.sample < first.sample) std::swap(first, second);
      const std::uint64_t firsts = first.end - first.begin, seconds = second.end - second.begin;
      std::uint64_t a = 0, b = 0;
      for (std::uint32_t at = both.begin; at < both.end; ++at) {
        const bool is_first = b == seconds || (a < firsts && (2 * a + 1) * seconds <= (2 * b + 1) * firsts);
        merged[at] = is_first ? leaf[first.begin + a++] : leaf[second.begin + b++];
      }
      nodes[i] = both;
    }
    leaf.swap(merged);
  }
  return leaf;
}

}  // namespace

std::vector<std::uint32_t> cell_net_order(const BalancedCells& cells, RandomKey key) {
  const auto count = static_cast<std::uint32_t>(cells.cell.size());
  std::vector<std::uint32_t> order;
  if (count < 2) return std::vector<std::uint32_t>(count, 0u);
  std::vector<std::uint32_t> rank(count);  // by number in the tree
  for (std::uint32_t r = 0; r < count; ++r) rank[cells.cell[r].leaf] = r;
  const CentreSums centres(cells.cell, rank);
  const NodeHalves halves(cells, centres, key);
  // By sample: the node that it represents. Every level halves them; the halves without a sample get one.
  std::vector<Node> nodes{{0, count, 0, {}}};
  nodes.reserve(count);
  const int levels = std::bit_width(count - 1);
  std::vector<LastNode> last(count);  // by its first leaf
  for (int level = 0; level < levels; ++level) {
    for (std::size_t j = 0, present = nodes.size(); j < present; ++j) {
      const Node node = nodes[j];
      const auto sample = static_cast<std::uint32_t>(j);
      if (node.leaves == 1) {
        if (level + 1 == levels) last[node.first].sample = sample;
        continue;
      }
      const auto [taken, other] = halves.of(node);
      nodes[j] = taken;
      if (level + 1 < levels)
        nodes.push_back(other);
      else
        last[node.first] = {sample, other.first};
    }
  }
  std::vector<LastLeaves> ranges;
  std::vector<std::uint32_t> leaves;
  ranges.reserve(nodes.size());
  leaves.reserve(count - nodes.size());
  for (const LastNode& node : last) {
    if (node.sample == LastNode::none) continue;
    const auto begin = static_cast<std::uint32_t>(leaves.size());
    if (node.leaf != LastNode::none) leaves.push_back(node.leaf);
    ranges.push_back({node.sample, begin, static_cast<std::uint32_t>(leaves.size())});
  }
  order.reserve(count);
  for (const Node& node : nodes) order.push_back(rank[node.first]);
  for (const std::uint32_t leaf : spread(std::move(ranges), std::move(leaves))) order.push_back(rank[leaf]);
  return order;
}

}  // namespace meander
