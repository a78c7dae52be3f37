#include "kernels/sample/cell_net.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

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
    for (std::size_t i = 0; i < entries.size(); ++i) {
      mass_[i] = entries[i].mass;
      row_[i] = i;
      total_ += entries[i].mass;
    }
  }
  std::uint64_t mass() const { return total_; }

  std::size_t longest_axis() const {
    ItemBox box;
    for (std::size_t i = begin_; i < end_; ++i) box.hold(entries_[number_of(row_[i])]);
    return largest_extent(box).axis;
  }

  // The axis that what follows is along.
  void lay_out(std::size_t axis) {
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
  std::size_t begin_ = 0, end_ = 0;
  std::uint64_t total_ = 0;
};

}  // namespace

const CellEntry& entry_in_net(const BalancedCells& cells, const Cell& cell, const DigitalShift& shift,
                              double choice, CellNetScratch& scratch) {
  const std::span<const CellEntry> entries = cells.entries(cell);
  CellPart part(entries, scratch);
  const std::size_t first = part.longest_axis();
  part.lay_out(first);
  const CellDigits digits(cell.history, shift, first);
  for (std::uint32_t j = 0; j < net_digits_in_cell; ++j) part.keep_half(digits(j) != 0);
  const std::size_t second = part.longest_axis();
  if (second != first) part.lay_out(second);
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

struct Node {
  std::uint32_t first, leaves;
  CutHistory history;  // of the cuts between the halves of those above
};

// Its halves: the one that the sample which represents it lies in, and the other one.
std::array<Node, 2> halves_of(const Node& node, const CentreSums& centres, const DigitalShift& shift) {
  const std::uint32_t end = node.first + node.leaves;
  std::uint32_t middle = node.first + node.leaves / 2;
  std::array<double, 3> way = centres.way(node.first, middle, end);
  const std::size_t axis = longest(way);
  if (const std::uint32_t lower = lower_leaves(node.leaves, node.history, axis, centres.count());
      lower != node.leaves / 2) {
    middle = node.first + lower;
    way = centres.way(node.first, middle, end);
  }
  const bool ascends = way[axis] >= 0;
  const bool upper =
      (net_digit(node.history.side_across_others[axis], 0) ^ shift.digit(axis, node.history.cuts[axis])) != 0;
  const auto half = [&](bool is_second) {
    Node child{is_second ? middle : node.first, is_second ? end - middle : middle - node.first, node.history};
    child.history.cut(axis, is_second == ascends);
    return child;
  };
  return {half(upper == ascends), half(upper != ascends)};
}

// The leaves of a node that no sample lies in before the last level, in the order in which they get theirs.
struct LastLeaves {
  std::uint32_t first;   // leaf of the node
  std::uint32_t sample;  // the first in it
  std::vector<std::uint32_t> leaf;
};

// Those of all nodes, evenly spread: of two halves of a node first the one with the earlier sample, then from
// both in turn, in proportion to their numbers. O(n log n).
std::vector<std::uint32_t> spread(std::vector<LastLeaves> nodes) {
  std::sort(nodes.begin(), nodes.end(),
            [](const LastLeaves& a, const LastLeaves& b) { return a.first < b.first; });
  while (nodes.size() > 1) {
    for (std::size_t i = 0; i < nodes.size() / 2; ++i) {
      LastLeaves &first = nodes[2 * i], &second = nodes[2 * i + 1];
      if (second.sample < first.sample) std::swap(first, second);
      LastLeaves both{std::min(first.first, second.first), first.sample, {}};
      both.leaf.reserve(first.leaf.size() + second.leaf.size());
      for (std::size_t a = 0, b = 0; a < first.leaf.size() || b < second.leaf.size();) {
        const bool is_first =
            b == second.leaf.size() ||
            (a < first.leaf.size() && (2 * a + 1) * second.leaf.size() <= (2 * b + 1) * first.leaf.size());
        both.leaf.push_back(is_first ? first.leaf[a++] : second.leaf[b++]);
      }
      nodes[i] = std::move(both);
    }
    nodes.resize(nodes.size() / 2);
  }
  return std::move(nodes.front().leaf);
}

}  // namespace

std::vector<std::uint32_t> cell_net_order(std::span<const Cell> cells, const DigitalShift& shift) {
  const auto count = static_cast<std::uint32_t>(cells.size());
  std::vector<std::uint32_t> order;
  if (count < 2) return std::vector<std::uint32_t>(count, 0u);
  std::vector<std::uint32_t> rank(count);  // by number in the tree
  for (std::uint32_t r = 0; r < count; ++r) rank[cells[r].leaf] = r;
  const CentreSums centres(cells, rank);
  // By sample: the node that it represents. Every level halves them; the halves without a sample get one.
  std::vector<Node> nodes{{0, count, {}}};
  nodes.reserve(count);
  std::vector<LastLeaves> last;
  const int levels = std::bit_width(count - 1);
  for (int level = 0; level < levels; ++level) {
    for (std::size_t j = 0, present = nodes.size(); j < present; ++j) {
      const Node node = nodes[j];
      const auto sample = static_cast<std::uint32_t>(j);
      if (node.leaves == 1) {
        if (level + 1 == levels) last.push_back({node.first, sample, {}});
        continue;
      }
      const auto [taken, other] = halves_of(node, centres, shift);
      nodes[j] = taken;
      if (level + 1 < levels)
        nodes.push_back(other);
      else
        last.push_back({node.first, sample, {other.first}});
    }
  }
  order.reserve(count);
  for (const Node& node : nodes) order.push_back(rank[node.first]);
  for (const std::uint32_t leaf : spread(std::move(last))) order.push_back(rank[leaf]);
  return order;
}

}  // namespace meander
