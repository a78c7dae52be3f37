// Encoding rows of the store, and the checksum that every reader of a store begins with.
#include <fcntl.h>

#include <filesystem>
#include <fstream>

#include "bench/bench_shapes.h"
#include "io/store/file_checksum.h"
#include "io/store/row_codec.h"

namespace meander::bench {

namespace {

void encode(benchmark::State& state) {
  static constexpr const char* names[] = {"standard", "none"};
  Model model = prepared_shape(0);
  const SampleParameters parameters = method_parameters("direct", static_cast<std::uint32_t>(state.range(1)));
  run_stages(placing_stages(parameters, nullptr), model);
  StoreHeader header;
  header.samples = parameters.samples;
  header.compression = static_cast<Compression>(state.range(0));
  header.parameters_json = "{}";
  header.ids = {"sphere.off"};
  header.labels = {-1};
  EncodedRow row;
  for ([[maybe_unused]] auto _ : state) {
    row = encode_row(header, 0, model.row);
    benchmark::DoNotOptimize(row.bytes.data());
  }
  count_items(state, "sample", static_cast<double>(header.samples));
  state.counters["bytes"] = static_cast<double>(row.bytes.size());
  check_sum(state, names[state.range(0)], row.bytes);
}
BENCHMARK(encode)->ArgsProduct({{0, 1}, {2048, 100000}})->Unit(benchmark::kMillisecond);

// A file in the page cache, by threads.
void checksum_file(benchmark::State& state) {
  const std::filesystem::path path = std::filesystem::temp_directory_path() / "meander-checksum-bench";
  std::ofstream(path, std::ios::binary) << std::string(std::size_t{256} << 20, 'm');
  {
    const FileDescriptor file = open_file(path, O_RDONLY);
    std::uint32_t checksum = 0;
    for ([[maybe_unused]] auto _ : state)
      checksum = store::checksum_of_file(file, 0, path, static_cast<std::size_t>(state.range(0)));
    benchmark::DoNotOptimize(checksum);
    state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(file_size(file, path)));
  }
  std::filesystem::remove(path);
}
BENCHMARK(checksum_file)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace meander::bench
