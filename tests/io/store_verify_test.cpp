// verify finds every damage; export_pointnet writes what loaders expect.
#include <hdf5.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <map>

#include "io/store/crc32c.h"
#include "io/store/pointnet_export.h"
#include "io/store/store_file.h"
#include "store_support.h"
#include "support/catch.h"
#include "support/sanitized.h"

using namespace meander;
using namespace meander::test;
namespace fs = std::filesystem;

namespace {

// Makes the user block agree with the bytes again, so that only the contents are wrong.
void reseal(const fs::path& path) {
  std::string bytes = read_file(path);
  const std::string_view body = std::string_view(bytes).substr(store::user_block_bytes);
  bytes.replace(
      0, store::user_block_bytes,
      store::user_block_text(bytes.size(), crc32c(std::span<const char>(body.data(), body.size()))));
  write_file(path, bytes);
}

// Overwrites one element block of a dataset through the library and reseals the file.
template <class Value>
void tamper(const fs::path& path, const char* dataset_name, std::vector<hsize_t> begin, const Value& value) {
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t dataset = H5Dopen2(file, dataset_name, H5P_DEFAULT);
  const hid_t type = H5Dget_type(dataset);
  const hid_t space = H5Dget_space(dataset);
  REQUIRE(H5Tget_size(type) == sizeof(Value));
  const std::vector<hsize_t> one(begin.size(), 1);
  H5Sselect_hyperslab(space, H5S_SELECT_SET, begin.data(), nullptr, one.data(), nullptr);
  const hid_t memory = H5Screate(H5S_SCALAR);
  REQUIRE(H5Dwrite(dataset, type, memory, space, H5P_DEFAULT, &value) >= 0);
  H5Sclose(memory);
  H5Sclose(space);
  H5Tclose(type);
  H5Dclose(dataset);
  H5Fclose(file);
  reseal(path);
}

std::uint64_t first_row(const StoreHeader& header, bool ok) {
  std::uint64_t row = 0;
  while ((make_row(header, row).report.status == Status::ok) != ok) ++row;
  return row;
}

}  // namespace

TEST_CASE("verify: every single flipped bit of a small store is found") {
  const ScratchFolder folder;
  const fs::path store = folder / "s.h5";
  write_store(store, make_header(3, 2));
  const std::string good = read_file(store);
  REQUIRE(verify_store(store).problems.empty());
  std::fstream file(store, std::ios::in | std::ios::out | std::ios::binary);
  const auto put = [&](std::size_t at, char byte) {
    file.seekp(static_cast<std::streamoff>(at));
    file.put(byte);
    file.flush();
  };
  std::mt19937 random(1);
  const std::size_t step = sanitized ? 17 : 1;  // release builds try every byte
  for (std::size_t i = 0; i < good.size(); i += step) {
    put(i, static_cast<char>(good[i] ^ (1 << (random() % 8))));
    if (verify_store(store).problems.empty()) FAIL("a flipped bit in byte " << i << " was not found");
    put(i, good[i]);
  }
  CHECK(verify_store(store).problems.empty());
}

TEST_CASE("verify: every wrong file length is found") {
  const ScratchFolder folder;
  const fs::path store = folder / "s.h5";
  write_store(store, make_header(3, 2));
  const std::string good = read_file(store);
  for (std::size_t length = 0; length < good.size(); length += 97) {
    write_file(store, good.substr(0, length));
    CHECK(verify_store(store).problems.size() == 1);
  }
  write_file(store, good + '\0');
  CHECK(verify_store(store).problems.size() == 1);
  fs::remove(store);
  CHECK(verify_store(store).problems.size() == 1);
  write_file(store, "");
  CHECK(verify_store(store).problems.size() == 1);
}

TEST_CASE("verify: wrong contents are found where all checksums match") {
  const StoreHeader header = make_header(30, 300);
  const ScratchFolder folder;
  write_store(folder / "good.h5", header);
  const hsize_t ok = first_row(header, true), failed = first_row(header, false);
  const fs::path store = folder / "s.h5";
  const auto problem = [&](const auto& damage) {
    fs::copy_file(folder / "good.h5", store, fs::copy_options::overwrite_existing);
    damage();
    const VerifyResult result = verify_store(store);
    REQUIRE(result.problems.size() > 0);
    return result.problems.front();
  };
  const std::string row = "row " + std::to_string(ok) + " (" + header.ids[ok] + ")";
  const std::string failed_row = "row " + std::to_string(failed) + " (" + header.ids[failed] + ")";
  using Catch::Matchers::ContainsSubstring;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  CHECK_THAT(problem([&] {
               tamper(store, "/points", {ok, 5, 1}, 0.25f);
             }),
             ContainsSubstring(row) && ContainsSubstring("checksum of its points"));
  CHECK_THAT(problem([&] {
               tamper(store, "/normals", {ok, 299, 2}, nan);
             }),
             ContainsSubstring(row) && ContainsSubstring("/normals"));
  CHECK_THAT(problem([&] {
               tamper(store, "/descriptors/a3", {ok, 2}, nan);
             }),
             ContainsSubstring(row) && ContainsSubstring("/descriptors/a3"));
  CHECK_THAT(problem([&] {
               tamper(store, "/face_index", {ok, 7}, std::uint32_t{4000000});
             }),
             ContainsSubstring("4000000 in /face_index"));
  CHECK_THAT(problem([&] {
               tamper(store, "/corners", {ok, 7, 0}, std::uint32_t{0xFFFFFFFF});
             }),
             ContainsSubstring("/corners"));
  CHECK_THAT(problem([&] {
               tamper(store, "/curve_rank", {ok, 7}, std::uint32_t{300});
             }),
             ContainsSubstring("not an order of 0 .. 299"));
  CHECK_THAT(problem([&] {
               const std::uint32_t twice = make_row(header, ok).samples.curve_rank[0];
               tamper(store, "/curve_rank", {ok, 7}, twice);
             }),
             ContainsSubstring("not an order"));
  CHECK_THAT(problem([&] {
               tamper(store, "/density", {failed, 0}, 1.0f);
             }),
             ContainsSubstring(failed_row) && ContainsSubstring("not all fill"));
  CHECK_THAT(problem([&] { tamper(store, "/items/status", {ok}, std::uint8_t{77}); }),
             ContainsSubstring("unknown value 77"));
  CHECK_THAT(problem([&] { tamper(store, "/items/method", {ok}, std::uint8_t{9}); }),
             ContainsSubstring("unknown value 9"));
  CHECK_THAT(problem([&] { tamper(store, "/items/status", {ok}, std::uint8_t{3}); }),
             ContainsSubstring("unsupported_format"));
  CHECK_THAT(problem([&] { tamper(store, "/items/points_crc32c", {failed}, 5u); }),
             ContainsSubstring(failed_row));
  CHECK_THAT(problem([&] {
               tamper(store, "/label", {ok, 0}, std::int32_t{3});
             }),
             ContainsSubstring("label 3 of 3 classes"));
  struct Id {
    char bytes[28];
  } id{};
  std::copy(header.ids[20].begin(), header.ids[20].end(), id.bytes);
  CHECK_THAT(problem([&] { tamper(store, "/items/id", {10}, id); }),
             ContainsSubstring("row 11") && ContainsSubstring("does not come after"));
}

TEST_CASE("verify: values outside the range of their column are found where all checksums match") {
  const StoreHeader header = make_header(30, 300);
  const ScratchFolder folder;
  write_store(folder / "good.h5", header);
  const hsize_t ok = first_row(header, true);
  const ItemReport report = make_row(header, ok).report;
  const fs::path store = folder / "s.h5";
  const std::string row = "row " + std::to_string(ok) + " (" + header.ids[ok] + ")";
  const auto check = [&](const char* dataset, std::vector<hsize_t> at, const auto& value, const char* what) {
    fs::copy_file(folder / "good.h5", store, fs::copy_options::overwrite_existing);
    tamper(store, dataset, std::move(at), value);
    const VerifyResult result = verify_store(store);
    INFO(dataset << " " << value);
    REQUIRE(result.problems.size() > 0);
    CHECK_THAT(result.problems.front(),
               Catch::Matchers::ContainsSubstring(row) && Catch::Matchers::ContainsSubstring(what));
  };
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinity = std::numeric_limits<double>::infinity();
  for (const double wrong : {0.0, -1.0, nan, infinity}) {
    for (const char* const name : {"scale", "area", "measure", "area_scale_range", "distortion"})
      check((std::string("/items/") + name).c_str(), {ok}, wrong, name);
    if (std::isfinite(wrong)) continue;
    check("/items/loc", {ok, 1}, wrong, "loc");
    check("/items/bbox", {ok, 2}, wrong, "bbox");
    check("/items/bbox", {ok, 5}, wrong, "bbox");
  }
  check("/items/bbox", {ok, 0}, report.bbox[3] + 1, "bbox");
  check("/items/scale", {ok}, 100 * report.scale, "but its bbox is");
  check("/items/loc", {ok, 2}, report.loc[2] + 20, "but its bbox is");
  check("/items/overlap", {ok}, 1.5, "overlap");
  check("/items/overlap", {ok}, -0.5, "overlap");
  check("/items/components", {ok}, std::uint32_t{0}, "components");
  check("/items/vertices", {ok}, std::uint64_t{0}, "vertices");
  check("/items/faces", {ok}, std::uint64_t{0}, "faces");
  check("/items/method", {ok}, std::uint8_t{0}, "no method");
  check("/corners", {ok, 7, 0}, static_cast<std::uint32_t>(report.vertices), "/corners, which must be below");
  check("/barycentric", {ok, 9, 0}, -0.25f, "weights");
  check("/barycentric", {ok, 9, 1}, 1.25f, "weights");
  check("/barycentric", {ok, 9, 0}, static_cast<float>(nan), "not finite");
  check("/density", {ok, 3}, -1.0f, "/density, which must be 0 or more");
  check("/density", {ok, 3}, static_cast<float>(infinity), "/density that is not finite");
  check("/normals", {ok, 3, 2}, 2.0f, "of length");
}

TEST_CASE("verify: wrong contents are found in rows of many chunks, which are checked piecewise") {
  // Rows of 19 MB are checked one by one; 7 chunks in each dataset.
  StoreHeader header = make_header(4, 400001, Compression::none);
  header.descriptors.resize(1);
  const ScratchFolder folder;
  const fs::path store = folder / "s.h5";
  write_store(store, header);
  const hsize_t ok = first_row(header, true), failed = first_row(header, false);
  REQUIRE(std::max(ok, failed) < 4);
  CHECK(verify_store(store).problems.empty());
  const Samples samples = make_row(header, ok).samples;
  const auto problems_of = [&] { return verify_store(store).problems; };
  const std::string row = "row " + std::to_string(ok) + " (" + header.ids[ok] + ")";
  using Catch::Matchers::ContainsSubstring;
  constexpr hsize_t last = 400000;
  // The last and the first chunk: each change is undone before the next.
  const auto check = [&](const char* dataset, std::vector<hsize_t> at, auto wrong, auto right,
                         const char* sentence) {
    tamper(store, dataset, at, wrong);
    const std::vector<std::string> problems = problems_of();
    REQUIRE(problems.size() == 1);
    CHECK_THAT(problems.front(), ContainsSubstring(sentence));
    tamper(store, dataset, at, right);
  };
  check("/points", {ok, last, 1}, 0.25f, samples.points[3 * last + 1], "checksum of its points");
  check("/points", {ok, 0, 1}, 0.25f, samples.points[1], "checksum of its points");
  check("/normals", {ok, last, 2}, 7.0f, samples.normals[3 * last + 2], "of length");
  check("/face_index", {ok, 300000}, std::uint32_t{4000000}, samples.face[300000], "4000000 in /face_index");
  check("/curve_rank", {ok, last}, samples.curve_rank[0], samples.curve_rank[last], "not an order");
  check("/curve_rank", {ok, 1}, std::uint32_t{400001}, samples.curve_rank[1], "not an order of 0 .. 400000");
  CHECK(problems_of().empty());
  tamper(store, "/density", {failed, last}, 1.0f);
  REQUIRE(problems_of().size() == 1);
  CHECK_THAT(problems_of().front(), ContainsSubstring("/density is not all fill"));
}

TEST_CASE("verify: a chunk with a wrong checksum is named") {
  const StoreHeader header = make_header(30, 300, Compression::none);
  const ScratchFolder folder;
  const fs::path store = folder / "s.h5";
  write_store(store, header);
  std::string bytes = read_file(store);
  const Row row = make_row(header, first_row(header, true));
  const std::string needle(reinterpret_cast<const char*>(row.samples.normals.data()), 400);
  const std::size_t at = bytes.find(needle);
  REQUIRE(at != std::string::npos);
  bytes[at + 9] = static_cast<char>(bytes[at + 9] ^ 2);
  write_file(store, bytes);
  reseal(store);
  const VerifyResult result = verify_store(store);
  REQUIRE(result.problems.size() == 1);
  CHECK_THAT(result.problems.front(), Catch::Matchers::ContainsSubstring("/normals") &&
                                          Catch::Matchers::ContainsSubstring("fails its checksum"));
}

TEST_CASE("verify: problems are listed up to the limit") {
  const StoreHeader header = make_header(30, 2);
  const ScratchFolder folder;
  const fs::path store = folder / "s.h5";
  write_store(store, header);
  for (hsize_t row = 0; row < 30; ++row) tamper(store, "/label", {row, 0}, std::int32_t{50});
  CHECK(verify_store(store).problems.size() == 30);
  CHECK(verify_store(store, 4).problems.size() == 4);
}

TEST_CASE("verify: progress ends at the number of rows") {
  const ScratchFolder folder;
  write_store(folder / "s.h5", make_header(30, 2));
  std::uint64_t last = 0;
  const auto progress = [&](std::uint64_t done, std::uint64_t total) {
    CHECK(total == 30);
    CHECK(done > last);
    last = done;
  };
  CHECK(verify_store(folder / "s.h5", 100, progress).ok_rows > 0);
  CHECK(last == 30);
}

TEST_CASE("export_pointnet: ok rows with a class are written in shards per split, with their lists") {
  const StoreHeader header = make_header(150, 20);
  const ScratchFolder folder;
  write_store(folder / "s.h5", header);
  const StoreReader store(folder / "s.h5");
  const PointnetCounts counts = export_pointnet(store, folder / "out/pointnet", 8);
  std::map<std::string, std::vector<std::uint64_t>> wanted;
  std::uint64_t unlabeled = 0;
  for (std::uint64_t row = 0; row < 150; ++row) {
    if (store.report(row).status != Status::ok) continue;
    const Split split = store.split(row);
    if (store.label(row) < 0)
      ++unlabeled;
    else
      wanted[split == Split::test ? "test" : split == Split::validation ? "val" : "train"].push_back(row);
  }
  CHECK(counts.unlabeled == unlabeled);
  CHECK(counts.train == wanted["train"].size());
  CHECK(counts.test == wanted["test"].size());
  CHECK(counts.validation == wanted["val"].size());
  for (const auto& [part, ok] : wanted) {
    INFO(part);
    REQUIRE(ok.size() > 8);
    const std::string start = "out/pointnet/ply_data_" + part;
    std::string files;
    const std::size_t shards = (ok.size() + 7) / 8;
    for (std::size_t k = 0; k < shards; ++k) {
      const fs::path path = folder / (start + std::to_string(k) + ".h5");
      files += path.string() + "\n";
      const std::size_t rows = std::min<std::size_t>(8, ok.size() - 8 * k);
      std::vector<float> data(rows * 60), normal(rows * 60);
      std::vector<std::uint8_t> label(rows);
      const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
      const auto read = [&](const char* name, hid_t type, hsize_t size, void* values) {
        const hid_t dataset = H5Dopen2(file, name, H5P_DEFAULT);
        CHECK(H5Dget_storage_size(dataset) > 0);
        const hid_t space = H5Dget_space(dataset);
        CHECK(static_cast<hsize_t>(H5Sget_simple_extent_npoints(space)) == size);
        CHECK(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
        H5Sclose(space);
        H5Dclose(dataset);
      };
      read("data", H5T_NATIVE_FLOAT, rows * 60, data.data());
      read("normal", H5T_NATIVE_FLOAT, rows * 60, normal.data());
      read("label", H5T_NATIVE_UINT8, rows, label.data());
      H5Fclose(file);
      std::string ids = "[";
      for (std::size_t i = 0; i < rows; ++i) {
        const Row row = make_row(header, ok[8 * k + i]);
        CHECK(std::equal(row.samples.points.begin(), row.samples.points.end(),
                         data.begin() + static_cast<long>(60 * i)));
        CHECK(std::equal(row.samples.normals.begin(), row.samples.normals.end(),
                         normal.begin() + static_cast<long>(60 * i)));
        CHECK(label[i] == header.labels[ok[8 * k + i]]);
        ids += (i ? ",\"" : "\"") + header.ids[ok[8 * k + i]] + "\"";
      }
      CHECK(read_file(folder / (start + "_" + std::to_string(k) + "_id2file.json")) == ids + "]\n");
    }
    CHECK_FALSE(fs::exists(folder / (start + std::to_string(shards) + ".h5")));
    CHECK(read_file(folder / ("out/pointnet/" + part + "_files.txt")) == files);
  }
  CHECK(read_file(folder / "out/pointnet/shape_names.txt") == "airplane\nchair\n\xC3\xA9tag\xC3\xA8re\n");
}

TEST_CASE("export_pointnet: shards say whether they hold stored or file coordinates") {
  const StoreHeader header = make_header(150, 20);
  const ScratchFolder folder;
  write_store(folder / "s.h5", header);
  const StoreReader store(folder / "s.h5");
  std::vector<std::uint64_t> trained;  // the rows of the first shard
  for (std::uint64_t row = 0; row < 150 && trained.size() < 8; ++row)
    if (store.report(row).status == Status::ok && store.label(row) >= 0 &&
        (store.split(row) == Split::train || store.split(row) == Split::none))
      trained.push_back(row);
  for (const PointFrame frame : {PointFrame::stored, PointFrame::file}) {
    export_pointnet(store, folder / "out", 8, nullptr, frame);
    const hid_t file = H5Fopen((folder / "out/ply_data_train0.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    const hid_t data = H5Dopen2(file, "data", H5P_DEFAULT), type = H5Dget_type(data);
    CHECK(H5Tget_size(type) == (frame == PointFrame::file ? 8 : 4));
    std::vector<double> values(8 * 60);
    REQUIRE(H5Dread(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0);
    CHECK(store::read_text_attribute(data, "frame") == name_of(frame));
    H5Tclose(type);
    H5Dclose(data);
    H5Fclose(file);
    for (std::size_t i = 0; i < 8; ++i) {
      const Row row = make_row(header, trained[i]);
      for (std::size_t k = 0; k < 60; ++k) {
        const double stored = row.samples.points[k];
        const double expected =
            frame == PointFrame::file ? row.report.loc[k % 3] + row.report.scale * stored : stored;
        REQUIRE(values[60 * i + k] == expected);
      }
    }
  }
}

TEST_CASE("export_pointnet: a second export removes only the files of the first") {
  StoreHeader header = make_header(60, 5);
  const ScratchFolder folder;
  write_store(folder / "s.h5", header);
  header.splits.assign(60, Split::none);
  write_store(folder / "t.h5", header);
  CHECK(pointnet_files(folder / "out").empty());
  export_pointnet(StoreReader(folder / "s.h5"), folder / "out", 4);
  write_file(folder / "out/ply_data_trainx.h5", "x");
  write_file(folder / "out/other.txt", "x");
  const std::size_t many = pointnet_files(folder / "out").size();
  const PointnetCounts counts = export_pointnet(StoreReader(folder / "t.h5"), folder / "out");
  CHECK(counts.test == 0);
  // One shard, its ids, two lists and the names of the classes.
  CHECK(pointnet_files(folder / "out").size() == 5);
  CHECK(many > 5);
  CHECK(read_file(folder / "out/test_files.txt").empty());
  CHECK_FALSE(fs::exists(folder / "out/val_files.txt"));
  CHECK(fs::exists(folder / "out/ply_data_trainx.h5"));
  CHECK(fs::exists(folder / "out/other.txt"));
}

TEST_CASE("export_pointnet: without any class nothing is written") {
  StoreHeader header = make_header(10, 5);
  header.labels.assign(10, -1);
  const ScratchFolder folder;
  write_store(folder / "s.h5", header);
  CHECK_THROWS_WITH(export_pointnet(StoreReader(folder / "s.h5"), folder / "out"),
                    Catch::Matchers::ContainsSubstring("--labels"));
  CHECK_FALSE(fs::exists(folder / "out"));
}

TEST_CASE("export_pointnet: too many classes and folders that cannot be created are errors") {
  StoreHeader header = make_header(5, 4);
  for (int i = 0; i < 300; ++i) header.label_names.push_back("class " + std::to_string(i));
  const ScratchFolder folder;
  write_store(folder / "s.h5", header);
  const StoreReader store(folder / "s.h5");
  CHECK_THROWS_AS(export_pointnet(store, folder / "out"), RunError);
  write_file(folder / "file", "x");
  CHECK_THROWS_AS(export_pointnet(store, folder / "file"), RunError);
  CHECK_THROWS_AS(export_pointnet(store, folder / "out", 0), RunError);
}
