// meander measure measures the quality of point sets of any origin.
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "io/file/atomic_file.h"
#include "io/json_writer.h"
#include "io/mesh/point_reader.h"
#include "io/table/table.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/output_guard.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/store_items.h"
#include "jobs/laboratory/commands.h"
#include "jobs/laboratory/measure_tables.h"

namespace meander {

namespace {

struct Measure {
  const char* name;
  const char* help;
  Table (*table)(PointSets&, MeasuredSurfaces&, const MeasureOptions&);
  bool draws, shapes, random;  // which of --picture, --shapes, --seed apply
};
constexpr Measure measures[] = {
    {"boxes",
     "error over random rotated boxes, relative to random points, and the least that is known to be possible "
     "(meshes)",
     measure_boxes, false, true, true},
    {"rings", "discrepancy over patches grown ring by ring, as Quinn et al. 2013 (meshes)", measure_rings,
     false, true, true},
    {"spacing",
     "nearest-neighbor distances, rho, coverage radius, largest hole, Chamfer distance (plane, meshes)",
     measure_spacing, false, false, true},
    {"modes",
     "error of the integrals of the lowest eigenfunctions of the Laplacian, relative to random points "
     "(meshes)",
     measure_modes, false, true, false},
    {"discrepancy", "over boxes, triangles, quarter circles (plane); caps, triangles (sphere)",
     measure_discrepancy, false, true, true},
    {"integral", "integration error by number of points, and its slope (plane, meshes)", measure_integral,
     false, false, false},
    {"spectrum", "radially averaged power and anisotropy, mean of all sets (plane)", measure_spectrum, true,
     false, false},
    {"differences",
     "differential domain analysis, mean of all sets, of any density or tensor field (plane, meshes)",
     measure_differences, true, false, true},
    {"distance", "mean, RMS and maximum distance between two meshes, in both directions", nullptr, false,
     false, true},
};

void check_outputs(const MeasureOptions& options) {
  OutputGuard guard;
  for (const std::string& input : options.inputs) {
    guard.protect(input);
    guard.protect(input.substr(0, input.find("::")));  // FILE.h5::ITEM
  }
  guard.protect(options.surface);
  guard.check(options.csv, {FileKind::csv}, "--csv");
  guard.check(options.picture, {FileKind::png}, "--picture");
}

int measure(const MeasureOptions& options) {
  const Measure& chosen = *std::find_if(std::begin(measures), std::end(measures),
                                        [&](const Measure& m) { return options.what == m.name; });
  if (!options.picture.empty() && !chosen.draws)
    throw UsageError("measure " + options.what + " has no picture: leave --picture out");
  if (options.samples > 0 && chosen.table != nullptr)
    throw UsageError("measure " + options.what + " measures the given points: leave --samples out");
  if (options.seed_given && !chosen.random)
    throw UsageError("measure " + options.what + " uses no random numbers: leave --seed out");
  if (options.shapes > 0 && !chosen.shapes)
    throw UsageError("measure " + options.what + " has no shapes: leave --shapes out");
  check_outputs(options);
  Table table;
  if (chosen.table == nullptr) {
    if (!options.surface.empty()) throw UsageError("measure distance takes two meshes: leave --surface out");
    table = measure_distance(options);
  } else {
    if (options.surface.empty())
      throw UsageError("measure " + options.what +
                       " needs --surface: plane, sphere, a mesh file, or the folder of a store's models");
    PointSets sets(options.inputs, options.check);
    MeasuredSurfaces surfaces(options.surface);
    table = chosen.table(sets, surfaces, options);
  }
  if (!options.csv.empty()) replace_file(options.csv, csv_text(table));
  if (options.json) {
    fmt::print("{}\n", json_object([&](JsonWriter& json) {
                 json.member("measure", options.what);
                 json.member("surface", options.surface);
                 json.member("seed", options.seed);
                 json.key("results");
                 write_table(json, table);
               }));
  } else {
    fmt::print("{}", text_table(table));
  }
  return exit_done;
}

}  // namespace

JobFunction add_measure_job(Command& program) {
  Command command = program.add_subcommand("measure", "Measure the quality of point sets from any source");
  command.example("meander measure boxes theirs.ply store.h5 --surface bunny.off",
                  "Your points beside those of a store, over the same boxes");
  command.example("meander measure distance before.ply after.ply", "How far two meshes are apart");
  auto options = std::make_shared<MeasureOptions>();
  std::vector<std::string> names;
  std::string help = "The measure:";
  for (const Measure& m : measures) {
    names.push_back(m.name);
    help += fmt::format("\n  {}: {}", m.name, m.help);
  }
  command.add_option("WHAT", options->what, help).required().one_of(names);
  command
      .add_option("INPUT", options->inputs,
                  "Stores (FILE.h5: all ok items, FILE.h5::ITEM: one), point files (" + point_extensions() +
                      "); two meshes for distance")
      .required();
  command.add_option("--surface", options->surface,
                     "Surface of the points: plane (unit square), sphere (unit sphere), a mesh file, or the "
                     "folder of a store's models");
  command
      .add_option(
          "--shapes", options->shapes,
          "Number of test shapes, 1 to 200000 (default: 1000 boxes, 256 ring seeds, 30 modes, 4096 planar "
          "shapes, 200 cap axes)")
      .range(1, 200000);
  command.add_option("--seed", options->seed, "Seed of test shapes and reference points").show_default();
  command
      .add_option("--samples", options->samples, "distance: points on each mesh, 1 to 10^9 (default 100000)")
      .range(1.0, 1e9);
  command.add_option("--csv", options->csv, "Also write the table to this CSV file");
  command.add_option("--picture", options->picture, "spectrum, differences: PNG file for the map");
  command.add_flag("--json", options->json, "Print the table as JSON");
  add_trust_option(command, options->check);
  return [options, command] {
    options->seed_given = command.given("--seed");
    return measure(*options);
  };
}

}  // namespace meander
