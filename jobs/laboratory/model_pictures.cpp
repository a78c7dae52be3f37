#include "jobs/laboratory/model_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <span>

#include "io/archive/model_bytes.h"
#include "io/mesh/mesh_reader.h"
#include "jobs/laboratory/picture_options.h"
#include "kernels/core/parallel.h"
#include "kernels/mesh/prepare_mesh.h"
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

SrgbColor normal_color(const float* normal) {
  SrgbColor color;
  for (std::size_t k = 0; k < 3; ++k)
    color[k] = static_cast<std::uint8_t>(std::lround(127.5 * (1 + std::clamp(normal[k], -1.0f, 1.0f))));
  return color;
}

struct PicturedRow : Row {
  std::int32_t label = -1;
};

std::vector<SrgbColor> colors_of(const PicturedRow& row, const DensityRange& range, const ModelLook& look) {
  const Samples& samples = row.samples;
  const std::size_t count = drawn_count(row, look);
  if (look.color == SampleColor::plain)
    return {look.style == SampleStyle::splats ? splat_color : plain_color};
  if (look.color == SampleColor::label)
    return {row.label < 0 ? SrgbColor{110, 110, 110}
                          : srgb(palette_color(static_cast<std::size_t>(row.label)))};
  std::vector<SrgbColor> colors(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (look.color == SampleColor::normal) {
      colors[i] = normal_color(&samples.normals[3 * i]);
      continue;
    }
    const double t = look.color == SampleColor::rank
                         ? samples.curve_rank[i] / std::max(1.0, static_cast<double>(samples.count()) - 1)
                         : (samples.density[i] - range.least) / std::max(range.largest - range.least, 1e-300);
    colors[i] = srgb(map_color(t));
  }
  return colors;
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
RgbImage draw_surface(const PolygonMesh& file, const PicturedRow& row, const DensityRange& range,
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
  const std::vector<SrgbColor> colors = colors_of(row, range, look);
  const std::vector<double> radii = radii_of(row, visible_area(positions, mesh.total_area), look);
  return sampled_surface_picture(
      {positions, mesh.triangles, points, std::span(row.samples.normals).first(values), colors, radii},
      surface_look(look));
}

RgbImage draw_points(const PicturedRow& row, const DensityRange& range, const ModelLook& look) {
  SplatParameters parameters;
  parameters.size = look.size;
  parameters.view = look.view;
  parameters.up = look.up;
  const std::size_t values = 3 * drawn_count(row, look);
  const double area = row.report.area / (row.report.scale * row.report.scale);
  const std::vector<SrgbColor> colors = colors_of(row, range, look);
  return splat_picture(std::span(row.samples.points).first(values),
                       std::span(row.samples.normals).first(values), area, parameters, colors);
}

// Draws the samples alone and, with their mesh (or null), measures the white space between them.
RgbImage draw_sample_splats(const PolygonMesh* file, const PicturedRow& row, const DensityRange& range,
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
  const std::vector<SrgbColor> colors = colors_of(row, range, look);
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

void draw_cell(const PicturedModel& model, const PicturedRow& row, const DensityRange& range,
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
    cell.picture = draw_sample_splats(lacking.empty() ? &mesh : nullptr, row, range, look, cell.note);
  } else {
    cell.picture = lacking.empty() ? draw_surface(mesh, row, range, look) : draw_points(row, range, look);
  }
  if (lacking.empty() || !look.surfaces) return;
  cell.note = fmt::format("{}: {}", alone ? "white space unknown" : "points only", lacking);
  cell.note_color = warning_note;
}

}  // namespace

DensityRange density_range(const StoreReader& store, std::span<const PicturedModel> models,
                           const ModelLook& look) {
  if (look.color != SampleColor::density) return {};
  DensityRange range{std::numeric_limits<double>::infinity(), 0};
  for (const PicturedModel& model : models) {
    const Row row = store.read_row(model.row);
    if (row.report.status != Status::ok) continue;
    for (std::size_t i = 0; i < drawn_count(row, look); ++i) {
      const double density = row.samples.density[i];
      range.least = std::min(range.least, density);
      range.largest = std::max(range.largest, density);
    }
  }
  return range.least <= range.largest ? range : DensityRange{};
}

std::uint64_t picture_bytes(const StoreReader& store, const PicturedModel& model, const ModelLook& look) {
  std::uint64_t bytes = std::uint64_t{look.size} * look.size * bytes_per_pixel +
                        std::uint64_t{store.samples()} * bytes_per_drawn_sample;
  if (!model.file || !model.file->known_format) return bytes;
  try {
    const MeshEstimate mesh = peek_model(*model.file);
    bytes += mesh.file_bytes + mesh.decoding_bytes + mesh.triangles * bytes_per_triangle;
  } catch (const ItemError&) {  // read_surface reports it
  }
  return bytes;
}

std::vector<SheetCell> model_cells(const StoreReader& store, std::span<const PicturedModel> models,
                                   const DensityRange& range, const ModelLook& look) {
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
    if (look.color == SampleColor::label && rows[i].label >= 0)
      cells[i].note_color = palette_color(static_cast<std::size_t>(rows[i].label));
    if (rows[i].label >= 0) cells[i].note = store.label_names()[static_cast<std::size_t>(rows[i].label)];
  }
  parallel_tasks(models.size(), [&](std::size_t i) { draw_cell(models[i], rows[i], range, look, cells[i]); });
  return cells;
}

std::vector<SheetCell> model_cells(const StoreReader& store, std::vector<PicturedModel> models,
                                   const DensityRange& range, const ModelLook& look, std::uint64_t memory,
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
        model_cells(store, std::span(models).subspan(begin, end - begin), range, look);
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

std::optional<SheetLegend> legend_of(const DensityRange& range, const ModelLook& look) {
  switch (look.color) {
    case SampleColor::plain:
      return {};
    case SampleColor::density:
      if (range.largest <= 1.0005 * range.least)
        return SheetLegend{fmt::format("density {:.3g} everywhere", range.least), false, "", ""};
      return SheetLegend{"density", true, fmt::format("{:.3g}", range.least),
                         fmt::format("{:.3g}", range.largest)};
    case SampleColor::rank:
      return SheetLegend{"position along the curve", true, "first", "last"};
    case SampleColor::normal:
      return SheetLegend{"colour: the unit normal, red x, green y, blue z", false, "", ""};
    case SampleColor::label:
      return SheetLegend{"colour: the class, named below each model", false, "", ""};
  }
  return {};
}

}  // namespace meander
