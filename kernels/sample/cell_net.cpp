#include "kernels/sample/cell_net.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "kernels/core/random.h"
#include "kernels/core/vector_instructions.h"
#include "kernels/partition/node_items.h"
#include "kernels/partition/weighted_selection.h"

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

// A node of the tree and the cuts above it.
struct Node {
  std::size_t number;
  std::uint32_t first, leaves;
  CutHistory history;
  std::uint32_t parted;  // how many of them were not across an axis
};

struct alignas(16) Lanes {
  float lane[4];
};

// The leaves of the tree in the order in which they get their samples.
class NetOrder {
 public:
  NetOrder(const BalancedCells& cells, RandomKey key, const SamplePlace& place)
      : cells_(cells),
        place_(place),
        key_(key),
        shift_(digital_shift(key)),
        place_shift_(digital_shift(key, 1)),
        part_shift_(digital_shift(key, 2)),
        rank_(cells.cell.size()),
        order_(cells.cell.size()),
        merged_(cells.cell.size()) {
    for (std::uint32_t r = 0; r < rank_.size(); ++r) rank_[cells.cell[r].leaf] = r;
    std::iota(order_.begin(), order_.end(), 0u);
    if (!order_.empty()) sort({0, 0, static_cast<std::uint32_t>(cells.cell.size()), {}, 0});
  }
  std::vector<std::uint32_t> ranks() const {
    std::vector<std::uint32_t> ranks(order_.size());
    std::transform(order_.begin(), order_.end(), ranks.begin(),
                   [&](std::uint32_t leaf) { return rank_[leaf]; });
    return ranks;
  }

 private:
  // Those of a node, in its range of the order.
  void sort(const Node& node) {
    if (node.leaves == 1) return;
    const TreeCut cut = cells_.cut[node.number];
    const bool parts = cut.axis == TreeCut::between_parts;
    const std::uint32_t high_leaves = node.leaves - cut.low_leaves;
    if (!parts && cut.low_leaves != high_leaves) {
      if (at_.empty()) at_.resize(order_.size());
      for (std::uint32_t leaf = node.first; leaf < node.first + node.leaves; ++leaf) {
        const std::array<float, 3> at = place_(rank_[leaf]);
        at_[leaf] = {{at[0], at[1], at[2], 0}};
      }
      bisect(node.first, node.leaves, node.history);
      return;
    }
    Node low{CutTree::low(node.number), node.first, cut.low_leaves, node.history, node.parted + parts};
    Node high{CutTree::high(node.number, cut.low_leaves), node.first + cut.low_leaves, high_leaves,
              node.history, node.parted + parts};
    if (!parts) {
      low.history.cut(cut.axis, false);
      high.history.cut(cut.axis, true);
    }
    sort(low);
    sort(high);
    // The digits of a sample in its cell follow those of the cuts above it: no other cuts may take theirs
    // from the same shift, and no two of them the same bit. Parts are one more direction, which all others
    // are across.
    if (!parts)
      alternate(node.first, node.leaves, cut.low_leaves, is_upper(node.history, cut.axis, shift_));
    else if (std::max(cut.low_leaves, high_leaves) - std::min(cut.low_leaves, high_leaves) <= 1)
      alternate(node.first, node.leaves, cut.low_leaves,
                (net_digit(node.history.side, 0) ^ part_shift_.digit(0, node.parted)) != 0);
    else
      mix(node.first, node.leaves, cut.low_leaves);
  }

  // Leaves whose node is not cut in halves, by bisection of the places of their samples: prefixes of 2^j lie
  // in as many equal parts, and digits say on which side a sample lies, not only its cell.
  void bisect(std::uint32_t first, std::uint32_t leaves, const CutHistory& history) {
    if (leaves == 1) return;
    const std::span<std::uint32_t> range = std::span(order_).subspan(first, leaves);
    __m128 least = _mm_set1_ps(INFINITY), most = _mm_set1_ps(-INFINITY);
    for (const std::uint32_t leaf : range) {
      const __m128 at = _mm_load_ps(at_[leaf].lane);
      least = _mm_min_ps(least, at);
      most = _mm_max_ps(most, at);
    }
    Lanes extent;
    _mm_store_ps(extent.lane, _mm_sub_ps(most, least));
    std::size_t axis = 0;
    for (std::size_t k = 1; k < 3; ++k)
      if (extent.lane[k] > extent.lane[axis]) axis = k;
    const bool upper = is_upper(history, axis, place_shift_);
    if (leaves == 2) {
      const auto entry = [&](std::uint32_t leaf) { return row_entry(at_[leaf].lane[axis], leaf); };
      if ((entry(range[0]) > entry(range[1])) != upper) std::swap(range[0], range[1]);
      return;
    }
    // The larger half of an odd number lies on either side: were it always the same, prefixes of all sets
    // would have more samples there, or fewer.
    const std::uint32_t low = leaves / 2 + static_cast<std::uint32_t>(leaves & word_of(first, leaves, 1) & 1);
    row_.clear();
    for (const std::uint32_t leaf : range) row_.push_back(row_entry(at_[leaf].lane[axis], leaf));
    select_by_mass(std::span(row_), low, [](std::uint64_t) { return std::uint64_t{1}; });
    std::transform(row_.begin(), row_.end(), range.begin(), number_of);
    CutHistory below = history, above = history;
    below.cut(axis, false);
    above.cut(axis, true);
    bisect(first, low, below);
    bisect(first + low, leaves - low, above);
    alternate(first, leaves, low, upper);
  }

  static bool is_upper(const CutHistory& history, std::size_t axis, const DigitalShift& shift) {
    return (net_digit(history.side_across_others[axis], 0) ^ shift.digit(axis, history.cuts[axis])) != 0;
  }

  // From both halves in turn, which may be one leaf apart; from the one first that the digits of the net say.
  // A larger half is so much more often the first one that all leaves are equally likely.
  void alternate(std::uint32_t first, std::uint32_t leaves, std::uint32_t low_leaves, bool upper) {
    const std::uint32_t half = leaves / 2;
    const bool is_odd = leaves % 2 != 0, low_is_larger = low_leaves > half;
    if (is_odd && word_of(first, leaves, 0) * leaves < std::uint64_t{1} << 32) upper = !low_is_larger;
    const std::uint32_t *from = order_.data() + first, *other = from + low_leaves;
    if (upper) std::swap(from, other);
    std::uint32_t* const to = merged_.data() + first;
    for (std::uint32_t i = 0; i < half; ++i) {
      to[2 * i] = from[i];
      to[2 * i + 1] = other[i];
    }
    if (is_odd) to[2 * half] = low_is_larger != upper ? from[half] : other[half];
    std::copy_n(to, leaves, order_.begin() + first);
  }

  // From both parts in proportion, from a random phase on: either is first as often as its share of the
  // leaves asks for, whatever the digits are.
  void mix(std::uint32_t first, std::uint32_t leaves, std::uint32_t low_leaves) {
    std::uint64_t phase = (word_of(first, leaves, 0) * leaves >> 32) * low_leaves % leaves;
    std::uint32_t low = first, high = first + low_leaves;
    for (std::uint32_t i = 0; i < leaves; ++i) {
      phase += low_leaves;
      const bool is_low = phase >= leaves;
      if (is_low) phase -= leaves;
      merged_[first + i] = order_[is_low ? low++ : high++];
    }
    std::copy_n(merged_.begin() + first, leaves, order_.begin() + first);
  }

  std::uint64_t word_of(std::uint32_t first, std::uint32_t leaves, std::size_t number) const {
    return random_words(key_, Stream::digital_shift, first, leaves)[number];
  }

  const BalancedCells& cells_;
  const SamplePlace& place_;
  RandomKey key_;
  DigitalShift shift_, place_shift_, part_shift_;
  std::vector<std::uint32_t> rank_;  // by leaf
  std::vector<Lanes> at_;            // by leaf, where nodes are bisected: of its sample
  std::vector<std::uint32_t> order_, merged_;
  std::vector<std::uint64_t> row_;
};

}  // namespace

std::vector<std::uint32_t> cell_net_order(const BalancedCells& cells, RandomKey key,
                                          const SamplePlace& place) {
  return NetOrder(cells, key, place).ranks();
}

}  // namespace meander
