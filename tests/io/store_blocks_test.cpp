// Rows whose samples are made and encoded while they are written.
#include <atomic>

#include "store_support.h"
#include "support/catch.h"
#include "support/sanitized.h"

using namespace meander;
using namespace meander::test;
namespace fs = std::filesystem;

namespace {

// No descriptors; chunks of 50,000 to 65,536 samples, four a row but for the shorter sets.
StoreHeader header_of(std::uint64_t rows, std::uint32_t samples, Compression compression) {
  StoreHeader header = make_header(rows, samples, compression);
  header.descriptors.clear();
  return header;
}

// Samples [begin, end) of all arrays.
Samples slice(const Samples& from, std::uint64_t begin, std::uint64_t end) {
  const auto part = [&](const auto& values) {
    const std::size_t width = values.size() / from.count();
    return std::decay_t<decltype(values)>(values.begin() + static_cast<std::ptrdiff_t>(width * begin),
                                          values.begin() + static_cast<std::ptrdiff_t>(width * end));
  };
  Samples to;
  to.points = part(from.points);
  to.normals = part(from.normals);
  to.face = part(from.face);
  to.corners = part(from.corners);
  to.barycentric = part(from.barycentric);
  to.curve_rank = part(from.curve_rank);
  to.density = part(from.density);
  return to;
}

EncodedRow in_blocks(const StoreHeader& header, std::uint64_t row, const Row& made) {
  return encode_row_in_blocks(header, row, made.report, [&made](std::uint64_t begin, std::uint64_t end) {
    return slice(made.samples, begin, end);
  });
}

// A run whose rows that are ok are written in blocks.
void write_in_blocks(const fs::path& store, const StoreHeader& header) {
  RunDirectory run(store, header);
  for (std::uint64_t row = 0; row < header.ids.size(); ++row) {
    const Row made = make_row(header, row);
    run.end_item(made.report.status == Status::ok ? in_blocks(header, row, made)
                                                  : encode_row(header, row, made));
  }
  run.finish();
}

std::uint64_t ok_row(const StoreHeader& header) {
  std::uint64_t row = 0;
  while (make_row(header, row).report.status != Status::ok) ++row;
  return row;
}

}  // namespace

TEST_CASE("blocks: a store written in blocks equals one of rows encoded as a whole") {
  for (const Compression compression : {Compression::standard, Compression::none})
    for (const std::uint32_t samples : thinned(2, std::vector{1400u, 200003u, 65536u})) {
      const StoreHeader header = header_of(6, samples, compression);
      const ScratchFolder folder;
      write_in_blocks(folder / "s.h5", header);
      REQUIRE((read_file(folder / "s.h5") == store_bytes(header)));
      CHECK(verify_store(folder / "s.h5").problems.empty());
    }
}

TEST_CASE("blocks: the journal holds what encode_row makes") {
  const StoreHeader header = header_of(6, 200003, Compression::standard);
  const std::uint64_t row = ok_row(header);
  const Row made = make_row(header, row);
  const ScratchFolder folder;
  RunDirectory run(folder / "s.h5", header);
  run.end_item(in_blocks(header, row, made));
  const std::vector<std::byte> whole = encode_row(header, row, made).bytes;
  const std::string journal = read_file(folder / "s.h5.run/journal/rows-000000.wal");
  REQUIRE(journal.size() == whole.size());
  CHECK(std::memcmp(journal.data(), whole.data(), whole.size()) == 0);
}

TEST_CASE("blocks: a row whose blocks fail changes nothing and can be ended with another status") {
  const StoreHeader header = header_of(6, 200003, Compression::none);
  const std::uint64_t row = ok_row(header);
  const Row made = make_row(header, row);
  const ScratchFolder folder;
  const fs::path wal = folder / "s.h5.run/journal/rows-000000.wal";
  RunDirectory run(folder / "s.h5", header);
  run.end_item(encode_row(header, 5, make_row(header, 5)));
  const auto size = fs::file_size(wal);
  EncodedRow encoded = in_blocks(header, row, made);
  encoded.blocks = [&](std::uint64_t begin, std::uint64_t end) {
    if (end == header.samples) throw ItemError(Status::timeout, "took too long");
    return slice(made.samples, begin, end);
  };
  CHECK_THROWS_AS(run.end_item(encoded), ItemError);
  CHECK(fs::file_size(wal) == size);
  CHECK_FALSE(run.done(row));
  // Blocks of other lengths are a bug of the caller.
  encoded.blocks = [&](std::uint64_t begin, std::uint64_t end) {
    return slice(made.samples, begin, end - (end == header.samples ? 1 : 0));
  };
  CHECK_THROWS_AS(run.end_item(encoded), ItemError);
  CHECK(fs::file_size(wal) == size);
  Row failed;
  failed.report.status = Status::timeout;
  failed.report.reason = "took too long";
  run.end_item(encode_row(header, row, failed));
  CHECK(run.status(row) == Status::timeout);
}

TEST_CASE("blocks: a journal that ends within a row, or before its head, loses that row alone") {
  const StoreHeader header = header_of(6, 140000, Compression::none);
  const std::uint64_t row = ok_row(header), other = row + 1;
  const Row made = make_row(header, row);
  const ScratchFolder folder;
  const fs::path wal = folder / "s.h5.run/journal/rows-000000.wal";
  std::uintmax_t before = 0;
  {
    RunDirectory run(folder / "s.h5", header);
    run.end_item(encode_row(header, other, make_row(header, other)));
    before = fs::file_size(wal);
  }
  const std::string first = read_file(wal);
  const std::vector<std::byte> encoded = encode_row(header, row, made).bytes;
  const std::string record(reinterpret_cast<const char*>(encoded.data()), encoded.size());
  std::string headless = record;
  std::fill_n(headless.begin(), 200, '\0');
  for (const std::string& torn : {record.substr(0, record.size() - 1), headless, std::string(400, '\0')}) {
    write_file(wal, first + torn);
    const RunDirectory run(folder / "s.h5", header);
    CHECK(run.done(other));
    CHECK_FALSE(run.done(row));
    CHECK(fs::file_size(wal) == before);
  }
}

TEST_CASE("blocks: rows with descriptors, in chunks of several rows, or not ok have no blocks") {
  const Row made = make_row(header_of(6, 2000, Compression::none), 0);
  CHECK_THROWS_AS(encode_row_in_blocks(make_header(6, 2000), 0, made.report, {}), ItemError);
  CHECK_THROWS_AS(encode_row_in_blocks(header_of(600, 100, Compression::none), 0, made.report, {}),
                  ItemError);
  ItemReport failed;
  failed.status = Status::timeout;
  CHECK_THROWS_AS(encode_row_in_blocks(header_of(6, 2000, Compression::none), 0, failed, {}), ItemError);
}
