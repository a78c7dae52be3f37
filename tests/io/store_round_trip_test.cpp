// A store returns what was written to it.
#include <limits>

#include "io/store/crc32c.h"
#include "store_support.h"
#include "support/catch.h"

using namespace meander;
using namespace meander::test;

namespace {

// `all`: the values of every row. Ranges begin and end inside, at and across chunks.
void check_descriptor(const StoreReader& reader, const DescriptorSchema& schema,
                      const std::vector<float>& all) {
  CHECK(all.size() == reader.rows() * schema.width);
  for (const std::uint64_t begin : {0ul, 1ul, 255ul, 256ul, 4000ul})
    for (const std::uint64_t count : {1ul, 256ul, 300ul, 513ul, 5000ul}) {
      if (begin >= reader.rows()) continue;
      const std::uint64_t here = std::min<std::uint64_t>(count, reader.rows() - begin);
      const std::vector<float> values = reader.read_descriptor(schema.name, begin, here);
      if (values.size() != here * schema.width ||
          std::memcmp(values.data(), all.data() + begin * schema.width, sizeof(float) * values.size()) != 0)
        FAIL(schema.name << " of " << here << " rows from " << begin);
    }
}

void check_round_trip(const StoreHeader& header) {
  const ScratchFolder folder;
  write_store(folder / "s.h5", header, 3);
  const VerifyResult verified = verify_store(folder / "s.h5");
  CHECK(verified.problems == std::vector<std::string>{});
  CHECK(verified.rows == header.ids.size());
  const StoreReader reader(folder / "s.h5");
  REQUIRE(reader.rows() == header.ids.size());
  CHECK(reader.samples() == header.samples);
  CHECK(reader.seed() == header.seed);
  CHECK(reader.order() == header.order);
  CHECK(reader.compression() == header.compression);
  CHECK(reader.parameters_json() == header.parameters_json);
  CHECK(reader.label_names() == header.label_names);
  CHECK(reader.format_version() == store_format_version);
  CHECK(reader.method_version() == store_method_version);
  CHECK_FALSE(reader.tool_version().empty());
  REQUIRE(reader.descriptors().size() == header.descriptors.size());
  for (std::size_t i = 0; i < header.descriptors.size(); ++i) {
    CHECK(reader.descriptors()[i].name == header.descriptors[i].name);
    CHECK(reader.descriptors()[i].width == header.descriptors[i].width);
    CHECK(reader.descriptors()[i].attributes == header.descriptors[i].attributes);
  }
  std::uint64_t ok = 0;
  std::vector<std::vector<float>> descriptors(header.descriptors.size());
  for (std::uint64_t row = 0; row < reader.rows(); ++row) {
    const Row made = make_row(header, row), back = reader.read_row(row);
    ok += made.report.status == Status::ok;
    if (!same(made, back) || reader.id(row) != header.ids[row] || !same(reader.report(row), made.report) ||
        reader.label(row) != header.labels[row] || reader.split(row) != header.split(row))
      FAIL("row " << row << " differs");
    for (std::size_t d = 0; d < descriptors.size(); ++d)
      if (made.report.status == Status::ok)
        descriptors[d].insert(descriptors[d].end(), made.descriptors[d].values.begin(),
                              made.descriptors[d].values.end());
      else
        descriptors[d].resize(descriptors[d].size() + header.descriptors[d].width,
                              std::numeric_limits<float>::quiet_NaN());
    if (made.report.status == Status::ok &&
        back.report.points_crc32c != crc32c(std::span<const float>(made.samples.points)))
      FAIL("row " << row << " has the wrong checksum");
  }
  CHECK(verified.ok_rows == ok);
  for (std::size_t d = 0; d < descriptors.size(); ++d)
    check_descriptor(reader, header.descriptors[d], descriptors[d]);
}

}  // namespace

TEST_CASE("store: rows survive a round trip, whatever N and the compression") {
  for (const Compression compression : {Compression::standard, Compression::none}) {
    check_round_trip(make_header(700, 1, compression));
    check_round_trip(make_header(700, 7, compression));
    check_round_trip(make_header(300, 256, compression));
    check_round_trip(make_header(40, 2048, compression));
    check_round_trip(make_header(3, 100000, compression));
  }
}

TEST_CASE("store: rows of several journals survive a round trip") {
  check_round_trip(make_header(4096 * 2 + 300, 3));
}

TEST_CASE("store: a single row survives a round trip") {
  for (const std::uint32_t samples : {1u, 3000u}) {
    check_round_trip(make_header(1, samples));
    check_round_trip(make_header(2, samples));
  }
}

TEST_CASE("store: a store without rows can be read") { check_round_trip(make_header(0, 16)); }

TEST_CASE("store: a store without descriptors and classes can be read") {
  StoreHeader header = make_header(20, 5);
  header.descriptors.clear();
  header.label_names.clear();
  header.labels.assign(20, -1);
  check_round_trip(header);
}

TEST_CASE("store: many classes and a wide descriptor survive a round trip") {
  StoreHeader header = make_header(30, 5);
  for (int i = 0; i < 6000; ++i) header.label_names.push_back("class number " + std::to_string(i));
  header.parameters_json = "{\"text\":\"" + std::string(70000, 'x') + "\"}";
  header.descriptors[0].width = 5000;
  check_round_trip(header);
}

TEST_CASE("store: the id of every row is found, other ids are not") {
  const ScratchFolder folder;
  const StoreHeader header = make_header(5000, 1);
  write_store(folder / "s.h5", header);
  const StoreReader reader(folder / "s.h5");
  for (std::uint64_t row = 0; row < 5000; row += 37) CHECK(reader.find(header.ids[row]) == row);
  CHECK(reader.find("") == std::nullopt);
  CHECK(reader.find("class/m00000") == std::nullopt);
  CHECK(reader.find(header.ids[77] + "x") == std::nullopt);
  CHECK(reader.find("zzz") == std::nullopt);
  CHECK_THROWS_AS(reader.report(5000), ItemError);
}

TEST_CASE("store: ids that are not UTF-8 are kept byte for byte") {
  const ScratchFolder folder;
  StoreHeader header = make_header(3, 4);
  header.ids = {"a\xFF.off", "b \"quoted\".off", "\xC3\xA9.off"};
  write_store(folder / "s.h5", header);
  const StoreReader reader(folder / "s.h5");
  for (std::uint64_t row = 0; row < 3; ++row) CHECK(reader.id(row) == header.ids[row]);
}

TEST_CASE("store: without splits in the header every row has the split none") {
  const ScratchFolder folder;
  StoreHeader header = make_header(3, 4);
  const std::string with = store_bytes(header);
  header.splits.assign(3, Split::none);
  const std::string none = store_bytes(header);
  header.splits.clear();
  CHECK(store_bytes(header) == none);
  CHECK(with != none);
}

// tests/support/version1_store.h5 was written by the last program of format version 1: two models and an
// empty file, eight samples each, d2.
TEST_CASE("reader: a store of format version 1 is valid and lacks later columns") {
  const std::filesystem::path path =
      std::filesystem::path(MEANDER_SOURCE_DIR) / "tests/support/version1_store.h5";
  CHECK(verify_store(path).problems == std::vector<std::string>{});
  const StoreReader reader(path);
  CHECK(reader.format_version() == 1);
  REQUIRE(reader.rows() == 3);
  CHECK(reader.id(1) == "table/empty.off");
  const ItemReport failed = reader.report(1);
  CHECK(failed.status == Status::empty);
  CHECK_FALSE(failed.reason.empty());
  const Row row = reader.read_row(0);
  CHECK(row.report.status == Status::ok);
  CHECK(row.report.method == Method::direct);
  CHECK(row.report.faces == 4);
  CHECK(row.report.content_sha256[0] != 0);
  CHECK(row.samples.count() == 8);
  REQUIRE(row.descriptors.size() == 1);
  CHECK(row.descriptors[0].values.size() == 8);
  const StoreHeader header = reader.header();
  for (std::uint64_t i = 0; i < 3; ++i) {
    CHECK(reader.split(i) == Split::none);
    CHECK(header.split(i) == Split::none);
    CHECK(reader.report(i).file_bytes == 0);
    CHECK(reader.report(i).order_reason == OrderReason::as_asked);
  }
  // What is made from it is a store of this version with the same rows.
  const ScratchFolder folder;
  RunDirectory run(folder / "s.h5", header);
  for (std::uint64_t i = 0; i < 3; ++i) run.end_item(encode_row(header, i, reader.read_row(i)));
  run.finish();
  CHECK(verify_store(folder / "s.h5").problems == std::vector<std::string>{});
  const StoreReader again(folder / "s.h5");
  CHECK(again.format_version() == store_format_version);
  for (std::uint64_t i = 0; i < 3; ++i) CHECK(same(again.read_row(i), reader.read_row(i)));
}

TEST_CASE("reader: a file that is not a store is refused with a message") {
  const ScratchFolder folder;
  const auto refusal = [&](const std::string& bytes) {
    write_file(folder / "x.h5", bytes);
    try {
      const StoreReader reader(folder / "x.h5");
    } catch (const RunError& error) {
      CHECK(error.kind() == RunError::Kind::unusable);
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK_FALSE(refusal("").empty());
  CHECK_FALSE(refusal("not HDF5 at all").empty());
  CHECK_FALSE(refusal(store_bytes(make_header(3, 4)).substr(0, 3000)).empty());
  CHECK_THROWS_AS(StoreReader(folder / "absent.h5"), RunError);
}
