// Checksums, chunk filters, row records, the schema table.
#include <hdf5.h>

#include "io/store/chunk_codec.h"
#include "io/store/crc32c.h"
#include "io/store/row_codec.h"
#include "io/store/schema.h"
#include "store_support.h"
#include "support/catch.h"

using namespace meander;
using namespace meander::test;

namespace {

std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

std::uint32_t slow_crc32c(std::span<const std::byte> bytes) {
  std::uint32_t crc = 0xFFFFFFFFu;
  for (const std::byte byte : bytes) {
    crc ^= std::to_integer<std::uint32_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = crc & 1u ? crc >> 1 ^ 0x82F63B78u : crc >> 1;
  }
  return ~crc;
}

// The definition: sums modulo 65535 word by word, where a sum that is not zero never becomes zero.
std::uint32_t slow_fletcher32(std::span<const std::byte> bytes) {
  std::uint32_t sum1 = 0, sum2 = 0;
  for (std::size_t i = 0; i < bytes.size(); i += 2) {
    std::uint32_t word = std::to_integer<std::uint32_t>(bytes[i]) << 8;
    if (i + 1 < bytes.size()) word |= std::to_integer<std::uint32_t>(bytes[i + 1]);
    sum1 += word;
    sum1 = (sum1 & 0xFFFF) + (sum1 >> 16);
    sum2 += sum1;
    sum2 = (sum2 & 0xFFFF) + (sum2 >> 16);
  }
  return sum2 << 16 | sum1;
}

std::vector<std::byte> random_bytes(std::size_t count, std::uint64_t seed, unsigned range = 256) {
  std::mt19937_64 random(seed);
  std::vector<std::byte> bytes(count);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random() % range);
  return bytes;
}

// A dataset of one chunk with our filters, for the library to fill or to read.
class OneChunk {
 public:
  OneChunk(hid_t type, hsize_t elements, Compression compression) : type_(type) {
    file_ = H5Fcreate((folder_ / "one.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t space = H5Screate_simple(1, &elements, nullptr);
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_chunk(creation, 1, &elements);
    if (compression == Compression::standard) {
      H5Pset_shuffle(creation);
      H5Pset_deflate(creation, 1);
    }
    H5Pset_fletcher32(creation);
    dataset_ = H5Dcreate2(file_, "x", type, space, H5P_DEFAULT, creation, H5P_DEFAULT);
    H5Pclose(creation);
    H5Sclose(space);
  }
  ~OneChunk() {
    H5Dclose(dataset_);
    H5Fclose(file_);
  }
  // The chunk as the library filters it.
  std::vector<std::byte> filter(std::span<const std::byte> values) {
    H5Dwrite(dataset_, type_, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Dflush(dataset_);
    const hsize_t offset = 0;
    hsize_t bytes = 0;
    H5Dget_chunk_storage_size(dataset_, &offset, &bytes);
    std::vector<std::byte> chunk(bytes);
    std::uint32_t mask = 0;
    H5Dread_chunk(dataset_, H5P_DEFAULT, &offset, &mask, chunk.data());
    return chunk;
  }
  // The values that the library finds in a filtered chunk.
  std::vector<std::byte> unfilter(std::span<const std::byte> chunk, std::size_t bytes) {
    const hsize_t offset = 0;
    std::vector<std::byte> values(bytes);
    H5Dwrite_chunk(dataset_, H5P_DEFAULT, 0, &offset, chunk.size(), chunk.data());
    if (H5Dread(dataset_, type_, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0) values.clear();
    return values;
  }

 private:
  ScratchFolder folder_;
  hid_t type_, file_, dataset_;
};

}  // namespace

TEST_CASE("crc32c: matches published test vectors") {
  CHECK(crc32c(bytes_of("123456789")) == 0xE3069283u);
  CHECK(crc32c(bytes_of("")) == 0u);
  CHECK(crc32c(std::span<const std::byte>(std::vector<std::byte>(32, std::byte{0}))) ==
        0x8A9136AAu);  // RFC 3720
  CHECK(crc32c(std::span<const std::byte>(std::vector<std::byte>(32, std::byte{0xFF}))) == 0x62A8AB43u);
}

TEST_CASE("crc32c: every length matches the bit-by-bit form, whole or in two parts") {
  const std::vector<std::byte> bytes = random_bytes(10000, 1);
  const std::span<const std::byte> all(bytes);
  for (std::size_t length = 0; length < bytes.size(); length += length < 40 ? 1 : 617) {
    const auto part = all.subspan(length % 7 > length ? 0 : length % 7, length - length % 7 % (length + 1));
    CHECK(crc32c(part) == slow_crc32c(part));
    CHECK(crc32c(part.subspan(part.size() / 3), crc32c(part.first(part.size() / 3))) == crc32c(part));
  }
}

TEST_CASE("fletcher32: matches the definition for every length and for extreme bytes") {
  for (std::size_t length = 0; length < 70000; length += length < 20 ? 1 : 4099) {
    const auto bytes = random_bytes(length, length);
    CHECK(store::fletcher32(bytes) == slow_fletcher32(bytes));
    const std::vector<std::byte> ones(length, std::byte{0xFF});
    CHECK(store::fletcher32(ones) == slow_fletcher32(ones));
    CHECK(store::fletcher32(std::vector<std::byte>(length)) == 0);
  }
}

TEST_CASE("chunk codec: HDF5 reads our chunks, we read the chunks of HDF5") {
  const hid_t text = H5Tcopy(H5T_C_S1);
  H5Tset_size(text, 37);
  for (const Compression compression : {Compression::standard, Compression::none})
    for (const auto& [type, size] : std::vector<std::pair<hid_t, std::size_t>>{
             {H5T_IEEE_F32LE, 4}, {H5T_IEEE_F64LE, 8}, {H5T_STD_U8LE, 1}, {text, 37}})
      for (const unsigned range : {256u, 140u, 3u, 1u})
        for (const std::size_t elements : {std::size_t{1}, std::size_t{2113}, std::size_t{70000}}) {
          auto values = random_bytes(elements * size, size + range, range);
          // A third of the elements zero: planes that are neither random nor regular.
          for (std::size_t i = 0; i < values.size(); ++i)
            if (range == 140 && i / size % 3 == 0) values[i] = std::byte{};
          std::vector<std::byte> ours, back(values.size());
          store::append_filtered(values, size, compression, ours);
          CHECK((OneChunk(type, elements, compression).unfilter(ours, values.size()) == values));
          const std::vector<std::byte> theirs = OneChunk(type, elements, compression).filter(values);
          CHECK(store::unfilter(theirs, size, compression, back));
          CHECK((back == values));
          if (compression == Compression::none)
            CHECK((ours == theirs));
          else
            CHECK(ours.size() <= theirs.size() + theirs.size() / 50 + 64);
        }
  H5Tclose(text);
}

TEST_CASE("chunk codec: unfiltering gives the chunk back and refuses every damage") {
  for (const Compression compression : {Compression::standard, Compression::none})
    for (const std::size_t size : {std::size_t{1}, std::size_t{4}, std::size_t{37}}) {
      const auto values = random_bytes(61 * size, size, 7);
      std::vector<std::byte> filtered, back(values.size());
      store::append_filtered(values, size, compression, filtered);
      REQUIRE(store::unfilter(filtered, size, compression, back));
      CHECK(back == values);
      for (std::size_t i = 0; i < filtered.size(); ++i) {
        auto damaged = filtered;
        damaged[i] ^= static_cast<std::byte>(1u << (i % 8));
        CHECK_FALSE(store::unfilter(damaged, size, compression, back));
      }
      for (std::size_t length = 0; length < filtered.size(); ++length)
        CHECK_FALSE(
            store::unfilter(std::span<const std::byte>(filtered).first(length), size, compression, back));
    }
}

TEST_CASE("chunk shapes: at least 16 KiB, a power of two up to 256 rows, long rows cut evenly") {
  using store::ChunkShape;
  CHECK(store::sample_chunk(1000, 2048) == ChunkShape{1, 2048, 1});
  CHECK(store::sample_chunk(1000, 1366) == ChunkShape{1, 1366, 1});
  CHECK(store::sample_chunk(1000, 1365) == ChunkShape{2, 1365, 1});
  CHECK(store::sample_chunk(1000, 256) == ChunkShape{8, 256, 1});
  CHECK(store::sample_chunk(5, 256) == ChunkShape{5, 256, 1});
  CHECK(store::sample_chunk(1000, 1) == ChunkShape{256, 1, 1});
  CHECK(store::sample_chunk(1000, 87381) == ChunkShape{1, 87381, 1});
  CHECK(store::sample_chunk(1000, 87382) == ChunkShape{1, 43691, 2});
  CHECK(store::sample_chunk(1000, 100000) == ChunkShape{1, 50000, 2});
  CHECK(store::sample_chunk(1000, 1000000) == ChunkShape{1, 62500, 16});
  CHECK(store::descriptor_chunk(1000, 64) == ChunkShape{256, 0, 1});
  CHECK(store::descriptor_chunk(1000, 4096) == ChunkShape{64, 0, 1});
  CHECK(store::descriptor_chunk(3, 64) == ChunkShape{3, 0, 1});
}

TEST_CASE("row codec: decoding gives the row back") {
  for (const std::uint32_t samples : {1u, 7u, 256u, 2048u, 100000u})
    for (const Compression compression : {Compression::standard, Compression::none}) {
      const StoreHeader header = make_header(300, samples, compression);
      for (const std::uint64_t row : {0, 1, 2, 3, 299}) {
        const Row made = make_row(header, row);
        const Row back = decode_row(header, encode_row(header, row, made));
        CHECK(same(made, back));
        CHECK(back.report.points_crc32c ==
              (made.samples.count() > 0 ? crc32c(std::span<const float>(made.samples.points)) : 0));
      }
    }
}

TEST_CASE("row codec: arrays of the wrong size are internal errors") {
  const StoreHeader header = make_header(10, 16);
  std::uint64_t number = 0;
  while (make_row(header, number).report.status != Status::ok) ++number;
  const Row good = make_row(header, number);
  const auto refused = [&](const std::function<void(Row&)>& change) {
    Row row = good;
    change(row);
    try {
      encode_row(header, number, row);
    } catch (const ItemError& error) {
      return error.status() == Status::internal;
    }
    return false;
  };
  CHECK(refused([](Row& row) { row.samples.points.pop_back(); }));
  CHECK(refused([](Row& row) { row.samples.curve_rank.push_back(0); }));
  CHECK(refused([](Row& row) { row.report.status = Status::timeout; }));
  CHECK(refused([](Row& row) { row.descriptors.pop_back(); }));
  CHECK(refused([](Row& row) { row.descriptors[0].values.pop_back(); }));
  CHECK(refused([](Row& row) { row.descriptors[0].name = "other"; }));
  CHECK(refused([](Row& row) { row.descriptors[1] = row.descriptors[0]; }));
  CHECK_THROWS_AS(encode_row(header, 10, good), ItemError);
  Row swapped = good;
  std::swap(swapped.descriptors[0], swapped.descriptors[1]);
  CHECK(encode_row(header, number, swapped).bytes == encode_row(header, number, good).bytes);
}

TEST_CASE("row codec: one changed bit of an encoded row is detected") {
  const StoreHeader header = make_header(10, 4);
  const EncodedRow good = make_encoded(header, 1);
  for (std::size_t i = 0; i < good.bytes.size(); ++i) {
    EncodedRow damaged = good;
    damaged.bytes[i] ^= static_cast<std::byte>(1u << (i * 5 % 8));
    CHECK_THROWS_AS(decode_row(header, damaged), ItemError);
  }
}

TEST_CASE("reasons: one line of valid UTF-8 of bounded length") {
  CHECK(store::clean_line("face 3: index 9", store::longest_reason) == "face 3: index 9");
  CHECK(store::clean_line(std::string("a\nb\tc\0d\x7F", 8), store::longest_reason) == "a b c d ");
  CHECK(store::clean_line("\xC3\xA9 \xFF\xC3", store::longest_reason) == "\xC3\xA9 ??");
  CHECK(store::clean_line("\xED\xA0\x80", store::longest_reason) == "???");
  std::string lengthy;
  while (lengthy.size() < 2000) lengthy += "\xE2\x82\xAC";
  const std::string clean = store::clean_line(lengthy, store::longest_reason);
  CHECK(clean.size() <= store::longest_reason);
  CHECK(clean.size() > store::longest_reason - 3);
  CHECK(lengthy.starts_with(clean));
  CHECK(clean.size() % 3 == 0);
}

TEST_CASE("schema: the table in docs/STORE.md matches the code") {
  const std::string page = read_file(std::filesystem::path(MEANDER_SOURCE_DIR) / "docs" / "STORE.md");
  const std::string table = store::layout_markdown();
  INFO("the table of the code is\n" << table);
  CHECK(page.find(table) != std::string::npos);
}
