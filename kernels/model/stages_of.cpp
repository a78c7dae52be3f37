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
#include "kernels/sample/column_makers.h"
#include "kernels/sample/curved_samples.h"
#include "kernels/sample/point_frames.h"
#include "kernels/sample/sample_attributes.h"
#include "kernels/sample/sample_frame.h"

namespace meander {

namespace {

// ---- up to the charts

// Throws ItemError(incomplete) for notes of the kinds `strict`.
void report_file(const PolygonMesh& file, NoteSet strict, ItemReport& report) {
  report.vertices = file.vertex_count();
  report.faces = file.polygon_count();
  report.repairs = file.repairs;
  report.notes = file.notes.counts;
  report.note_text = text_of(file.notes);
  if (const std::string text = text_of(file.notes, strict); !text.empty())
    throw ItemError(Status::incomplete, text);
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

// What the first stage of every method takes of the parameters.
struct SurfaceParameters {
  explicit SurfaceParameters(const SampleParameters& p)
      : density(p.density), strict(p.strict), topology(p.topology) {}
  DensityParameters density;
  NoteSet strict;
  bool topology;
};

void prepare_surface(Model& model, const SurfaceParameters& parameters) {
  const auto& [density, strict, topology] = parameters;
  report_file(model.file, strict, model.row.report);
  model.surface = topology ? prepare_mesh(model.file, model.cancel) : prepare_soup(model.file, model.cancel);
  report_surface(model.surface, model.row.report);
  model.measure.density = make_density(model.file, model.surface, density, model.cancel);
}

void measure_surface(Model& model, bool keep_masses = true) {
  model.measure = measure_of(model.surface, std::move(model.measure.density), keep_masses);
  model.row.report.measure = file_measure(model.surface, model.measure.total());
}

ModelStages charting_direct(const SampleParameters& p) {
  const Method method = order_of(p) == ElementOrder::balanced ? Method::balanced : Method::direct;
  const bool is_placed_last = p.rows_only && p.describe.descriptors.empty();
  const bool frees_topology = is_placed_last && !any_reads(p.columns, &ColumnReads::neighbours);
  const bool frees_polygons =
      is_placed_last && p.attributes.empty() && !any_reads(p.columns, &ColumnReads::polygons);
  return {{"prepare_mesh", [surface = SurfaceParameters(p), rows_only = p.rows_only, frees_topology,
                            frees_polygons, method](Model& model) {
             prepare_surface(model, surface);
             if (frees_topology) model.surface.opposite = std::vector<std::uint32_t>();
             if (frees_polygons) model.file.polygon_begin = std::vector<std::uint32_t>();
             measure_surface(model, !rows_only);
             model.row.report.method = method;
           }}};
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
  ModelStages stages = {{"prepare_mesh", [surface = SurfaceParameters(p)](Model& model) {
                           prepare_surface(model, surface);
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
  stages.push_back({"flatten_chart", [flatten = p.flatten](Model& model) {
                      const PreparedMesh& mesh = charted_mesh(model);
                      model.charts = flatten_components(mesh, std::move(model.cuts),
                                                        flatten_parameters(model, flatten), model.cancel);
                      report_charts(mesh.components, model.charts, model.row.report);
                    }});
  return stages;
}

ModelStages charting_anisotropic(const SampleParameters& p) {
  return {
      {"prepare_mesh", [surface = SurfaceParameters(p)](Model& model) { prepare_surface(model, surface); }},
      {"follow_tensor",
       [wanted = p.tensor_charts, tensor = p.tensor](Model& model) {
         TensorParameters own = tensor;
         if (model.tensor_table) own.table = model.tensor_table;
         model.segments = make_tensor_segments(model.file, model.surface, model.measure.density, own, wanted,
                                               model.cancel);
         model.row.report.measure = model.segments.file_measure;
       }},
      {"chart_segments", [p](Model& model) {
         model.charts = chart_segments(model.segments, p, model.cancel);
         report_charts(model.segments.mesh.components, model.charts, model.row.report);
       }}};
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

void forget_order(Model& model) {
  model.elements = CurveElements{};
  model.cells = ElementCells{};
  model.regions = SurfaceRegions{};
}

// Of the elements, and whether they are made region by region.
struct OrderParameters {
  ElementParameters elements;
  bool in_regions = false;
};
OrderParameters order_parameters(const SampleParameters& p) {
  return {element_parameters(p), places_in_regions(p)};
}

void order_elements(Model& model, const Domain& domain, const TriangleHints& hints,
                    const OrderParameters& order) {
  ElementParameters elements = order.elements;
  if (domain.coarse != nullptr)
    elements.elements_per_sample =
        std::max(elements.elements_per_sample, coarse_elements_per_sample(elements.samples));
  // Placed a second time, the model may have been put in the other order before.
  forget_order(model);
  const ChartSet charts(model.charts, domain.coarse);
  if (order.in_regions)
    model.regions =
        build_regions(domain.mesh, domain.measure, charts, hints.sheet, model.key, elements, model.cancel);
  else if (elements.order == ElementOrder::balanced)
    model.cells = build_cells(domain.mesh, domain.measure, charts, hints, model.key, elements, model.cancel);
  else
    model.elements =
        build_elements(domain.mesh, domain.measure, charts, hints, model.key, elements, model.cancel);
}

// With what the rays have found. Of coarse triangles only the sheets matter for the triangles over them,
// which are small beside the leaves of the curve.
void order_located(Model& model, const Domain& domain, const Located& located, const OrderParameters& order) {
  if (domain.coarse == nullptr) {
    order_elements(model, domain, {located.hits, located.sheet}, order);
    return;
  }
  std::vector<std::uint8_t> sheet(domain.coarse->triangle.size());
  for (std::size_t t = 0; t < sheet.size(); ++t) sheet[t] = located.sheet[domain.coarse->triangle[t]];
  order_elements(model, domain, {{}, sheet}, order);
}

// Elements in the order of the charts, or without any in that of space.
ModelStages locating_elements(const SampleParameters& p, DomainOf domain_of) {
  return {{"locate_vertices", [order = order_parameters(p), domain_of](Model& model) {
             order_elements(model, domain_of(model), {}, order);
           }}};
}

ModelStages locating_rays(const SampleParameters& p, const EmbreeDevice* device, DomainOf domain_of) {
  const LocateParameters curved = locate_parameters(p);
  ModelStages stages = {{"build_curve", [locator = curved, domain_of](Model& model) {
                           const Domain domain = domain_of(model);
                           model.trees = build_curves(domain.charted_mesh(), model.charts,
                                                      domain.charted_masses(), locator, model.cancel);
                         }}};
  if (p.locate == LocatorKind::first_hit) {
    stages.push_back({"locate_vertices", [locator = curved, device, domain_of](Model& model) {
                        const Domain domain = domain_of(model);
                        forget_order(model);
                        model.elements = locate_first_hit(*device, domain.mesh.mesh(), domain.measure,
                                                          model.charts, model.trees, locator, model.cancel);
                      }});
  } else {
    stages.push_back(
        {"locate_vertices", [locator = curved, order = order_parameters(p), device, domain_of](Model& model) {
           const Domain domain = domain_of(model);
           const Located located =
               locate_with_embree(*device, domain.charted_mesh(), model.charts, domain.charted_masses(),
                                  model.trees, model.key, locator, model.cancel);
           order_located(model, domain, located, order);
         }});
  }
  return stages;
}

ModelStages locating(const SampleParameters& p, const EmbreeDevice* device, DomainOf domain_of) {
  if (!casts_rays(p)) return locating_elements(p, domain_of);
  if (device == nullptr) throw std::invalid_argument("the locator needs an Embree device");
  return locating_rays(p, device, domain_of);
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

void place(Model& model, const PlaceParameters& parameters, const Domain& domain,
           const MetricAt& metric = {}) {
  ItemReport& report = model.row.report;
  OutputFrame frame = first_frame(model, parameters);
  const auto placed = [&](const auto& order) {
    return place_samples(model.file, domain.mesh, domain.measure.density, order, model.key, parameters, frame,
                         report.repairs, model.cancel, metric);
  };
  if (model.regions.count() > 0)
    model.row.samples =
        place_samples(model.file, domain.mesh, domain.measure.density, {model.charts, domain.coarse},
                      model.regions, model.key, parameters, frame, report.repairs, model.cancel);
  else
    model.row.samples = model.cells.count() > 0 ? placed(model.cells) : placed(model.elements);
  report_frame(frame, report);
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

// The same for sets that nobody needs as a whole. What they are made of has served.
void place_as_sites(Model& model, const PlaceParameters& parameters) {
  ItemReport& report = model.row.report;
  const Domain domain = surface_domain(model);
  OutputFrame frame = first_frame(model, parameters);
  model.sites = place_sites(model.file, domain.mesh, domain.measure.density, {model.charts, domain.coarse},
                            model.regions, model.key, parameters, frame, report.repairs, model.cancel);
  report_frame(frame, report);
  release_charts(model);
  report.status = Status::ok;
}

ModelStages placing_on_surface(const SampleParameters& p) {
  if (leaves_sites(p))
    return {{"place_samples",
             [parameters = place_parameters(p)](Model& model) { place_as_sites(model, parameters); }}};
  return {{"place_samples", [parameters = place_parameters(p), curved = p.curved](Model& model) {
             place(model, parameters, surface_domain(model));
             if (curved) lift(model, parameters, model.row.samples.triangle);
             model.row.report.status = Status::ok;
           }}};
}

ModelStages placing_on_segments(const SampleParameters& p) {
  return {{"place_samples", [parameters = place_parameters(p), curved = p.curved](Model& model) {
             const MetricAt metric = [&segments = model.segments](std::uint32_t t, double b1, double b2) {
               return metric_at(segments, t, b1, b2);
             };
             place(model, parameters, segments_domain(model), metric);
             Samples& samples = model.row.samples;
             std::vector<std::uint32_t> sources;
             for (const std::uint32_t triangle : samples.triangle)
               sources.push_back(model.segments.source_triangle[triangle]);
             if (curved) lift(model, parameters, sources);  // may change the scale, which tensors need
             add_sample_tensors(model.segments, model.row.report.scale, samples);
             samples.triangle = std::move(sources);
             model.row.report.status = Status::ok;
           }}};
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

// ---- descriptors

void describe(Model& model, const DescribeParameters& parameters) {
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
  return {{"describe_shape", [parameters = p.describe](Model& model) { describe(model, parameters); }}};
}

ModelStages describing_anisotropy(const SampleParameters& p) {
  return {{"describe_shape", [parameters = p.describe](Model& model) {
             const AnisotropyReport report = model.segments.report;
             describe(model, parameters);
             for (DescriptorRow& row : anisotropy_rows(report))
               model.row.descriptors.push_back(std::move(row));
           }}};
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

struct MethodStages {
  MethodChoice choice;
  ModelStages (*charting)(const SampleParameters&);
  ModelStages (*placing)(const SampleParameters&, const EmbreeDevice*);
  ModelStages (*describing)(const SampleParameters&);
};
constexpr std::array<MethodStages, sampling_methods.size()> stages_by_method = {
    {{MethodChoice::automatic, charting_direct, placing_direct, describing},
     {MethodChoice::conformal, charting_conformal, placing_conformal, describing},
     {MethodChoice::direct, charting_direct, placing_direct, describing},
     {MethodChoice::anisotropic, charting_anisotropic, placing_anisotropic, describing_anisotropy}}};

static_assert([] {
  for (std::size_t i = 0; i < sampling_methods.size(); ++i)
    if (static_cast<std::size_t>(sampling_methods[i].choice) != i ||
        stages_by_method[i].choice != sampling_methods[i].choice)
      return false;
  return true;
}());

const MethodStages& registered(const SampleParameters& p) {
  return stages_by_method[static_cast<std::size_t>(p.method)];
}

}  // namespace

ModelStages charting_stages(const SampleParameters& parameters) {
  return registered(parameters).charting(parameters);
}

ModelStages placing_stages(const SampleParameters& parameters, const EmbreeDevice* device) {
  return registered(parameters).placing(parameters, device);
}

ModelStages stages_of(const SampleParameters& parameters, const EmbreeDevice* device) {
  return joined({charting_stages(parameters), placing_stages(parameters, device), making_columns(parameters),
                 attributing(parameters), registered(parameters).describing(parameters)});
}

void run_stages(const ModelStages& stages, Model& model) {
  for (const ModelStage& stage : stages) stage.run(model);
}

Samples samples_at(const Model& model, const PlaceParameters& parameters, std::size_t begin,
                   std::size_t end) {
  return samples_at(model.sites, model.file, model.surface, model.measure.density, model.key, parameters,
                    reported_frame(model.row.report), begin, end);
}

void release_charts(Model& model) {
  model.segments = TensorSegments{};
  model.coarse = CoarseMesh{};
  model.cuts = std::vector<CutChart>();
  model.charts = std::vector<FlatChart>();
  model.trees = std::vector<CurveTree>();
  forget_order(model);
}

}  // namespace meander
