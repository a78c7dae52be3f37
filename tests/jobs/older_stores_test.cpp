// Stores and unfinished runs that older programs left (tests/fixtures): this program goes on with them.
#include <fmt/format.h>
#include <hdf5.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/digest.h"
#include "io/store/crc32c.h"
#include "io/store/store_file.h"
#include "io/store/store_reader.h"
#include "io/store/store_verify.h"
#include "support/catch.h"
#include "support/meander_program.h"
#include "support/scratch_files.h"

using namespace meander;
using namespace meander::test;

namespace fs = std::filesystem;

namespace {

const fs::path fixtures = fs::path(MEANDER_SOURCE_DIR) / "tests/fixtures";

// The method version of what a program of format 5 left is made this program's: what its parameters select
// has had the same points since, and a run of another method version is not gone on with, as a case below
// shows.
void adopt_store(const fs::path& store) {
  const hid_t file = H5Fopen(store.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  REQUIRE(file >= 0);
  const hid_t attribute = H5Aopen(file, "method_version", H5P_DEFAULT);
  const std::uint32_t version = store_method_version;
  CHECK(H5Awrite(attribute, H5T_NATIVE_UINT32, &version) >= 0);
  H5Aclose(attribute);
  H5Fclose(file);
  std::string bytes = read_file(store);
  const std::uint32_t checksum = crc32c(std::span<const char>(bytes).subspan(store::user_block_bytes));
  bytes.replace(0, store::user_block_bytes, store::user_block_text(bytes.size(), checksum));
  write_file(store, bytes);
}
void adopt_run(const fs::path& folder) {
  // A plan is a line, numbers of eight bytes (format version, method version), more, and a checksum.
  std::string plan = read_file(folder / "plan.bin"), json = read_file(folder / "run.json");
  const std::size_t end = plan.size() - sizeof(std::uint32_t), at = plan.find('\n') + 1 + 8;
  const auto digest = [&] { return hex_text(sha256(std::as_bytes(std::span(plan)))); };
  const auto replace = [&](const std::string& from, const std::string& to) {
    const std::size_t place = json.find(from);
    REQUIRE(place != std::string::npos);
    json.replace(place, from.size(), to);
  };
  const std::string before = digest();
  replace(fmt::format("\"method_version\":{},", static_cast<unsigned>(plan.at(at))),
          fmt::format("\"method_version\":{},", store_method_version));
  plan[at] = static_cast<char>(store_method_version);
  const std::uint32_t checksum = crc32c(std::span<const char>(plan).first(end));
  std::memcpy(&plan[end], &checksum, sizeof checksum);
  replace(before, digest());
  write_file(folder / "plan.bin", plan);
  write_file(folder / "run.json", json);
}

// A folder as the older program left it: the models, and of `name` the store and the unfinished run.
struct OlderFolder {
  ScratchFolder scratch;

  explicit OlderFolder(const std::string& format) : from_(fixtures / format) {
    fs::copy(from_ / "models", scratch / "models", fs::copy_options::recursive);
    // A checkout is younger than the stores in it.
    const auto before = fs::file_time_type::clock::now() - std::chrono::hours(24 * 365);
    for (const auto& entry : fs::recursive_directory_iterator(scratch / "models"))
      if (entry.is_regular_file()) fs::last_write_time(entry.path(), before);
  }
  void bring_store(const std::string& name) const {
    fs::copy_file(from_ / (name + ".h5"), scratch / (name + ".h5"));
    adopt_store(scratch / (name + ".h5"));
  }
  void bring_run(const std::string& name) const {
    fs::copy(from_ / (name + ".unfinished"), scratch / (name + ".h5.run"), fs::copy_options::recursive);
    adopt_run(scratch / (name + ".h5.run"));
  }
  ProcessResult command(std::vector<std::string> arguments) const {
    ProcessOptions options;
    options.in_child = [folder = scratch.path().string()] {
      if (::chdir(folder.c_str()) != 0) ::_exit(127);
    };
    return meander_with(std::move(arguments), options);
  }
  ProcessResult run(const std::string& store, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {
        "run",       "models", "-n", "32",         "--colors", "--attribute", "quality",    "--describe",
        "d2,basics", "--bins", "8",  "--progress", "none",     "-o",          store + ".h5"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    ProcessResult result = command(std::move(arguments));
    INFO(result.err);
    CHECK(result.exit_code == 3);  // empty.off
    return result;
  }
  std::string bytes(const std::string& store) const { return read_file(scratch / (store + ".h5")); }
  // The store of a new run over all models.
  std::string fresh_bytes() const {
    run("fresh");
    return bytes("fresh");
  }

 private:
  fs::path from_;
};

std::string all_output(const ProcessResult& result) { return result.out + result.err; }

}  // namespace

TEST_CASE("older stores: a stopped run of format 5 resumes to byte-identical output") {
  const OlderFolder folder("format5");
  folder.bring_run("begun");
  const ProcessResult result = folder.run("begun");
  CHECK(contains(all_output(result), "6 models in"));  // four rows were there
  CHECK(folder.bytes("begun") == folder.fresh_bytes());
}

TEST_CASE("older stores: a stopped update of format 5 resumes with its own --retry") {
  const OlderFolder folder("format5");
  folder.bring_store("update");
  folder.bring_run("update");
  const ProcessResult result = folder.run("update", {"--retry", "timeout,changed"});
  CHECK(contains(all_output(result), "5 models in"));
  CHECK(folder.bytes("update") == folder.fresh_bytes());
}

TEST_CASE("older stores: a stopped update of format 5 is finished by a command with another --retry") {
  const OlderFolder folder("format5");
  folder.bring_store("update");
  folder.bring_run("update");
  folder.run("update", {"--retry", "changed"});
  CHECK(folder.bytes("update") == folder.fresh_bytes());
}

TEST_CASE("older stores: a stopped description of format 5 resumes to byte-identical output") {
  const OlderFolder folder("format5");
  const std::vector<std::string> more = {"--descriptors", "a3,harmonics,d1,d3", "--bins", "64", "--progress",
                                         "none"};
  const auto describe = [&](const std::string& name) {
    std::vector<std::string> arguments = {"describe", name + ".h5"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProcessResult result = folder.command(std::move(arguments));
    INFO(result.err);
    CHECK(result.exit_code == 0);
  };
  folder.bring_store("describe");
  fs::copy_file(folder.scratch / "describe.h5", folder.scratch / "fresh.h5");
  folder.bring_run("describe");
  describe("describe");
  describe("fresh");
  CHECK(folder.bytes("describe") == folder.bytes("fresh"));
}

TEST_CASE("older stores: a store of format 5 is whole, and is extended to byte-identical output") {
  const OlderFolder folder("format5");
  folder.bring_store("describe");
  CHECK(verify_store(folder.scratch / "describe.h5").problems == std::vector<std::string>{});
  const ProcessResult result = folder.run("describe");
  CHECK(contains(all_output(result), "3 models in"));
  CHECK(folder.bytes("describe") == folder.fresh_bytes());
}

TEST_CASE("older stores: rows of a store of format 5 are reused") {
  const OlderFolder folder("format5");
  folder.bring_store("describe");
  folder.run("new", {"--reuse", "describe.h5"});
  CHECK(folder.bytes("new") == folder.fresh_bytes());
}

TEST_CASE("older stores: a run of an older method version is not gone on with, and the message names both") {
  const ScratchFolder scratch;
  fs::copy(fixtures / "format5/models", scratch / "models", fs::copy_options::recursive);
  fs::copy(fixtures / "format5/begun.unfinished", scratch / "begun.h5.run", fs::copy_options::recursive);
  ProcessOptions options;
  options.in_child = [folder = scratch.path().string()] {
    if (::chdir(folder.c_str()) != 0) ::_exit(127);
  };
  const ProcessResult result =
      meander_with({"run", "models", "-n", "32", "--colors", "--attribute", "quality", "--describe",
                    "d2,basics", "--bins", "8", "--progress", "none", "-o", "begun.h5"},
                   options);
  CHECK(result.exit_code == 2);
  CHECK(contains(result.err, fmt::format("the method version was 18, now it is {}", store_method_version)));
}

TEST_CASE("older stores: stores of formats 2 to 4 are whole, exported, and described further") {
  for (std::uint32_t format = 2; format <= 4; ++format) {
    const ScratchFolder scratch;
    const fs::path store = scratch / "s.h5";
    fs::copy_file(fixtures / "formats_2_to_4" / ("format" + std::to_string(format) + ".h5"), store);
    INFO("format " << format);
    CHECK(verify_store(store).problems == std::vector<std::string>{});
    const StoreReader before(store);
    CHECK(before.format_version() == format);
    REQUIRE(before.rows() == 4);
    const ProcessResult exported =
        meander_with({"export", store.string(), "--format", "npz", "-o", (scratch / "arrays").string()});
    INFO(exported.out << exported.err);
    CHECK(exported.exit_code == 0);

    const ProcessResult described = meander_with({"describe", store.string(), "--descriptors", "a3",
                                                  "--progress", "none", "-o", (scratch / "d.h5").string()});
    INFO(described.out << described.err);
    CHECK(described.exit_code == 0);
    CHECK(verify_store(scratch / "d.h5").problems == std::vector<std::string>{});
    const StoreReader after(scratch / "d.h5");
    CHECK(after.format_version() == store_format_version);
    for (std::uint64_t row = 0; row < 4; ++row) {
      CHECK(after.id(row) == before.id(row));
      CHECK(after.read_row(row).samples.points == before.read_row(row).samples.points);
      CHECK(after.read_row(row).samples.face == before.read_row(row).samples.face);
      CHECK(after.read_row(row).samples.rgb == before.read_row(row).samples.rgb);
    }
  }
}

TEST_CASE("older stores: samples of another method version are neither extended nor reused") {
  const OlderFolder folder("format5");
  fs::copy_file(fixtures / "formats_2_to_4/format4.h5", folder.scratch / "old.h5");
  const std::string before = folder.bytes("old");
  for (const std::vector<std::string>& target :
       {std::vector<std::string>{"-o", "old.h5"},
        std::vector<std::string>{"-o", "new.h5", "--reuse", "old.h5"}}) {
    std::vector<std::string> arguments = {"run",         "models",     "-n",         "16", "--colors",
                                          "--attribute", "quality",    "--describe", "d2", "--bins",
                                          "8",           "--progress", "none"};
    arguments.insert(arguments.end(), target.begin(), target.end());
    const ProcessResult result = folder.command(arguments);
    CHECK(result.exit_code == 2);
    CHECK(contains(result.err, "the method version was 15, now it is"));
  }
  CHECK(folder.bytes("old") == before);
  CHECK_FALSE(fs::exists(folder.scratch / "new.h5"));
}
