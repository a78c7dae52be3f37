#include "io/page/model_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "io/digest.h"
#include "io/page/page_parts.h"
#include "kernels/core/portable_functions.h"

namespace meander {

namespace {

// The marks in page.html that the other parts replace.
constexpr std::string_view policy_mark = "{{policy}}", style_mark = "{{style}}", data_mark = "{{data}}";

std::uint8_t byte_share(double share) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
}

std::string whole_script() {
  std::string script = "'use strict';\n";
  for (const std::string_view part : page_parts::scripts) script += part;
  return script;
}

std::string source_hash(std::string_view text) {
  const std::array<std::uint8_t, 32> digest = sha256(std::as_bytes(std::span(text)));
  return "'sha256-" + base64(std::as_bytes(std::span(digest))) + "'";
}

// The markup before and after the data, with policy and style filled in.
struct PageFrame {
  std::string before, behind;
};
PageFrame make_frame(std::string_view script) {
  std::string text(page_parts::markup);
  const auto fill = [&text](std::string_view mark, std::string_view content) {
    text.replace(text.find(mark), mark.size(), content);
  };
  fill(policy_mark, fmt::format("default-src 'none'; script-src {}; style-src {}; img-src data: blob:; "
                                "base-uri 'none'; form-action 'none'",
                                source_hash(script), source_hash(page_parts::style)));
  fill(style_mark, page_parts::style);
  const std::size_t at = text.find(data_mark);
  return {text.substr(0, at), text.substr(at + data_mark.size())};
}

void put_u16(std::vector<std::byte>& bytes, double share) {
  const auto value = static_cast<std::uint16_t>(std::lround(65535 * std::clamp(share, 0.0, 1.0)));
  bytes.push_back(static_cast<std::byte>(value & 0xFF));
  bytes.push_back(static_cast<std::byte>(value >> 8));
}

}  // namespace

std::array<std::int8_t, 2> octahedral_normal(const float* normal) {
  const double sum = std::abs(double{normal[0]}) + std::abs(double{normal[1]}) + std::abs(double{normal[2]});
  if (!(sum > 0) || !std::isfinite(sum)) return {0, 0};
  double u = normal[0] / sum, v = normal[1] / sum;
  if (normal[2] < 0) {
    const double folded = (1 - std::abs(v)) * (u < 0 ? -1 : 1);
    v = (1 - std::abs(u)) * (v < 0 ? -1 : 1);
    u = folded;
  }
  return {static_cast<std::int8_t>(std::lround(127 * u)), static_cast<std::int8_t>(std::lround(127 * v))};
}

PackedPoints pack_points(const Samples& samples, std::span<const std::uint32_t> chosen) {
  PackedPoints packed;
  if (chosen.empty()) return packed;
  if (*std::max_element(chosen.begin(), chosen.end()) >= samples.count())
    throw std::out_of_range("pack_points: no such sample");
  packed.density_low = packed.density_high = samples.density.at(chosen[0]);
  for (std::size_t axis = 0; axis < 3; ++axis)
    packed.low[axis] = packed.high[axis] = samples.points[3 * std::size_t{chosen[0]} + axis];
  for (const std::size_t i : chosen) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      packed.low[axis] = std::min(packed.low[axis], double{samples.points[3 * i + axis]});
      packed.high[axis] = std::max(packed.high[axis], double{samples.points[3 * i + axis]});
    }
    packed.density_low = std::min(packed.density_low, double{samples.density[i]});
    packed.density_high = std::max(packed.density_high, double{samples.density[i]});
  }
  const bool logarithmic = packed.density_low > 0;
  const auto level = [&](double density) { return logarithmic ? portable::log(density) : density; };
  const double lowest = level(packed.density_low), range = level(packed.density_high) - lowest;
  const double last_rank = static_cast<double>(std::max<std::size_t>(samples.count(), 2) - 1);
  packed.bytes.reserve(chosen.size() * packed_point_bytes);
  for (const std::size_t i : chosen) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double extent = packed.high[axis] - packed.low[axis];
      put_u16(packed.bytes, extent > 0 ? (samples.points[3 * i + axis] - packed.low[axis]) / extent : 0.5);
    }
    for (const std::int8_t value : octahedral_normal(samples.normals.data() + 3 * i))
      packed.bytes.push_back(static_cast<std::byte>(value));
    packed.bytes.push_back(
        std::byte{byte_share(range > 0 ? (level(samples.density[i]) - lowest) / range : 0)});
    packed.bytes.push_back(std::byte{byte_share(samples.curve_rank[i] / last_rank)});
  }
  return packed;
}

std::string base64(std::span<const std::byte> bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (k < count ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? digits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string json_in_markup(std::string_view json) {
  std::string text;
  text.reserve(json.size());
  for (const char c : json) c == '<' ? text += "\\u003c" : text += c;
  return text;
}

ModelPageWriter::ModelPageWriter(const std::filesystem::path& path) : file_(path) {
  append(make_frame(whole_script()).before);
}

void ModelPageWriter::append(std::string_view text) {
  file_.append(text);
  size_ += text.size();
}

void ModelPageWriter::append_model(std::span<const std::byte> bytes) {
  append(fmt::format("<script type=\"text/plain\" id=\"model-{}\">{}</script>\n", models_++, base64(bytes)));
}

std::uint64_t ModelPageWriter::finish(std::string_view facts_json) {
  const std::string script = whole_script();
  append(fmt::format("<script type=\"application/json\" id=\"facts\">{}</script>\n<script>",
                     json_in_markup(facts_json)));
  append(script);
  append("</script>");
  append(make_frame(script).behind);
  file_.commit();
  return size_;
}

}  // namespace meander
