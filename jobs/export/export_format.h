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
  FileKind kind;  // of the files that it may replace
  PointFormat points = PointFormat::ply;
};

inline constexpr std::array<ExportFormat, 9> export_formats = {
    {{"ply", ExportContent::points, FileKind::ply_points, PointFormat::ply},
     {"off", ExportContent::points, FileKind::off_points, PointFormat::off},
     {"xyz", ExportContent::points, FileKind::xyz, PointFormat::xyz},
     {"npz", ExportContent::arrays, FileKind::zip},
     {"webdataset", ExportContent::arrays, FileKind::tar},
     {"csv", ExportContent::descriptors, FileKind::csv},
     {"fbin", ExportContent::descriptors, FileKind::fbin},
     {"npy", ExportContent::descriptors, FileKind::npy},
     {"ann-hdf5", ExportContent::descriptors, FileKind::hdf5}}};

// The row of a word of the table.
inline const ExportFormat& export_format(std::string_view word) {
  return *std::find_if(export_formats.begin(), export_formats.end() - 1,
                       [&](const ExportFormat& format) { return format.word == word; });
}

// Lists the formats of this content for messages: "csv, fbin, npy or ann-hdf5".
inline std::string formats_with(ExportContent content, std::string_view conjunction = {}) {
  std::vector<std::string_view> words;
  for (const ExportFormat& format : export_formats)
    if (format.content == content) words.push_back(format.word);
  return word_list(words, conjunction);
}

}  // namespace meander
