#include "io/store/tensor_dataset.h"

#include <cmath>
#include <limits>
#include <thread>

#include "support/catch.h"
#include "support/hdf5_dataset.h"
#include "support/mesh_files.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::ContainsSubstring;

namespace {

void check_fails(const std::filesystem::path& path, const std::string& dataset, std::size_t vertices,
                 const std::string& sentence) {
  CAPTURE(dataset);
  try {
    read_tensor_dataset(path, dataset, vertices);
    FAIL("nothing was thrown");
  } catch (const ItemError& error) {
    CHECK(error.status() == Status::unreadable);
    CHECK_THAT(error.what(), ContainsSubstring(sentence));
    CHECK_THAT(error.what(), ContainsSubstring(dataset));
    CHECK_THAT(error.what(), ContainsSubstring(path.string()));
  }
}

}  // namespace

TEST_CASE("read_tensor_dataset: six or three columns of any number type, in nested groups") {
  const ScratchFolder scratch;
  const auto file = scratch / "tensors.h5";
  const std::vector<double> six = {1, 0, 0.5, 2, 0, 3, 4, -1, 0, 5, 0, 6},
                            three = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  add_hdf5_dataset(file, "six.off", {2, 6}, six);
  add_hdf5_dataset(file, "chair/deep/three.off", {3, 3}, three, H5T_STD_I16BE);
  add_hdf5_dataset(file, "float.off", {2, 6}, six, H5T_IEEE_F32LE);
  const TensorTable tensors = read_tensor_dataset(file, "six.off", 2);
  CHECK(tensors.columns == 6);
  CHECK(tensors.values == six);
  const TensorTable vectors = read_tensor_dataset(file, "chair/deep/three.off", 3);
  CHECK(vectors.columns == 3);
  CHECK(vectors.row_count() == 3);
  CHECK(vectors.values == three);
  CHECK(read_tensor_dataset(file, "float.off", 2).values == six);
}

TEST_CASE("read_tensor_dataset: non-finite numbers are read, and judged later against the mesh") {
  const ScratchFolder scratch;
  add_hdf5_dataset(scratch / "t.h5", "a", {1, 3}, {std::numeric_limits<double>::quiet_NaN(), 1, 0});
  CHECK(std::isnan(read_tensor_dataset(scratch / "t.h5", "a", 1).values[0]));
}

TEST_CASE("read_tensor_dataset: every mistake is unreadable and names file and dataset") {
  const ScratchFolder scratch;
  const auto file = scratch / "tensors.h5";
  add_hdf5_dataset(file, "group/flat", {12}, std::vector<double>(12, 1));
  add_hdf5_dataset(file, "four", {3, 4}, std::vector<double>(12, 1));
  add_hdf5_dataset(file, "cube", {2, 3, 2}, std::vector<double>(12, 1));
  add_hdf5_dataset(file, "good", {2, 6}, std::vector<double>(12, 1));
  add_hdf5_dataset(file, "none", {0, 6}, {});
  check_fails(file, "group/flat", 2, "not of the shape V x 6 or V x 3");
  check_fails(file, "four", 3, "not of the shape V x 6 or V x 3");
  check_fails(file, "cube", 2, "not of the shape V x 6 or V x 3");
  check_fails(file, "good", 3, "has 2 rows, but the mesh 3 vertices");
  check_fails(file, "none", 3, "has 0 rows, but the mesh 3 vertices");
  check_fails(file, "missing", 2, "open /missing");
  check_fails(file, "group/missing", 2, "open /group/missing");
  check_fails(file, "group", 2, "open /group");
  CHECK_THROWS_AS(read_tensor_dataset(scratch / "nowhere.h5", "good", 2), ItemError);
  write_file(scratch / "text.h5", "1 0 0 1 0 1\n");
  CHECK_THROWS_AS(read_tensor_dataset(scratch / "text.h5", "good", 2), ItemError);
  // Reading still works after all these errors.
  CHECK(read_tensor_dataset(file, "good", 2).row_count() == 2);
}

TEST_CASE("read_tensor_dataset: an extent larger than memory allocates nothing") {
  const ScratchFolder scratch;
  const auto file = scratch / "huge.h5";
  // 6 x 2^62 wraps around to 2^63; x 8 bytes to 0.
  add_hdf5_dataset(file, "wraps", {hsize_t{1} << 62, 6}, {});
  add_hdf5_dataset(file, "terabytes", {hsize_t{1} << 38, 6}, {});
  check_fails(file, "wraps", 12, "rows, but the mesh 12 vertices");
  check_fails(file, "terabytes", 12, "rows, but the mesh 12 vertices");
}

TEST_CASE("read_tensor_dataset: strings are not numbers") {
  const ScratchFolder scratch;
  const auto file = scratch / "words.h5";
  const hid_t word = H5Tcopy(H5T_C_S1);
  H5Tset_size(word, 8);
  add_hdf5_dataset(file, "words", {2, 6}, {}, word);
  H5Tclose(word);
  check_fails(file, "words", 2, "read /words");
}

TEST_CASE("read_tensor_dataset: several threads can read one file") {
  const ScratchFolder scratch;
  const auto file = scratch / "t.h5";
  for (int i = 0; i < 4; ++i) add_hdf5_dataset(file, std::to_string(i), {20, 3}, std::vector<double>(60, i));
  std::vector<int> wrong(4, 0);
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&, i] {
      for (int k = 0; k < 25; ++k)
        wrong[static_cast<std::size_t>(i)] +=
            read_tensor_dataset(file, std::to_string(i), 20).values != std::vector<double>(60, i);
    });
  for (std::thread& thread : threads) thread.join();
  CHECK(wrong == std::vector<int>(4, 0));
}
