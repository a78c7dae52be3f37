// A store of very many rows with a descriptor and one sample each, without meshes: for measuring searches.
//
//   make_large_store STORE ROWS WIDTH CLASSES [standard|none]
//
// Every class has a histogram of its own, half of its bins empty, and every row is a perturbation of it; the
// values are square roots of shares. The same bytes for the same arguments.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "io/store/run_directory.h"
#include "kernels/core/parallel.h"
#include "kernels/core/random.h"

using namespace meander;

namespace {

double random_at(std::uint64_t seed, std::uint64_t index) {
  return random_pair(make_random_key(seed, {}), Stream::sequence, index).first;
}

std::vector<float> descriptor_of(std::uint64_t row, std::uint64_t label, std::uint32_t width) {
  std::vector<float> values(width);
  double sum = 0;
  for (std::uint32_t b = 0; b < width; ++b) {
    const double of_class = std::max(0.0, random_at(1, label * width + b) - 0.5);
    const double value = of_class * (0.5 + random_at(2, row * width + b));
    values[b] = static_cast<float>(value);
    sum += value;
  }
  for (float& value : values) value = static_cast<float>(std::sqrt(double{value} / sum));
  return values;
}

Row make_row(const StoreHeader& header, std::uint64_t row) {
  Row made;
  made.report.status = Status::ok;
  made.report.method = Method::direct;
  made.report.vertices = 3;
  made.report.faces = 1;
  made.report.components = 1;
  made.report.area = made.report.measure = made.report.scale = 1;
  made.samples.points = made.samples.normals = {0, 0, 1};
  made.samples.face = {0};
  made.samples.corners = {0, 1, 2};
  made.samples.barycentric = {0.25f, 0.25f};
  made.samples.curve_rank = {0};
  made.samples.density = {1};
  const DescriptorSchema& schema = header.descriptors.front();
  made.descriptors = {
      {schema.name, descriptor_of(row, static_cast<std::uint64_t>(header.labels[row]), schema.width)}};
  return made;
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 5 || count > 6) {
    std::fputs("make_large_store STORE ROWS WIDTH CLASSES [standard|none]\n", stderr);
    return 2;
  }
  const std::uint64_t rows = std::stoull(arguments[2]), classes = std::stoull(arguments[4]);
  StoreHeader header;
  header.samples = 1;
  header.parameters_json = "{}";
  if (count == 6 && std::string(arguments[5]) == "none") header.compression = Compression::none;
  header.descriptors = {
      {"histogram", static_cast<std::uint32_t>(std::stoul(arguments[3])), {{"bins", "roots of shares"}}}};
  for (std::uint64_t c = 0; c < classes; ++c) header.label_names.push_back(fmt::format("class{:05}", c));
  for (std::uint64_t row = 0; row < rows; ++row) {
    header.ids.push_back(fmt::format("{:09}.off", row));
    header.labels.push_back(static_cast<std::int32_t>(row % classes));
  }
  RunDirectory run(arguments[1], header);
  constexpr std::uint64_t at_once = 4096;
  for (std::uint64_t begin = 0; begin < rows; begin += at_once) {
    std::vector<EncodedRow> encoded(std::min(at_once, rows - begin));
    parallel_tasks(encoded.size(), [&](std::size_t i) {
      encoded[i] = encode_row(header, begin + i, make_row(header, begin + i));
    });
    for (EncodedRow& row : encoded) {
      run.begin_item(row.row);
      run.end_item(std::move(row));
    }
  }
  run.finish();
  return 0;
}
