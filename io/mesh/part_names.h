// Internal to io/mesh: numbers that readers give to faces by what their files divide a surface into, and the
// names behind them.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/data/samples.h"
#include "kernels/mesh/polygon_mesh.h"

namespace meander {

// Whether a column asks for the numbers of this name.
bool asks_for(std::span<const AttributeColumn> attributes, std::string_view name);

// Faces with the numbers of what they belong to: 0, 1, ... in the order in which faces first do.
struct NumberedFaces {
  std::vector<double> values;      // NaN: of nothing
  std::vector<std::string> names;  // by number, as the file has them; empty: no face belongs to anything
};

// Takes up attributes of faces in ascending order of their names.
class NumberedAttributes {
 public:
  using NameOf = std::function<std::string_view(std::size_t)>;  // by number, as the file has it

  explicit NumberedAttributes(PolygonMesh& mesh) : mesh_(mesh) {}
  // As an asked attribute of the mesh, with the names; nothing where no face belongs to anything.
  void add(const std::string& attribute, NumberedFaces faces);
  // The same with `count` names, see add_names.
  void add(const std::string& attribute, std::vector<double> values, std::size_t count,
           const NameOf& name_of);
  // The names alone, of an attribute that the mesh has. Those beyond most_name_bytes in all are noted; they
  // are not looked at but for the first.
  void add_names(std::string_view attribute, std::size_t count, const NameOf& name_of);
  void finish();

 private:
  PolygonMesh& mesh_;
  std::string lists_;
};

}  // namespace meander
