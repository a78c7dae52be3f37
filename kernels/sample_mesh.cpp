#include "kernels/sample_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <optional>
#include <stdexcept>

#include "kernels/core/check_range.h"
#include "kernels/core/parallel.h"
#include "kernels/describe/curved_samples.h"
#include "kernels/mesh/count_limit.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/sample/point_frames.h"
#include "kernels/sample_tensor.h"

namespace meander {

namespace {

// The report of the whole model from those of its charts: the weakest method, sums, and area-weighted means.
void summarise_charts(ModelState& model) {
  ItemReport& report = model.row.report;
  const auto weakness = [](Method method) {
    return method == Method::anisotropic ? Method::conformal
           : method == Method::none      ? Method::direct
                                         : method;
  };
  Method weakest = Method::conformal;
  bool anisotropic = false;
  double weight = 0, overlap = 0, distortion = 0;
  for (std::size_t c = 0; c < model.charts.size(); ++c) {
    const double area = model.mesh.components[c].area;
    if (!(area > 0)) continue;
    const ChartReport& chart = model.charts[c].report;
    weakest = std::max(weakest, weakness(chart.method));
    anisotropic |= chart.method == Method::anisotropic;
    if (chart.method == Method::none) continue;
    report.flips += chart.flips;
    report.area_scale_range = std::max(report.area_scale_range, chart.area_scale_range);
    weight += area;
    overlap += area * chart.overlap;
    distortion += area * chart.mean_distortion;
  }
  report.method = weakest == Method::conformal && anisotropic ? Method::anisotropic : weakest;
  if (weight > 0) {
    report.overlap = overlap / weight;
    report.distortion = distortion / weight;
  }
}

}  // namespace

std::vector<std::string> validate(const SampleParameters& p) {
  std::vector<std::string> problems;
  check_range(problems, "samples", p.place.samples, 1, 2147483648.0);
  check_range(problems, "jitter", p.place.jitter, 0.0, 1.0);
  check_range(problems, "elements per sample", p.elements.elements_per_sample, 1.0, 64.0);
  check_range(problems, "leaves per sample", p.locator.curve.leaves_per_sample, 1.0, 256.0);
  check_range(problems, "curve depth", p.locator.curve.max_depth, 1, 31);
  check_range(problems, "sheets", p.locator.max_sheets, 1, 16);
  check_range(problems, "extremity seams", p.cut.extremity_seams, 0, 16);
  check_range(problems, "extra seams", p.flatten.max_extra_seams, 0, 64);
  check_range(problems, "density floor", p.density.floor, 1e-6, 1.0);
  check_range(problems, "density exponent", p.density.exponent, 0.25, 4.0);
  check_range(problems, "density quantile", p.density.quantile, 0.01, 1.0);
  const bool wants_attribute =
      p.density.kind == DensityKind::vertex_attribute || p.density.kind == DensityKind::face_attribute;
  if (wants_attribute && p.density.attribute.empty())
    problems.push_back("the density needs the name of an attribute");
  if (p.locate == LocatorKind::first_hit && p.place.place == PlaceKind::element)
    problems.push_back("the locator first-hit knows curve vertices only: place at vertices");
  check_range(problems, "descriptor bins", p.describe.bins, 8, 1024);
  check_range(problems, "geodesic sources", p.describe.geodesic_sources, 0, 2147483648.0);
  if (!p.describe.descriptors.empty() && p.place.samples < 4)
    problems.push_back("descriptors need at least 4 samples");
  if (p.method == MethodChoice::anisotropic) {
    // Tables may come with each model (ModelState::tensor_table).
    TensorParameters tensor = p.tensor;
    if (tensor.kind == TensorKind::table && !tensor.table) tensor.table = std::make_shared<TensorTable>();
    for (const std::string& problem : validate(tensor)) problems.push_back(problem);
  }
  check_range(problems, "segments", p.tensor_charts.segment.count, 1, 65536);
  check_range(problems, "smallest segment", p.tensor_charts.segment.min_triangles, 1, 1 << 20);
  check_range(problems, "bisections", p.tensor_charts.max_bisections, 0, 16);
  if (p.elements.samples != p.place.samples || p.locator.samples != p.place.samples)
    problems.push_back("the stages disagree about the number of samples (see set_samples)");
  return problems;
}

bool casts_rays(const SampleParameters& parameters) {
  return parameters.method != MethodChoice::direct && parameters.locate != LocatorKind::elements;
}

double elements_per_sample(const SampleParameters& parameters) {
  const double asked = parameters.elements.elements_per_sample;
  return parameters.method == MethodChoice::anisotropic ? std::max(asked, tensor_elements_per_sample) : asked;
}

void set_samples(SampleParameters& parameters, std::uint32_t samples) {
  parameters.place.samples = samples;
  parameters.elements.samples = samples;
  parameters.locator.samples = samples;
}

void prepare_model(ModelState& model, const SampleParameters& parameters) {
  ItemReport& report = model.row.report;
  report.vertices = model.file.vertex_count();
  report.faces = model.file.polygon_count();
  report.repairs = model.file.repairs;
  model.mesh = prepare_mesh(model.file, model.cancel);
  const PreparedMesh& mesh = model.mesh;
  report.repairs = mesh.repairs;
  report.components = static_cast<std::uint32_t>(mesh.components.size());
  for (const Component& c : mesh.components) {
    report.genus += c.genus;
    report.boundaries += c.boundary_loops;
  }
  report.bbox = mesh.bbox;
  report.area = file_area(mesh, mesh.total_area);
  model.density = make_density(model.file, mesh, parameters.density, model.cancel);
  model.masses = triangle_masses(mesh, model.density);
  report.measure = file_measure(mesh, model.masses);
}

void follow_tensor_model(ModelState& model, const SampleParameters& parameters) {
  if (parameters.method != MethodChoice::anisotropic) return;
  make_tensor_segments(model, parameters);
}

void cut_model(ModelState& model, const SampleParameters& parameters) {
  if (parameters.method == MethodChoice::direct) return;
  model.cuts.resize(model.mesh.components.size());
  parallel_tasks(model.cuts.size(), [&](std::size_t c) {
    if (model.mesh.components[c].area > 0)
      model.cuts[c] = cut_to_disk(model.mesh, model.mesh.components[c], parameters.cut, model.cancel);
  });
}

void flatten_model(ModelState& model, const SampleParameters& parameters) {
  if (parameters.method == MethodChoice::direct) {
    model.row.report.method = Method::direct;
    return;
  }
  if (parameters.method == MethodChoice::anisotropic) {
    flatten_segments(model, parameters);
    summarise_charts(model);
    return;
  }
  model.charts.resize(model.cuts.size());
  parallel_tasks(model.charts.size(), [&](std::size_t c) {
    if (model.mesh.components[c].area > 0)
      model.charts[c] = flatten_chart(model.mesh, std::move(model.cuts[c]), parameters.flatten, model.cancel);
  });
  model.cuts.clear();
  summarise_charts(model);
}

void build_model_curves(ModelState& model, const SampleParameters& parameters) {
  if (!casts_rays(parameters)) return;
  model.trees = build_curves(model.mesh, model.charts, model.masses, parameters.locator, model.cancel);
}

void locate_model(ModelState& model, const SampleParameters& parameters, const EmbreeDevice* device) {
  ElementParameters elements = parameters.elements;
  elements.elements_per_sample = elements_per_sample(parameters);
  elements.keep_vertices = parameters.place.place == PlaceKind::vertex;
  elements.curve = parameters.locator.curve.kind;
  const bool rays = casts_rays(parameters);
  if (rays && device == nullptr) throw ItemError(Status::internal, "the locator needs an Embree device");
  if (rays && parameters.locate == LocatorKind::first_hit) {
    model.elements = locate_first_hit(*device, model.mesh, model.density, model.charts, model.trees,
                                      parameters.locator, model.cancel);
    return;
  }
  Located located;
  if (rays)
    located = locate_with_embree(*device, model.mesh, model.charts, model.masses, model.trees, model.key,
                                 parameters.locator, model.cancel);
  model.elements = build_elements(model.mesh, model.density, model.charts, {located.hits, located.sheet},
                                  model.key, elements, model.cancel);
}

namespace {

// Distances and normals need the whole surface, not its segments.
void join_segments(ModelState& model, const SampleParameters& parameters) {
  if (parameters.method == MethodChoice::anisotropic) model.mesh = prepare_mesh(model.file, model.cancel);
}

// Moves the samples from the chords to the smooth surface that the vertex normals describe.
void lift_model_samples(ModelState& model, const OutputFrame& frame) {
  const PreparedMesh& mesh = model.mesh;
  Samples& samples = model.row.samples;
  const std::vector<std::uint32_t> triangle = sample_triangles(model.file, mesh, samples);
  const std::vector<double> normals = crease_normals(mesh.x, mesh.y, mesh.z, mesh.triangles);
  const std::vector<double> lifted =
      lift_samples(mesh.x, mesh.y, mesh.z, mesh.triangles, normals, triangle, samples.barycentric);
  samples.points = stored_points(lifted, mesh, frame);
}

}  // namespace

void place_model(ModelState& model, const SampleParameters& parameters) {
  ItemReport& report = model.row.report;
  const OutputFrame frame = output_frame(model.mesh, parameters.place.normalize);
  report.loc = {frame.loc.x, frame.loc.y, frame.loc.z};
  report.scale = frame.scale;
  model.row.samples = place_samples(model.file, model.mesh, model.density, model.elements, model.key,
                                    parameters.place, frame, report.repairs, model.cancel);
  if (parameters.method == MethodChoice::anisotropic) add_sample_tensors(model);
  if (parameters.curved) {
    join_segments(model, parameters);
    lift_model_samples(model, frame);
  }
  report.status = Status::ok;
}

void release_curves(ModelState& model) {
  model.charts = {};
  model.trees = {};
  model.elements = {};
}

void describe_model(ModelState& model, const SampleParameters& parameters) {
  const bool anisotropic = parameters.method == MethodChoice::anisotropic;
  if (parameters.describe.descriptors.empty() && !anisotropic) return;
  release_curves(model);
  const std::vector<Descriptor>& wanted = parameters.describe.descriptors;
  if (!parameters.curved && std::find_if(wanted.begin(), wanted.end(), needs_mesh) != wanted.end())
    join_segments(model, parameters);
  model.row.descriptors = describe_samples(model.file, model.mesh, model.row.samples, model.key,
                                           parameters.describe, model.cancel);
  if (!anisotropic) return;
  const AnisotropyReport& report = model.anisotropy;
  const std::array<double, anisotropy_names.size()> values = {static_cast<double>(report.segments),
                                                              report.accepted_share,
                                                              report.mean_angle,
                                                              report.mean_chart_ratio,
                                                              report.mean_spacing_ratio,
                                                              report.clamped_share};
  for (std::size_t i = 0; i < values.size(); ++i)
    model.row.descriptors.push_back({anisotropy_names[i], {static_cast<float>(values[i])}});
}

Row sample_mesh(std::span<const double> positions, std::span<const std::uint32_t> faces,
                const SampleParameters& parameters, std::span<const std::uint8_t> content) {
  const std::vector<std::string> problems = validate(parameters);
  if (!problems.empty()) {
    std::string all;
    for (const std::string& problem : problems) all += (all.empty() ? "" : "; ") + problem;
    throw std::invalid_argument(all);
  }
  if (positions.size() % 3 != 0 || faces.size() % 3 != 0)
    throw std::invalid_argument("positions and faces must hold three entries per vertex and face");
  ModelState model;
  try {
    check_count(positions.size() / 3, "vertices");
    check_count(faces.size(), "corners");
    for (std::size_t i = 0; i < positions.size(); i += 3) {
      model.file.x.push_back(positions[i]);
      model.file.y.push_back(positions[i + 1]);
      model.file.z.push_back(positions[i + 2]);
    }
    model.file.corners.assign(faces.begin(), faces.end());
    for (std::size_t f = 0; f <= faces.size(); f += 3)
      model.file.polygon_begin.push_back(static_cast<std::uint32_t>(f));
    model.key = make_random_key(parameters.seed, content);
    prepare_model(model, parameters);
    follow_tensor_model(model, parameters);
    cut_model(model, parameters);
    flatten_model(model, parameters);
    std::optional<EmbreeDevice> device;
    if (casts_rays(parameters)) device.emplace();
    build_model_curves(model, parameters);
    locate_model(model, parameters, device ? &*device : nullptr);
    place_model(model, parameters);
    describe_model(model, parameters);
  } catch (const ItemError& error) {
    model.row.report.status = error.status();
    model.row.report.reason = error.what();
    model.row.samples = {};
    model.row.descriptors.clear();
  } catch (const std::bad_alloc&) {
    model.row.report.status = Status::out_of_memory;
    model.row.report.reason = "an allocation failed";
    model.row.samples = {};
    model.row.descriptors.clear();
  }
  return std::move(model.row);
}

}  // namespace meander
