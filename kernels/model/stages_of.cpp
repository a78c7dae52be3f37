// The stages of every method. A method is a list; what is shared between lists is a function.
#include <algorithm>
#include <array>
#include <initializer_list>
#include <span>
#include <stdexcept>
#include <utility>

#include "kernels/mesh/prepare_mesh.h"
#include "kernels/model/charts.h"
#include "kernels/model/model.h"
#include "kernels/rays/first_hit.h"
#include "kernels/sample/column_makers.h"
#include "kernels/sample/curved_samples.h"
#include "kernels/sample/point_frames.h"
#include "kernels/sample/relaxed_samples.h"
#include "kernels/sample/sample_attributes.h"
#include "kernels/sample/sample_frame.h"

namespace meander {

namespace {

// ---- bytes: of what stages hold, by the arrays that are alive at once

// The neighbors of triangles are found, in the first stage or by descriptors.
bool finds_topology(const SampleParameters& p) {
  return p.topology || std::any_of(p.describe.descriptors.begin(), p.describe.descriptors.end(), needs_mesh);
}

// The prepared surface, with its segments under a tensor field.
double surface_bytes(const SampleParameters& p, const ModelSizes& sizes) {
  return prepared_bytes(sizes.triangles, sizes.vertices, finds_topology(p)).peak +
         (method_of(p).follows_tensor ? tensor_bytes(sizes.triangles) : 0);
}

double flattening_bytes(const SampleParameters& p, const ModelSizes& sizes) {
  return surface_bytes(p, sizes) + flatten_bytes(sizes.triangles, sizes.unknowns());
}

double charted_bytes(const SampleParameters& p, const ModelSizes& sizes) {
  return surface_bytes(p, sizes) + (method_of(p).makes_charts ? chart_bytes(sizes.triangles) : 0);
}

// The charts of a coarse mesh need more elements.
ElementParameters over_coarse_mesh(ElementParameters elements) {
  elements.elements_per_sample =
      std::max(elements.elements_per_sample, coarse_elements_per_sample(elements.samples));
  return elements;
}

OrderBytes bytes_of_order(const SampleParameters& p, const ModelSizes& sizes) {
  const SamplingMethod& method = method_of(p);
  const PreparedBytes surface = prepared_bytes(sizes.triangles, sizes.vertices, finds_topology(p));
  const ElementParameters elements = element_parameters(p);
  return order_bytes({.triangles = sizes.triangles,
                      .in_space = !method.makes_charts,
                      .uniform = p.density.kind == DensityKind::uniform,
                      .in_metric = method.follows_tensor,
                      .in_regions = places_in_regions(p),
                      .freed_bytes = surface.peak - surface.held,
                      .threads = sizes.threads},
                     method.makes_charts ? over_coarse_mesh(elements) : elements);
}

double ordering_bytes(const SampleParameters& p, const ModelSizes& sizes) {
  return charted_bytes(p, sizes) + (casts_rays(p) ? locate_bytes(locate_parameters(p), sizes.triangles) : 0) +
         bytes_of_order(p, sizes).building;
}

double bytes_of_samples(const SampleParameters& p, const ModelSizes& sizes) {
  const PlaceParameters place = place_parameters(p);
  return places_in_regions(p) ? region_sample_bytes(place, leaves_sites(p), sizes.triangles, sizes.threads)
                              : sample_bytes(place, method_of(p).follows_tensor);
}

double placing_bytes(const SampleParameters& p, const ModelSizes& sizes) {
  return charted_bytes(p, sizes) + bytes_of_order(p, sizes).placing + bytes_of_samples(p, sizes) +
         (p.finish == FinishKind::relax ? relaxation_bytes(p.samples, sizes.triangles) : 0) +
         (p.curved ? lift_bytes(sizes.triangles) : 0);
}

double describing_bytes(const SampleParameters& p, const ModelSizes& sizes) {
  double most = 0;
  for (const Descriptor descriptor : p.describe.descriptors)
    if (const auto bytes = group_of(descriptor).bytes) most = std::max(most, bytes(p.describe, sizes));
  return surface_bytes(p, sizes) + bytes_of_samples(p, sizes) + most;
}

// ---- up to the charts

// Throws ItemError(incomplete) for notes of the kinds `strict`.
void report_notes(const Notes& notes, NoteSet strict, ItemReport& report) {
  report.notes = notes.counts;
  report.note_text = text_of(notes);
  if (const std::string text = text_of(notes, strict); !text.empty())
    throw ItemError(Status::incomplete, text);
}

// Notes of a later stage, beside those of the file.
void report_more(const Notes& notes, NoteSet strict, Model& model) {
  if (!notes.any()) return;
  add(model.file.notes, notes);
  report_notes(model.file.notes, strict, model.row.report);
}

void report_file(const PolygonMesh& file, NoteSet strict, ItemReport& report) {
  report.vertices = file.vertex_count();
  report.faces = file.polygon_count();
  report.repairs = file.repairs;
  report_notes(file.notes, strict, report);
}

void report_surface(const PreparedMesh& mesh, ItemReport& report) {
  report.repairs = mesh.repairs;
  if (mesh.has_topology()) {
    report.components = static_cast<std::uint32_t>(mesh.components.size());
    for (const Component& c : mesh.components) {
      report.genus += c.genus;
      report.boundaries += c.boundary_loops;
    }
  }
  report.bbox = mesh.bbox;
  report.area = file_area(mesh, mesh.total_area);
}

void prepare_surface(Model& model, const SampleParameters& p) {
  report_file(model.file, p.strict, model.row.report);
  model.surface =
      p.topology ? prepare_mesh(model.file, model.cancel) : prepare_soup(model.file, model.cancel);
  report_surface(model.surface, model.row.report);
  model.measure.density = make_density(model.file, model.surface, p.density, model.cancel);
}

void measure_surface(Model& model, bool keep_masses = true) {
  model.measure = measure_of(model.surface, std::move(model.measure.density), keep_masses);
  model.row.report.measure = file_measure(model.surface, model.measure.total());
}

ModelStages charting_direct(const SampleParameters& p) {
  return {{"prepare_mesh",
           [p](Model& model) {
             const bool is_placed_last = p.rows_only && p.describe.descriptors.empty();
             prepare_surface(model, p);
             if (is_placed_last && p.finish == FinishKind::none && !p.queries.any() &&
                 !any_reads(p.columns, &ColumnReads::neighbors))
               model.surface.opposite = std::vector<std::uint32_t>();
             if (is_placed_last && p.attributes.empty() && !p.queries.any() &&
                 !any_reads(p.columns, &ColumnReads::polygons))
               model.file.polygon_begin = std::vector<std::uint32_t>();
             measure_surface(model, !p.rows_only);
             model.row.report.method = row_of(element_orders, order_of(p)).in_space;
           },
           surface_bytes}};
}

// The mesh that is cut and flattened.
const PreparedMesh& charted_mesh(const Model& model) {
  return model.coarse.empty() ? model.surface : model.coarse.mesh;
}

FlattenParameters flatten_parameters(const Model& model, FlattenParameters parameters) {
  if (!model.coarse.empty())
    parameters.max_mean_distortion = std::max(parameters.max_mean_distortion, coarse_mean_distortion);
  return parameters;
}

ModelStages charting_conformal(const SampleParameters& p) {
  ModelStages stages = {{"prepare_mesh", [p](Model& model) {
                           prepare_surface(model, p);
                           measure_surface(model);
                         }}};
  // The first triangle that a ray hits is the sample's own: it is located on the surface itself.
  if (p.locate != LocatorKind::first_hit)
    stages.push_back({"coarsen_mesh", [coarsen = p.coarsen, samples = p.samples](Model& model) {
                        model.coarse =
                            coarsen_mesh(model.surface, model.measure.masses, samples, coarsen, model.cancel);
                      }});
  stages.push_back({"cut_to_disk", [cut = p.cut](Model& model) {
                      model.cuts = cut_components(charted_mesh(model), cut, model.cancel);
                    }});
  stages.push_back({"flatten_chart",
                    [flatten = p.flatten](Model& model) {
                      const PreparedMesh& mesh = charted_mesh(model);
                      model.charts = flatten_components(mesh, std::move(model.cuts),
                                                        flatten_parameters(model, flatten), model.cancel);
                      report_charts(mesh.components, model.charts, model.row.report);
                    },
                    flattening_bytes});
  return stages;
}

ModelStages charting_anisotropic(const SampleParameters& p) {
  return {{"prepare_mesh", [p](Model& model) { prepare_surface(model, p); }},
          {"follow_tensor",
           [wanted = p.tensor_charts, tensor = p.tensor](Model& model) {
             TensorParameters own = tensor;
             if (model.tensor_table) own.table = model.tensor_table;
             model.segments = make_tensor_segments(model.file, model.surface, model.measure.density, own,
                                                   wanted, model.cancel);
             model.row.report.measure = model.segments.file_measure;
           }},
          {"chart_segments",
           [p](Model& model) {
             model.charts = chart_segments(model.segments, p, model.cancel);
             report_charts(model.segments.mesh.components, model.charts, model.row.report);
           },
           flattening_bytes}};
}

// ---- from the charts to the samples

// What is sampled: the surface, or its segments under a tensor field.
struct Domain {
  MeasuredMesh mesh;
  const MeshMeasure& measure;
  const CoarseMesh* coarse = nullptr;  // whose charts it has, if they are not its own

  const PreparedMesh& charted_mesh() const { return coarse != nullptr ? coarse->mesh : mesh.mesh(); }
  std::span<const double> charted_masses() const {
    return coarse != nullptr ? coarse->masses : measure.masses;
  }
};
Domain surface_domain(const Model& model) {
  return {model.surface, model.measure, model.coarse.empty() ? nullptr : &model.coarse};
}
Domain segments_domain(const Model& model) { return {model.segments.measured(), model.segments.measure}; }
using DomainOf = Domain (*)(const Model&);

SurfaceContext context_of(const Model& model, const Domain& domain, const TriangleHints& hints = {}) {
  return {domain.mesh, domain.measure, model.key, {model.charts, domain.coarse}, hints, model.cancel};
}

void order_elements(Model& model, const Domain& domain, const TriangleHints& hints,
                    const SampleParameters& p) {
  const ElementParameters elements = element_parameters(p);
  model.order = SurfaceOrder();  // that of a model that is placed a second time
  model.order =
      build_order(context_of(model, domain, hints),
                  domain.coarse != nullptr ? over_coarse_mesh(elements) : elements, places_in_regions(p));
}

// With what the rays have found. Of coarse triangles only the sheets matter for the triangles over them,
// which are small beside the leaves of the curve.
void order_located(Model& model, const Domain& domain, const Located& located, const SampleParameters& p) {
  if (domain.coarse == nullptr) {
    order_elements(model, domain, {located.hits, located.sheet}, p);
    return;
  }
  std::vector<std::uint8_t> sheet(domain.coarse->triangle.size());
  for (std::size_t t = 0; t < sheet.size(); ++t) sheet[t] = located.sheet[domain.coarse->triangle[t]];
  order_elements(model, domain, {{}, sheet}, p);
}

// Elements in the order of the charts, or without any in that of space.
ModelStages locating_elements(const SampleParameters& p, DomainOf domain_of) {
  return {{"locate_vertices",
           [p, domain_of](Model& model) { order_elements(model, domain_of(model), {}, p); }, ordering_bytes}};
}

ModelStages locating_rays(const SampleParameters& p, const EmbreeDevice* device, DomainOf domain_of) {
  const LocateParameters curved = locate_parameters(p);
  ModelStages stages = {{"build_curve", [locator = curved, domain_of](Model& model) {
                           const Domain domain = domain_of(model);
                           model.trees = build_curves(domain.charted_mesh(), model.charts,
                                                      domain.charted_masses(), locator, model.cancel);
                         }}};
  if (p.locate == LocatorKind::first_hit) {
    stages.push_back({"locate_vertices",
                      [locator = curved, device, domain_of](Model& model) {
                        const Domain domain = domain_of(model);
                        model.order = SurfaceOrder();
                        model.order = locate_first_hit(*device, domain.mesh.mesh(), domain.measure,
                                                       model.charts, model.trees, locator, model.cancel);
                      },
                      ordering_bytes});
  } else {
    stages.push_back({"locate_vertices",
                      [locator = curved, p, device, domain_of](Model& model) {
                        const Domain domain = domain_of(model);
                        const Located located = locate_with_embree(
                            *device, domain.charted_mesh(), model.charts, domain.charted_masses(),
                            model.trees, model.key, locator, model.cancel);
                        order_located(model, domain, located, p);
                      },
                      ordering_bytes});
  }
  return stages;
}

ModelStages locating(const SampleParameters& p, const EmbreeDevice* device, DomainOf domain_of) {
  return casts_rays(p) ? locating_rays(p, device, domain_of) : locating_elements(p, domain_of);
}

// The frame of the stored points, which the row names.
void report_frame(const OutputFrame& frame, ItemReport& report) {
  report.loc = {frame.loc.x, frame.loc.y, frame.loc.z};
  report.scale = frame.scale;
}
// The frame in which samples are placed; it may become that of the samples.
OutputFrame first_frame(Model& model, const PlaceParameters& parameters) {
  const OutputFrame frame = output_frame(model.surface, parameters.normalize);
  report_frame(frame, model.row.report);
  return frame;
}
OutputFrame reported_frame(const ItemReport& report) {
  return {{report.loc[0], report.loc[1], report.loc[2]}, report.scale};
}

void place(Model& model, const SampleParameters& p, const Domain& domain, MetricAt metric = {}) {
  const PlaceParameters parameters = place_parameters(p);
  ItemReport& report = model.row.report;
  OutputFrame frame = first_frame(model, parameters);
  const PlaceContext context{context_of(model, domain), model.file, parameters, std::move(metric)};
  Notes placing;
  model.row.samples = place_samples(context, model.order, frame, report.repairs, placing);
  report_frame(frame, report);
  report_more(placing, p.strict, model);
}

// The frame that lifted samples define, whatever their order in the file. lifted: in working units.
OutputFrame frame_of_lifted(const Model& model, std::span<const double> lifted) {
  const std::vector<std::uint32_t>& rank = model.row.samples.curve_rank;
  std::vector<std::uint32_t> by_rank(rank.size());
  for (std::size_t i = 0; i < rank.size(); ++i) by_rank[rank[i]] = static_cast<std::uint32_t>(i);
  return frame_of_points(
      model.surface, rank.size(),
      [&](const Vector3& from, std::size_t r) {
        const double* const at = &lifted[3 * std::size_t{by_rank[r]}];
        return Vector3{at[0], at[1], at[2]} - to_working(model.surface, from);
      },
      reported_frame(model.row.report));
}

// Moves the samples, on these triangles of the surface, from the chords to the smooth surface that the vertex
// normals describe.
void lift(Model& model, const PlaceParameters& parameters, std::span<const std::uint32_t> triangle) {
  const PreparedMesh& mesh = model.surface;
  Samples& samples = model.row.samples;
  const std::vector<double> normals = crease_normals(mesh.x, mesh.y, mesh.z, mesh.triangles);
  const std::vector<double> lifted =
      lift_samples(mesh.x, mesh.y, mesh.z, mesh.triangles, normals, triangle, samples.barycentric);
  if (parameters.normalize == NormalizeKind::pointnet)
    report_frame(frame_of_lifted(model, lifted), model.row.report);
  samples.points = stored_points(lifted, mesh, reported_frame(model.row.report));
}

// The same for sets that nobody needs as a whole. Frees what they are made of.
void place_as_sites(Model& model, const PlaceParameters& parameters) {
  ItemReport& report = model.row.report;
  OutputFrame frame = first_frame(model, parameters);
  model.sites = place_sites({context_of(model, surface_domain(model)), model.file, parameters},
                            std::get<SurfaceRegions>(model.order), frame, report.repairs);
  report_frame(frame, report);
  release_charts(model);
  report.status = Status::ok;
}

ModelStages placing_on_surface(const SampleParameters& p) {
  if (leaves_sites(p))
    return {{"place_samples",
             [parameters = place_parameters(p)](Model& model) { place_as_sites(model, parameters); },
             placing_bytes}};
  return {{"place_samples",
           [p](Model& model) {
             place(model, p, surface_domain(model));
             if (p.curved) lift(model, place_parameters(p), model.row.samples.triangle);
             model.row.report.status = Status::ok;
           },
           placing_bytes}};
}

ModelStages placing_on_segments(const SampleParameters& p) {
  return {{"place_samples",
           [p](Model& model) {
             const MetricAt metric = [&segments = model.segments](std::uint32_t t, double b1, double b2) {
               return metric_at(segments, t, b1, b2);
             };
             place(model, p, segments_domain(model), metric);
             Samples& samples = model.row.samples;
             std::vector<std::uint32_t> sources;
             for (const std::uint32_t triangle : samples.triangle)
               sources.push_back(model.segments.source_triangle[triangle]);
             // May change the scale, which tensors need.
             if (p.curved) lift(model, place_parameters(p), sources);
             add_sample_tensors(model.segments, model.row.report.scale, samples);
             samples.triangle = std::move(sources);
             model.row.report.status = Status::ok;
           },
           placing_bytes}};
}

// ---- columns that are asked for

void report_made(MadeColumn made, std::size_t bit, ItemReport& report) {
  if (made.lacks_some) report.lacks |= std::uint32_t{1} << bit;
  if (made.is_missing) report.missing |= std::uint32_t{1} << bit;
}

void add_bad_attributes(std::uint64_t count, RepairCounts& repairs) {
  std::uint32_t& bad = repairs[Repair::bad_attributes];
  bad = static_cast<std::uint32_t>(
      std::min<std::uint64_t>(bad + count, std::numeric_limits<std::uint32_t>::max()));
}

ModelStages attributing(const SampleParameters& p) {
  if (p.attributes.empty()) return {};
  return {{"attribute_samples", [attributes = p.attributes](Model& model) {
             Samples& samples = model.row.samples;
             ItemReport& report = model.row.report;
             model.row.names = std::move(model.file.names);
             for (std::size_t i = 0; i < attributes.size(); ++i) {
               SampleValues made = sample_attribute(model.file, attributes[i], samples, model.cancel);
               report_made({made.lacks_some, made.is_missing}, i, report);
               add_bad_attributes(made.bad_values, report.repairs);
               if (attributes[i].is_classes()) {
                 samples.classes.resize(i);
                 samples.classes.push_back(std::move(made.classes));
               } else {
                 samples.attributes.resize(i);
                 samples.attributes.push_back(std::move(made.values));
               }
             }
           }}};
}

ModelStages making_columns(const SampleParameters& p) {
  ModelStages stages;
  std::size_t bit = p.attributes.size();  // of the next one with optional values
  for (const ColumnMaker& maker : column_makers) {
    if (!p.columns[maker.column]) continue;
    stages.push_back({maker.stage, [make = maker.make, bit](Model& model) {
                        const MadeColumn made = make({model.file, model.surface, model.cancel}, model.row);
                        report_made(made, bit, model.row.report);
                      }});
    bit += sample_columns[maker.column].is_optional();
  }
  return stages;
}

// ---- further sets of points

double sharpening_bytes(const SampleParameters& p, const ModelSizes& sizes) {
  return surface_bytes(p, sizes) + bytes_of_samples(p, sizes) + sharp_bytes(p.sharp.samples, sizes.triangles);
}

ModelStages sharpening(const SampleParameters& p) {
  ModelStages stages;
  if (p.sharp.samples > 0 || p.queries.has(QueryKind::near_sharp))
    stages.push_back({"sharp_edges",
                      [sharp = p.sharp, strict = p.strict](Model& model) {
                        model.cancel.check();
                        Notes notes;
                        model.sharp_edges = sharp_edges_of(model.file, model.surface, sharp, notes);
                        report_more(notes, strict, model);
                      },
                      sharpening_bytes});
  if (p.sharp.samples > 0)
    stages.push_back({"sharp_samples", [sharp = p.sharp, order = p.order, jitter = p.jitter,
                                        is_last = !p.queries.has(QueryKind::near_sharp)](Model& model) {
                        model.cancel.check();
                        add_sharp_samples(model.surface, model.sharp_edges, sharp, order, jitter, model.key,
                                          model.cancel, model.row);
                        if (is_last) model.sharp_edges = {};
                      }});
  return stages;
}

double querying_bytes(const SampleParameters& p, const ModelSizes& sizes) {
  return surface_bytes(p, sizes) + bytes_of_samples(p, sizes) + 40.0 * p.sharp.samples +
         query_bytes(query_count(p.queries.terms), sizes.triangles, sizes.vertices) +
         (p.queries.has(QueryKind::near_sharp) ? sharp_bytes(0, sizes.triangles) : 0);
}

ModelStages querying(const SampleParameters& p) {
  if (!p.queries.any()) return {};
  return {{"query_points",
           [queries = p.queries, normalize = p.normalize](Model& model) {
             release_charts(model);
             add_query_points(model.file, model.surface, queries, std::exchange(model.sharp_edges, {}),
                              normalize == NormalizeKind::none, model.key, model.cancel, model.row);
           },
           querying_bytes}};
}

// ---- descriptors

void add_descriptors(Model& model, const DescribeParameters& parameters) {
  release_charts(model);
  // A store names the triangle of a sample by its polygon and corners. A polygon that visits the same three
  // corners twice has two such triangles; this takes the one that `describe` will find in the store.
  const std::vector<Descriptor>& wanted = parameters.descriptors;
  if (std::any_of(wanted.begin(), wanted.end(), [](Descriptor d) { return group_of(d).needs_triangles; }))
    model.row.samples.triangle = sample_triangles(model.file, model.surface, model.row.samples, model.cancel);
  model.row.descriptors =
      describe_samples(model.surface, model.row.samples, model.key, parameters, model.cancel);
}

ModelStages describing(const SampleParameters& p) {
  if (p.describe.descriptors.empty()) return {};
  return {{"describe_shape", [parameters = p.describe](Model& model) { add_descriptors(model, parameters); },
           describing_bytes}};
}

ModelStages describing_anisotropy(const SampleParameters& p) {
  return {{"describe_shape",
           [parameters = p.describe](Model& model) {
             const AnisotropyReport report = model.segments.report;
             add_descriptors(model, parameters);
             for (DescriptorRow& row : anisotropy_rows(report))
               model.row.descriptors.push_back(std::move(row));
           },
           describing_bytes}};
}

// ---- the lists

ModelStages joined(std::initializer_list<ModelStages> lists) {
  ModelStages all;
  for (const ModelStages& list : lists) all.insert(all.end(), list.begin(), list.end());
  return all;
}

ModelStages placing_conformal(const SampleParameters& p, const EmbreeDevice* device) {
  return joined({locating(p, device, surface_domain), placing_on_surface(p)});
}

ModelStages placing_direct(const SampleParameters& p, const EmbreeDevice*) {
  return joined({locating_elements(p, surface_domain), placing_on_surface(p)});
}

ModelStages placing_anisotropic(const SampleParameters& p, const EmbreeDevice* device) {
  return joined({locating(p, device, segments_domain), placing_on_segments(p)});
}

// `device` may be null for stages that are not run.
ModelStages all_stages(const SampleParameters& p, const EmbreeDevice* device) {
  const MethodStages& stages = *method_of(p).stages;
  return joined({stages.charting(p), stages.placing(p, device), making_columns(p), attributing(p),
                 sharpening(p), querying(p), stages.describing(p)});
}

void check_device(const SampleParameters& parameters, const EmbreeDevice* device) {
  if (device == nullptr && casts_rays(parameters))
    throw std::invalid_argument("the locator needs an Embree device");
}

}  // namespace

constinit const MethodStages direct_stages = {charting_direct, placing_direct, describing};
constinit const MethodStages conformal_stages = {charting_conformal, placing_conformal, describing};
constinit const MethodStages anisotropic_stages = {charting_anisotropic, placing_anisotropic,
                                                   describing_anisotropy};

ModelStages charting_stages(const SampleParameters& parameters) {
  return method_of(parameters).stages->charting(parameters);
}

ModelStages placing_stages(const SampleParameters& parameters, const EmbreeDevice* device) {
  check_device(parameters, device);
  return method_of(parameters).stages->placing(parameters, device);
}

ModelStages stages_of(const SampleParameters& parameters, const EmbreeDevice* device) {
  check_device(parameters, device);
  return all_stages(parameters, device);
}

std::vector<StageBytes> stage_bytes(const SampleParameters& parameters) {
  std::vector<StageBytes> bytes;
  for (const ModelStage& stage : all_stages(parameters, nullptr))
    if (stage.bytes != nullptr) bytes.push_back(stage.bytes);
  return bytes;
}

void run_stages(const ModelStages& stages, Model& model) {
  for (const ModelStage& stage : stages) stage.run(model);
}

Samples samples_at(const Model& model, const PlaceParameters& parameters, std::size_t begin,
                   std::size_t end) {
  return samples_at(model.sites, {context_of(model, surface_domain(model)), model.file, parameters},
                    reported_frame(model.row.report), begin, end);
}

void release_charts(Model& model) {
  model.segments = TensorSegments{};
  model.coarse = CoarseMesh{};
  model.cuts = std::vector<CutChart>();
  model.charts = std::vector<FlatChart>();
  model.trees = std::vector<CurveTree>();
  model.order = SurfaceOrder();
}

}  // namespace meander
