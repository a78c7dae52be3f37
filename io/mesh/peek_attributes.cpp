#include "io/mesh/peek_attributes.h"

#include "io/mesh/format_readers.h"

namespace meander {

std::vector<FileAttribute> peek_attributes(const ByteSource& file, MeshFormat format) try {
  const auto attributes = row_of(format).attributes;
  return attributes == nullptr ? std::vector<FileAttribute>() : attributes(file);
} catch (const ItemError&) {  // reading the mesh will say what is wrong
  return {};
}

std::optional<bool> takes_integers(std::span<const FileAttribute> attributes, const AttributeColumn& column) {
  for (const bool of_faces : {false, true}) {
    const auto find = [&](const std::string& name, std::uint32_t width) -> std::optional<bool> {
      for (const FileAttribute& attribute : attributes)
        if (attribute.of_faces == of_faces && attribute.name == name && attribute.width == width)
          return attribute.integers;
      return std::nullopt;
    };
    if (const std::optional<bool> whole = find(column.name, column.width)) return whole;
    for (const auto& suffixes : attribute_suffixes) {
      if (column.width == 1) break;
      bool integers = true, has_all = true;
      for (std::uint32_t k = 0; k < column.width && has_all; ++k) {
        const std::optional<bool> one = find(column.name + suffixes[k], 1);
        has_all = one.has_value();
        integers = integers && one.value_or(false);
      }
      if (has_all) return integers;
    }
  }
  return std::nullopt;
}

}  // namespace meander
