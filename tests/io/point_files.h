// Points in files, as `meander export` writes them.
#pragma once

#include <filesystem>
#include <string_view>

#include "io/file/atomic_file.h"
#include "io/mesh/point_writer.h"

namespace meander::test {

inline void write_points(const std::filesystem::path& path, PointFormat format, const Samples& samples,
                         const ItemReport& report, PointFrame frame = PointFrame::file) {
  AtomicFile file(path);
  meander::write_points([&file](std::string_view data) { file.append(data); }, format, samples, report,
                        frame);
  file.commit();
}

}  // namespace meander::test
