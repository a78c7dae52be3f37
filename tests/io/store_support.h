// Random rows and headers for the tests of io/store.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "io/run_error.h"
#include "io/store/run_directory.h"
#include "io/store/store_reader.h"
#include "io/store/store_verify.h"
#include "support/scratch_files.h"

namespace meander::test {

inline StoreHeader make_header(std::uint64_t rows, std::uint32_t samples,
                               Compression compression = Compression::standard) {
  StoreHeader header;
  header.samples = samples;
  header.compression = compression;
  header.seed = 7;
  header.parameters_json = R"({"density":"uniform","describe":["d2"],"method":"conformal"})";
  header.label_names = {"airplane", "chair", "\xC3\xA9tag\xC3\xA8re"};
  header.descriptors = {{"d2", 64, {{"bins", "64 equal bins of [0, 2]"}, {"scale", "mean distance is 1"}}},
                        {"a3", 5, {{"bins", "5 equal bins of [0, pi]"}}}};
  for (std::uint64_t row = 0; row < rows; ++row) {
    std::string number = std::to_string(row);
    header.ids.push_back("class/m" + std::string(7 - number.size(), '0') + number +
                         (row % 5 == 0 ? "-long-name.off" : ".off"));
    header.labels.push_back(static_cast<std::int32_t>(row % 4) - 1);
    header.splits.push_back(static_cast<Split>(row % 7 % 4));
  }
  std::sort(header.ids.begin(), header.ids.end());
  return header;
}

// No other column of samples.
inline StoreColumns points_alone_columns() {
  StoreColumns columns;
  for (std::size_t c = column_of(&Samples::points) + 1; c < sample_columns.size(); ++c)
    columns.left_out[c] = columns.applies(c);
  return columns;
}

// A row whose every value is a function of (row, header) and within its range; about one in three is not ok.
inline Row make_row(const StoreHeader& header, std::uint64_t row) {
  std::mt19937_64 random(row * 977 + header.samples);
  const auto real = [&] { return static_cast<float>(random() >> 40) * 0x1p-24f - 0.5f; };
  Row made;
  ItemReport& report = made.report;
  report.status = random() % 3 == 0 ? static_cast<Status>(1 + random() % 13) : Status::ok;
  const bool ok = report.status == Status::ok;
  if (!ok) report.reason = "row " + std::to_string(row) + " is " + std::string(name_of(report.status));
  report.method = ok ? static_cast<Method>(1 + random() % 3) : Method::none;
  report.order_reason = static_cast<OrderReason>(row % order_reason_names.size());
  report.file_bytes = random() % (std::uint64_t{1} << 40);
  report.vertices = 1 + random() % 100000;
  report.faces = 1 + random() % 100000;
  report.components = 1 + static_cast<std::uint32_t>(random() % 10);
  report.genus = static_cast<std::uint32_t>(random() % 3);
  report.boundaries = static_cast<std::uint32_t>(random() % 7);
  report.area = 1 + real();
  report.measure = 1 + real();
  for (std::size_t axis = 0; axis < 3; ++axis) {  // around all points, wherever loc and scale put them
    report.bbox[axis] = -2 + real();
    report.bbox[axis + 3] = 2 + real();
  }
  for (double& value : report.loc) value = real();
  report.scale = 1 + real();
  report.flips = static_cast<std::uint32_t>(random() % 5);
  report.overlap = 0.5 + real();
  report.area_scale_range = 1 + real();
  report.distortion = 1 + real();
  for (std::uint32_t& count : report.repairs.counts) count = static_cast<std::uint32_t>(random() % 3);
  for (std::uint8_t& byte : report.content_sha256) byte = static_cast<std::uint8_t>(random());
  if (!ok) return made;
  const std::size_t n = header.samples;
  Samples& samples = made.samples;
  for (std::size_t i = 0; i < 3 * n; ++i) {
    samples.points.push_back(real());
    samples.corners.push_back(static_cast<std::uint32_t>(random() % report.vertices));
  }
  for (std::size_t i = 0; i < n; ++i) {
    const float x = real(), y = real(), z = 1 + real(), length = std::hypot(x, y, z);
    for (const float value : {x, y, z}) samples.normals.push_back(value / length);
    const float first = 0.5f + real();
    samples.barycentric.push_back(first);
    samples.barycentric.push_back((0.5f + real()) * (1 - first));
  }
  for (std::size_t i = 0; i < n; ++i) {
    samples.face.push_back(static_cast<std::uint32_t>(random() % report.faces));
    samples.density.push_back(1 + real());
  }
  samples.curve_rank.resize(n);
  std::iota(samples.curve_rank.begin(), samples.curve_rank.end(), 0u);
  std::shuffle(samples.curve_rank.begin(), samples.curve_rank.end(), random);
  const StoreColumns& columns = *header.columns;
  std::size_t numbers = 0, classes = 0;  // each list ends with its last column
  for (std::size_t i = 0; i < columns.attributes.size(); ++i)
    (columns.attributes[i].is_classes() ? classes : numbers) = i + 1;
  samples.attributes.resize(numbers);
  samples.classes.resize(classes);
  for (std::size_t bit = 0; bit < columns.chosen_count(); ++bit) {
    const bool is_texcoord = bit >= columns.attributes.size();
    const std::size_t width = is_texcoord ? 2 : columns.attributes[bit].width;
    if (!is_texcoord && columns.attributes[bit].is_classes()) {
      std::vector<std::int32_t>& values = samples.classes[bit];
      for (std::size_t i = 0; i < width * n; ++i) values.push_back(static_cast<std::int32_t>(random()));
      if (random() % 3 != 0) continue;
      report.lacks |= std::uint32_t{1} << bit;
      const bool is_missing = random() % 2 == 0;
      if (is_missing) report.missing |= std::uint32_t{1} << bit;
      for (std::size_t i = 0; i < (is_missing ? width * n : width); ++i) values[i] = no_sample_class;
      continue;
    }
    std::vector<float>& values = is_texcoord ? samples.texcoord : samples.attributes[bit];
    for (std::size_t i = 0; i < width * n; ++i) values.push_back(100 * real());
    if (random() % 3 != 0) continue;
    report.lacks |= std::uint32_t{1} << bit;
    const std::size_t lost = random() % n;
    for (std::size_t k = 0; k < width; ++k)
      values[width * lost + k] = std::numeric_limits<float>::quiet_NaN();
  }
  if (columns.has_names() && random() % 4 != 0) {  // now and then some that fill most of a chunk
    made.names = "{\"object\":[\"" + std::string(random() % 5 == 0 ? 60000 : random() % 300, 'n') + "\"]}";
    report.names_bytes = static_cast<std::uint32_t>(made.names.size());
  }
  for (const DescriptorSchema& schema : header.descriptors) {
    made.descriptors.push_back({schema.name, {}});
    for (std::uint32_t i = 0; i < schema.width; ++i) made.descriptors.back().values.push_back(real());
  }
  return made;
}

inline EncodedRow make_encoded(const StoreHeader& header, std::uint64_t row) {
  return encode_row(header, row, make_row(header, row));
}

inline std::vector<std::uint64_t> row_order(std::uint64_t rows, std::uint64_t seed) {
  std::vector<std::uint64_t> order(rows);
  std::iota(order.begin(), order.end(), std::uint64_t{0});
  if (seed != 0) std::shuffle(order.begin(), order.end(), std::mt19937_64(seed));
  return order;
}

// A whole run without errors; the rows arrive in an order of that seed (0: ascending).
inline void write_store(const std::filesystem::path& store, const StoreHeader& header,
                        std::uint64_t seed = 0) {
  RunDirectory run(store, header);
  for (const std::uint64_t row : row_order(header.ids.size(), seed)) {
    run.begin_item(row);
    run.end_item(make_encoded(header, row));
  }
  run.finish();
}

inline std::string store_bytes(const StoreHeader& header) {
  const ScratchFolder folder;
  write_store(folder / "s.h5", header);
  return read_file(folder / "s.h5");
}

inline bool same(const ItemReport& a, const ItemReport& b) {
  return a.status == b.status && a.reason == b.reason && a.method == b.method &&
         a.order_reason == b.order_reason && a.vertices == b.vertices && a.faces == b.faces &&
         a.components == b.components && a.genus == b.genus && a.boundaries == b.boundaries &&
         a.area == b.area && a.measure == b.measure && a.bbox == b.bbox && a.loc == b.loc &&
         a.scale == b.scale && a.flips == b.flips && a.overlap == b.overlap &&
         a.area_scale_range == b.area_scale_range && a.distortion == b.distortion &&
         a.repairs.counts == b.repairs.counts && a.file_bytes == b.file_bytes &&
         a.content_sha256 == b.content_sha256 && a.lacks == b.lacks && a.missing == b.missing &&
         a.names_bytes == b.names_bytes;
}

inline bool same(const Row& a, const Row& b) {
  if (!same(a.report, b.report) || a.descriptors.size() != b.descriptors.size()) return false;
  for (std::size_t i = 0; i < a.descriptors.size(); ++i)
    if (a.descriptors[i].name != b.descriptors[i].name || a.descriptors[i].values != b.descriptors[i].values)
      return false;
  const Samples &s = a.samples, &t = b.samples;
  return a.names == b.names && s.points == t.points && s.normals == t.normals && s.face == t.face &&
         s.corners == t.corners && s.barycentric == t.barycentric && s.curve_rank == t.curve_rank &&
         s.density == t.density;
}

// The message and kind with which a run is refused; kind 0 unusable, 1 stopped, 2 not refused.
inline std::pair<std::string, int> refusal(const std::filesystem::path& store, const StoreHeader& header) {
  try {
    const RunDirectory run(store, header);
  } catch (const RunError& error) {
    return {error.what(), error.kind() == RunError::Kind::stopped ? 1 : 0};
  }
  return {"", 2};
}

}  // namespace meander::test
