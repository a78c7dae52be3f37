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

  constexpr ExportFormat(std::string_view name, ExportContent what, FileKind of, bool one_file = true)
      : word(name), content(what), kind(of), ending(one_file ? ending_of(of) : std::string_view()) {}
  constexpr ExportFormat(std::string_view name, ExportContent what, PointFormat format)
      : ExportFormat(name, what, kind_of(format)) {
    points = format;
  }
};

inline constexpr std::array<ExportFormat, 9> export_formats = {
    {{"ply", ExportContent::points, PointFormat::ply},
     {"off", ExportContent::points, PointFormat::off},
     {"xyz", ExportContent::points, PointFormat::xyz},
     {"npz", ExportContent::arrays, FileKind::zip},
     {"webdataset", ExportContent::arrays, FileKind::tar, false},
     {"csv", ExportContent::descriptors, FileKind::csv},
     {"fbin", ExportContent::descriptors, FileKind::fbin},
     {"npy", ExportContent::descriptors, FileKind::npy},
     {"ann-hdf5", ExportContent::descriptors, FileKind::hdf5}}};

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
