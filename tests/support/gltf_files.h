// glTF files as the tests need them: binary data collected piece by piece, the rest as JSON of the test's
// own.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace meander::test {

inline std::string base64(std::string_view bytes) {
  static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    std::uint32_t bits = 0;
    const std::size_t have = bytes.size() - at < 3 ? bytes.size() - at : 3;
    for (std::size_t k = 0; k < 3; ++k)
      bits = bits << 8 | (k < have ? static_cast<unsigned char>(bytes[at + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) out += k <= have ? digits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

class GltfFile {
 public:
  std::string binary;
  std::string views, accessors;  // JSON, comma separated
  int view_count = 0, accessor_count = 0;

  // Each returns the number of what it adds. `extra`: further members, with a comma in front.
  int add_view(std::string_view bytes, const std::string& extra = {}) {
    while (binary.size() % 4 != 0) binary += '\0';
    const std::size_t offset = binary.size();
    binary += bytes;
    views += (view_count == 0 ? "" : ",") + ("{\"buffer\":0,\"byteOffset\":" + std::to_string(offset)) +
             ",\"byteLength\":" + std::to_string(bytes.size()) + extra + "}";
    return view_count++;
  }
  template <class T>
  int add_view(const std::vector<T>& values, const std::string& extra = {}) {
    std::string bytes(values.size() * sizeof(T), '\0');
    if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
    return add_view(std::string_view(bytes), extra);
  }
  int add_accessor(int view, int component, std::size_t count, const char* type,
                   const std::string& extra = {}) {
    accessors += (accessor_count == 0 ? "" : ",") + ("{\"componentType\":" + std::to_string(component)) +
                 ",\"count\":" + std::to_string(count) + ",\"type\":\"" + type + "\"" +
                 (view < 0 ? "" : ",\"bufferView\":" + std::to_string(view)) + extra + "}";
    return accessor_count++;
  }
  int add_points(const std::vector<float>& xyz) {
    return add_accessor(add_view(xyz), 5126, xyz.size() / 3, "VEC3");
  }
  template <class T>
  int add_indices(const std::vector<T>& indices) {
    constexpr int component = sizeof(T) == 1 ? 5121 : sizeof(T) == 2 ? 5123 : 5125;
    return add_accessor(add_view(indices), component, indices.size(), "SCALAR");
  }

  // `rest`: the members nodes, meshes, ... with a comma in front. `uri`: of the buffer; empty: none.
  std::string json(const std::string& rest, const std::string& uri = {}) const {
    return R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":)" + std::to_string(binary.size()) +
           (uri.empty() ? "" : ",\"uri\":\"" + uri + "\"") + "}],\"bufferViews\":[" + views +
           "],\"accessors\":[" + accessors + "]" + rest + "}";
  }
  std::string with_data_uri(const std::string& rest) const {
    return json(rest, "data:application/octet-stream;base64," + base64(binary));
  }
  std::string glb(const std::string& rest) const { return glb_of(json(rest), binary); }

  static std::string glb_of(std::string text, std::string data) {
    while (text.size() % 4 != 0) text += ' ';
    while (data.size() % 4 != 0) data += '\0';
    std::string chunks = word(text.size()) + "JSON" + text;
    if (!data.empty()) chunks += word(data.size()) + std::string("BIN\0", 4) + data;
    return "glTF" + word(2) + word(12 + chunks.size()) + chunks;
  }

 private:
  static std::string word(std::size_t value) {
    std::string bytes;
    for (int k = 0; k < 4; ++k) bytes += static_cast<char>(value >> (8 * k) & 0xFF);
    return bytes;
  }
};

// One mesh of one primitive in one node; `members`: of the primitive, with a comma in front.
inline std::string primitive_of(const std::string& members) {
  return R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0})" + members +
         R"(}]}],"nodes":[{"mesh":0}])";
}

// A cube from (0, 0, 0) to (1, 1, 1), its outside outside.
inline const std::vector<float> gltf_cube_points = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0,
                                                    0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1};
inline const std::vector<std::uint16_t> gltf_cube_indices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6,
                                                             0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7,
                                                             0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};

}  // namespace meander::test
