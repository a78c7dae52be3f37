// What a remeshed model takes at its peak, measured, against what is reserved for it.

#include "io/mesh/mesh_writer.h"
#include "jobs/remesh/remesh_stages.h"
#include "pipeline/memory_estimate.h"
#include "support/allocation_counter.h"
#include "support/catch.h"
#include "support/mesh_files.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

TEST_CASE("remesh memory: no model takes more than is reserved for it") {
  if (!counts_allocations()) {
    WARN("skipped: this build does not count allocations");
    return;
  }
  const ScratchFolder scratch;
  write_mesh(scratch / "ball.off", icosphere(5));
  write_mesh(scratch / "plate.off", two_sided_plate(40, 0.01));
  PolygonMesh soup = cube();
  for (int i = 0; i < 300; ++i) soup = merged(soup, moved(tetrahedron(), 0.5, 3.0 * i, 0, 0));
  write_mesh(scratch / "soup.off", soup);
  for (const char* name : {"ball.off", "plate.off", "soup.off"})
    for (const std::uint32_t samples : {100u, 20000u})
      for (const bool fit : {false, true}) {
        // Values are carried in the one or in the other, so that both are measured.
        const CarriedColumns carried =
            fit ? CarriedColumns{} : CarriedColumns{true, true, {{"a", 1}, {"b", 4}}};
        INFO(name << ", " << samples << " samples" << (fit ? ", fitted" : ""));
        SampleParameters parameters;
        parameters.sequence = SequenceKind::spaced;
        parameters.columns[&Samples::rgb] = carried.colors;
        parameters.columns[&Samples::texcoord] = carried.texcoord;
        parameters.attributes = carried.attributes;
        parameters.samples = samples;
        RemeshParameters wanted;
        wanted.fit = fit;
        PlanItem plan;
        plan.path = scratch / name;
        plan.id = name;
        GraphParameters graph;
        graph.sample = parameters;
        bool made = false;
        GraphStages stages = sampling_stages(parameters, nullptr);
        add_remesh_stages(stages, parameters, wanted, carried,
                          [&](const PlanItem&, const RemeshedSurface& mesh, const CarriedValues& values) {
                            write_mesh(scratch / "out.ply", MeshFormat::ply, mesh.x, mesh.y, mesh.z,
                                       mesh.triangles, values.view());
                            made = true;
                          });
        const std::int64_t before = allocated_bytes();
        reset_peak();
        run_item_alone(plan, graph, stages, [](std::string_view) {});
        const std::int64_t taken = peak_allocated_bytes() - before;
        const MeshEstimate mesh = peek_mesh(plan.path, plan.format);
        CHECK(made);
        CHECK(static_cast<std::uint64_t>(taken) <=
              estimate_bytes(mesh, parameters, 1) + remesh_bytes(mesh, samples, fit, carried));
      }
}
