// The result of sampling one model, as the store keeps it: plain arrays and the report of the item.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/core/notes.h"
#include "kernels/core/status.h"
#include "kernels/data/sign_rule.h"
#include "kernels/public/samples.h"

namespace meander {

// The part of a data set that an item belongs to. The numbers are part of the store format.
enum class Split : std::uint8_t { none = 0, train = 1, test = 2, validation = 3 };
inline constexpr std::array<std::string_view, 4> split_names = {"none", "train", "test", "validation"};
constexpr std::string_view name_of(Split split) { return split_names[static_cast<std::size_t>(split)]; }

// Where the colors of the samples of a model come from; of several sources the largest. The numbers are part
// of the store format.
enum class ColorSource : std::uint8_t { none = 0, material = 1, face = 2, vertex = 3, texture = 4 };
inline constexpr std::array<std::string_view, 5> color_source_names = {"none", "material", "face", "vertex",
                                                                       "texture"};
constexpr std::string_view name_of(ColorSource source) {
  return color_source_names[static_cast<std::size_t>(source)];
}

// The coordinates in which points are handed out: as they are stored, or those of the model's file.
enum class PointFrame : std::uint8_t { stored, file };
inline constexpr std::array<std::string_view, 2> point_frame_names = {"stored", "file"};
constexpr std::string_view name_of(PointFrame frame) {
  return point_frame_names[static_cast<std::size_t>(frame)];
}

// How a column takes the numbers of vertices. The numbers are part of the format of plans.
enum class AttributeKind : std::uint8_t {
  plain,    // float32: interpolated, but those that the model declares as integers of the nearest corner
  classes,  // int32, of the nearest corner
  linear    // float32, interpolated whatever the model declares; stored as `plain`
};

// Attributes of faces that readers make: the numbers of what their files divide a surface into.
inline constexpr std::array<std::string_view, 4> numbered_attributes = {"group", "material", "object",
                                                                        "part"};

inline constexpr std::size_t most_name_bytes = 65536;  // of the names behind them, of one model

// A column of samples that holds an attribute of the model: numbers of vertices or faces by the name that its
// file gives them.
struct AttributeColumn {
  std::string name;
  std::uint32_t width = 1;  // numbers per sample, 1 to 4
  AttributeKind kind = AttributeKind::plain;
  bool is_classes() const { return kind == AttributeKind::classes; }
  friend bool operator==(const AttributeColumn&, const AttributeColumn&) = default;
};

// Attributes of these names, behind that of a column, are the numbers of a vector; the first spelling of
// which a model has all.
inline constexpr std::array<std::array<const char*, 4>, 2> attribute_suffixes = {
    {{"_0", "_1", "_2", "_3"}, {"_x", "_y", "_z", "_w"}}};

// One row of /items: everything known about an input, whatever its status.
struct ItemReport : SampleReport {
  std::array<std::uint32_t, note_count> notes{};  // how many of each kind (core/notes.h),
  std::string note_text;                          // and what they say (text_of)
  std::uint64_t file_bytes = 0;                   // length of the input; 0 when it was not read
  std::array<std::uint8_t, 32> content_sha256{};
  ColorSource color_source = ColorSource::none;  // this and the next two: of samples with colors only
  std::uint32_t color_fills = 0;                 // samples without a color, which have the fill
  std::array<std::uint8_t, 32> color_sha256{};   // of the files read for colors alone; zeros: none
  // Bit i: the i-th of the columns asked for, attributes and then texture coordinates, has no value at one
  // sample or more, which have NaN there, in columns of classes no_sample_class.
  std::uint32_t lacks = 0;
  std::uint32_t missing = 0;  // bit i: the model has no such attribute, or no texture coordinates, at all
  std::uint32_t points_crc32c = 0;      // over the N x 3 little-endian float32 of `points`; 0 unless ok
  std::uint32_t names_bytes = 0;        // length of Row::names as it is stored; 0 unless ok
  std::uint32_t sharp_edges = 0;        // with points on sharp edges only: how many edges are sharp, and
  SignRule sign_rule = SignRule::none;  // with points that have a side only: how it was decided, and
  std::uint32_t uncertain = 0;          // of how many it is not certain
  double sharp_length = 0;              // how long they are in units of the file
};

// One row of the store.
struct Row {
  ItemReport report;
  Samples samples;  // empty arrays unless status is ok
  std::vector<DescriptorRow> descriptors;
  std::string names = {};  // see PolygonMesh::names; of a row that is ok
};

}  // namespace meander
