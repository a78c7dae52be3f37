// The columns of samples and of items, a row each: the one list behind rows on the disk, stores, verify,
// exports, options, Python, and the tables of the documents.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "kernels/data/samples.h"

namespace meander {

// Little-endian everywhere; word: 8-bit enums with names; text: UTF-8 of fixed width padded with zero bytes.
enum class ElementType : std::uint8_t { f32, f64, i32, u8, u32, u64, word, text, f16 };

inline constexpr std::uint64_t fill_ones = 0xFFFFFFFFu;  // u32 "nothing", i32 -1, u8 255
inline constexpr std::uint64_t fill_nan = 0x7FC00000u;   // f32
inline constexpr std::uint64_t fill_half_nan = 0x7E00u;  // f16
// The width of /items/note_text, in bytes: longer texts are cut.
inline constexpr std::uint32_t note_text_width = 320;

// ---- samples

// The points that a row has: its samples, and further sets that are asked for by their number.
enum class PointSet : std::uint8_t { samples, sharp, queries };
// As options, parameters and the attributes of stores call their numbers.
inline constexpr std::array<std::string_view, 3> point_set_names = {"samples", "sharp", "queries"};
constexpr std::string_view name_of(PointSet set) { return point_set_names[static_cast<std::size_t>(set)]; }
// How many points of each set a row has; that of the samples stands elsewhere and is 0 here.
using SetCounts = std::array<std::uint32_t, point_set_names.size()>;

// Which samples have a column: all, those of one kind of model, those under a tensor field; or those that are
// asked for it, taken over from the model, or made from its surface. Those of another set: all of its
// points, where these have a side, or where their nearest point is asked for.
enum class Having : std::uint8_t { all, meshes, surfaces, tensors, taken, made, set, sides, nearest };

// The rule for values of rows that are ok, which verify checks. Floats are finite, except that `optional`
// ones are NaN where the model has no value (/items/lacks).
enum class Values : std::uint8_t {
  any,
  at_box,        // points, by the box of the item
  unit_vectors,  // but for surfaces that degenerate
  weights,       // of corners 1 and 2
  parameters,    // within [0, 1]
  not_negative,
  positive,
  faces,     // numbers below that of the faces
  vertices,  // numbers below that of the vertices
  ranks,     // each of 0 .. N - 1 once
  optional,
  sharp_points,   // at the box, as the next two; or NaN where the model has no sharp edge
  sharp_vectors,  // unit vectors
  sharp_edges,    // fill where the model has no sharp edge
  truths,         // 0 or 1
  groups,         // numbers below that of the groups of queries
  windings        // NaN where the rule that decides sides has none
};

using SampleArray = std::variant<std::vector<float> Samples::*, std::vector<std::uint32_t> Samples::*,
                                 std::vector<std::uint8_t> Samples::*>;

struct SampleColumn {
  std::string_view name;    // of the dataset, without the leading `/`
  SampleArray array;        // its type is that of the dataset
  std::uint32_t width = 0;  // values of a sample along an axis of their own; 0: one, without an axis
  std::string_view unit, doc;
  Having having = Having::all;
  Values values = Values::any;
  std::string_view ply = {};    // the properties of PLY files, by blanks; empty: not in such files
  std::string_view alias = {};  // in Python and in exported arrays, where that is another name
  std::string_view link = {};   // a second name of the dataset
  std::uint32_t renamed = 0;    // the first format version with this name; before it the only one was `link`
  // The option that asks for the column, without `--` (stores record it as a parameter), its help, and what
  // the note on models without values calls them; empty for columns without an option.
  std::string_view option = {}, help = {}, title = {};
  bool common = false;               // the short help shows the option
  PointSet set = PointSet::samples;  // whose points have it
  bool halves = false;               // float16 where queries are (StoreColumns::halves)

  // Whether an option asks for this column alone.
  constexpr bool is_asked_for() const { return having == Having::taken || having == Having::made; }
  constexpr bool is_of_samples() const { return set == PointSet::samples; }
  constexpr bool is_optional() const { return values == Values::optional; }
  // The name of the dataset in stores of this format version.
  constexpr std::string_view name_in(std::uint32_t version) const { return version < renamed ? link : name; }
  // The word of --store, which takes a folder as a whole; and the one that stores record as a parameter,
  // which stays where the column is renamed.
  constexpr std::string_view word() const { return name.substr(0, name.find('/')); }
  constexpr std::string_view recorded_word() const { return renamed > 0 ? link : word(); }
  // The name of the array in Python and in exports.
  std::string array_name() const {
    std::string text(alias.empty() ? name : alias);
    std::replace(text.begin(), text.end(), '/', '_');
    return text;
  }
  constexpr std::uint32_t values_each() const { return width > 0 ? width : 1; }
};

// A column of the points on sharp edges.
constexpr SampleColumn sharp_column(std::string_view name, SampleArray array, std::uint32_t width,
                                    std::string_view unit, std::string_view doc, Values values) {
  SampleColumn column{name, array, width, unit, doc, Having::set, values};
  column.option = "sharp";
  column.set = PointSet::sharp;
  return column;
}

// A column of the points that signed distances are given at.
constexpr SampleColumn query_column(std::string_view name, SampleArray array, std::uint32_t width,
                                    std::string_view unit, std::string_view doc, Values values,
                                    Having having = Having::set, bool halves = false) {
  SampleColumn column{name, array, width, unit, doc, having, values};
  column.option = having == Having::nearest ? "queries-nearest" : "queries";
  column.set = PointSet::queries;
  column.halves = halves;
  return column;
}

// In the order of the file.
inline constexpr auto sample_columns = [] {
  using S = Samples;
  using H = Having;
  using V = Values;
  constexpr auto sharp = sharp_column;
  return std::to_array<SampleColumn>({
      {"points", &S::points, 3, "length / scale", "the points; file coordinates = loc + scale * point",
       H::all, V::at_box, "", "", "data"},
      {"normals", &S::normals, 3, "1", "unit normals at the points", H::all, V::unit_vectors, "nx ny nz", "",
       "normal"},
      {"uv", &S::uv, 2, "1", "parameters of the point in [0, 1]", H::surfaces, V::parameters, "u v"},
      {"face_index", &S::face, 0, "1", "number of the polygon in file order", H::meshes, V::faces, "face", "",
       "face", 6},
      {"corners", &S::corners, 3, "1", "vertex numbers of the file around the point", H::meshes, V::vertices},
      {"barycentric", &S::barycentric, 2, "1", "weights of corners 1 and 2; corner 0 has the rest", H::meshes,
       V::weights},
      {"curve_rank", &S::curve_rank, 0, "1", "position along the curve, 0 .. N - 1", H::all, V::ranks},
      {"density", &S::density, 0, "1", "value of the density at the point", H::all, V::not_negative,
       "density"},
      {"tensor/direction", &S::tensor_direction, 3, "1",
       "anisotropic samples only: unit vector along the long spacing, of any sign", H::tensors,
       V::unit_vectors},
      {"tensor/spacing", &S::tensor_spacing, 2, "length / scale",
       "anisotropic samples only: wanted spacings along and across the direction", H::tensors, V::positive},
      {"rgb", &S::rgb, 3, "1 / 255", "with --colors only: red, green and blue as displayed (sRGB)", H::taken,
       V::any, "red green blue", "", "", 0, "colors",
       "Take over the colors of the models (/rgb): of vertices, faces, materials or textures", "", true},
      {"texcoord", &S::texcoord, 2, "1",
       "with --texcoord only: texture coordinates as the file has them, NaN where there are none", H::taken,
       V::optional, "", "", "", 0, "texcoord", "Take over the texture coordinates of the models (/texcoord)",
       "texture coordinates"},
      sharp("sharp/points", &S::sharp_points, 3, "length / scale",
            "with --sharp only: points on sharp edges; file coordinates = loc + scale * point",
            V::sharp_points),
      sharp("sharp/normals", &S::sharp_normals, 3, "1",
            "with --sharp only: the mean of the unit normals of the two faces at the edge, of length 1",
            V::sharp_vectors),
      sharp("sharp/tangents", &S::sharp_tangents, 3, "1",
            "with --sharp only: the direction of the edge, a unit vector", V::sharp_vectors),
      sharp("sharp/edge", &S::sharp_edge, 0, "1",
            "with --sharp only: number of the sharp edge, along curves; 0xFFFFFFFF where the model has none",
            V::sharp_edges),
      query_column("queries/points", &S::query_points, 3, "length / scale",
                   "with --queries only: points in space; file coordinates = loc + scale * point", V::any,
                   H::set, true),
      query_column(
          "queries/kind", &S::query_kind, 0, "1",
          "with --queries only: which kind and size of the option the point belongs to (attribute `names`)",
          V::groups),
      query_column("queries/distance", &S::query_distance, 0, "length / scale",
                   "with --queries only: distance from the surface, negative inside", V::any, H::set, true),
      query_column("queries/inside", &S::query_inside, 0, "1",
                   "with --queries only: 1 inside, 0 outside; absent with --sign none", V::truths, H::sides),
      query_column(
          "queries/winding", &S::query_winding, 0, "1",
          "with --queries only: winding number, NaN where sides are decided without; absent with --sign none",
          V::windings, H::sides, true),
      query_column("queries/sign_certain", &S::query_certain, 0, "1",
                   "with --queries only: 1 where the side is certain, 0 where not; absent with --sign none",
                   V::truths, H::sides),
      query_column("queries/face", &S::query_face, 0, "1",
                   "with --queries-nearest only: number of the polygon of the nearest point, in file order",
                   V::faces, H::nearest),
      query_column("queries/corners", &S::query_corners, 3, "1",
                   "with --queries-nearest only: vertex numbers of the file around the nearest point",
                   V::vertices, H::nearest),
      query_column("queries/barycentric", &S::query_barycentric, 2, "1",
                   "with --queries-nearest only: weights of corners 1 and 2 at the nearest point", V::weights,
                   H::nearest),
  });
}();

// The place of the column of this array.
template <class Value>
constexpr std::size_t column_of(std::vector<Value> Samples::*array) {
  std::size_t c = 0;
  while (sample_columns.at(c).array != SampleArray(array)) ++c;
  return c;
}

// Returns use(array) for the array of a column.
template <class AnySamples, class Use>
decltype(auto) with_array(const SampleColumn& column, AnySamples& samples, const Use& use) {
  return std::visit([&](auto array) -> decltype(auto) { return use(samples.*array); }, column.array);
}

// A set of columns of samples.
class ColumnSet {
 public:
  constexpr ColumnSet() = default;
  template <class... Value>
  explicit constexpr ColumnSet(std::vector<Value> Samples::*... arrays) {
    ((has_[column_of(arrays)] = true), ...);
  }
  constexpr bool& operator[](std::size_t column) { return has_.at(column); }
  constexpr const bool& operator[](std::size_t column) const { return has_.at(column); }
  template <class Value>
  constexpr bool& operator[](std::vector<Value> Samples::*array) {
    return has_[column_of(array)];
  }
  template <class Value>
  constexpr const bool& operator[](std::vector<Value> Samples::*array) const {
    return has_[column_of(array)];
  }
  // How many of its columns have the property.
  template <class Is>
  constexpr std::size_t count(const Is& is) const {
    std::size_t number = 0;
    for (std::size_t c = 0; c < has_.size(); ++c) number += has_[c] && is(sample_columns[c]);
    return number;
  }
  constexpr bool empty() const {
    return count([](const SampleColumn&) { return true; }) == 0;
  }
  friend constexpr bool operator==(const ColumnSet&, const ColumnSet&) = default;

 private:
  std::array<bool, sample_columns.size()> has_{};
};

// ---- items

// Values of an item that are not in its report.
enum class ItemKey : std::uint8_t { label, id, split, reason };

using ItemMember =
    std::variant<ItemKey, double ItemReport::*, std::uint32_t ItemReport::*, std::uint64_t ItemReport::*,
                 std::array<double, 3> ItemReport::*, std::array<double, 6> ItemReport::*,
                 std::array<std::uint8_t, 32> ItemReport::*,
                 std::array<std::uint32_t, note_count> ItemReport::*, RepairCounts ItemReport::*,
                 Status ItemReport::*, Method ItemReport::*, OrderReason ItemReport::*,
                 ColorSource ItemReport::*, SignRule ItemReport::*, std::string ItemReport::*>;

// Which stores have a column of items: all; those whose samples have colors, columns with optional values,
// or classes with names; those with points on sharp edges, or points that have a side.
enum class ItemHaving : std::uint8_t { all, colors, optional_values, names, sharp, sides };

// Who tells the value of one item: `info --json` (in its order of members, not that of the file), and Samples
// of Python.
enum class Told : std::uint8_t { nowhere, info, everywhere, python };

struct ItemColumn {
  std::string_view name;  // of the dataset, without the leading `/`
  ItemMember member;
  std::string_view unit, doc;
  Told told = Told::nowhere;
  std::uint64_t fill = 0;
  std::uint32_t since = 1;  // the first format version that has it
  ItemHaving having = ItemHaving::all;

  constexpr bool is_in_python() const { return told == Told::everywhere || told == Told::python; }
  constexpr bool is_in_info() const { return told == Told::everywhere || told == Told::info; }
  constexpr std::string_view short_name() const { return name.substr(name.find('/') + 1); }
};

// In the order of the file.
inline constexpr auto item_columns = [] {
  using R = ItemReport;
  using enum Told;
  constexpr auto colors = ItemHaving::colors;
  constexpr auto optional = ItemHaving::optional_values;
  return std::to_array<ItemColumn>({
      {"label", ItemKey::label, "1", "class number, -1 where unknown", nowhere, fill_ones},
      {"items/id", ItemKey::id, "", "path of the item below the input root; ascending by bytes"},
      {"items/split", ItemKey::split, "", "part of the data set", nowhere, 0, 2},
      {"items/status", &R::status, "", "how the item ended", nowhere,
       static_cast<std::uint64_t>(Status::internal)},
      {"items/reason", ItemKey::reason, "", "one sentence when the status is not ok"},
      {"items/method", &R::method, "", "the weakest method any component needed", everywhere},
      {"items/order_reason", &R::order_reason, "", "why that method, where another one was asked for", info,
       0, 3},
      {"items/vertices", &R::vertices, "1", "vertices of the file", info},
      {"items/faces", &R::faces, "1", "polygons of the file", info},
      {"items/components", &R::components, "1", "connected components", everywhere},
      {"items/genus", &R::genus, "1", "sum of the genera of the components", everywhere},
      {"items/boundaries", &R::boundaries, "1", "boundary loops", everywhere},
      {"items/area", &R::area, "length^2", "surface area", everywhere},
      {"items/measure", &R::measure, "length^2", "area x density", everywhere},
      {"items/bbox", &R::bbox, "length", "min x, y, z, max x, y, z", everywhere},
      {"items/loc", &R::loc, "length", "file coordinates = loc + scale * point", python},
      {"items/scale", &R::scale, "length", "file coordinates = loc + scale * point", python},
      {"items/flips", &R::flips, "1", "flipped triangles of all charts", info},
      {"items/overlap", &R::overlap, "1", "share of the area where charts overlap themselves", info},
      {"items/area_scale_range", &R::area_scale_range, "1", "largest over smallest area scale, worst chart",
       info},
      {"items/distortion", &R::distortion, "1", "area-weighted mean quasi-conformal distortion", info},
      {"items/repairs", &R::repairs, "1", "what was repaired, counted by name (attribute `names`)",
       everywhere},
      {"items/notes", &R::notes, "1",
       "what the file asks for and did not get, counted by name (attribute `names`)", everywhere, 0, 5},
      {"items/note_text", &R::note_text, "",
       "the notes in words, with an example of each as far as there is room", everywhere, 0, 5},
      {"items/file_bytes", &R::file_bytes, "byte", "length of the input; 0 where it was not read", info, 0,
       2},
      {"items/content_sha256", &R::content_sha256, "1", "SHA-256 of the bytes of the input", info},
      {"items/points_crc32c", &R::points_crc32c, "1",
       "CRC32C of the row of /points (little-endian); 0 unless ok"},
      {"items/color_source", &R::color_source, "", "with --colors only: where the colors come from",
       everywhere, 0, 1, colors},
      {"items/color_fills", &R::color_fills, "1",
       "with --colors only: samples without a color, which have the fill 204", everywhere, 0, 1, colors},
      {"items/color_sha256", &R::color_sha256, "1",
       "with --colors only: SHA-256 of the digests of the files read for colors alone; zeros: none", nowhere,
       0, 1, colors},
      {"items/lacks", &R::lacks, "1",
       "with --attribute or --texcoord: bit i: column i (attribute `names`) has no value at one sample or "
       "more",
       nowhere, 0, 1, optional},
      {"items/missing", &R::missing, "1",
       "with --attribute or --texcoord: bit i: the model has no such attribute, or no texture "
       "coordinates, at all",
       nowhere, 0, 5, optional},
      {"items/names_bytes", &R::names_bytes, "byte",
       "with --attribute group, object, material or part only: length of the row's part of /names", nowhere,
       0, 5, ItemHaving::names},
      {"items/sharp_edges", &R::sharp_edges, "1",
       "with --sharp only: number of the sharp edges; 0: the model has none", everywhere, 0, 1,
       ItemHaving::sharp},
      {"items/sharp_length", &R::sharp_length, "length", "with --sharp only: length of all sharp edges",
       everywhere, 0, 1, ItemHaving::sharp},
      {"items/sign_rule", &R::sign_rule, "", "with --queries only: how the sides of points were decided",
       everywhere, 0, 1, ItemHaving::sides},
      {"items/uncertain", &R::uncertain, "1", "with --queries only: points whose side is not certain",
       everywhere, 0, 1, ItemHaving::sides},
  });
}();

// ---- their types

struct ColumnType {
  ElementType element = ElementType::f32;
  std::uint32_t width = 0;  // as of SampleColumn; of a text its bytes, 0: those of the longest
  std::span<const std::string_view> words = {};  // of `word`, by value
  std::span<const std::string_view> names = {};  // what each of the `width` values counts. Such lists grow
};

ColumnType type_of(const SampleColumn& column);
ColumnType type_of(const ItemColumn& column);

}  // namespace meander
