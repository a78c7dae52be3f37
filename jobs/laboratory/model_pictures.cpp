#include "jobs/laboratory/model_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <span>

#include "io/archive/model_bytes.h"
#include "io/mesh/mesh_reader.h"
#include "jobs/laboratory/picture_options.h"
#include "kernels/core/joined_texts.h"
#include "kernels/core/parallel.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/query/sharp_edges.h"
#include "kernels/render/picture_camera.h"
#include "kernels/render/sampled_surface.h"
#include "kernels/render/splat_picture.h"
#include "kernels/sample/point_frames.h"

namespace meander {

namespace {

constexpr SrgbColor plain_color = {196, 62, 28};
constexpr Rgb quiet_note{120, 120, 120}, warning_note{176, 92, 20};
// The memory of surface_picture, nine fine pixels of depth, light, normal, color and nearest disc for each
// pixel; draw_splats takes less.
constexpr std::uint64_t bytes_per_pixel = 9 * 28, bytes_per_triangle = 500, bytes_per_drawn_sample = 250;

std::size_t drawn_count(const Row& row, const ModelLook& look) {
  const std::size_t count = row.samples.count();
  return look.points == 0 ? count : std::min<std::size_t>(count, look.points);
}

struct PicturedRow : Row {
  std::int32_t label = -1;
};

std::vector<SrgbColor> row_colors(const PicturedRow& row, const ColorScale& scale, const ModelLook& look) {
  return colors_of(row.samples, row.label, drawn_count(row, look), look.color, scale,
                   look.style == SampleStyle::splats ? splat_color : plain_color);
}

// Discs are smaller where the samples are denser.
std::vector<double> radii_of(const Row& row, double area, const ModelLook& look) {
  const std::size_t count = drawn_count(row, look);
  const double mean_density = row.report.area > 0 ? row.report.measure / row.report.area : 1;
  const double plain = look.disc * std::sqrt(area / static_cast<double>(std::max<std::size_t>(count, 1)));
  std::vector<double> radii(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double relative = row.samples.density[i] / mean_density;
    radii[i] = plain / std::sqrt(std::isfinite(relative) && relative > 0 ? relative : 1.0);
  }
  return radii;
}

SurfacePictureParameters surface_look(const ModelLook& look) {
  SurfacePictureParameters parameters;
  parameters.size = look.size;
  parameters.view = look.view;
  parameters.up = look.up;
  return parameters;
}

// The area of the surface, limited to that of its box, which no convex surface in the box exceeds: if sheets
// lie upon sheets, discs for the area of all of them would cover the visible ones.
double visible_area(std::span<const double> positions, double area) {
  ViewBox box;
  for (std::size_t k = 0; k + 2 < positions.size(); k += 3)
    box.add({positions[k], positions[k + 1], positions[k + 2]});
  if (box.empty()) return area;
  const double x = box.size(0), y = box.size(1), z = box.size(2);
  return std::min(area, 2 * (x * y + y * z + z * x));
}

// The surface in working coordinates, since those of the file may be too large to compute a picture with.
RgbImage draw_surface(const PolygonMesh& file, const PicturedRow& row, const ColorScale& scale,
                      const ModelLook& look) {
  const PreparedMesh mesh = prepare_mesh(file);
  std::vector<double> positions(3 * mesh.vertex_count());
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    positions[3 * v] = mesh.x[v];
    positions[3 * v + 1] = mesh.y[v];
    positions[3 * v + 2] = mesh.z[v];
  }
  const std::size_t values = look.samples ? 3 * drawn_count(row, look) : 0;
  const std::vector<double> points =
      working_points(row.report, std::span(row.samples.points).first(values), mesh);
  const std::vector<SrgbColor> colors = row_colors(row, scale, look);
  const std::vector<double> radii = radii_of(row, visible_area(positions, mesh.total_area), look);
  std::vector<double> lines;
  if (look.sharp_angle > 0) {
    const SharpEdges edges = find_sharp_edges(mesh, {.angle = look.sharp_angle});
    lines.reserve(6 * edges.count());
    for (std::size_t e = 0; e < edges.count(); ++e)
      for (const std::uint32_t v : {edges.start[e], edges.end[e]})
        lines.insert(lines.end(), {mesh.x[v], mesh.y[v], mesh.z[v]});
  }
  return sampled_surface_picture(
      {positions, mesh.triangles, points, std::span(row.samples.normals).first(values), colors, radii, lines},
      surface_look(look));
}

RgbImage draw_points(const PicturedRow& row, const ColorScale& scale, const ModelLook& look) {
  SplatParameters parameters;
  parameters.size = look.size;
  parameters.view = look.view;
  parameters.up = look.up;
  const std::size_t values = 3 * drawn_count(row, look);
  const double area = row.report.area / (row.report.scale * row.report.scale);
  const std::vector<SrgbColor> colors = row_colors(row, scale, look);
  return splat_picture(std::span(row.samples.points).first(values),
                       std::span(row.samples.normals).first(values), area, parameters, colors);
}

// Draws the samples alone and, with their mesh (or null), measures the white space between them.
RgbImage draw_sample_splats(const PolygonMesh* file, const PicturedRow& row, const ColorScale& scale,
                            const ModelLook& look, std::string& note) {
  const std::size_t count = drawn_count(row, look);
  const auto points = std::span(row.samples.points).first(3 * count);
  SplatView view = fitted_view(points, look.view, look.up, look.size, look.size);
  std::vector<float> half_axes = splat_half_axes(row, sample_areas(row, count), look.splats);
  // Large splats get a wider margin, since they reach beyond their centers.
  double reach = 0;
  for (const float axis : half_axes) reach += double{axis} / static_cast<double>(half_axes.size());
  if (look.style == SampleStyle::splats)
    view = fitted_view(points, look.view, look.up, look.size, look.size,
                       0.05 + std::min(0.15, reach * view.scale / look.size));
  const std::vector<SrgbColor> colors = row_colors(row, scale, look);
  const OrientedSplats splats = splats_of(row, half_axes, colors, view);
  SplatLook drawn;
  drawn.backs = look.both_sides || !is_closed(row);
  // Points have the size of those on a sheet.
  if (look.style == SampleStyle::points)
    drawn.shown = std::min(1.0, look.disc * std::sqrt(std::numbers::pi / look.splats.cover));
  if (file != nullptr && look.style == SampleStyle::splats)
    note = fmt::format("white space {:.2f} %",
                       100 * white_space(splats, view, mesh_depth(row, prepare_mesh(*file), view)).share());
  return draw_splats(splats, view, drawn).image;
}

// The mesh of a row, or the reason why there is none.
std::string read_surface(const PicturedModel& model, const Row& row, PolygonMesh& mesh) {
  if (!model.lacking.empty()) return model.lacking;
  if (!model.file) return "no mesh in the INPUT";
  try {
    const ModelBytes file(*model.file);
    if (model.in_store && file.content_sha256() != row.report.content_sha256) return "the mesh has changed";
    mesh = file.mesh();
  } catch (const ItemError& error) {
    return error.what();
  }
  return {};
}

void draw_cell(const PicturedModel& model, const PicturedRow& row, const ColorScale& scale,
               const ModelLook& look, SheetCell& cell) {
  if (row.report.status != Status::ok) {
    cell.failure = fmt::format("{}: {}", name_of(row.report.status), row.report.reason);
    return;
  }
  PolygonMesh mesh;
  const std::string lacking = read_surface(model, row, mesh);
  if (!model.in_store && !lacking.empty()) {
    cell.failure = lacking;
    return;
  }
  const bool alone = look.style != SampleStyle::surface;
  if (alone) {
    cell.picture = draw_sample_splats(lacking.empty() ? &mesh : nullptr, row, scale, look, cell.note);
  } else {
    cell.picture = lacking.empty() ? draw_surface(mesh, row, scale, look) : draw_points(row, scale, look);
  }
  if (lacking.empty() || !look.surfaces) return;
  cell.note = fmt::format("{}: {}", alone ? "white space unknown" : "points only", lacking);
  cell.note_color = warning_note;
}

// The class, where the colors come from if they are drawn, and how much the model asked for and did not get.
std::string words_below(const StoreReader& store, const PicturedRow& row, const ModelLook& look) {
  std::vector<std::string> words;
  if (row.label >= 0) words.push_back(store.label_names()[static_cast<std::size_t>(row.label)]);
  if (row.report.status == Status::ok && look.color.kind == ColoringKind::rgb)
    words.push_back(fmt::format("colors: {}", name_of(row.report.color_source)));
  std::uint64_t notes = 0;
  for (const std::uint32_t count : row.report.notes) notes += count > 0;
  if (notes > 0) words.push_back(fmt::format("{} note{}", notes, notes == 1 ? "" : "s"));
  return joined_texts(words);
}

}  // namespace

std::uint64_t picture_bytes(const StoreReader& store, const PicturedModel& model, const ModelLook& look) {
  std::uint64_t bytes = std::uint64_t{look.size} * look.size * bytes_per_pixel +
                        std::uint64_t{store.samples()} * bytes_per_drawn_sample;
  if (!model.file || !model.file->known_format) return bytes;
  try {
    const MeshEstimate mesh = peek_model(*model.file);
    bytes += mesh.file_bytes + mesh.decoding_bytes + mesh.triangles * bytes_per_triangle;
    // Edges, and lines of 112 bytes for three of a triangle at most.
    if (look.sharp_angle > 0)
      bytes += 336 * mesh.triangles +
               static_cast<std::uint64_t>(sharp_edges_bytes(static_cast<double>(mesh.triangles)));
  } catch (const ItemError&) {  // read_surface reports it
  }
  return bytes;
}

std::vector<SheetCell> model_cells(const StoreReader& store, std::span<const PicturedModel> models,
                                   const ColorScale& scale, const ModelLook& look) {
  std::vector<PicturedRow> rows;
  std::vector<SheetCell> cells(models.size());
  for (std::size_t i = 0; i < models.size(); ++i) {
    if (!models[i].in_store) {
      rows.emplace_back().report.status = Status::ok;
      continue;
    }
    rows.push_back({store.read_row(models[i].row), store.label(models[i].row)});
    cells[i].title = store.id(models[i].row);
    cells[i].note_color = quiet_note;
    if (look.color.kind == ColoringKind::label && rows[i].label >= 0)
      cells[i].note_color = palette_color(static_cast<std::size_t>(rows[i].label));
    cells[i].note = words_below(store, rows[i], look);
  }
  parallel_tasks(models.size(), [&](std::size_t i) { draw_cell(models[i], rows[i], scale, look, cells[i]); });
  return cells;
}

std::vector<SheetCell> model_cells(const StoreReader& store, std::vector<PicturedModel> models,
                                   const ColorScale& scale, const ModelLook& look, std::uint64_t memory,
                                   std::size_t threads) {
  std::vector<std::uint64_t> bytes;
  for (PicturedModel& model : models) {
    bytes.push_back(picture_bytes(store, model, look));
    if (bytes.back() <= memory || !model.file) continue;
    model.file.reset();
    model.lacking = "the mesh needs more than --memory";
    bytes.back() = picture_bytes(store, model, look);
  }
  std::vector<SheetCell> cells;
  for (std::size_t begin = 0; begin < models.size();) {
    std::uint64_t taken = bytes[begin];
    std::size_t end = begin + 1;
    while (end < models.size() && end - begin < threads && taken + bytes[end] <= memory)
      taken += bytes[end++];
    std::vector<SheetCell> drawn =
        model_cells(store, std::span(models).subspan(begin, end - begin), scale, look);
    std::move(drawn.begin(), drawn.end(), std::back_inserter(cells));
    begin = end;
  }
  return cells;
}

std::uint64_t sheet_bytes(const SheetLook& sheet, std::size_t models) {
  constexpr std::uint64_t bytes_per_pixel = 3;
  const std::uint64_t picture = std::uint64_t{sheet.cell} * sheet.cell;
  const std::uint64_t place = std::uint64_t{sheet.cell + sheet.gap} * (sheet.cell + 3 * sheet.gap);
  return bytes_per_pixel * (picture + place) * models;
}

void look_along(const std::string& up, ModelLook& look) {
  look.up = axis_of(up);
  look.view = view_of({}, up);
}

}  // namespace meander
