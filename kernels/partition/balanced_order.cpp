#include "kernels/partition/balanced_order.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>

#include "kernels/core/large_vector.h"
#include "kernels/core/parallel.h"
#include "kernels/core/ranked_bits.h"
#include "kernels/partition/exact_cells.h"
#include "kernels/partition/mass_units.h"
#include "kernels/partition/node_items.h"
#include "kernels/partition/sheet_cut.h"
#include "kernels/partition/weighted_selection.h"

namespace meander {

namespace {

// Nodes of at most this many leaves take split elements by halves, and by all parts.
constexpr std::uint32_t halved_leaves = 64, block_leaves = 16;
constexpr int all_parts = 2;  // levels of splits
// Nodes of more elements than this are worked on by other threads too.
constexpr std::size_t parallel_node = 32768;

using Point = std::array<float, 3>;

float distance(const Point& a, const Point& b) {
  const float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return std::sqrt(x * x + y * y + z * z);
}

// Arrays of one thread, reused from node to node.
struct Scratch {
  std::vector<float> coordinate;  // by item, where a node is not cut across an axis
  DivideScratch divide;
  SheetScratch sheets;
  struct Buffers {
    std::vector<NodeItem> front, back;  // a node's items are in one, its halves' in the other
  };
  std::array<Buffers, all_parts> taken_apart;  // by levels of splits
};

struct Leaf {
  std::uint32_t block = 0, count = 0;
  std::size_t first = 0;
  CutHistory history;
};

class Bisection {
 public:
  Bisection(std::span<const MassPoint> elements, std::uint32_t n, std::uint64_t shares,
            const ElementTraits& traits, const ExactTriangles* exact, const CancelToken& cancel)
      : n_(n),
        shares_(shares),
        count_(elements.size()),
        elements_(elements),
        traits_(traits),
        exact_(exact),
        cancel_(cancel),
        tree_(n) {
    double total = 0;
    for (const MassPoint& e : elements) total += e.mass;
    if (n == 0 || !(total > 0)) throw std::invalid_argument("balanced_order: no samples or no mass");
    if (elements.size() > most_balanced_elements)
      throw std::invalid_argument("balanced_order: more than 2^29 elements");
    if ((!traits.normal.empty() || !traits.group.empty()) && traits.triangle.size() != elements.size())
      throw std::invalid_argument("balanced_order: traits of triangles without the triangles");
    if (traits.splits.element.size() != traits.splits.split.size() ||
        !ascend_below(traits.splits.element, elements.size()))
      throw std::invalid_argument("balanced_order: splits of other elements");
    mass_ = total;
    units_ = MassUnits(total);
    leaves_.resize(n);
    if (exact != nullptr) {
      if (!traits.splits.empty() || !traits.group.empty())
        throw std::invalid_argument("exact_order: elements with splits or groups");
      return;
    }
    if (!traits.splits.empty()) {
      split_number_ = RankedBits(traits.splits.element, elements.size());
      split_point_.reserve(traits.splits.element.size());
      for (const std::uint32_t e : traits.splits.element) split_point_.push_back(elements[e]);
    }
    resize_large(front_, elements.size() + n);
    std::vector<std::uint64_t> masses((elements.size() + sum_block - 1) / sum_block);
    parallel_blocks(elements.size(), sum_block, [&](std::size_t begin, std::size_t end) {
      std::uint64_t mass = 0;
      for (std::size_t e = begin; e < end; ++e) {
        front_[e] = whole_item(elements[e], static_cast<std::uint32_t>(e));
        mass += front_[e].mass;
      }
      masses[begin / sum_block] = mass;
    });
    total_ = std::accumulate(masses.begin(), masses.end(), std::uint64_t{0});
    blocks_.resize(std::size_t{n} + 2);
    if (!traits_.group.empty()) group_.resize(2 * std::size_t{n});
  }

  // Null where exact cells would keep too many polygons.
  std::optional<BalancedCells> cells() {
    if (exact_ == nullptr)
      bisect_all();
    else if (!cut_all_exactly())
      return std::nullopt;
    path_.reserve(n_);
    visit(0, 0, n_, nullptr, nullptr);
    return collect();
  }

 private:
  static constexpr std::uint32_t several_groups = ~0u;

  bool cut_all_exactly() {
    std::optional<ExactCells> cut = cut_exactly(elements_, mass_, n_, traits_, *exact_, cancel_);
    if (!cut) return false;
    ExactCells& exact = *cut;
    tree_ = std::move(exact.tree);
    points_ = std::move(exact.point);
    for (std::size_t leaf = 0; leaf < n_; ++leaf) leaves_[leaf].history = exact.history[leaf];
    if (exact_->max_polygons == 0) {
      blocks_.resize(1);
      return true;
    }
    for (std::size_t leaf = 0; leaf < n_; ++leaf) {
      const EntryRange& range = exact.entries[leaf];
      leaves_[leaf].block = range.block;
      leaves_[leaf].first = range.first;
      leaves_[leaf].count = range.count;
    }
    blocks_ = std::move(exact.block);
    polygons_ = std::move(exact.polygon);
    return true;
  }

  void bisect_all() {
    resize_large(back_, front_.size());  // the elements may be gone by now
    Scratch scratch;
    bisect({0, 0, n_, front_.data(), back_.data(), count_, 0, 0, {}}, scratch);
    if (traits_.splits.empty()) {
      blocks_[n_] = std::move(front_);
      blocks_[n_ + 1] = std::move(back_);
    }
    front_ = std::vector<NodeItem>();
    back_ = std::vector<NodeItem>();
  }

  // A node: its number in depth-first order, its first leaf and number of leaves, its items, the place in the
  // other buffer where its halves' go, the level to which splits are taken apart, and, once that is the last,
  // the block that the items of leaves are kept in; the cuts above.
  struct Node {
    std::size_t number;
    std::uint32_t first, leaves;
    NodeItem *items, *other;
    std::size_t count;
    int level;
    std::uint32_t block;
    CutHistory history;
  };

  std::uint64_t units(const MassPoint& e) const { return static_cast<std::uint64_t>(units_.of(e.mass)); }

  // Items are named by element and part.
  static std::uint32_t name(std::uint32_t element, std::uint32_t part) { return element << 3 | part; }

  NodeItem whole_item(const MassPoint& e, std::uint32_t element) const {
    return {{e.at[0], e.at[1], e.at[2]}, name(element, 1), units(e)};
  }

  // A part of the element, which is split number `number`.
  NodeItem part_item(std::size_t number, std::uint32_t element, std::uint32_t part) const {
    NodeItem item = whole_item(split_point_[number], element);
    if (part == 1) return item;
    item.name = name(element, part);
    const ElementSplit& split = traits_.splits.split[number];
    const auto halve = [&](bool second, const float(&way)[3]) {
      const std::uint64_t first_mass = item.mass / 2;
      item.mass = second ? item.mass - first_mass : first_mass;
      for (std::size_t k = 0; k < 3; ++k) item.at[k] += second ? -way[k] : way[k];
    };
    const std::uint32_t half = part < 4 ? part : part / 2;
    halve(half == 3, split.half);
    if (part >= 4) halve(part % 2 != 0, split.quarter[half - 2]);
    return item;
  }

  // The mass before the leaf of that number.
  std::uint64_t boundary(std::uint32_t leaf) const {
    const std::uint64_t share = shares_ == n_ ? leaf : leaf * shares_ / n_;
    return total_ / shares_ * share + total_ % shares_ * share / shares_;  // floor(total share / shares)
  }

  // The level to which nodes of that many leaves take splits apart.
  int level_of(std::uint32_t leaves) const {
    if (leaves <= block_leaves) return all_parts;
    return leaves <= halved_leaves && !traits_.splits.empty() ? 1 : 0;
  }

  // The node with parts of its items instead. What a cut above has divided stays as it is.
  void take_apart(Node node, int level, Scratch& scratch) {
    node.level = level;
    if (traits_.splits.empty()) {
      bisect(node, scratch);
      return;
    }
    Scratch::Buffers& buffers = scratch.taken_apart[static_cast<std::size_t>(level) - 1];
    const auto deeper_levels = [&](std::size_t number, const NodeItem& item) {
      if (number == RankedBits::none) return 0;
      const int levels = std::min<int>(traits_.splits.split[number].levels, level);
      return std::max(levels - static_cast<int>(std::bit_width(item.part())) + 1, 0);
    };
    std::size_t room = node.leaves;
    for (std::size_t i = 0; i < node.count; ++i)
      room += std::size_t{1} << deeper_levels(split_number_.rank_of(node.items[i].element()), node.items[i]);
    if (buffers.front.size() < room) buffers.front.resize(room);
    if (buffers.back.size() < room) buffers.back.resize(room);
    NodeItem* to = buffers.front.data();
    for (std::size_t i = 0; i < node.count; ++i) {
      const NodeItem& item = node.items[i];
      const std::uint32_t element = item.element(), part = item.part();
      const std::size_t number = split_number_.rank_of(element);
      const int deeper = deeper_levels(number, item);
      if (deeper == 0 || part_item(number, element, part).mass != item.mass) {
        *to++ = item;
        continue;
      }
      const std::uint32_t first = part << deeper;
      for (std::uint32_t p = first; p < first + (1u << deeper); ++p) *to++ = part_item(number, element, p);
    }
    node.count = static_cast<std::size_t>(to - buffers.front.data());
    node.items = buffers.front.data();
    node.other = buffers.back.data();
    if (level == all_parts) {  // its leaves are kept together
      node.block = node.first;
      blocks_[node.block].reserve(room);
    }
    bisect(node, scratch);
  }

  void bisect(const Node& node, Scratch& scratch) {
    if (const int level = level_of(node.leaves); level > node.level) {
      take_apart(node, level, scratch);
      return;
    }
    const std::span<const NodeItem> items(node.items, node.count);
    if (node.count > parallel_node) cancel_.check();
    if (node.leaves == 1) {
      finish_leaf(node, items);
      return;
    }
    const ItemExtent extent = largest_extent(items);
    std::uint32_t low_leaves = lower_leaves(node.leaves);
    const bool by_coordinate = find_coordinates(node, items, extent, scratch, low_leaves);
    const std::uint32_t high_leaves = node.leaves - low_leaves;
    const std::uint64_t target = boundary(node.first + low_leaves) - boundary(node.first);
    // Every cut may add an item: a node of s leaves has room for s - 1 more, as its halves have.
    NodeItem* const to = node.other;
    NodeItem* const end = to + node.count + low_leaves;  // of the high half; its room for more is behind it
    const auto [low, high] =
        by_coordinate ? divide(
                            items, [&](std::size_t i) { return scratch.coordinate[i]; },
                            range_of(scratch.coordinate), target, to, end, scratch.divide)
                      : divide(
                            items, [&, axis = extent.axis](std::size_t i) { return items[i].at[axis]; },
                            extent, target, to, end, scratch.divide);
    NodeItem* const high_items = end - high;
    CutHistory below = node.history, above = node.history;
    if (!by_coordinate) {
      below.cut(extent.axis, false);
      above.cut(extent.axis, true);
    }
    const Node children[2] = {
        {CutTree::low(node.number), node.first, low_leaves, to, node.items, low, node.level, node.block,
         below},
        {CutTree::high(node.number, low_leaves), node.first + low_leaves, high_leaves, high_items,
         node.items + (high_items - to), high, node.level, node.block, above}};
    if (node.count > parallel_node && node.level < all_parts) {
      parallel_tasks(2, [&](std::size_t i) {
        Scratch own;
        bisect(children[i], own);
      });
    } else {
      for (const Node& child : children) bisect(child, scratch);
    }
    tree_.join(node.number, node.leaves,
               {low_leaves, by_coordinate ? TreeCut::between_parts : static_cast<std::uint8_t>(extent.axis)});
    if (!group_.empty()) {
      const std::uint32_t low_group = group_[children[0].number], high_group = group_[children[1].number];
      group_[node.number] = low_group == high_group ? low_group : several_groups;
    }
  }

  static ItemExtent range_of(const std::vector<float>& values) {
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    return {0, *least, *most};
  }

  // Where the node is not cut across its largest extent: fills the coordinates that it is cut
  // across, and the leaves of its low half.
  bool find_coordinates(const Node& node, std::span<const NodeItem> items, const ItemExtent& extent,
                        Scratch& scratch, std::uint32_t& low_leaves) const {
    if (!traits_.group.empty())
      return order_groups(items, boundary(node.first + low_leaves) - boundary(node.first),
                          scratch.coordinate);
    if (node.leaves < least_stack || traits_.normal.empty()) return false;
    probe(items, few_sheet_probes, scratch.sheets);
    if (!may_be_stack(scratch.sheets, node.leaves)) return false;
    probe(items, many_sheet_probes, scratch.sheets);
    const std::optional<SheetCut> cut = find_sheet_cut(scratch.sheets, node.leaves);
    return cut && separate_sheets(node, items, *cut, extent.axis, scratch.coordinate, low_leaves);
  }

  void probe(std::span<const NodeItem> items, std::size_t most, SheetScratch& sheets) const {
    sheets.probes.clear();
    const std::size_t probes = std::min(items.size(), most);
    for (std::size_t p = 0; p < probes; ++p) {
      // One of every block, not always the same one: sides may alternate in the file.
      const std::size_t begin = p * items.size() / probes, end = (p + 1) * items.size() / probes;
      const NodeItem& item = items[begin + ((p + 1) * 2654435761u >> 7) % (end - begin)];
      sheets.probes.push_back({{item.at[0], item.at[1], item.at[2]}, normal_of(item)});
    }
  }

  // One sheet, or one side of the stack, before the other: along the largest extent within each. The halves
  // get as many leaves as their masses ask for; if one gets none, the node is cut in space after all.
  bool separate_sheets(const Node& node, std::span<const NodeItem> items, const SheetCut& cut,
                       std::size_t axis, std::vector<float>& at, std::uint32_t& low_leaves) const {
    at.resize(items.size());
    std::uint64_t low = 0;
    for (std::size_t i = 0; i < items.size(); ++i) {
      const bool above = is_above(cut, items[i]);
      at[i] = items[i].at[axis] + (above ? 4.0f : 0.0f);  // coordinates lie in [-1, 1]
      if (!above) low += items[i].mass;
    }
    const std::uint64_t mass = boundary(node.first + node.leaves) - boundary(node.first);
    const double leaves = static_cast<double>(low) / static_cast<double>(mass) * node.leaves;
    const auto wanted = static_cast<std::uint32_t>(std::lround(leaves));
    if (wanted == 0 || wanted >= node.leaves) return false;
    low_leaves = wanted;
    return true;
  }

  bool is_above(const SheetCut& cut, const NodeItem& item) const {
    return cut.is_above({item.at[0], item.at[1], item.at[2]}, normal_of(item));
  }
  Point normal_of(std::uint32_t element) const {
    const float* n = &traits_.normal[3 * std::size_t{traits_.triangle[element]}];
    return {n[0], n[1], n[2]};
  }
  Point normal_of(const NodeItem& item) const { return normal_of(item.element()); }
  std::uint32_t group_of(const NodeItem& item) const {
    return traits_.group[traits_.triangle[item.element()]];
  }

  // Groups in their order; the one that the cut falls into is cut across its own largest extent.
  bool order_groups(std::span<const NodeItem> items, std::uint64_t target, std::vector<float>& at) const {
    std::vector<std::pair<std::uint32_t, std::uint64_t>> masses;  // of runs of items of one group
    for (const NodeItem& item : items) {
      const std::uint32_t group = group_of(item);
      if (masses.empty() || masses.back().first != group) masses.emplace_back(group, 0);
      masses.back().second += item.mass;
    }
    if (masses.size() < 2) return false;
    std::sort(masses.begin(), masses.end());
    std::uint64_t below = 0;
    std::uint32_t crossed = masses.back().first;
    for (const auto& [group, mass] : masses) {
      below += mass;
      if (below <= target) continue;
      crossed = group;
      break;
    }
    ItemBox box;
    for (const NodeItem& item : items)
      if (group_of(item) == crossed) box.hold(item);
    const std::size_t axis = largest_extent(box).axis;
    at.resize(items.size());
    for (std::size_t i = 0; i < items.size(); ++i) {
      const std::uint32_t group = group_of(items[i]);
      at[i] = group < crossed ? -4 : group > crossed ? 4 : items[i].at[axis];
    }
    return true;
  }

  void finish_leaf(const Node& node, std::span<const NodeItem> items) {
    double sum[3] = {}, mass = 0;
    for (const NodeItem& item : items) {
      const auto m = static_cast<double>(item.mass);
      for (std::size_t k = 0; k < 3; ++k) sum[k] += m * static_cast<double>(item.at[k]);
      mass += m;
    }
    for (std::size_t k = 0; k < 3; ++k)
      tree_.center[node.number][k] = mass > 0 ? static_cast<float>(sum[k] / mass) : 0.0f;
    if (!group_.empty()) {
      group_[node.number] = items.empty() ? 0 : group_of(items.front());
      for (const NodeItem& item : items)
        if (group_of(item) != group_[node.number]) group_[node.number] = several_groups;
    }
    if (traits_.splits.empty()) {  // the items stay where they are
      const bool in_front = std::less_equal<>()(front_.data(), node.items) &&
                            std::less<>()(node.items, front_.data() + front_.size());
      const std::vector<NodeItem>& buffer = in_front ? front_ : back_;
      leaves_[node.first] = {in_front ? n_ : n_ + 1, static_cast<std::uint32_t>(items.size()),
                             static_cast<std::size_t>(node.items - buffer.data()), node.history};
      return;
    }
    std::vector<NodeItem>& kept = blocks_[node.block];
    leaves_[node.first] = {node.block, static_cast<std::uint32_t>(items.size()), kept.size(), node.history};
    kept.insert(kept.end(), items.begin(), items.end());
  }

  bool same_group(std::size_t a, std::size_t b) const {
    return group_.empty() || (group_[a] == group_[b] && group_[a] != several_groups);
  }

  // Appends the leaves of the node to the path, which comes from the node `from` and goes on to `to` (null:
  // it begins or ends here); returns the number of the last leaf's node.
  std::size_t visit(std::size_t node, std::uint32_t first, std::uint32_t leaves, const std::size_t* from,
                    const std::size_t* to) {
    if (leaves == 1) {
      path_.push_back({first, node});
      return node;
    }
    if (leaves > 65536) cancel_.check();
    const std::uint32_t low_leaves = tree_.cut[node].low_leaves;
    const std::size_t low = CutTree::low(node), high = tree_.high(node);
    float straight = 0, swapped = 0;
    if (from && same_group(*from, node)) {
      straight += distance(tree_.center[*from], tree_.center[low]);
      swapped += distance(tree_.center[*from], tree_.center[high]);
    }
    if (to && same_group(*to, node)) {
      straight += distance(tree_.center[*to], tree_.center[high]);
      swapped += distance(tree_.center[*to], tree_.center[low]);
    }
    if (swapped < straight && same_group(low, high)) {
      const std::size_t last = visit(high, first + low_leaves, leaves - low_leaves, from, &low);
      return visit(low, first, low_leaves, &last, to);
    }
    const std::size_t last = visit(low, first, low_leaves, from, &high);
    return visit(high, first + low_leaves, leaves - low_leaves, &last, to);
  }

  // The direction in which the path passes its r-th leaf.
  Point direction(std::size_t r) const {
    const std::size_t node = path_[r].node;
    const std::size_t before = r > 0 && same_group(path_[r - 1].node, node) ? path_[r - 1].node : node;
    const std::size_t after =
        r + 1 < path_.size() && same_group(path_[r + 1].node, node) ? path_[r + 1].node : node;
    Point d;
    for (std::size_t k = 0; k < 3; ++k) d[k] = tree_.center[after][k] - tree_.center[before][k];
    if (d[0] == 0 && d[1] == 0 && d[2] == 0) {  // alone: along its largest extent
      const Leaf& leaf = leaves_[path_[r].leaf];
      d[largest_extent(std::span<const NodeItem>(blocks_[leaf.block]).subspan(leaf.first, leaf.count)).axis] =
          1;
    }
    return d;
  }

  BalancedCells collect() {
    BalancedCells cells;
    cells.cell.resize(path_.size());
    cells.unit = units_.from;
    parallel_blocks(path_.size(), sum_block, [&](std::size_t from, std::size_t to) {
      cancel_.check();
      for (std::size_t r = from; r < to; ++r) {
        const Leaf& leaf = leaves_[path_[r].leaf];
        cells.cell[r] = {leaf.block, leaf.count, leaf.first, direction(r), path_[r].leaf, leaf.history};
      }
    });
    if (!points_.empty()) {
      cells.point.resize(path_.size());
      for (std::size_t r = 0; r < path_.size(); ++r) cells.point[r] = points_[path_[r].leaf];
    }
    cells.block = std::move(blocks_);
    cells.polygon = std::move(polygons_);
    cells.cut = std::move(tree_.cut);
    if (!group_.empty()) order_mixed(cells);
    return cells;
  }

  // Entries of cells with several groups: in order, group by group.
  void order_mixed(BalancedCells& cells) const {
    std::vector<std::uint32_t> order;
    for (std::size_t r = 0; r < path_.size(); ++r) {
      if (group_[path_[r].node] != several_groups) continue;
      Cell& cell = cells.cell[r];
      order_entries(cells, cell, order);
      const std::span<NodeItem> entries =
          std::span(cells.block[cell.block]).subspan(cell.first, cell.entries);
      const std::vector<NodeItem> old(entries.begin(), entries.end());
      std::stable_sort(order.begin(), order.end(),
                       [&](std::uint32_t a, std::uint32_t b) { return group_of(old[a]) < group_of(old[b]); });
      for (std::size_t i = 0; i < old.size(); ++i) entries[i] = old[order[i]];
      cell.direction = {};
    }
  }

  struct Step {
    std::uint32_t leaf;
    std::size_t node;
  };

  std::uint32_t n_;
  std::uint64_t shares_;
  std::size_t count_;
  std::span<const MassPoint> elements_;
  const ElementTraits& traits_;
  const ExactTriangles* exact_;
  const CancelToken& cancel_;
  double mass_ = 0;          // of all elements
  std::uint64_t total_ = 0;  // likewise, in units
  MassUnits units_;
  RankedBits split_number_;                    // of elements that are split
  std::vector<MassPoint> split_point_;         // by that number: the elements may be gone by now
  std::vector<NodeItem> front_, back_;         // a node's items are in one, its halves' in the other
  std::vector<std::vector<NodeItem>> blocks_;  // by first leaf: the items of a block's leaves; at n and
  // n + 1 all, where none are taken apart
  std::vector<Leaf> leaves_;       // by place in the tree, as
  std::vector<CellPoint> points_;  // those of cells that are cut exactly, or, by block,
  std::vector<CellPolygons> polygons_;
  CutTree tree_;
  std::vector<std::uint32_t> group_;  // by node: that all its elements belong to, or several_groups
  std::vector<Step> path_;
};

// Entries by their places along the direction of a cell, with their numbers.
void lay_out(std::span<const CellEntry> entries, const Point& d, std::vector<std::uint64_t>& row) {
  row.resize(entries.size());
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const float* at = entries[i].at;
    row[i] = row_entry(d[0] * at[0] + d[1] * at[1] + d[2] * at[2], i);
  }
}

std::uint64_t checked_shares(std::uint64_t shares, std::uint32_t n) {
  if (shares == 0) return n;
  if (shares < n || shares > std::numeric_limits<std::uint32_t>::max())
    throw std::invalid_argument("balanced_order: shares are fewer than cells, or more than 2^32 - 1");
  return shares;
}

}  // namespace

BalancedCells balanced_order(std::vector<MassPoint> elements, std::uint32_t n, const ElementTraits& traits,
                             const CancelToken& cancel, std::uint64_t shares) {
  Bisection bisection(elements, n, checked_shares(shares, n), traits, nullptr, cancel);
  elements = std::vector<MassPoint>();
  return *bisection.cells();
}

std::optional<BalancedCells> exact_order(std::span<const MassPoint> elements, std::uint32_t n,
                                         const ElementTraits& traits, const ExactTriangles& exact,
                                         const CancelToken& cancel) {
  return Bisection(elements, n, n, traits, &exact, cancel).cells();
}

const CellEntry& entry_at(const BalancedCells& cells, const Cell& cell, double share,
                          std::vector<std::uint64_t>& scratch) {
  const std::span<const CellEntry> entries = cells.entries(cell);
  lay_out(entries, cell.direction, scratch);
  std::uint64_t total = 0;
  for (const CellEntry& entry : entries) total += entry.mass;
  const auto target = std::min(static_cast<std::uint64_t>(share * static_cast<double>(total)), total - 1);
  const SelectedEntry found =
      select_by_mass(scratch, target, [&](std::uint64_t entry) { return entries[number_of(entry)].mass; });
  return entries[number_of(scratch[found.place])];
}

void order_entries(const BalancedCells& cells, const Cell& cell, std::vector<std::uint32_t>& order) {
  std::vector<std::uint64_t> row;
  lay_out(cells.entries(cell), cell.direction, row);
  std::sort(row.begin(), row.end());
  order.clear();
  for (const std::uint64_t entry : row) order.push_back(number_of(entry));
}

}  // namespace meander
