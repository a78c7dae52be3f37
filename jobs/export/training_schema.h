// Points of a store under the names, and in the shapes and types, that the loaders of published projects
// read.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/archive/archive_writers.h"
#include "io/store/store_reader.h"
#include "kernels/core/vector3.h"
#include "kernels/core/words.h"

namespace meander {

enum class SchemaKind : std::uint8_t { hunyuan, dora, deepsdf, occnet, vecset };
inline constexpr Word<SchemaKind> schema_words[] = {{"hunyuan", SchemaKind::hunyuan},
                                                    {"dora", SchemaKind::dora},
                                                    {"deepsdf", SchemaKind::deepsdf},
                                                    {"occnet", SchemaKind::occnet},
                                                    {"vecset", SchemaKind::vecset}};

// Of points whose side is not certain, in exports that say on which side points are.
enum class UncertainChoice : std::uint8_t { drop, keep };
inline constexpr Word<UncertainChoice> uncertain_words[] = {{"drop", UncertainChoice::drop},
                                                            {"keep", UncertainChoice::keep}};

// The coordinates of a schema: the center of the model's box at 0 and half its longest side 1 (half_box), or
// its longest side 1 (box); or those of the store, which must be of --normalize unit-sphere (sphere).
enum class SchemaFrame : std::uint8_t { half_box, box, sphere };

// What an array holds. Points are three numbers, `with_normals` six, `with_distance` four.
enum class SchemaPart : std::uint8_t {
  points,
  normals,
  with_normals,
  distances,
  with_distance,
  outside_with_distance,
  inside_with_distance,
  occupancies,
  packed_occupancies,  // eight to a byte, the first in the highest bit
  loc,
  scale,
  one
};

// Which points: samples, those on sharp edges, or queries of these kinds, one kind after the other.
enum class SchemaPoints : std::uint8_t { samples, sharp, near, near_sharp, volume, near_then_volume, all };

enum class SchemaType : std::uint8_t { f16, f32, f64, u8, truth };

// An array of a file. `file`: its name, `{}` being the id of the model; a name in .npy is the array alone.
struct SchemaArray {
  SchemaKind schema;
  std::string_view file, key;
  SchemaPart part;
  SchemaPoints points;
  SchemaType type;
  bool middle_axis = false;  // (N, 1, ...) in place of (N, ...)
};

// What a store is exported as.
struct SchemaChoice {
  SchemaKind kind = SchemaKind::hunyuan;
  UncertainChoice uncertain = UncertainChoice::drop;
};

struct SchemaFacts {
  SchemaKind schema;
  SchemaFrame frame;
  bool positive_inside;  // the sign of distances
};
inline constexpr std::array<SchemaFacts, 5> schema_facts = {
    {{SchemaKind::hunyuan, SchemaFrame::half_box, true},
     {SchemaKind::dora, SchemaFrame::half_box, true},
     {SchemaKind::deepsdf, SchemaFrame::sphere, false},
     {SchemaKind::occnet, SchemaFrame::box, false},
     {SchemaKind::vecset, SchemaFrame::half_box, false}}};

// The arrays of all schemas, those of a file side by side.
inline constexpr auto schema_arrays = [] {
  using enum SchemaKind;
  using P = SchemaPart;
  using W = SchemaPoints;
  using T = SchemaType;
  return std::to_array<SchemaArray>({
      {hunyuan, "{}_surface.npz", "random_surface", P::with_normals, W::samples, T::f16},
      {hunyuan, "{}_surface.npz", "sharp_surface", P::with_normals, W::sharp, T::f16},
      {hunyuan, "{}_sdf.npz", "vol_points", P::points, W::volume, T::f16},
      {hunyuan, "{}_sdf.npz", "vol_label", P::distances, W::volume, T::f16},
      {hunyuan, "{}_sdf.npz", "random_near_points", P::points, W::near, T::f16},
      {hunyuan, "{}_sdf.npz", "random_near_label", P::distances, W::near, T::f16},
      {hunyuan, "{}_sdf.npz", "sharp_near_points", P::points, W::near_sharp, T::f16},
      {hunyuan, "{}_sdf.npz", "sharp_near_label", P::distances, W::near_sharp, T::f16},
      {dora, "{}.npz", "fps_coarse_surface", P::with_normals, W::samples, T::f32, true},
      {dora, "{}.npz", "fps_sharp_surface", P::with_normals, W::sharp, T::f32, true},
      {dora, "{}.npz", "sharp_near_surface", P::with_distance, W::near_sharp, T::f32},
      {dora, "{}.npz", "rand_points", P::with_distance, W::near_then_volume, T::f32},
      {deepsdf, "SdfSamples/{}.npz", "pos", P::outside_with_distance, W::all, T::f32},
      {deepsdf, "SdfSamples/{}.npz", "neg", P::inside_with_distance, W::all, T::f32},
      {occnet, "{}/points.npz", "points", P::points, W::volume, T::f32},
      {occnet, "{}/points.npz", "occupancies", P::packed_occupancies, W::volume, T::u8},
      {occnet, "{}/points.npz", "loc", P::loc, W::volume, T::f64},
      {occnet, "{}/points.npz", "scale", P::scale, W::volume, T::f64},
      {occnet, "{}/pointcloud.npz", "points", P::points, W::samples, T::f32},
      {occnet, "{}/pointcloud.npz", "normals", P::normals, W::samples, T::f32},
      {occnet, "{}/pointcloud.npz", "loc", P::loc, W::samples, T::f64},
      {occnet, "{}/pointcloud.npz", "scale", P::scale, W::samples, T::f64},
      {vecset, "ShapeNetV2_point/{}.npz", "vol_points", P::points, W::volume, T::f32},
      {vecset, "ShapeNetV2_point/{}.npz", "vol_label", P::occupancies, W::volume, T::truth},
      {vecset, "ShapeNetV2_point/{}.npz", "near_points", P::points, W::near, T::f32},
      {vecset, "ShapeNetV2_point/{}.npz", "near_label", P::occupancies, W::near, T::truth},
      {vecset, "ShapeNetV2_point/{}.npy", "", P::one, W::volume, T::f64},
      {vecset, "ShapeNetV2_watertight/{/4_pointcloud/}.npz", "points", P::points, W::samples, T::f32},
  });
}();

// The files of a model, relative to the folder of the export. In a name `{/FOLDER/}` is the id with FOLDER in
// front of its last part.
std::vector<std::string> schema_files(SchemaKind schema, const std::string& id);
// How they end in shards of WebDataset, where a key stands in place of the id and of folders: `surface.npz`.
std::vector<std::string> schema_members(SchemaKind schema);

// Coordinates of files are center + size * those of a schema.
struct SchemaPlace {
  Vector3 center;
  double size = 1;
};
SchemaPlace schema_place(const ItemReport& report, SchemaKind schema);

// Throws UsageError when the store lacks what the schema needs, and says which option makes it.
void require_schema(const StoreReader& store, SchemaKind schema);

// Whether anything is left of a row: with UncertainChoice::drop a model whose sides are not known is not.
bool has_sides(const ItemReport& report, std::uint32_t queries, UncertainChoice uncertain);

// File `number` of schema_files. Throws RunError(unusable) for 4 GiB and more.
void write_schema_file(const PutBytes& put, const StoreColumns& columns, SchemaChoice schema,
                       std::size_t number, const Row& row, const std::string& id);

// The table of docs/TRAINING.md: one line of Markdown for each array.
std::string schema_markdown();

}  // namespace meander
