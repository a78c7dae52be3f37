// Rows of a store by the ids of their models, and small ones to put there.
#pragma once

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "io/store/store_reader.h"

namespace meander::test {

inline std::vector<std::string> ids_of(const std::filesystem::path& store) {
  return StoreReader(store).header().ids;
}

inline Row row_of(const std::filesystem::path& store, const std::string& id) {
  const StoreReader reader(store);
  const std::vector<std::string> ids = reader.header().ids;
  const auto at = std::find(ids.begin(), ids.end(), id);
  if (at == ids.end()) throw std::runtime_error(store.string() + " has no row " + id);
  return reader.read_row(static_cast<std::uint64_t>(at - ids.begin()));
}

// A row that is ok, of one sample in a model of one triangle.
inline Row row_of_one_sample() {
  Row row;
  row.report.status = Status::ok;
  row.report.method = Method::direct;
  row.report.vertices = 3;
  row.report.faces = 1;
  row.samples.points = row.samples.normals = {0, 0, 1};
  row.samples.face = {0};
  row.samples.corners = {0, 1, 2};
  row.samples.barycentric = {0.25f, 0.25f};
  row.samples.curve_rank = {0};
  row.samples.density = {1};
  return row;
}

}  // namespace meander::test
