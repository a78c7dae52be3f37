// Vectors with known nearest neighbors as the HDF5 file of ANN-benchmarks (Aumueller, Bernhardsson and
// Faithfull 2020): datasets train, test, neighbors, distances; attribute distance.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

namespace meander {

struct AnnFileShape {
  std::uint64_t train = 0, test = 0;  // rows
  std::uint32_t width = 0;            // values of a vector
  std::uint32_t neighbors = 0;        // of a test vector
};

// Takes the file piece by piece, every part in the order of its rows. The file gets its name in finish(),
// synced; without that nothing is left. Throws RunError(unusable) when it cannot be written. No
// thread-safety.
class AnnFileWriter {
 public:
  // distance: "euclidean" or "angular", as ANN-benchmarks names them.
  AnnFileWriter(const std::filesystem::path& path, const AnnFileShape& shape, std::string_view distance);
  ~AnnFileWriter();
  AnnFileWriter(const AnnFileWriter&) = delete;
  AnnFileWriter& operator=(const AnnFileWriter&) = delete;

  void append_train(std::span<const float> vectors);
  void append_test(std::span<const float> vectors);
  // Positions in train and their distances, nearest first, `neighbors` of each test vector.
  void append_neighbors(std::span<const std::int32_t> positions, std::span<const float> distances);
  void finish();  // once, after everything was appended

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace meander
