// Colors, attributes and texture coordinates of the vertices of a remeshed model.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "io/mesh/mesh_writer.h"
#include "kernels/model/model.h"
#include "kernels/remesh/remesh_surface.h"

namespace meander {

// What vertices take over from the input.
struct CarriedColumns {
  bool colors = false, texcoord = false;
  std::vector<AttributeColumn> attributes;
};

// The names of the numbers of attributes in files: NAME of one number, NAME_0, NAME_1, ... of several.
std::vector<std::string> attribute_properties(std::span<const AttributeColumn> attributes);

struct CarriedValues {
  std::vector<std::uint8_t> rgb;               // 3 V
  std::vector<float> texcoord;                 // 2 V
  std::vector<std::string> names;              // of the numbers of attributes
  std::vector<std::vector<float>> attributes;  // V each
  std::vector<bool> integers;                  // of each: whole numbers throughout, none missing
  std::uint32_t lacks = 0;                     // bit i: attribute i; the next one: texture coordinates
  bool lacks_colors = false;

  WrittenValues view() const;
};

// Samples carry what the stages of `run` made (column_makers.h, sample_attributes.h), and vertices of the
// surface their own values. Vertices on edges carry values linear between the two ends, or, for integers, the
// value of the nearer end. O(V).
CarriedValues carried_values(const Model& model, const RemeshedSurface& mesh, const CarriedColumns& columns);

// The columns of which a model has no value at some vertices: the words of the options, separated by commas.
std::string lacking_text(const CarriedValues& values, const CarriedColumns& columns);

}  // namespace meander
