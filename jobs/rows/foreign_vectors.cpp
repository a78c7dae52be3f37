#include "jobs/rows/foreign_vectors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <numeric>
#include <optional>
#include <sstream>
#include <string>
#include <unordered_map>
#include <vector>

#include "io/file/file_bytes.h"
#include "io/file/read_file.h"
#include "io/table/npy_header.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/csv_text.h"
#include "kernels/public/status.h"

namespace meander {

namespace {

constexpr std::uint64_t max_width = 65536;
constexpr std::uint64_t no_vector = std::numeric_limits<std::uint64_t>::max();

struct Matrix {
  std::uint64_t rows = 0;
  std::uint32_t width = 0;
  std::vector<float> values;
};

template <class Number>
std::vector<float> values_at(const char* from, std::size_t count) {
  std::vector<float> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    Number number;
    std::memcpy(&number, from + i * sizeof number, sizeof number);
    values[i] = static_cast<float>(number);
  }
  return values;
}

Matrix read_matrix(const std::string& path) {
  const auto refuse = [&](const std::string& why) {
    return UsageError(fmt::format("--vectors: `{}` {}", path, why));
  };
  std::optional<FileBytes> file;
  std::string_view content;
  NpyHeader header;
  try {
    file.emplace(path);
    content = {reinterpret_cast<const char*>(file->bytes().data()), file->bytes().size()};
    header = read_npy_header(content);
  } catch (const ItemError& error) {
    throw refuse(fmt::format("is no array of numpy: {}", error.what()));
  }
  if (header.shape.size() != 2 || (header.type != "<f4" && header.type != "<f8") || header.fortran_order)
    throw refuse("should be an array of rows x values, float32 or float64, in C order");
  const std::uint64_t rows = header.shape[0], width = header.shape[1];
  const std::size_t size = header.type == "<f4" ? 4 : 8;
  if (width < 1 || width > max_width)
    throw refuse(fmt::format("has {} values in a row, not 1 to {}", width, max_width));
  if (rows > (content.size() - header.bytes) / size / width ||
      rows * width * size != content.size() - header.bytes)
    throw refuse(fmt::format("states {} x {} values, which is not what follows", rows, width));
  const char* const from = content.data() + header.bytes;
  return {rows, static_cast<std::uint32_t>(width),
          size == 4 ? values_at<float>(from, rows * width) : values_at<double>(from, rows * width)};
}

// A line each, or the column `id` of a table.
std::vector<std::string> read_ids(const std::string& path) {
  const std::string content = content_of_file(path);
  std::vector<std::string> ids;
  CsvText table(content, "--ids: `" + path + "`");
  if (const auto heading = table.next()) {
    const auto at = std::find(heading->fields.begin(), heading->fields.end(), "id");
    if (at != heading->fields.end()) {
      const auto column = static_cast<std::size_t>(at - heading->fields.begin());
      while (const auto record = table.next()) {
        if (record->is_blank()) continue;
        if (column >= record->fields.size()) table.fail(record->line, "there is no column id");
        ids.push_back(record->fields[column]);
      }
      return ids;
    }
  }
  std::istringstream text(content);
  for (std::string line; std::getline(text, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    ids.push_back(line);
  }
  return ids;
}

// Reads ids in the order of the rows: the store keeps them in blocks, which a search for one after the other
// would read again and again.
std::unordered_map<std::string, std::uint64_t> rows_by_id(const StoreReader& store) {
  std::unordered_map<std::string, std::uint64_t> rows;
  rows.reserve(store.rows());
  for (std::uint64_t row = 0; row < store.rows(); ++row) rows.emplace(store.id(row), row);
  return rows;
}

// The vector of each row of the store, from the ids of the vectors.
std::vector<std::uint64_t> vectors_of_rows(const StoreReader& store, const std::vector<std::string>& read,
                                           const std::string& ids) {
  const std::unordered_map<std::string, std::uint64_t> rows = rows_by_id(store);
  std::vector<std::uint64_t> vector_of(store.rows(), no_vector);
  for (std::size_t i = 0; i < read.size(); ++i) {
    const auto row = rows.find(read[i]);
    if (row == rows.end())
      throw UsageError(fmt::format("--ids: the store has no model `{}` of `{}`", read[i], ids));
    if (vector_of[row->second] != no_vector)
      throw UsageError(fmt::format("--ids: `{}` has `{}` twice", ids, read[i]));
    vector_of[row->second] = i;
  }
  return vector_of;
}

}  // namespace

std::string foreign_name(const std::string& vectors) {
  return std::filesystem::path(vectors).stem().string();
}

std::shared_ptr<const SideVectors> read_foreign_vectors(const StoreReader& store, const std::string& vectors,
                                                        const std::string& ids) {
  const std::string name = foreign_name(vectors);
  if (name.empty() || name.find_first_of("+=") != std::string::npos)
    throw UsageError(
        fmt::format("--vectors: `{}` names a descriptor `{}`: rename it without `+` and `=`", vectors, name));
  for (const DescriptorSchema& schema : store.descriptors())
    if (schema.name == name)
      throw UsageError(fmt::format("--vectors: the store has a descriptor `{}`: rename `{}`", name, vectors));
  const Matrix matrix = read_matrix(vectors);
  std::vector<std::uint64_t> vector_of;
  if (ids.empty()) {
    if (matrix.rows != store.rows())
      throw UsageError(fmt::format("--vectors: `{}` has {} rows and the store {}: give their ids with --ids",
                                   vectors, matrix.rows, store.rows()));
    vector_of.resize(store.rows());
    std::iota(vector_of.begin(), vector_of.end(), std::uint64_t{0});
  } else {
    const std::vector<std::string> read = read_ids(ids);
    if (read.size() != matrix.rows)
      throw UsageError(
          fmt::format("--ids: `{}` has {} ids and `{}` {} rows", ids, read.size(), vectors, matrix.rows));
    vector_of = vectors_of_rows(store, read, ids);
  }
  auto made = std::make_shared<SideVectors>();
  made->schema = {name, matrix.width, {{"value", "vectors of " + vectors}}, vectors_group};
  made->values.assign(store.rows() * matrix.width, std::numeric_limits<float>::quiet_NaN());
  for (std::uint64_t row = 0; row < store.rows(); ++row)
    if (vector_of[row] != no_vector && store.report(row).status == Status::ok)
      std::copy_n(matrix.values.begin() + static_cast<std::ptrdiff_t>(vector_of[row] * matrix.width),
                  matrix.width, made->values.begin() + static_cast<std::ptrdiff_t>(row * matrix.width));
  return made;
}

}  // namespace meander
