#include "kernels/partition/exact_cells.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "kernels/core/parallel.h"
#include "kernels/core/random.h"
#include "kernels/partition/mass_units.h"
#include "kernels/partition/net_digits.h"
#include "kernels/partition/sheet_cut.h"

namespace meander {

namespace {

// Nodes of at least so many leaves are worked on by other threads too.
constexpr std::uint32_t parallel_leaves = 4096;

using Point = ClippedPieces::Point;

struct ExactNode {
  std::size_t number;
  std::uint32_t first, leaves;  // by place in the tree
  ClippedPieces::List pieces;
  CutHistory history;
};

class ExactBisection {
 public:
  ExactBisection(std::span<const MassPoint> elements, double total, std::uint32_t n,
                 const ElementTraits& traits, const ExactTriangles& exact, const CancelToken& cancel)
      : traits_(traits),
        exact_(exact),
        shift_(digital_shift(exact.key)),
        cancel_(cancel),
        cells_{CutTree(n), std::vector<CutHistory>(n), {}, {}, {}, {}} {
    if (keeps_polygons()) {
      cells_.entries.resize(n);
      cells_.block.resize(n);
      cells_.polygon.resize(n);
    } else {
      cells_.point.resize(n);
    }
    ClippedPieces pieces;
    const MassPoint& middle = elements[elements.size() / 2];
    pieces.begin({middle.at[0], middle.at[1], middle.at[2]}, elements.size(), room_of(n));
    // The total is near one: masses over lengths are in the range of float.
    const MassUnits units(total);
    double mass = 0;
    for (std::uint32_t e = 0; e < elements.size(); ++e) {
      const double share = 0x1p-61 * units.of(elements[e].mass);
      pieces.add(exact_.corners(e), share, e);
      mass += share;
    }
    cell_mass_ = mass / n;
    SheetScratch sheets;
    cut({0, 0, n, pieces.all(), {}}, pieces, sheets, 0);
    if (n < parallel_leaves) close_block(0);
  }

  // None where there are more polygons than may be kept.
  std::optional<ExactCells> cells() {
    if (is_abandoned_) return std::nullopt;
    return std::move(cells_);
  }

 private:
  bool keeps_polygons() const { return exact_.max_polygons > 0; }

  // `block`: that of the entries of cells below.
  void cut(const ExactNode& node, ClippedPieces& pieces, SheetScratch& sheets, std::uint32_t block) {
    if (is_abandoned_.load(std::memory_order_relaxed)) return;
    const ClippedPieces::Extent extent = pieces.extent_of(node.pieces);
    if (node.leaves == 1) {
      cells_.tree.center[node.number] = pieces.center(extent);
      cells_.history[node.first] = node.history;
      if (keeps_polygons())
        keep_entries(node, pieces, block);
      else
        cells_.point[node.first] = net_point(node, extent, pieces);
      return;
    }
    if (node.leaves >= parallel_leaves) cancel_.check();
    const ClippedPieces::Mark mark = pieces.mark();
    ExactNode low = node, high = node;
    const bool by_sheets = cut_sheets(node, extent, pieces, sheets, low, high);
    if (!by_sheets) {
      low.leaves = lower_leaves(node.leaves);
      const double target = extent.mass * low.leaves / node.leaves;
      std::tie(low.pieces, high.pieces) = pieces.cut(node.pieces, extent, target, cell_mass_);
      low.history.cut(extent.axis, false);
      high.history.cut(extent.axis, true);
    }
    low.number = CutTree::low(node.number);
    high.number = CutTree::high(node.number, low.leaves);
    high.first = node.first + low.leaves;
    high.leaves = node.leaves - low.leaves;
    const ExactNode* const children[2] = {&low, &high};
    if (node.leaves >= parallel_leaves) {  // as all nodes above: the pieces are its own
      ClippedPieces halves[2];
      for (std::size_t i = 0; i < 2; ++i)
        halves[i].take(pieces, children[i]->pieces, room_of(children[i]->leaves));
      pieces = ClippedPieces();
      parallel_tasks(2, [&](std::size_t i) {
        ClippedPieces own = std::move(halves[i]);
        SheetScratch own_sheets;
        ExactNode child = *children[i];
        child.pieces = own.all();
        cut(child, own, own_sheets, child.first);
        if (child.leaves < parallel_leaves) close_block(child.first);
      });
    } else {
      for (const ExactNode* const child : children) cut(*child, pieces, sheets, block);
      pieces.release(mark);
    }
    cells_.tree.join(
        node.number, node.leaves,
        {low.leaves, by_sheets ? TreeCut::between_parts : static_cast<std::uint8_t>(extent.axis)});
  }

  // Cuts a node that is a stack of sheets between these; false if it is none.
  bool cut_sheets(const ExactNode& node, const ClippedPieces::Extent& extent, ClippedPieces& pieces,
                  SheetScratch& sheets, ExactNode& low, ExactNode& high) const {
    if (node.leaves < least_stack || traits_.normal.empty()) return false;
    const auto normal_here = [&](std::uint32_t name) {
      const float* n = &traits_.normal[3 * std::size_t{traits_.triangle[name]}];
      return ClippedPieces::turned({n[0], n[1], n[2]});
    };
    const auto look = [&](std::size_t probes) {
      sheets.probes.clear();
      pieces.probe(node.pieces, extent.mass, probes, [&](const Point& at, std::uint32_t name) {
        sheets.probes.push_back({at, normal_here(name)});
      });
    };
    look(few_sheet_probes);
    if (!may_be_stack(sheets, node.leaves)) return false;
    look(many_sheet_probes);
    const std::optional<SheetCut> cut = find_sheet_cut(sheets, node.leaves);
    if (!cut) return false;
    const auto [below, above] = pieces.part(node.pieces, [&](const Point& at, std::uint32_t name) {
      return cut->is_above(at, normal_here(name));
    });
    // The halves get as many leaves as their masses ask for; what one has too much is cut off.
    const ClippedPieces::Extent lower = pieces.extent_of(below), upper = pieces.extent_of(above);
    const auto wanted = static_cast<std::uint32_t>(std::lround(lower.mass / extent.mass * node.leaves));
    if (wanted == 0 || wanted >= node.leaves) return false;
    low.leaves = wanted;
    const double target = extent.mass * wanted / node.leaves;
    if (lower.mass > target) {
      const auto [kept, rest] = pieces.cut(below, lower, target, cell_mass_);
      low.pieces = kept;
      high.pieces = pieces.joined(rest, above);
    } else {
      const auto [more, rest] = pieces.cut(above, upper, target - lower.mass, cell_mass_);
      low.pieces = pieces.joined(below, more);
      high.pieces = rest;
    }
    return true;
  }

  // Nodes of many leaves are cut once, then their halves are copied.
  static ClippedPieces::Room room_of(std::uint32_t leaves) {
    return leaves < parallel_leaves ? ClippedPieces::Room::tree : ClippedPieces::Room::one_cut;
  }

  // A cell of nothing is one too many: that can only be rounding.
  void keep_entries(const ExactNode& leaf, const ClippedPieces& pieces, std::uint32_t block) {
    std::vector<CellEntry>& entries = cells_.block[block];
    CellPolygons& polygons = cells_.polygon[block];
    const std::size_t first = entries.size();
    pieces.visit(leaf.pieces, [&](const ClippedPieces::Part& part) {
      const auto mass = static_cast<std::uint64_t>(std::llround(part.mass * 0x1p61));
      if (mass == 0) return;
      entries.push_back({{part.at[0], part.at[1], part.at[2]}, part.name << 3 | 1, mass});
      for (std::size_t k = 0; k < part.first.size(); ++k)
        polygons.corner.push_back({part.first[k], part.second[k]});
      polygons.end.push_back(static_cast<std::uint32_t>(polygons.corner.size()));
    });
    const std::size_t count = entries.size() - first;
    cells_.entries[leaf.first] = {block, static_cast<std::uint32_t>(count), first};
    if (count == 0 || kept_.fetch_add(count) + count > exact_.max_polygons) is_abandoned_ = true;
  }

  // No more is added to it: vectors that have grown may be twice as long as what they hold.
  void close_block(std::uint32_t block) {
    if (!keeps_polygons()) return;
    cells_.block[block].shrink_to_fit();
    cells_.polygon[block].end.shrink_to_fit();
    cells_.polygon[block].corner.shrink_to_fit();
  }

  CellPoint net_point(const ExactNode& leaf, const ClippedPieces::Extent& extent,
                      ClippedPieces& pieces) const {
    const PhiloxBlock words = random_words(exact_.key, Stream::sequence, exact_.first_cell + leaf.first);
    const auto share = [&](std::size_t across, std::uint32_t rest) {
      return CellDigits(leaf.history, shift_, across).share(unit_double(rest, 0));
    };
    const std::size_t along = pieces.cross(leaf.pieces, extent, share(extent.axis, words[0]));
    return pieces.point(share(along, words[1]), unit_double(words[2], 0));
  }

  const ElementTraits& traits_;
  const ExactTriangles& exact_;
  DigitalShift shift_;
  const CancelToken& cancel_;
  double cell_mass_ = 0;
  std::atomic<std::uint64_t> kept_ = 0;  // polygons of cells
  std::atomic<bool> is_abandoned_ = false;
  ExactCells cells_;
};

}  // namespace

std::optional<ExactCells> cut_exactly(std::span<const MassPoint> elements, double total, std::uint32_t n,
                                      const ElementTraits& traits, const ExactTriangles& exact,
                                      const CancelToken& cancel) {
  return ExactBisection(elements, total, n, traits, exact, cancel).cells();
}

}  // namespace meander
