// Calls of functions over arrays, by their names: those of array_functions.h, and of the laboratory
// (meander.laboratory in Python).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "io/json/json_tree.h"
#include "kernels/mesh/polygon_mesh.h"
#include "kernels/model/model.h"

namespace meander {

// An array that a caller holds: rows x columns values, row by row; one column of arrays of one dimension.
struct GivenArray {
  std::string name;
  std::variant<std::span<const double>, std::span<const float>, std::span<const std::uint32_t>,
               std::span<const std::uint8_t>>
      values;
  std::uint64_t rows = 0, columns = 1;
};

// What a function works on: a mesh, a model that was staged before, or neither.
struct LaboratorySubject {
  std::shared_ptr<const PolygonMesh> mesh;
  std::shared_ptr<const Model> staged;
};

// What a function is given: options by name, arrays by name, and its subject.
// Throws std::invalid_argument, which names what is missing, of another type or of another shape.
class LaboratoryArguments {
 public:
  // options: a JSON object. Throws ItemError(unreadable) where it is no JSON (JsonTree).
  LaboratoryArguments(std::string_view options, std::vector<GivenArray> arrays, LaboratorySubject subject);

  bool has(std::string_view name) const;
  double real(std::string_view name) const;
  double real(std::string_view name, double otherwise) const;
  std::uint64_t whole(std::string_view name) const;
  std::uint64_t whole(std::string_view name, std::uint64_t otherwise) const;
  std::string text(std::string_view name) const;
  std::string text(std::string_view name, const std::string& otherwise) const;
  bool flag(std::string_view name) const;                       // false where it is not given
  std::vector<std::string> words(std::string_view name) const;  // a list of texts; none where it is not given
  std::uint64_t columns(std::string_view name) const;           // of an array
  // Throw where the array has another number of columns. Real numbers are double, numbers of things uint32.
  std::span<const double> reals(std::string_view name, std::uint64_t columns = 1) const;
  std::span<const float> floats(std::string_view name, std::uint64_t columns = 1) const;
  std::span<const std::uint32_t> numbers(std::string_view name, std::uint64_t columns = 1) const;
  std::span<const std::uint8_t> bytes(std::string_view name, std::uint64_t columns = 1) const;
  // One column of an array of two, or of three: x of points.
  std::vector<double> column(std::string_view name, std::uint64_t columns, std::uint64_t number) const;
  // Whether there is a mesh, as the subject or as the arrays `vertices` and `faces` (triangles); and that
  // mesh.
  bool has_mesh() const { return subject_.mesh || has("vertices"); }
  PolygonMesh mesh() const;
  const Model& staged() const;

 private:
  const GivenArray& array(std::string_view name) const;
  const GivenArray& array(std::string_view name, std::uint64_t columns) const;

  JsonTree options_;
  std::vector<GivenArray> arrays_;
  LaboratorySubject subject_;
};

// What a function returns: single numbers and arrays by name, and a model for later calls.
struct LaboratoryResult {
  using Values = std::variant<std::vector<double>, std::vector<float>, std::vector<std::uint32_t>,
                              std::vector<std::uint8_t>>;
  struct Array {
    std::string name;
    Values values;
    std::uint64_t columns = 0;  // 0: an array of one dimension
  };
  std::vector<std::pair<std::string, double>> numbers;
  std::vector<Array> arrays;
  std::shared_ptr<const Model> staged;

  void add(std::string name, double number) { numbers.emplace_back(std::move(name), number); }
  void add(std::string name, Values values, std::uint64_t columns = 0) {
    arrays.push_back({std::move(name), std::move(values), columns});
  }
};

// Calls the function of that name. Throws std::invalid_argument where there is none, std::runtime_error in a
// build without the laboratory, and what the function throws.
LaboratoryResult call_laboratory(std::string_view name, const LaboratoryArguments& arguments);

}  // namespace meander
