#include "kernels/model/sample_parameters.h"

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "kernels/core/check_range.h"
#include "kernels/density/formula_density.h"
#include "kernels/model/sample_settings.h"
#include "kernels/partition/element_cells.h"
#include "kernels/sample/column_makers.h"

namespace meander {

SampleParameters parameters_for(std::string_view method) {
  SampleParameters parameters;
  if (!take_word(sampling_methods, method, parameters.method))
    throw std::invalid_argument("there is no sampling method `" + std::string(method) + "`");
  return parameters;
}

namespace {

// What cannot be had from the triangles alone.
void check_without_topology(const SampleParameters& p, std::vector<std::string>& problems) {
  const auto need = [&](const std::string& what) {
    problems.push_back(what + " needs the topology of the surface: do without it, or find the topology");
  };
  const SamplingMethod& method = method_of(p);
  if (method.makes_charts) need("the method " + std::string(method.text));
  if (form_of(p.density).needs_topology || uses_curvature(p.density)) need("a curvature density");
  if (p.curved) need("lifting the samples to the curved surface");
  if (p.finish == FinishKind::relax) need("the finish `relax`");
  for (const ColumnMaker& maker : column_makers)
    if (p.columns[maker.column] && maker.reads.neighbors)
      need("the column " + std::string(sample_columns[maker.column].name));
  for (const Descriptor descriptor : p.describe.descriptors)
    if (group_of(descriptor).needs_mesh) need("the descriptor " + std::string(name_of(descriptor)));
}

}  // namespace

std::vector<std::string> validate(const SampleParameters& p) {
  std::vector<std::string> problems;
  for (const SampleSettings* const list : sample_settings()) check_ranges(*list, p, problems);
  check_range(problems, "jitter", p.jitter, 0.0, 1.0);
  check_range(problems, "elements per sample", p.elements.elements_per_sample, 1.0, 64.0);
  check_range(problems, "leaves per sample", p.locator.curve.leaves_per_sample, 1.0, 256.0);
  check_range(problems, "curve depth", p.locator.curve.max_depth, 1, 31);
  check_range(problems, "sheets", p.locator.max_sheets, 1, 16);
  check_range(problems, "coarse triangles per sample", p.coarsen.triangles_per_sample, 0.25, 1e12);
  check_range(problems, "coarse triangles", p.coarsen.min_triangles, 64, 2147483648.0);
  check_range(problems, "coarse triangles of a component", p.coarsen.min_of_component, 64, 2147483648.0);
  check_range(problems, "extremity seams", p.cut.extremity_seams, 0, 16);
  check_range(problems, "extra seams", p.flatten.max_extra_seams, 0, 64);
  check_range(problems, "effort", p.flatten.effort, 0.0, 1e6);
  check_range(problems, "density quantile", p.density.quantile, 0.01, 1.0);
  if (form_of(p.density).text_member == &DensityParameters::attribute && p.density.attribute.empty())
    problems.push_back("the density needs the name of an attribute");
  const SamplingMethod& method = method_of(p);
  if (is_formula(p.density.kind)) {
    try {
      formula_of(p.density);
    } catch (const std::invalid_argument& error) {
      problems.push_back("density: " + std::string(error.what()));
    }
  }
  if (reads_textures(p.density.kind) && !p.columns[&Samples::rgb])
    problems.push_back("the density `texture` is read from the images of models: set colors");
  if (is_in_pieces(p.density) && method.follows_tensor)
    problems.push_back("the density `" +
                       (is_formula(p.density.kind) ? p.density.formula : std::string("texture")) +
                       "` does not go with the method " + std::string(method.text) +
                       ", which takes none that is finer than triangles: choose another density or method");
  if (p.curve && !method.takes_curve)
    problems.push_back("the method " + std::string(method.text) +
                       " chooses the order itself: name a method to choose the curve");
  if (!method.makes_charts && row_of(element_orders, order_of(p)).in_space == Method::none)
    problems.push_back("the method " + std::string(method.text) + " knows the curves hilbert and balanced");
  if (!p.topology) check_without_topology(p, problems);
  if (p.locate == LocatorKind::first_hit && method_of(p).makes_charts &&
      order_of(p) == ElementOrder::balanced)
    problems.push_back("the locator first-hit follows a curve: it has no balanced order");
  if (p.locate == LocatorKind::first_hit && p.place == PlaceKind::element)
    problems.push_back("the locator first-hit knows curve vertices only: place at vertices");
  if (p.sequence == SequenceKind::spaced && p.place == PlaceKind::vertex)
    problems.push_back(
        "the sequence `spaced` chooses points in elements: place at elements, not vertices, or choose "
        "another sequence");
  if (p.queries.halves && p.normalize == NormalizeKind::none)
    problems.push_back(
        "float16 does not hold coordinates of files: choose a frame for points of queries in float16 "
        "(normalize), or float32");
  if (const std::string& name = p.sharp.attribute;
      !name.empty() &&
      std::none_of(p.attributes.begin(), p.attributes.end(),
                   [&](const AttributeColumn& column) { return column.name == name && column.width == 1; }))
    problems.push_back("sharp edges between faces that differ in `" + name +
                       "` need this attribute of faces, one number each: store it (attribute)");
  if (p.finish == FinishKind::relax) {
    const std::string relaxing = "the finish `relax` ";
    if (method.follows_tensor)
      problems.push_back(relaxing + "keeps distances in space and does not go with the method " +
                         std::string(method.text) + ": choose another method or no finish");
    if (p.place == PlaceKind::vertex)
      problems.push_back(relaxing + "moves samples off the vertices of the curve: place at elements");
  }
  if (!p.describe.descriptors.empty() && p.samples < 4)
    problems.push_back("descriptors need at least 4 samples");
  if (method_of(p).follows_tensor) {
    // Tables may come with each model (Model::tensor_table).
    TensorParameters tensor = p.tensor;
    if (tensor.kind == TensorKind::table && !tensor.table) tensor.table = std::make_shared<TensorTable>();
    for (const std::string& problem : validate(tensor)) problems.push_back(problem);
  }
  check_range(problems, "smallest segment", p.tensor_charts.segment.min_triangles, 1, 1 << 20);
  check_range(problems, "bisections", p.tensor_charts.max_bisections, 0, 16);
  constexpr std::size_t most_columns = 32;  // the bits of ItemReport::lacks
  const std::size_t optional =
      p.attributes.size() + p.columns.count([](const SampleColumn& column) { return column.is_optional(); });
  if (optional > most_columns)
    problems.push_back("attributes and texture coordinates are " + std::to_string(optional) +
                       " columns, at most " + std::to_string(most_columns) + " are possible");
  for (const AttributeColumn& column : p.attributes)
    check_range(problems, "the width of an attribute", column.width, 1, 4);
  return problems;
}

bool casts_rays(const SampleParameters& parameters) {
  return method_of(parameters).makes_charts && parameters.locate != LocatorKind::elements;
}

ElementOrder order_of(const SampleParameters& parameters) {
  return parameters.curve.value_or(method_of(parameters).order);
}

namespace {

ElementUse use_of(const SampleParameters& parameters) {
  if (parameters.place == PlaceKind::vertex) return ElementUse::vertices;
  if (parameters.sequence == SequenceKind::spaced) return ElementUse::places;
  return forms_net(place_parameters(parameters)) ? ElementUse::net : ElementUse::positions;
}

}  // namespace

double elements_per_sample(const SampleParameters& parameters) {
  const double asked = parameters.elements.elements_per_sample;
  double least = 0;
  if (method_of(parameters).follows_tensor) least = tensor_elements_per_sample;
  if (order_of(parameters) == ElementOrder::balanced) {
    const bool splits = may_split(use_of(parameters), !method_of(parameters).makes_charts,
                                  parameters.density.kind == DensityKind::uniform);
    least = std::max(least, balanced_elements_per_sample(parameters.samples, splits));
  }
  return std::max(asked, least);
}

bool places_in_regions(const SampleParameters& parameters) {
  return parameters.samples > most_whole_samples && parameters.sequence != SequenceKind::spaced &&
         parameters.finish == FinishKind::none &&
         !(method_of(parameters).makes_charts && parameters.locate == LocatorKind::first_hit);
}

bool leaves_sites(const SampleParameters& parameters) {
  return parameters.rows_only && parameters.samples > parameters.most_kept_samples &&
         places_in_regions(parameters) && !method_of(parameters).follows_tensor && !parameters.curved &&
         parameters.columns.empty() && parameters.attributes.empty() && parameters.sharp.samples == 0 &&
         !parameters.queries.any() && parameters.describe.descriptors.empty();
}

ElementParameters element_parameters(const SampleParameters& parameters) {
  ElementParameters elements = parameters.elements;
  elements.samples = parameters.samples;
  elements.elements_per_sample = elements_per_sample(parameters);
  elements.order = order_of(parameters);
  elements.use = use_of(parameters);
  return elements;
}

LocateParameters locate_parameters(const SampleParameters& parameters) {
  LocateParameters locator = parameters.locator;
  locator.samples = parameters.samples;
  locator.curve.kind = curve_of(order_of(parameters));
  return locator;
}

PlaceParameters place_parameters(const SampleParameters& parameters) {
  return {parameters.samples,   parameters.sequence, parameters.order,   parameters.place,
          parameters.normalize, parameters.jitter,   parameters.spacing, parameters.finish};
}

bool reads_coordinates(const SampleParameters& p) {
  return any_reads(p.columns, &ColumnReads::coordinates) || uses_coordinates(p.density) ||
         (method_of(p).follows_tensor && uses_coordinates(p.tensor));
}

}  // namespace meander
