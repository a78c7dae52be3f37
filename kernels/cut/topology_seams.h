// The seams that topology needs: after them a component is a disk, or a closed sphere.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/cut/seam_graph.h"

namespace meander {

// Interior half-edges (one of each pair) along which to cut so that handles open and all boundary loops join.
// Empty for spheres and disks. Tree-cotree (Eppstein 2003, "Dynamic generators of topologically embedded
// graphs"; Erickson and Whittlesey 2005): a shortest-path tree over vertices, every boundary loop one node, a
// maximum spanning tree of the dual over the other edges, and the edges in neither, pruned of dead ends.
// Cost: O(T), with handles O(T log T).
std::vector<std::uint32_t> find_topology_seams(const SeamGraph& graph, const CancelToken& cancel);

// V - E + F of the graph.
std::int64_t euler_characteristic(const SeamGraph& graph);

}  // namespace meander
