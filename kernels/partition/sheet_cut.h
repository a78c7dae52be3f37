// Where a thin stack of sheets is to be cut: between the sides that face different ways, or between layers
// that face the same way (docs/METHODS.md 6.5).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace meander {

// Elements looked at: to see whether there may be a stack at all, and, where there may, to cut it.
inline constexpr std::size_t few_sheet_probes = 32, many_sheet_probes = 128;

// Nodes of fewer samples are not looked at: a stack thin against its cells shows above.
inline constexpr std::uint32_t least_stack = 16;

struct SheetProbe {
  std::array<float, 3> at;
  std::array<float, 3> normal;
};

// At most many_sheet_probes of them, by coordinate: four are worked on at once.
class SheetProbes {
 public:
  using Column = std::array<float, many_sheet_probes + 3>;
  void clear() { count_ = 0; }
  void push_back(const SheetProbe& probe) {
    for (std::size_t k = 0; k < 3; ++k) {
      at[k][count_] = probe.at[k];
      normal[k][count_] = probe.normal[k];
    }
    ++count_;
  }
  std::size_t size() const { return count_; }
  SheetProbe operator[](std::size_t i) const {
    return {{at[0][i], at[1][i], at[2][i]}, {normal[0][i], normal[1][i], normal[2][i]}};
  }

  std::array<Column, 3> at{}, normal{};

 private:
  std::size_t count_ = 0;
};

// Those on one side of a cut, by their places within the sheets and their heights across them.
struct FlatProbes {
  SheetProbes::Column u{}, v{}, height{};
  std::size_t count = 0;
};

struct SheetScratch {
  SheetProbes probes;
  SheetProbes::Column height{};
  FlatProbes above, below;
};

// An element is above the cut if its normal (sides) or its centroid (layers) is beyond `threshold` along
// `direction`.
struct SheetCut {
  std::array<float, 3> direction{};
  float threshold = 0;
  bool by_normal = false;
  bool is_above(const std::array<float, 3>& at, const std::array<float, 3>& normal) const {
    const std::array<float, 3>& v = by_normal ? normal : at;
    return direction[0] * v[0] + direction[1] * v[1] + direction[2] * v[2] > threshold;
  }
};

// Whether the probes look like a stack of sheets. Sides: the normals' covariance has an eigenvalue l > 0.3,
// and along its direction the positions vary by less than a quarter of l times their second largest
// eigenvalue. Layers: the normals agree, the positions vary as little along their mean, and leave a clear gap
// there. And neither the distance between neighbors within the sheets nor that across them is far beyond
// what find_sheet_cut allows: so few probes know both, squared, to a factor of two. Pure. O(P^2). False for
// fewer than 8 probes.
bool may_be_stack(SheetScratch& scratch, std::uint32_t leaves);

// The cut, if it really is a stack and closer than a third of a sample's width, when `leaves` samples share
// the node: the elements of one part have near neighbors in the other, off them across the stack. Patches
// beside each other, or faces of one flat sheet that are turned differently, are no stack. Pure. O(P^2).
std::optional<SheetCut> find_sheet_cut(SheetScratch& scratch, std::uint32_t leaves);

}  // namespace meander
