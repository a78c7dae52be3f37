#include "kernels/tensor/make_tensor_field.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "kernels/core/check_range.h"
#include "kernels/core/expression.h"
#include "kernels/core/ordered_blocks.h"
#include "kernels/core/parallel.h"
#include "kernels/core/portable_functions.h"
#include "kernels/density/mesh_variables.h"
#include "kernels/tensor/curvature_tensors.h"
#include "kernels/tensor/tensor_blocks.h"
#include "kernels/tensor/vertex_tensors.h"

namespace meander {

namespace {

// Eigenvalues below this share of the larger one are zero within rounding.
constexpr double min_eigenvalue = 1e-14;
constexpr double min_length = 1 - 1e-6;  // of vectors, which files hold as float32

std::string printed(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

CurvatureFieldParameters curvature_parameters(const TensorParameters& p) {
  CurvatureFieldParameters result;
  result.adaptive = p.adaptive;
  result.max_ratio = p.max_ratio;
  result.epsilon = p.epsilon;
  result.smoothing = p.smoothing;
  return result;
}

AmbientTensor ambient(const double* v) { return {v[0], v[1], v[2], v[3], v[4], v[5]}; }

bool positive_definite(const std::array<double, 6>& values) {
  // The values are scaled, so that products of large numbers stay finite.
  double size = 0;
  for (const double v : values) {
    if (!std::isfinite(v)) return false;
    size = std::max(size, std::abs(v));
  }
  std::array<double, 6> scaled{};
  for (std::size_t k = 0; k < 6 && size > 0; ++k) scaled[k] = values[k] / size;
  const AmbientTensor a = ambient(scaled.data());
  // Sylvester's minors decide.
  const double second = a.xx * a.yy - a.xy * a.xy;
  const double third = a.xx * (a.yy * a.zz - a.yz * a.yz) - a.xy * (a.xy * a.zz - a.yz * a.xz) +
                       a.xz * (a.xy * a.yz - a.yy * a.xz);
  return a.xx > 0 && second > 0 && third > 0;
}

// 3 or 6 numbers for each of `count` elements, in columns or rows.
struct Columns {
  std::string name;     // in sentences: the vertex attribute "T", the table
  std::string element;  // vertex or face
  unsigned columns = 0;
  std::size_t count = 0, stride = 1;
  std::array<const double*, 6> begin{};
  const std::uint32_t* polygon = nullptr;  // rows by corners of triangles: the face of each triangle

  std::string place(std::size_t i) const {
    return polygon == nullptr ? element + " " + std::to_string(i) : "face " + std::to_string(polygon[i / 3]);
  }
  std::array<double, 6> row(std::size_t i) const {
    std::array<double, 6> values{};
    for (unsigned k = 0; k < columns; ++k) values[k] = begin[k][i * stride];
    return values;
  }
};

constexpr std::array<const char*, 6> tensor_suffix = {"_xx", "_xy", "_xz", "_yy", "_yz", "_zz"};
constexpr std::array<const char*, 3> vector_suffix = {"_x", "_y", "_z"};

const ScalarAttribute* find(std::span<const ScalarAttribute> attributes, const std::string& name) {
  for (const ScalarAttribute& attribute : attributes)
    if (attribute.name == name) return &attribute;
  return nullptr;
}

Columns columns_of(std::span<const ScalarAttribute> attributes, const std::string& name,
                   const std::string& element) {
  Columns result;
  result.name = "the " + element + " attribute \"" + name + "\"";
  result.element = element;
  const auto any = [&](std::span<const char* const> suffixes) {
    return std::any_of(suffixes.begin(), suffixes.end(),
                       [&](const char* s) { return find(attributes, name + s) != nullptr; });
  };
  const auto take = [&](std::span<const char* const> suffixes) {
    result.columns = static_cast<unsigned>(suffixes.size());
    for (std::size_t k = 0; k < suffixes.size(); ++k) {
      const ScalarAttribute* const attribute = find(attributes, name + suffixes[k]);
      if (attribute == nullptr)
        throw ItemError(Status::missing_attribute, "the tensor field needs the " + element + " attribute " +
                                                       name + suffixes[k] + " but the file has no such");
      result.begin[k] = attribute->values.data();
      result.count = k == 0 ? attribute->values.size() : std::min(result.count, attribute->values.size());
    }
  };
  if (any(tensor_suffix)) {
    take(tensor_suffix);
  } else if (any(vector_suffix)) {
    take(vector_suffix);
  } else {
    std::string names;
    for (const ScalarAttribute& attribute : attributes) names += (names.empty() ? "" : ", ") + attribute.name;
    throw ItemError(Status::missing_attribute,
                    "the tensor field needs the " + element + " attributes " + name + "_xx to " + name +
                        "_zz, or " + name + "_x to " + name + "_z, but the file " +
                        (names.empty() ? "has no " + element + " attributes"
                                       : "has only the " + element + " attributes " + names));
  }
  return result;
}

Columns columns_of(const TensorTable& table, std::size_t vertices) {
  Columns result;
  result.name = "the tensor table";
  result.element = "vertex";
  result.columns = table.columns;
  result.count = table.row_count();
  result.stride = table.columns;
  for (unsigned k = 0; k < table.columns; ++k) result.begin[k] = table.values.data() + k;
  if (result.count != vertices)
    throw ItemError(Status::unreadable, "the tensor table has " + std::to_string(result.count) +
                                            " rows but the file has " + std::to_string(vertices) +
                                            " vertices");
  return result;
}

// log S in the plane of the frame; false when the values are invalid.
bool log_spacing(const std::array<double, 6>& values, unsigned columns, TensorForm form,
                 const TangentFrame& frame, TangentTensor& result) {
  for (unsigned k = 0; k < columns; ++k)
    if (!std::isfinite(values[k])) return false;
  if (columns == 3) {
    const Vector3 v{values[0], values[1], values[2]};
    const double ratio = portable::hypot(v.x, v.y, v.z);
    if (!(ratio >= min_length) || !std::isfinite(ratio)) return false;
    const double x = dot(v, frame.x), y = dot(v, frame.y), length = portable::hypot(x, y);
    const double half = 0.5 * portable::log(std::max(1.0, ratio));
    result = {};
    if (length > 1e-6 * ratio) result = tensor_of({half, -half, x / length, y / length});
    return true;
  }
  const TangentTensor inner = tangent_part(ambient(values.data()), frame);
  TensorAxes axes = tensor_axes(inner);
  if (!std::isfinite(axes.first) || !(axes.second > min_eigenvalue * axes.first)) return false;
  axes.first = portable::log(axes.first);
  axes.second = portable::log(axes.second);
  result = tensor_of(axes);
  if (form == TensorForm::metric) result = -0.5 * result;
  return true;
}

[[noreturn]] void fail_at(const Columns& columns, std::size_t i) {
  const std::array<double, 6> values = columns.row(i);
  const std::string at = columns.place(i);
  for (unsigned k = 0; k < columns.columns; ++k)
    if (!std::isfinite(values[k]))
      throw ItemError(Status::unreadable, columns.name + " is not finite at " + at);
  if (columns.columns == 3)
    throw ItemError(Status::unreadable, columns.name + " has length " +
                                            printed(portable::hypot(values[0], values[1], values[2])) +
                                            " at " + at +
                                            "; a length is the ratio of the spacings and must be 1 or more");
  throw ItemError(Status::unreadable,
                  columns.name + " is not positive definite in the tangent plane at " + at);
}

// element(h): the row behind corner h; plane(h): the frame that its tensor lies in.
template <class Element, class Plane>
TensorField field_of(const PreparedMesh& mesh, const Columns& columns, TensorForm form,
                     const Element& element, const Plane& plane, const CancelToken& cancel) {
  TensorField field;
  field.corner.resize(mesh.triangles.size());
  std::atomic<std::size_t> bad{SIZE_MAX}, beyond{SIZE_MAX};
  const auto lower = [](std::atomic<std::size_t>& at, std::size_t i) {
    std::size_t old = at.load();
    while (i < old && !at.compare_exchange_weak(old, i)) {
    }
  };
  parallel_blocks(mesh.triangle_count(), tensor_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    for (std::size_t t = begin; t < end; ++t) {
      if (!(mesh.area[t] > 0)) continue;
      const TangentFrame own = triangle_frame(mesh, static_cast<std::uint32_t>(t));
      for (std::size_t h = 3 * t; h < 3 * t + 3; ++h) {
        const std::size_t i = element(h);
        if (i >= columns.count) {
          lower(beyond, i);
          continue;
        }
        const TangentFrame& frame = plane(h, own);
        TangentTensor value;
        if (!log_spacing(columns.row(i), columns.columns, form, frame, value))
          lower(bad, i);
        else
          field.corner[h] = &frame == &own ? value : transport(value, frame, own);
      }
    }
  });
  if (beyond < SIZE_MAX)
    throw ItemError(Status::internal, columns.name + " has " + std::to_string(columns.count) +
                                          " values but " + columns.element + " " + std::to_string(beyond) +
                                          " is used");
  if (bad < SIZE_MAX) fail_at(columns, bad);
  return field;
}

// A field from rows by vertices of the file, in the planes of the working vertices.
TensorField vertex_field(const PolygonMesh& file, const PreparedMesh& mesh, const Columns& columns,
                         TensorForm form, const CancelToken& cancel) {
  const std::vector<TangentFrame> frames = vertex_frames(mesh);
  return field_of(
      mesh, columns, form, [&](std::size_t h) -> std::size_t { return file.corners[mesh.corner_slot[h]]; },
      [&](std::size_t h, const TangentFrame&) -> const TangentFrame& { return frames[mesh.triangles[h]]; },
      cancel);
}

std::vector<Expression> formulas_of(const TensorParameters& p) {
  std::vector<Expression> formulas;
  for (const std::string_view text : split_formulas(p.formula)) formulas.emplace_back(text, mesh_variables);
  if (formulas.size() != 3 && formulas.size() != 6)
    throw std::invalid_argument(
        "the tensor \"" + p.formula + "\" has " + std::to_string(formulas.size()) +
        " formulas: it needs three, of a direction, or six, xx, xy, xz, yy, yz and zz");
  return formulas;
}

TensorField formula_field(const PolygonMesh& file, const PreparedMesh& mesh, const TensorParameters& p,
                          const CancelToken& cancel) {
  const std::vector<Expression> formulas = formulas_of(p);
  const MeshVariables variables(file, mesh, formulas, p.kind == TensorKind::unit_formula, cancel);
  const std::size_t count = mesh.triangles.size();
  std::vector<double> values(formulas.size() * count);
  ordered_blocks(mesh.triangle_count(), tensor_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    for (std::size_t k = 0; k < formulas.size(); ++k)
      variables.evaluate_corners(formulas[k], begin, end,
                                 std::span(values).subspan(k * count + 3 * begin, 3 * (end - begin)));
  });
  Columns columns{"the tensor `" + p.formula + "`",
                  "corner",
                  static_cast<unsigned>(formulas.size()),
                  count,
                  1,
                  {},
                  mesh.polygon.data()};
  for (std::size_t k = 0; k < formulas.size(); ++k) columns.begin[k] = values.data() + k * count;
  return field_of(
      mesh, columns, p.form, [](std::size_t h) -> std::size_t { return h; },
      [](std::size_t, const TangentFrame& own) -> const TangentFrame& { return own; }, cancel);
}

TensorField raw_field(const PolygonMesh& file, const PreparedMesh& mesh, const TensorParameters& p,
                      const CancelToken& cancel) {
  switch (p.kind) {
    case TensorKind::isotropic: {
      TensorField field;
      field.corner.resize(mesh.triangles.size());
      return field;
    }
    case TensorKind::vertex_attribute:
      return vertex_field(file, mesh, columns_of(file.vertex_attributes, p.attribute, "vertex"), p.form,
                          cancel);
    case TensorKind::face_attribute:
      return field_of(
          mesh, columns_of(file.face_attributes, p.attribute, "face"), p.form,
          [&](std::size_t h) -> std::size_t { return mesh.polygon[h / 3]; },
          [](std::size_t, const TangentFrame& own) -> const TangentFrame& { return own; }, cancel);
    case TensorKind::table:
      return vertex_field(file, mesh, columns_of(*p.table, file.vertex_count()), p.form, cancel);
    case TensorKind::constant: {
      Columns one{"the constant tensor", "vertex", 6, 1, 0, {}, nullptr};
      for (std::size_t k = 0; k < 6; ++k) one.begin[k] = &p.constant[k];
      const std::vector<TangentFrame> frames = vertex_frames(mesh);
      return field_of(
          mesh, one, p.form, [](std::size_t) -> std::size_t { return 0; },
          [&](std::size_t h, const TangentFrame&) -> const TangentFrame& {
            return frames[mesh.triangles[h]];
          },
          cancel);
    }
    case TensorKind::formula:
    case TensorKind::unit_formula:
      return formula_field(file, mesh, p, cancel);
    case TensorKind::curvature:
      break;
  }
  const std::vector<TangentFrame> frames = vertex_frames(mesh);
  cancel.check();
  return field_from_vertices(mesh, frames, curvature_field(mesh, frames, curvature_parameters(p), cancel));
}

// Reduces differences of the eigenvalues to log(max_ratio), with their sum kept.
TensorFieldReport clamp_ratios(const PreparedMesh& mesh, TensorField& field, double max_ratio) {
  const double limit = portable::log(max_ratio);
  std::vector<double> ratio(field.corner.size(), 1.0);
  std::vector<std::uint8_t> clamped(mesh.triangle_count(), 0);
  parallel_blocks(mesh.triangle_count(), tensor_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t h = 3 * begin; h < 3 * end; ++h) {
      if (!(mesh.area[h / 3] > 0)) continue;
      TangentTensor& tensor = field.corner[h];
      double difference = 2 * portable::hypot(0.5 * (tensor.xx - tensor.yy), tensor.xy);
      if (difference > limit) {
        // A difference in the last bits alone does not count.
        if (difference > limit + 1e-9) clamped[h / 3] = 1;
        const double half = 0.5 * trace(tensor), shrink = limit / difference;
        tensor = half * TangentTensor{1, 0, 1} + shrink * (tensor + -half * TangentTensor{1, 0, 1});
        difference = limit;
      }
      ratio[h] = portable::exp(difference);
    }
  });
  TensorFieldReport report;
  std::vector<double> weighted(mesh.area);
  for (std::size_t t = 0; t < weighted.size(); ++t) {
    weighted[t] *= (ratio[3 * t] + ratio[3 * t + 1] + ratio[3 * t + 2]) / 3;
    report.clamped_triangles += clamped[t];
  }
  report.mean_ratio = blocked_sum(weighted) / mesh.total_area;
  if (!ratio.empty()) report.max_ratio = *std::max_element(ratio.begin(), ratio.end());
  return report;
}

// Shifts values of any size (1e200, say) to where their exponentials are finite.
void center_spacings(const PreparedMesh& mesh, TensorField& field) {
  std::vector<double> weighted(mesh.area);
  for (std::size_t t = 0; t < weighted.size(); ++t)
    weighted[t] *=
        (trace(field.corner[3 * t]) + trace(field.corner[3 * t + 1]) + trace(field.corner[3 * t + 2])) / 6;
  const double mean = blocked_sum(weighted) / mesh.total_area;
  for (std::size_t h = 0; h < field.corner.size(); ++h)
    if (mesh.area[h / 3] > 0) field.corner[h] = field.corner[h] + -mean * TangentTensor{1, 0, 1};
}

}  // namespace

bool uses_coordinates(const TensorParameters& parameters) {
  if (!is_formula(parameters.kind)) return false;
  try {
    const std::vector<Expression> formulas = formulas_of(parameters);
    return std::ranges::any_of(formulas, [](const Expression& formula) { return uses_coordinates(formula); });
  } catch (const std::invalid_argument&) {
    return false;
  }
}

std::vector<std::string> validate(const TensorParameters& p) {
  std::vector<std::string> problems;
  check_range(problems, "tensor max ratio", p.max_ratio, 1, 64);
  check_range(problems, "tensor epsilon", p.epsilon, 1e-6, 1e3);
  check_range(problems, "tensor smoothing", p.smoothing, 0, 64);
  if ((p.kind == TensorKind::vertex_attribute || p.kind == TensorKind::face_attribute) && p.attribute.empty())
    problems.push_back("the tensor attribute has no name");
  if (p.kind == TensorKind::constant && !positive_definite(p.constant))
    problems.push_back("the constant tensor is not positive definite");
  if (is_formula(p.kind)) {
    try {
      formulas_of(p);
    } catch (const std::invalid_argument& error) {
      problems.push_back("tensor: " + std::string(error.what()));
    }
  }
  if (p.kind == TensorKind::table) {
    if (p.table == nullptr)
      problems.push_back("the tensor table is missing");
    else if ((p.table->columns != 3 && p.table->columns != 6) ||
             p.table->values.size() % p.table->columns != 0)
      problems.push_back("the tensor table must have 3 or 6 numbers a row");
  }
  return problems;
}

TensorField make_tensor_field(const PolygonMesh& file, const PreparedMesh& mesh,
                              const TensorParameters& parameters, const CancelToken& cancel,
                              TensorFieldReport* report) {
  std::string problems;
  for (const std::string& problem : validate(parameters))
    problems += (problems.empty() ? "" : "; ") + problem;
  if (!problems.empty()) throw std::invalid_argument(problems);
  TensorField field = raw_field(file, mesh, parameters, cancel);
  cancel.check();
  const TensorFieldReport ratios = clamp_ratios(mesh, field, parameters.max_ratio);
  if (report != nullptr) *report = ratios;
  center_spacings(mesh, field);
  if (const double factor = normalize_spacings(mesh, field); !std::isfinite(factor) || !(factor > 0))
    throw ItemError(Status::unreadable,
                    "the spacings of the tensor field differ too much: their density is not finite");
  return field;
}

}  // namespace meander
