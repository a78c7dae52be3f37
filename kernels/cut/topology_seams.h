// The seams that topology needs: they open a component to a disk, or leave a closed sphere as it is.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/cut/seam_graph.h"

namespace meander {

// Interior half-edges (one of each pair) to cut along so that handles open and all boundary loops join. Empty
// for spheres and disks. Tree-cotree (Eppstein 2003, "Dynamic generators of topologically embedded graphs";
// Erickson and Whittlesey 2005): a shortest-path tree over vertices with every boundary loop as one node, a
// maximum spanning tree of the dual over the other edges, and the edges in neither, pruned of dead ends.
// O(T), with handles O(T log T). Throws ItemError(internal) where the component is not a surface.
std::vector<std::uint32_t> find_topology_seams(const SeamGraph& graph, const CancelToken& cancel);

// V - E + F of the graph.
std::int64_t euler_characteristic(const SeamGraph& graph);

}  // namespace meander
