#include "kernels/solve/elimination_order.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

namespace meander {

std::vector<std::uint32_t> elimination_order(const UnknownGraph& graph) {
  using Pattern = Eigen::SparseMatrix<float, Eigen::ColMajor, int>;
  const auto n = static_cast<Eigen::Index>(graph.count());
  std::vector<std::uint32_t> order(graph.count());
  if (n == 0) return order;
  // Fills the upper triangle; the view below represents the whole matrix.
  Pattern pattern(n, n);
  pattern.resizeNonZeros(static_cast<Eigen::Index>(graph.neighbors.size() / 2 + graph.count()));
  int filled = 0;
  for (std::uint32_t i = 0; i < graph.count(); ++i) {
    pattern.outerIndexPtr()[i] = filled;
    for (std::uint32_t e = graph.begin[i]; e < graph.begin[i + 1]; ++e)
      if (graph.neighbors[e] < i) pattern.innerIndexPtr()[filled++] = static_cast<int>(graph.neighbors[e]);
    pattern.innerIndexPtr()[filled++] = static_cast<int>(i);
  }
  pattern.outerIndexPtr()[n] = filled;
  pattern.resizeNonZeros(filled);
  std::fill_n(pattern.valuePtr(), filled, 1.0f);
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  Eigen::AMDOrdering<int>()(pattern.selfadjointView<Eigen::Upper>(), permutation);
  for (std::size_t k = 0; k < order.size(); ++k)
    order[k] = static_cast<std::uint32_t>(permutation.indices()[static_cast<Eigen::Index>(k)]);
  return order;
}

}  // namespace meander
