#include "jobs/remesh_options.h"

#include <fmt/format.h>

#include "jobs/input_options.h"
#include "jobs/option_words.h"

namespace meander {

namespace {

constexpr Word<MeshFormat> format_words[] = {
    {"ply", MeshFormat::ply}, {"off", MeshFormat::off}, {"obj", MeshFormat::obj}};

void add_mesh_options(Command mesh, RemeshOptions& options) {
  ParameterTable& table = options.texts.table;
  RemeshParameters& parameters = options.mesh;
  table.add(mesh, "format", "--format", options.format, format_words, "Of the files that are written");
  table
      .add(mesh, "crease_angle", "--crease-angle", parameters.lines.crease_angle,
           "Edges with this angle or more between their triangles stay edges, 1 to 180 degrees; 180: none")
      .range(1.0, 180.0);
  table.add(mesh, "fit", "--fit", parameters.fit,
            "Flip edges and move the samples along their normals, so that the mesh is nearer to the surface, "
            "and onto "
            "creases beside them");
}

}  // namespace

void add_remesh_command(Command& program, RemeshOptions& options) {
  Command command = program.add_subcommand(
      "remesh", "Write a mesh for every model of the input whose vertices are its samples");
  command
      .add_option("INPUT", options.run.inputs,
                  "Mesh files, folders, @list.txt, - (paths on standard input), .cla files")
      .required();
  command.add_option("-o,--output", options.run.store, "The folder to write to, created if missing")
      .required();
  // Samples that keep their distance make better triangles.
  options.run.sample.place.sequence = SequenceKind::spaced;
  options.run.compression = Compression::none;
  add_mesh_options(command.under("Mesh"), options);
  add_value_options(command.under("Mesh"), options.run, options.texts, "Write", "at the vertices");
  add_point_options(command.under("Points"), options.run, options.texts);
  Command collection = command.under("Collection");
  add_list_options(collection, options.run.collect);
  Command running = command.under("Running");
  add_budget_options(running, options.run, options.texts);
  running.add_flag("--fresh", options.run.fresh, "Make all meshes anew; files of their names are replaced");
  add_progress_options(command.under("Report"), options.run);
}

void resolve_remesh_options(RemeshOptions& options) {
  resolve_run_options(options.run, options.texts, nullptr);
  if (options.run.sample.place.normalize != NormalizeKind::none)
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
  return {sample.colors, sample.texcoord, sample.attributes};
}

const char* extension_of(MeshFormat format) {
  return format == MeshFormat::ply ? ".ply" : format == MeshFormat::off ? ".off" : ".obj";
}

}  // namespace meander
