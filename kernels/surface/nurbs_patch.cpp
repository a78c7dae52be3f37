#include "kernels/surface/nurbs_patch.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <string>

#include "kernels/core/status.h"
#include "kernels/surface/digest_bytes.h"

namespace meander {

namespace {

constexpr std::size_t max_basis = max_nurbs_degree + 1;

// Values and first two derivatives (by the knot parameter) of the degree + 1 basis functions that do not
// vanish on a knot span.
struct Basis {
  std::size_t first = 0;  // the index of the first of them
  std::array<std::array<double, max_basis>, 3> value{};
};

// One direction of the net.
struct KnotLine {
  std::size_t degree = 0, count = 0;
  std::vector<double> knots;

  double begin() const { return knots[degree]; }
  double end() const { return knots[count]; }

  // The span [knots[k], knots[k + 1]) of positive length that holds t; the last span is closed.
  std::size_t span_of(double t) const {
    const auto from = knots.begin() + static_cast<std::ptrdiff_t>(degree);
    const auto to = knots.begin() + static_cast<std::ptrdiff_t>(count);
    const auto above = t < *to ? std::upper_bound(from, to, t) : std::lower_bound(from, to, *to);
    return static_cast<std::size_t>(above - knots.begin()) - 1;
  }

  // Cox and de Boor's recursion over rising degrees; derivatives come from the functions of lower degree.
  Basis basis(double t, int derivatives) const {
    Basis result;
    const std::size_t span = span_of(t);
    result.first = span - degree;
    std::array<double, max_basis> lower{}, lowest{};  // of degree - 1 and degree - 2
    std::array<double, max_basis>& n = result.value[0];
    n[0] = 1;
    for (std::size_t d = 1; d <= degree; ++d) {
      lowest = lower;
      lower = n;
      raise(span, d, t, lower, n);
    }
    if (derivatives >= 1) differentiate(span, degree, lower, result.value[1]);
    if (derivatives >= 2 && degree >= 2) {
      std::array<double, max_basis> slope{};
      differentiate(span, degree - 1, lowest, slope);
      differentiate(span, degree, slope, result.value[2]);
    }
    return result;
  }

  // Computes the functions of degree d at t from those of degree d - 1 on the same span.
  void raise(std::size_t span, std::size_t d, double t, const std::array<double, max_basis>& low,
             std::array<double, max_basis>& high) const {
    double carried = 0;
    for (std::size_t r = 0; r < d; ++r) {
      const double left = knots[span + 1 + r - d], right = knots[span + 1 + r];
      const double share = low[r] / (right - left);
      high[r] = carried + (right - t) * share;
      carried = (t - left) * share;
    }
    high[d] = carried;
  }

  // Computes derivatives of the functions of degree d whose lower neighbors (or derivatives of these) are
  // `low`.
  void differentiate(std::size_t span, std::size_t d, const std::array<double, max_basis>& low,
                     std::array<double, max_basis>& result) const {
    double carried = 0;
    for (std::size_t r = 0; r < d; ++r) {
      const double share = static_cast<double>(d) * low[r] / (knots[span + 1 + r] - knots[span + 1 + r - d]);
      result[r] = carried - share;
      carried = share;
    }
    result[d] = carried;
  }
};

struct Homogeneous {
  double x = 0, y = 0, z = 0, w = 0;
};

class NurbsPatch final : public PointwiseSurface<NurbsPatch> {
 public:
  explicit NurbsPatch(NurbsNet net) : points_(std::move(net.points)), weights_(std::move(net.weights)) {
    u_ = {static_cast<std::size_t>(net.degree_u),
          net.knots_u.size() - 1 - static_cast<std::size_t>(net.degree_u), std::move(net.knots_u)};
    v_ = {static_cast<std::size_t>(net.degree_v),
          net.knots_v.size() - 1 - static_cast<std::size_t>(net.degree_v), std::move(net.knots_v)};
    DigestBytes digest;
    digest.add(u_.degree);
    digest.add(v_.degree);
    for (const std::vector<double>* data : {&u_.knots, &v_.knots, &points_, &weights_})
      for (const double value : *data) digest.add(value);
    content_ = digest.bytes();
  }

  std::string_view name() const override { return "nurbs"; }
  std::array<std::uint8_t, 16> content() const override { return content_; }

 private:
  friend class PointwiseSurface<NurbsPatch>;

  // Sums numerator and denominator with their derivatives, then applies the quotient rule.
  SurfaceJet jet(double u, double v, int derivatives) const {
    const double length_u = u_.end() - u_.begin(), length_v = v_.end() - v_.begin();
    const Basis along_u = u_.basis(u_.begin() + u * length_u, derivatives);
    const Basis along_v = v_.basis(v_.begin() + v * length_v, derivatives);
    const auto sum = [&](std::size_t order_u, std::size_t order_v, double scale) {
      Homogeneous total;
      for (std::size_t i = 0; i <= u_.degree; ++i) {
        Homogeneous row;
        for (std::size_t j = 0; j <= v_.degree; ++j) {
          const std::size_t k = (along_u.first + i) * v_.count + along_v.first + j;
          const double weight = along_v.value[order_v][j] * (weights_.empty() ? 1.0 : weights_[k]);
          row.x += weight * points_[3 * k];
          row.y += weight * points_[3 * k + 1];
          row.z += weight * points_[3 * k + 2];
          row.w += weight;
        }
        const double outer = along_u.value[order_u][i];
        total = {total.x + outer * row.x, total.y + outer * row.y, total.z + outer * row.z,
                 total.w + outer * row.w};
      }
      return Homogeneous{scale * total.x, scale * total.y, scale * total.z, scale * total.w};
    };
    const auto vector = [](const Homogeneous& h) { return Vector3{h.x, h.y, h.z}; };
    SurfaceJet result;
    const Homogeneous a = sum(0, 0, 1);
    const double inverse = 1 / a.w;
    const Vector3 p = inverse * vector(a);
    result.position = p;
    if (derivatives < 1) return result;
    const Homogeneous au = sum(1, 0, length_u), av = sum(0, 1, length_v);
    result.du = inverse * (vector(au) - au.w * p);
    result.dv = inverse * (vector(av) - av.w * p);
    if (derivatives < 2) return result;
    const Homogeneous auu = sum(2, 0, length_u * length_u), auv = sum(1, 1, length_u * length_v),
                      avv = sum(0, 2, length_v * length_v);
    result.duu = inverse * (vector(auu) - 2 * au.w * result.du - auu.w * p);
    result.duv = inverse * (vector(auv) - au.w * result.dv - av.w * result.du - auv.w * p);
    result.dvv = inverse * (vector(avv) - 2 * av.w * result.dv - avv.w * p);
    return result;
  }

  KnotLine u_, v_;
  std::vector<double> points_, weights_;
  std::array<std::uint8_t, 16> content_{};
};

void check_direction(std::vector<std::string>& problems, const std::string& axis, int degree,
                     const std::vector<double>& knots) {
  if (degree < 1 || degree > max_nurbs_degree) {
    problems.push_back("degree " + axis + " is " + std::to_string(degree) + ", must be 1 to " +
                       std::to_string(max_nurbs_degree));
    return;
  }
  const auto d = static_cast<std::size_t>(degree);
  if (knots.size() < 2 * (d + 1)) {
    problems.push_back("knots_" + axis + " has " + std::to_string(knots.size()) + " values, degree " +
                       std::to_string(degree) + " needs at least " + std::to_string(2 * (d + 1)));
    return;
  }
  if (!std::all_of(knots.begin(), knots.end(), [](double t) { return std::isfinite(t); })) {
    problems.push_back("knots_" + axis + " has a value that is not finite");
  } else if (!std::is_sorted(knots.begin(), knots.end())) {
    problems.push_back("knots_" + axis + " must ascend");
  } else if (!(knots[d] < knots[knots.size() - 1 - d])) {
    problems.push_back("knots_" + axis + " span no interval");
  }
}

std::size_t control_points(int degree, const std::vector<double>& knots) {
  return knots.size() - 1 - static_cast<std::size_t>(degree);
}

std::vector<std::string> problems_of(const NurbsNet& net) {
  std::vector<std::string> problems;
  check_direction(problems, "u", net.degree_u, net.knots_u);
  check_direction(problems, "v", net.degree_v, net.knots_v);
  if (!problems.empty()) return problems;
  const std::size_t expected =
      control_points(net.degree_u, net.knots_u) * control_points(net.degree_v, net.knots_v);
  if (net.points.size() != 3 * expected)
    problems.push_back("there are " + std::to_string(net.points.size() / 3) +
                       " control points, degrees and knots ask for " + std::to_string(expected));
  if (!net.weights.empty() && net.weights.size() != expected)
    problems.push_back("there are " + std::to_string(net.weights.size()) + " weights, not " +
                       std::to_string(expected));
  if (!std::all_of(net.points.begin(), net.points.end(), [](double x) { return std::isfinite(x); }))
    problems.push_back("a control point is not finite");
  if (!std::all_of(net.weights.begin(), net.weights.end(),
                   [](double w) { return w > 0 && std::isfinite(w); }))
    problems.push_back("a weight is not positive and finite");
  return problems;
}

// Reads the words of one line as numbers.
class LineReader {
 public:
  LineReader(std::string_view line, std::size_t number) : rest_(line), number_(number) {}

  [[noreturn]] void fail(const std::string& problem) const {
    throw ItemError(Status::unreadable, "line " + std::to_string(number_) + ": " + problem);
  }

  std::string_view word() {
    const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
    while (!rest_.empty() && blank(rest_.front())) rest_.remove_prefix(1);
    std::size_t length = 0;
    while (length < rest_.size() && !blank(rest_[length])) ++length;
    const std::string_view result = rest_.substr(0, length);
    rest_.remove_prefix(length);
    return result;
  }

  std::vector<double> numbers() {
    std::vector<double> values;
    for (std::string_view text = word(); !text.empty(); text = word()) {
      if (text.front() == '+') text.remove_prefix(1);
      double value = 0;
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
      if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
        fail("\"" + std::string(text) + "\" is not a finite number");
      values.push_back(value);
    }
    return values;
  }

 private:
  std::string_view rest_;
  std::size_t number_;
};

int read_degree(const LineReader& line, double value) {
  if (!(value >= 1 && value <= max_nurbs_degree) || value != std::floor(value))
    line.fail("a degree must be a whole number from 1 to " + std::to_string(max_nurbs_degree));
  return static_cast<int>(value);
}

void append_knots(const LineReader& line, const std::vector<double>& values, std::vector<double>& knots) {
  if (values.empty()) line.fail("no knots");
  for (const double value : values) {
    if (!knots.empty() && value < knots.back())
      line.fail("knots must ascend, but " + std::to_string(value) + " follows " +
                std::to_string(knots.back()));
    knots.push_back(value);
  }
}

}  // namespace

std::unique_ptr<ParametricSurface> make_nurbs_patch(NurbsNet net) {
  std::string all;
  for (const std::string& problem : problems_of(net)) all += (all.empty() ? "the net: " : "; ") + problem;
  if (!all.empty()) throw ItemError(Status::unreadable, all);
  return std::make_unique<NurbsPatch>(std::move(net));
}

NurbsNet parse_nurbs_net(std::string_view text) {
  NurbsNet net;
  bool weighted = false;
  std::size_t number = 0;
  while (!text.empty()) {
    ++number;
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view content = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    content = content.substr(0, content.find('#'));
    LineReader line(content, number);
    const std::string_view keyword = line.word();
    if (keyword.empty()) continue;
    if (keyword != "degree" && keyword != "knots_u" && keyword != "knots_v" && keyword != "point")
      line.fail("\"" + std::string(keyword.substr(0, 40)) + "\" is none of degree, knots_u, knots_v, point");
    if (keyword != "degree" && net.degree_u == 0) line.fail("the degrees must come first");
    const std::vector<double> values = line.numbers();
    if (keyword == "degree") {
      if (net.degree_u != 0) line.fail("the degrees are given twice");
      if (values.size() != 2) line.fail("two degrees are needed");
      net.degree_u = read_degree(line, values[0]);
      net.degree_v = read_degree(line, values[1]);
    } else if (keyword == "knots_u") {
      append_knots(line, values, net.knots_u);
    } else if (keyword == "knots_v") {
      append_knots(line, values, net.knots_v);
    } else {
      if (values.size() != 3 && values.size() != 4)
        line.fail("a point has 3 coordinates and perhaps a weight, not " + std::to_string(values.size()) +
                  " numbers");
      net.points.insert(net.points.end(), values.begin(), values.begin() + 3);
      net.weights.push_back(values.size() == 4 ? values[3] : 1.0);
      if (!(net.weights.back() > 0)) line.fail("a weight must be positive");
      weighted = weighted || net.weights.back() != 1;
    }
  }
  if (net.degree_u == 0) throw ItemError(Status::unreadable, "line 1: no degree in the text");
  if (!weighted) net.weights.clear();
  const std::vector<std::string> problems = problems_of(net);
  if (!problems.empty())
    throw ItemError(Status::unreadable,
                    "line " + std::to_string(number) + " (the last): " + problems.front());
  return net;
}

std::unique_ptr<ParametricSurface> parse_nurbs_patch(std::string_view text) {
  return make_nurbs_patch(parse_nurbs_net(text));
}

}  // namespace meander
