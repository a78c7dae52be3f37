// The formats of `meander export`.
#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "io/file_kind.h"
#include "io/mesh/point_writer.h"
#include "io/word_list.h"

namespace meander {

enum class ExportContent : std::uint8_t { points, arrays, descriptors };

struct ExportFormat {
  std::string_view word;
  ExportContent content;
  FileKind kind;            // of the files that it may replace
  std::string_view ending;  // of the file of one item or table; empty: several files, or any name
  PointFormat points = PointFormat::ply;
};

inline constexpr std::array<ExportFormat, 9> export_formats = {
    {{"ply", ExportContent::points, FileKind::ply_points, ".ply", PointFormat::ply},
     {"off", ExportContent::points, FileKind::off_points, ".off", PointFormat::off},
     {"xyz", ExportContent::points, FileKind::xyz, ".xyz", PointFormat::xyz},
     {"npz", ExportContent::arrays, FileKind::zip, ".npz"},
     {"webdataset", ExportContent::arrays, FileKind::tar, {}},
     {"csv", ExportContent::descriptors, FileKind::csv, ".csv"},
     {"fbin", ExportContent::descriptors, FileKind::fbin, ".fbin"},
     {"npy", ExportContent::descriptors, FileKind::npy, ".npy"},
     {"ann-hdf5", ExportContent::descriptors, FileKind::hdf5, {}}}};

// The row of a word of the table.
inline const ExportFormat& export_format(std::string_view word) {
  return *std::find_if(export_formats.begin(), export_formats.end() - 1,
                       [&](const ExportFormat& format) { return format.word == word; });
}

// The row whose files have this ending (in lower case, with its dot); null: none.
inline const ExportFormat* format_of_ending(std::string_view ending) {
  for (const ExportFormat& format : export_formats)
    if (!ending.empty() && format.ending == ending) return &format;
  return nullptr;
}

// Lists the formats of this content for messages: "csv, fbin, npy or ann-hdf5".
inline std::string formats_with(ExportContent content, std::string_view conjunction = {}) {
  std::vector<std::string_view> words;
  for (const ExportFormat& format : export_formats)
    if (format.content == content) words.push_back(format.word);
  return word_list(words, conjunction);
}

}  // namespace meander
