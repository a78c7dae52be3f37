// Writes the store that read_store.py reads: make_example_store PATH ROWS SAMPLES standard|none
#include <cstdio>

#include "store_support.h"

int main(int count, char** arguments) {
  using namespace meander;
  if (count != 5) return 2;
  const StoreHeader header =
      test::make_header(std::stoull(arguments[2]), static_cast<std::uint32_t>(std::stoul(arguments[3])),
                        std::string(arguments[4]) == "none" ? Compression::none : Compression::standard);
  test::write_store(arguments[1], header);
  // What the reader must find, one line per row: id, status, label, split, bytes, repairs, a coordinate or
  // "-".
  for (std::uint64_t row = 0; row < header.ids.size(); ++row) {
    const Row made = test::make_row(header, row);
    std::printf("%s %d %d %d %llu %u ", header.ids[row].c_str(), static_cast<int>(made.report.status),
                header.labels[row], static_cast<int>(header.split(row)),
                static_cast<unsigned long long>(made.report.file_bytes), made.report.repairs.counts[3]);
    if (made.report.status == Status::ok)
      std::printf("%.9g %.9g\n", static_cast<double>(made.samples.points.back()),
                  static_cast<double>(made.descriptors[0].values.back()));
    else
      std::printf("- -\n");
  }
  return 0;
}
