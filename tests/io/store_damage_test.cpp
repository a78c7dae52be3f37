// Damaged bytes of finished stores are refused before HDF5 sees them, those of journals before a store is
// made.
#include <fcntl.h>

#include <fstream>
#include <random>

#include "io/store/crc32c.h"
#include "io/store/file_checksum.h"
#include "store_support.h"
#include "support/catch.h"
#include "support/sanitized.h"

using namespace meander;
using namespace meander::test;
namespace fs = std::filesystem;

namespace {

// What opening the store throws; empty when it opens.
std::string refusal(const fs::path& store, StoreCheck check = StoreCheck::every_byte) {
  try {
    const StoreReader reader(store, check);
    return {};
  } catch (const RunError& error) {
    CHECK(error.kind() == RunError::Kind::unusable);
    return error.what();
  }
}

// Changes single bytes of a file in place.
class BytePutter {
 public:
  explicit BytePutter(const fs::path& path) : file_(path, std::ios::in | std::ios::out | std::ios::binary) {}
  void put(std::size_t at, char byte) {
    file_.seekp(static_cast<std::streamoff>(at));
    file_.put(byte);
    file_.flush();
  }

 private:
  std::fstream file_;
};

std::vector<std::byte> random_bytes(std::size_t count) {
  std::vector<std::byte> bytes(count);
  std::mt19937_64 random(count);
  for (std::size_t i = 0; i + 8 <= count; i += 8) {
    const std::uint64_t word = random();
    std::memcpy(bytes.data() + i, &word, sizeof word);
  }
  return bytes;
}

}  // namespace

TEST_CASE("crc32c: checksums of parts combine to that of the whole") {
  const std::vector<std::byte> bytes = random_bytes(100000);
  const std::span<const std::byte> whole(bytes);
  for (const std::size_t cut : {0, 1, 7, 4096, 65536, 99999, 100000})
    CHECK(crc32c_joined(crc32c(whole.first(cut)), crc32c(whole.subspan(cut)), whole.size() - cut) ==
          crc32c(whole));
  // Over lengths that no buffer has: joining is associative.
  constexpr std::uint64_t tebi = std::uint64_t{1} << 40;
  CHECK(crc32c_joined(crc32c_joined(1, 2, tebi), 3, 5 * tebi + 1) ==
        crc32c_joined(1, crc32c_joined(2, 3, 5 * tebi + 1), 6 * tebi + 1));
}

TEST_CASE("file checksum: does not depend on the number of threads, also at block boundaries") {
  constexpr std::size_t block = std::size_t{4} << 20;
  const ScratchFolder folder;
  const fs::path path = folder / "bytes";
  const std::vector<std::byte> bytes = random_bytes(3 * block + 5);
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{511}, block, block + 1, 2 * block + 3, bytes.size()}) {
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(size));
    const FileDescriptor file = open_file(path, O_RDONLY);
    for (const std::size_t begin : {0, 512}) {
      const std::size_t skipped = std::min(begin, size);
      const std::uint32_t expected =
          crc32c(std::span<const std::byte>(bytes).subspan(skipped, size - skipped));
      for (const std::size_t threads : {1, 2, 3, 16})
        CHECK(store::checksum_of_file(file, begin, path, threads) == expected);
      CHECK(store::checksum_of_file(file, begin, path) == expected);
    }
  }
}

TEST_CASE("reader: every single flipped bit of a small store is refused") {
  const ScratchFolder folder;
  const fs::path store = folder / "s.h5";
  write_store(store, make_header(3, 2));
  const std::string good = read_file(store);
  REQUIRE(refusal(store).empty());
  BytePutter file(store);
  std::mt19937 random(2);
  const std::size_t step = sanitized ? 17 : 1;  // release builds try every byte
  for (std::size_t i = 0; i < good.size(); i += step) {
    file.put(i, static_cast<char>(good[i] ^ (1 << (random() % 8))));
    const std::string message = refusal(store);
    if (message.find(store.string()) == std::string::npos || message.find("--trust") == std::string::npos)
      FAIL("a flipped bit in byte " << i << ": " << message);
    file.put(i, good[i]);
  }
  CHECK(refusal(store).empty());
}

TEST_CASE("reader: truncated stores and other files are refused, unchecked what is left is read") {
  const ScratchFolder folder;
  const fs::path store = folder / "s.h5";
  write_store(store, make_header(3, 2));
  const std::string good = read_file(store);
  write_file(store, good.substr(0, good.size() - 1));
  CHECK_THAT(refusal(store),
             Catch::Matchers::ContainsSubstring("is not a whole store: its first block says"));
  for (const std::string other : {"", "solid a mesh", "meander store\n"}) {
    write_file(store, other);
    CHECK_THAT(refusal(store), Catch::Matchers::ContainsSubstring("does not begin as a store does"));
  }
  // The text of the first block is wrong, everything that HDF5 reads is right.
  write_file(store, good);
  BytePutter(store).put(20, static_cast<char>(good[20] ^ 1));
  CHECK_FALSE(refusal(store).empty());
  CHECK(refusal(store, StoreCheck::none).empty());
}

TEST_CASE("run: any journal bit that flips before the store is written is detected") {
  // Chunks of several rows, of one row, and several of a row.
  for (const auto& [samples, longest_step] : {std::pair{1u, 1}, {1400u, 2000}, {90000u, 80000}}) {
    const StoreHeader header = make_header(3, samples);
    const ScratchFolder folder;
    const fs::path store = folder / "s.h5", journal = folder / "s.h5.run/journal/rows-000000.wal";
    RunDirectory run(store, header);
    for (std::uint64_t row = 0; row < header.ids.size(); ++row) run.end_item(make_encoded(header, row));
    const std::string good = read_file(journal);
    BytePutter file(journal);
    std::mt19937 random(3);
    // Release builds try more of the bytes, of the shortest journal all.
    const unsigned most = static_cast<unsigned>(longest_step) * (sanitized ? 3 : 1);
    for (std::size_t i = 0; i < good.size(); i += 1 + random() % most) {
      file.put(i, static_cast<char>(good[i] ^ (1 << (random() % 8))));
      std::string message;
      try {
        run.finish();
      } catch (const RunError& error) {
        CHECK(error.kind() == RunError::Kind::stopped);
        message = error.what();
      }
      INFO(samples << " samples, byte " << i);
      REQUIRE_THAT(message, Catch::Matchers::ContainsSubstring("rows-000000.wal has changed since row"));
      REQUIRE_FALSE(fs::exists(store));
      file.put(i, good[i]);
    }
    run.finish();
    CHECK(verify_store(store).problems.empty());
  }
}
