#include "jobs/remesh/remesh_options.h"

#include <fmt/format.h>

#include "jobs/cli/option_words.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/input_options.h"

namespace meander {

namespace {

constexpr Word<MeshFormat> format_words[] = {
    {"ply", MeshFormat::ply}, {"off", MeshFormat::off}, {"obj", MeshFormat::obj}};

using RemeshSettings = SettingList<RemeshOptions>;

const RemeshSettings& mesh_settings() {
  static const RemeshSettings list = [] {
    RemeshSettings made;
    made.under("Mesh");
    made.word(
            "format", "--format", [](auto& options) -> auto& { return options.format; }, format_words,
            "Of the files that are written")
        .common();
    made.number(
        "crease_angle", "--crease-angle",
        [](auto& options) -> auto& { return options.mesh.lines.crease_angle; }, 1, 180,
        "Edges with this angle or more between their triangles stay edges, 1 to 180 degrees; 180: none");
    made.flag(
            "fit", "--fit", [](auto& options) -> auto& { return options.mesh.fit; },
            "Flip edges and move the samples along their normals, so that the mesh is nearer to the surface, "
            "and onto creases beside them")
        .common();
    return made;
  }();
  return list;
}

}  // namespace

Command add_remesh_command(Command& program, RemeshOptions& options) {
  Command command = program.add_subcommand(
      "remesh", "Write a mesh for every model of the input whose vertices are its samples");
  command.example("meander remesh models/ -o remeshed -n 5000 --fit", "PLY files of 5,000 vertices each");
  command.example("meander remesh bunny.obj -o remeshed -n 2000 --format obj", "One mesh as OBJ");
  command
      .add_option("INPUT", options.run.inputs,
                  "Mesh files, folders, @list.txt, - (paths on standard input), .cla files")
      .required();
  command.add_option("-o,--output", options.run.store, "The folder to write to, created if missing")
      .required();
  // Samples that keep their distance make better triangles.
  options.run.sample.sequence = SequenceKind::spaced;
  options.run.compression = Compression::none;
  SettingOptions& settings = options.texts.settings;
  settings.add(command, mesh_settings(), options);
  settings.add(command, point_settings(), options.run.sample);
  settings.add(command, value_settings(), options.run.sample);
  Command collection = command.under("Collection");
  add_list_options(collection, options.run.collect);
  Command running = command.under("Running");
  add_limit_options(running, options.run);
  running.add_flag("--fresh", options.run.fresh, "Make all meshes anew; files of their names are replaced");
  add_progress_options(command.under("Report"), options.run);
  return command;
}

void resolve_remesh_options(RemeshOptions& options) {
  resolve_run_options(options.run, options.texts, nullptr);
  std::vector<std::string> problems;
  check_ranges(mesh_settings(), options, problems);
  if (!problems.empty()) throw UsageError(problems.front());
  RecordedSettings recorded;
  record(mesh_settings(), options, recorded);
  for (const SampleSettings* const list : {&point_settings(), &value_settings(), &chart_constants()})
    record(*list, options.run.sample, recorded);
  options.run.parameters_json = json_of(std::move(recorded));
  if (options.run.sample.normalize != NormalizeKind::none)
    throw UsageError("--normalize: meshes have the coordinates of their files");
  if (reads_textures(options.run.sample.density.kind))
    throw UsageError("--density texture: remeshing places no samples by the images of models");
  const CarriedColumns carried = carried_columns(options);
  for (const AttributeColumn& column : carried.attributes)
    if (column.is_classes())
      throw UsageError(fmt::format(
          "--attribute: `{}:class` is for stores: meshes keep the integers of their files as they are",
          column.name));
  if (const std::string problem = written_values_problem(options.format, carried.colors, carried.texcoord,
                                                         attribute_properties(carried.attributes));
      !problem.empty())
    throw UsageError("--format, --attribute: " + problem);
}

CarriedColumns carried_columns(const RemeshOptions& options) {
  const SampleParameters& sample = options.run.sample;
  return {sample.columns[&Samples::rgb], sample.columns[&Samples::texcoord], sample.attributes};
}

}  // namespace meander
