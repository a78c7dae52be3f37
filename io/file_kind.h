// The kind of a file, determined by its content, so that a file is replaced only by one of the same kind.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "io/mesh/mesh_format.h"

namespace meander {

enum class FileKind : std::uint8_t {
  empty,
  store,  // begins with the user block of a Meander store, whole or not
  hdf5,   // any other HDF5 file
  png,
  svg,
  html,
  json,
  csv,         // text whose lines have the same number of cells, two or more
  item_list,   // text that begins with a comment, `# `: the list of failed items
  xyz,         // text of numbers alone, three or more a line
  ply_points,  // PLY and OFF files without a face
  off_points,
  fbin,  // number of rows, width, then that many float32
  npy,   // an array of numpy
  tar,
  zip,              // arrays of numpy (npz) among others
  scores,           // of queries: meander retrieve evaluate --write-scores
  words,            // of local pairs: meander retrieve words
  graph,            // of nearest neighbors: meander retrieve graph
  distance_matrix,  // n x n float32 without header: finite, none negative, the first 0
  text,             // any other text
  unknown,
  mesh  // of the first mesh format; those of others follow: see mesh_kind
};

constexpr FileKind mesh_kind(MeshFormat format) {
  return static_cast<FileKind>(static_cast<int>(FileKind::mesh) + static_cast<int>(format));
}
constexpr bool is_mesh(FileKind kind) { return kind >= FileKind::mesh; }

// The endings of names, of what has one that says so; the first of a kind is that of files that are written.
// Meshes have theirs in the table of formats, stores have any.
struct KindEnding {
  FileKind kind;
  std::string_view ending;
};
inline constexpr KindEnding kind_endings[] = {
    {FileKind::ply_points, ".ply"}, {FileKind::off_points, ".off"}, {FileKind::xyz, ".xyz"},
    {FileKind::zip, ".npz"},        {FileKind::zip, ".zip"},        {FileKind::tar, ".tar"},
    {FileKind::csv, ".csv"},        {FileKind::fbin, ".fbin"},      {FileKind::npy, ".npy"},
    {FileKind::png, ".png"},        {FileKind::svg, ".svg"},        {FileKind::html, ".html"},
    {FileKind::json, ".json"}};
// Empty where the kind has none.
constexpr std::string_view ending_of(FileKind kind) {
  for (const KindEnding& row : kind_endings)
    if (row.kind == kind) return row.ending;
  return {};
}

// What sealed files begin with (io/sealed_file.h).
inline constexpr std::string_view graph_magic = "meander graph 1\n";
inline constexpr std::string_view words_magic = "meander words 1\n";
inline constexpr std::string_view scores_magic = "meander scores 1\n";

// For messages, with the article: "a PNG picture", "an OFF mesh".
std::string describe(FileKind kind);

// Reads up to 64 KiB of the file. The most specific kind that fits; a file that is cut short or damaged
// further on keeps the kind that its beginning shows. Throws FileError when it cannot be read. The
// path must name a regular file (symbolic links are followed).
FileKind kind_of_file(const std::filesystem::path& path);

}  // namespace meander
