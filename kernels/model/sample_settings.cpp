#include "kernels/model/sample_settings.h"

#include <algorithm>
#include <string_view>

#include "kernels/density/density_text.h"
#include "kernels/sample/attribute_text.h"
#include "kernels/tensor/tensor_text.h"

namespace meander {

namespace {

using P = SampleParameters;

constexpr double most_samples = 2147483648.0;

constexpr Word<LocatorKind> locate_words[] = {{"embree", LocatorKind::embree},
                                              {"elements", LocatorKind::elements},
                                              {"first-hit", LocatorKind::first_hit}};
constexpr Word<TensorForm> form_words[] = {{"spacing", TensorForm::spacing}, {"metric", TensorForm::metric}};
constexpr Word<AlignmentForm> parameterization_words[] = {{"metric", AlignmentForm::metric},
                                                          {"gradient", AlignmentForm::gradient}};
constexpr Word<bool> follow_words[] = {{"keep", false}, {"follow", true}};
constexpr Word<bool> topology_words[] = {{"full", true}, {"none", false}};
constexpr Word<HistogramScale> scale_words[] = {{"mean", HistogramScale::mean},
                                                {"largest", HistogramScale::largest}};

bool follows_tensor(const P& p) { return method_of(p).follows_tensor; }
bool has_coarse_charts(const P& p) { return method_of(p).makes_charts && !follows_tensor(p); }
bool is_shaped(const P& p) { return form_of(p.density).is_shaped; }
bool is_finished(const P& p) { return p.finish != FinishKind::none; }
bool has_sharp(const P& p) { return p.sharp.samples > 0; }
bool has_queries(const P& p) { return p.queries.any(); }
bool has_sharp_edges(const P& p) { return has_sharp(p) || p.queries.has(QueryKind::near_sharp); }
bool has_moves(const P& p) { return p.queries.has_moves(); }
bool has_gaussians(const P& p) { return has_moves(p) && p.queries.move != QueryMove::uniform; }
constexpr Word<bool> queries_type_words[] = {{"float32", false}, {"float16", true}};
bool is_spaced(const P& p) { return p.sequence == SequenceKind::spaced; }

template <bool (*has)(const DescriptorGroup&)>
bool describes(const DescribeParameters& p) {
  return std::any_of(p.descriptors.begin(), p.descriptors.end(),
                     [](Descriptor d) { return has(group_of(d)); });
}
bool has_bins(const DescriptorGroup& group) { return group.has_bins; }
bool takes_scale(const DescriptorGroup& group) { return group.takes_scale; }
bool takes_sources(const DescriptorGroup& group) { return group.takes_sources; }

std::string take_strict(P& p, std::string_view text) {
  std::string problems;
  p.strict = 0;
  for_each_word(text, [&](std::string_view word) {
    const auto at = std::find(note_names.begin(), note_names.end(), word);
    if (word == "all")
      p.strict = every_note;
    else if (at != note_names.end())
      p.strict |= set_of(static_cast<Note>(at - note_names.begin()));
    else
      problems += (problems.empty() ? "`" : "; `") + std::string(word) + "` is neither `all` nor a note (" +
                  joined_texts(note_names) + ")";
  });
  return problems;
}

void add_density_settings(SampleSettings& list) {
  list.text(
          "density", "--density", [](const P& p) { return density_text(p.density); },
          [](P& p, std::string_view text) { return take_density(text, p.density); }, density_help())
      .in_python("density")
      .common();
  constexpr const char* shaped = "applies to densities of curvature and textures only";
  list.number(
          "density_floor", "--density-floor", [](auto& p) -> auto& { return p.density.floor; }, 1e-6, 1,
          "Density of flat parts for curvature densities, of dark ones for textures, 1e-6 to 1")
      .in_python("density_floor")
      .acting(is_shaped, shaped);
  list.number(
          "density_exponent", "--density-exponent", [](auto& p) -> auto& { return p.density.exponent; }, 0.25,
          4, "Exponent of curvature and texture densities, 0.25 to 4")
      .in_python("density_exponent")
      .acting(is_shaped, shaped);
}

void add_place_settings(SampleSettings& list) {
  list.word(
      "locate", "--locate", [](auto& p) -> auto& { return p.locate; }, locate_words,
      "How a place along the curve becomes a point of the surface: embree: by a ray, which tells overlapping "
      "sheets of a chart apart; elements: within the piece of a triangle that the place lies in; first-hit: "
      "by "
      "the first triangle that a ray meets (Quinn et al. 2013)");
  list.word(
          "place", "--place", [](auto& p) -> auto& { return p.place; }, place_words,
          "Where samples lie in a curve element (default element; vertex for first-hit)")
      .without_default();
  list.word(
          "sequence", "--sequence", [](auto& p) -> auto& { return p.sequence; }, sequence_words,
          sequence_help)
      .in_python("sequence")
      .common();
  list.word(
          "spacing", "--spacing", [](auto& p) -> auto& { return p.spacing; }, spacing_words, spacing_help)
      .in_python("spacing")
      .only_recorded(is_spaced)
      .acting(is_spaced, spacing_applies_to);
  list.word(
          "finish", "--finish", [](auto& p) -> auto& { return p.finish; }, finish_words, finish_help)
      .in_python("finish")
      .only_recorded(is_finished);
  list.word(
          "order", "--order", [](auto& p) -> auto& { return p.order; }, order_words,
          "Order in the file: every prefix well spread, or along the curve")
      .in_python("order");
  list.text(
          "curve", "--curve", [](const P& p) { return std::string(text_of(element_orders, order_of(p))); },
          [](P& p, std::string_view text) {
            ElementOrder order{};
            if (!take_word(element_orders, text, order)) return none_of(text, all_words(element_orders));
            p.curve = order;
            return std::string();
          },
          "Order of a named method: a curve, or balanced bisection (default hilbert); direct: hilbert or "
          "balanced")
      .in_python("curve")
      .without_default()
      .words = all_words(element_orders);
}

void add_tensor_settings(SampleSettings& list) {
  constexpr const char* only = "applies to --method anisotropic only";
  list.under("Anisotropic");
  list.text(
          "tensor", "--tensor", [](const P& p) { return tensor_text(p.tensor); },
          [](P& p, std::string_view text) { return take_tensor(text, p.tensor); },
          "Wanted spacings of --method anisotropic: " + std::string(tensor_forms))
      .only_recorded(follows_tensor)
      .acting(follows_tensor, only);
  list.word(
          "tensor_form", "--tensor-form", [](auto& p) -> auto& { return p.tensor.form; }, form_words,
          "Six numbers are spacings S, or a metric G = S^-2")
      .only_recorded(follows_tensor)
      .acting(follows_tensor, only);
  list.number(
          "tensor_ratio", "--tensor-ratio", [](auto& p) -> auto& { return p.tensor.max_ratio; }, 0, 0,
          "Largest ratio of the two spacings, 1 to 64")
      .only_recorded(follows_tensor)
      .acting(follows_tensor, only);
  list.word(
          "tensor_density", "--tensor-density", [](auto& p) -> auto& { return p.tensor.adaptive; },
          follow_words, "curvature: keep the density (only shapes vary), or follow the curvature")
      .only_recorded(follows_tensor)
      .acting(follows_tensor, only);
  list.number(
          "tensor_smoothing", "--tensor-smoothing", [](auto& p) -> auto& { return p.tensor.smoothing; }, 0, 0,
          "curvature: rounds of smoothing, 0 to 64")
      .only_recorded(follows_tensor)
      .acting(follows_tensor, only);
  list.word(
          "tensor_charts", "--parameterization", [](auto& p) -> auto& { return p.tensor_charts.form; },
          parameterization_words,
          "Charts conformal in the tensor's metric, or along its directions (gradient)")
      .only_recorded(follows_tensor)
      .acting(follows_tensor, only);
  list.number(
          "tensor_segments", "--segments", [](auto& p) -> auto& { return p.tensor_charts.segment.count; }, 1,
          65536,
          "Initial number of segments (random walks), at least one per component; default: 1, gradient 16")
      .without_default()
      .only_recorded(follows_tensor)
      .acting(follows_tensor, only);
}

std::string method_help() {
  std::string help = "How the surface is ordered: ";
  for (const SamplingMethod& method : sampling_methods)
    help += (&method == &sampling_methods.front() ? "" : "; ") + std::string(method.help);
  return help;
}

SampleSettings make_point_settings() {
  SampleSettings list;
  list.under("Points");
  list.number(
          "samples", "-n,--samples", [](auto& p) -> auto& { return p.samples; }, 1, most_samples,
          "Points per model, 1 to 2^31")
      .in_python("n")
      .common();
  list.word(
          "method", "--method", [](auto& p) -> auto& { return p.method; }, sampling_methods, method_help())
      .in_python("method")
      .common();
  add_density_settings(list);
  add_place_settings(list);
  list.number(
          "seed", "--seed", [](auto& p) -> auto& { return p.seed; }, 0, 0, "Seed, 0 to 2^64 - 1")
      .in_python("seed")
      .common();
  list.word(
          "normalize", "--normalize", [](auto& p) -> auto& { return p.normalize; }, normalize_words,
          "Stored coordinates; loc and scale undo it. none: those of the file; unit-sphere: the center of "
          "the box at 0, the farthest vertex of a face with an area at distance 1; unit-box: that center "
          "at 0, the longest side of the box 1; unit-diagonal: that center at 0, the diagonal of the box 1, "
          "as in ShapeNet; pointnet: the mean of the samples at 0, the farthest sample at distance 1")
      .in_python("normalize")
      .common();
  list.flag(
          "curved", "--curved", [](auto& p) -> auto& { return p.curved; },
          "Lift the points from the flat triangles to the smooth surface that the vertex normals define")
      .in_python("curved")
      .only_recorded([](const P& p) { return p.curved; });
  add_tensor_settings(list);
  return list;
}

// A flag for each column that is asked for in this way.
void add_columns(SampleSettings& list, Having having) {
  for (std::size_t c = 0; c < sample_columns.size(); ++c) {
    const SampleColumn& column = sample_columns[c];
    if (!column.is_asked_for() || column.having != having) continue;
    const std::string word(column.option);
    auto& setting = list.flag(
        word, "--" + word, [c](auto& p) -> auto& { return p.columns[c]; }, std::string(column.help));
    setting.in_python(word).only_recorded([c](const P& p) { return p.columns[c]; });
    if (column.common) setting.common();
  }
}

SampleSettings make_value_settings() {
  SampleSettings list;
  list.under("Collection");
  add_columns(list, Having::taken);
  list.text(
          "attributes", "--attribute", [](const P& p) { return attributes_text(p.attributes); },
          [](P& p, std::string_view text) { return take_attributes(text, p.attributes); },
          "Store an attribute of the models as /attributes/NAME; repeat it for several. NAME:2, NAME:3 and "
          "NAME:4 name vectors. Values of faces are copied. Values of vertices are interpolated if they are "
          "real numbers; integers are classes, copied from the nearest corner of the triangle. NAME:class "
          "treats any values as classes (int32), NAME:linear interpolates integers")
      .list()
      .in_python("attributes")
      .only_recorded([](const P& p) { return !p.attributes.empty(); });
  return list;
}

void add_sharp_settings(SampleSettings& list) {
  constexpr const char *only = "applies to --sharp only",
                       *edges = "applies to --sharp and to --queries near-sharp=... only";
  list.number(
          "sharp", "--sharp", [](auto& p) -> auto& { return p.sharp.samples; }, 0, most_sharp_samples,
          "Points on the sharp edges of every model, beside its samples, evenly spread by length (/sharp)")
      .in_python("sharp")
      .without_default()
      .only_recorded(has_sharp);
  list.number(
          "sharp_angle", "--sharp-angle", [](auto& p) -> auto& { return p.sharp.angle; }, 1, 179,
          "Degrees between the normals of two faces from which their edge is sharp, 1 to 179")
      .in_python("sharp_angle")
      .only_recorded(has_sharp_edges)
      .acting(has_sharp_edges, edges);
  list.flag(
          "sharp_borders", "--sharp-borders", [](auto& p) -> auto& { return p.sharp.borders; },
          "Edges at which the surface ends are sharp, too")
      .in_python("sharp_borders")
      .only_recorded([](const P& p) { return p.sharp.borders; })
      .acting(has_sharp_edges, edges);
  list.flag(
          "sharp_corners", "--sharp-corners", [](auto& p) -> auto& { return p.sharp.corners; },
          "The first points of --sharp are the corners of its edges: where other than two meet, or where "
          "two turn by --sharp-angle")
      .in_python("sharp_corners")
      .only_recorded([](const P& p) { return p.sharp.corners; })
      .acting(has_sharp, only);
  list.text(
          "sharp_attribute", "--sharp-attribute", [](const P& p) { return p.sharp.attribute; },
          [](P& p, std::string_view text) {
            p.sharp.attribute = text;
            return std::string();
          },
          "Edges between faces that differ in this attribute, as material or part, are sharp, too; one of "
          "those that --attribute names")
      .in_python("sharp_attribute")
      .without_default()
      .only_recorded([](const P& p) { return !p.sharp.attribute.empty(); })
      .acting(has_sharp_edges, edges);
  list.word(
          "sharp_fill", "--sharp-fill", [](auto& p) -> auto& { return p.sharp.fill; }, sharp_fill_words,
          "What stands in where a model has no sharp edge: its samples, or NaN")
      .in_python("sharp_fill")
      .only_recorded(has_sharp)
      .acting(has_sharp, only);
}

SampleSettings make_column_settings() {
  SampleSettings list;
  list.under("Collection");
  add_columns(list, Having::made);
  return list;
}

void add_query_settings(SampleSettings& list) {
  constexpr const char* only = "applies to --queries only";
  list.text(
          "queries", "--queries", [](const P& p) { return queries_text(p.queries.terms); },
          [](P& p, std::string_view text) { return take_queries(text, p.queries.terms); },
          "Points in space with their signed distances, for every model (/queries), as in "
          "\"near=250000@.005,.05 near-sharp=125000@.001,.01 volume=250000@1.05\": near: points of the "
          "surface, moved by these sizes; near-sharp: those of sharp edges; volume: points in a box of this "
          "half side. In units of the stored frame, with --normalize none of half the longest side of the "
          "model")
      .in_python("queries")
      .without_default()
      .only_recorded(has_queries);
  list.word(
          "queries_move", "--queries-move", [](auto& p) -> auto& { return p.queries.move; }, query_move_words,
          "How near and near-sharp points are moved. gaussian: along each axis by a Gaussian whose standard "
          "deviation is the size; uniform: along each axis evenly by up to the size; along-normal: by such a "
          "Gaussian along the normal")
      .in_python("queries_move")
      .only_recorded([](const P& p) { return p.queries.move != QueryMove::gaussian; })
      .acting(has_moves, "applies to --queries near=... and near-sharp=... only");
  list.number(
          "queries_cut", "--queries-cut", [](auto& p) -> auto& { return p.queries.cut; }, 0,
          largest_query_size,
          "Take Gaussian moves that are no larger than this, in the unit of the sizes (0: all)")
      .in_python("queries_cut")
      .only_recorded([](const P& p) { return p.queries.cut > 0; })
      .acting(has_gaussians, "applies to --queries near=... and near-sharp=... with Gaussian moves only");
  list.word(
          "sign", "--sign", [](auto& p) -> auto& { return p.queries.sign; }, sign_choice_words,
          "How sides are decided. closed: by whole winding numbers, where every component is closed; "
          "winding: by winding numbers, where the surface is nearly closed; shell: inside is what a flood "
          "from outside does not reach; auto: the first of these that fits the model; none: distances have "
          "no "
          "sign")
      .in_python("sign")
      .only_recorded(has_queries)
      .acting(has_queries, only);
  list.word(
          "queries_type", "--queries-type", [](auto& p) -> auto& { return p.queries.halves; },
          queries_type_words, "Type of the points and distances of --queries; float16 needs --normalize")
      .in_python("queries_type")
      .only_recorded(has_queries)
      .acting(has_queries, only);
  list.flag(
          "queries_nearest", "--queries-nearest", [](auto& p) -> auto& { return p.queries.nearest; },
          "Store the face, corners and weights of the nearest point of the surface, too")
      .in_python("queries_nearest")
      .only_recorded([](const P& p) { return p.queries.nearest; })
      .acting(has_queries, only);
}

SampleSettings make_training_settings() {
  SampleSettings list;
  list.under("Training data");
  add_sharp_settings(list);
  add_query_settings(list);
  return list;
}

DescribeSettings make_describe_settings() {
  const auto only = [](bool (*has)(const DescriptorGroup&)) {
    return "applies to " + descriptors_with(has) + " only";
  };
  DescribeSettings list;
  list.number(
          "descriptor_bins", "--bins", [](auto& p) -> auto& { return p.bins; }, 8, 1024,
          "Bins of histograms, 8 to 1024")
      .in_python("bins")
      .acting(describes<has_bins>, only(has_bins));
  list.word(
          "descriptor_scale", "--descriptor-scale", [](auto& p) -> auto& { return p.scale; }, scale_words,
          "Bins of " + descriptors_with(takes_scale) +
              " up to 3 x the mean distance (mean; Osada et al. 2002) or up to the largest distance "
              "(largest; Quinn et al. 2013)")
      .acting(describes<takes_scale>, only(takes_scale));
  list.number(
          "geodesic_sources", "--geodesic-sources", [](auto& p) -> auto& { return p.geodesic_sources; }, 0,
          most_samples, "Samples that geodesic distances start from (0: all)")
      .acting(describes<takes_sources>, only(takes_sources));
  return list;
}

SampleSettings make_collection_settings() {
  SampleSettings list;
  list.under("Points");
  list.word(
          "topology", "--topology", [](auto& p) -> auto& { return p.topology; }, topology_words,
          "full: find components, boundaries and one orientation of every surface; none: take the "
          "triangles as they are, faster and in less memory (auto and direct)")
      .in_python("topology")
      .as_truth("full", "none")
      .only_recorded([](const P& p) { return !p.topology; });
  list.under("Collection");
  list.text(
          "describe", "--describe",
          [](const P& p) {
            std::string names;
            for (const Descriptor d : p.describe.descriptors)
              names += (names.empty() ? "" : ",") + std::string(name_of(d));
            return names.empty() ? std::string("none") : names;
          },
          [](P& p, std::string_view text) { return take_descriptors(text, p.describe.descriptors); },
          "Descriptors to store: none, or one or more of " + joined_texts(descriptor_names, ",") +
              ", separated by commas")
      .in_python("describe")
      .common();
  list.append(describe_settings(), &P::describe);
  list.text(
          "strict", "--strict", [](const P& p) { return words_of(p.strict); }, take_strict,
          "Fail models of which something is missing, such as a texture image: they get the status "
          "incomplete "
          "instead of a row without it. The notes that count: all, or one or more of " +
              joined_texts(note_names))
      .list()
      .only_recorded([](const P& p) { return p.strict != 0; });
  return list;
}

SampleSettings make_constants() {
  SampleSettings list;
  list.constant("curve_max_depth", [](const P& p) { return p.locator.curve.max_depth; });
  list.constant("density_quantile", [](const P& p) { return p.density.quantile; });
  list.constant("elements_per_sample", [](const P& p) { return elements_per_sample(p); });
  list.constant("extremity_seams", [](const P& p) { return p.cut.extremity_seams; });
  list.constant("jitter", [](const P& p) { return p.jitter; });
  list.constant("leaves_per_sample", [](const P& p) { return p.locator.curve.leaves_per_sample; });
  list.constant("max_extra_seams", [](const P& p) { return p.flatten.max_extra_seams; });
  list.constant("max_mean_distortion", [](const P& p) { return p.flatten.max_mean_distortion; });
  list.constant("max_sheets", [](const P& p) { return p.locator.max_sheets; });
  list.constant("min_component_samples", [](const P& p) { return p.locator.min_component_samples; });
  list.constant("min_log_scale", [](const P& p) { return p.flatten.min_log_scale; });
  list.constant("min_sheet_samples", [](const P& p) { return p.locator.min_sheet_samples; });
  return list;
}

SampleSettings make_chart_constants() {
  SampleSettings list;
  const auto coarse = [&list](const char* name, auto get) {
    list.constant(name, get).only_recorded(has_coarse_charts);
  };
  coarse("coarse_mean_distortion", [](const P&) { return coarse_mean_distortion; });
  coarse("coarse_elements_per_sample", [](const P& p) { return coarse_elements_per_sample(p.samples); });
  coarse("coarse_least_of_component", [](const P& p) { return p.coarsen.min_of_component; });
  coarse("coarse_least_triangles", [](const P& p) { return p.coarsen.min_triangles; });
  coarse("coarse_triangles_per_sample", [](const P& p) { return p.coarsen.triangles_per_sample; });
  const auto add = [&list](const char* name, auto get) {
    list.constant(name, get).only_recorded(follows_tensor);
  };
  add("tensor_bisections", [](const P& p) { return p.tensor_charts.max_bisections; });
  add("tensor_chart_ratio", [](const P& p) { return p.tensor_charts.limits.ratio; });
  add("tensor_epsilon", [](const P& p) { return p.tensor.epsilon; });
  add("tensor_mean_distortion", [](const P&) { return metric_mean_distortion; });
  return list;
}

}  // namespace

const SampleSettings& point_settings() {
  static const SampleSettings list = make_point_settings();
  return list;
}

const SampleSettings& value_settings() {
  static const SampleSettings list = make_value_settings();
  return list;
}

const SampleSettings& column_settings() {
  static const SampleSettings list = make_column_settings();
  return list;
}

const SampleSettings& training_settings() {
  static const SampleSettings list = make_training_settings();
  return list;
}

const SampleSettings& collection_settings() {
  static const SampleSettings list = make_collection_settings();
  return list;
}

std::span<const SampleSettings* const> sample_settings() {
  static const SampleSettings* const lists[] = {&point_settings(), &value_settings(), &column_settings(),
                                                &training_settings(), &collection_settings()};
  return lists;
}

const DescribeSettings& describe_settings() {
  static const DescribeSettings list = make_describe_settings();
  return list;
}

const SampleSettings& sampling_constants() {
  static const SampleSettings list = make_constants();
  return list;
}

const SampleSettings& chart_constants() {
  static const SampleSettings list = make_chart_constants();
  return list;
}

std::string descriptors_with(bool (*has)(const DescriptorGroup&)) {
  std::vector<std::string_view> names;
  for (const DescriptorGroup& group : descriptor_groups)
    if (has(group)) names.push_back(group.name);
  if (names.size() < 2) return names.empty() ? "none" : std::string(names.front());
  const std::string last(names.back());
  names.pop_back();
  return joined_texts(names) + " and " + last;
}

void settle(SampleParameters& p, const GivenSettings& given) {
  const bool first_hit = p.locate == LocatorKind::first_hit;
  if (!given.contains("place")) p.place = first_hit ? PlaceKind::vertex : PlaceKind::element;
  // A sample at a curve vertex needs many vertices per sample, or the pattern is quantized (docs/METHODS.md
  // 7.4).
  if (first_hit) p.locator.curve.leaves_per_sample = 64;
  if (!first_hit && p.place == PlaceKind::vertex) p.elements.elements_per_sample = 64;
  if (!given.contains("tensor_segments") && p.tensor_charts.form == AlignmentForm::gradient)
    p.tensor_charts.segment.count = 16;
}

}  // namespace meander
