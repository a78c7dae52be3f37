// Runs that must not start or continue, and their messages.

#include "io/store/crc32c.h"
#include "io/store/run_folder.h"
#include "io/store/run_plan.h"
#include "store_support.h"
#include "support/catch.h"

using namespace meander;
using namespace meander::test;
namespace fs = std::filesystem;

namespace {

// The plan of a run of these rows, without its checksum.
std::string begun_plan(const fs::path& store, const StoreHeader& header) {
  { const RunDirectory run(store, header); }
  std::string plan = read_file(store::with_suffix(store, ".run") / "plan.bin");
  plan.resize(plan.size() - sizeof(std::uint32_t));
  return plan;
}

void write_plan_text(const fs::path& store, std::string plan) {
  const std::uint32_t checksum = crc32c(std::span<const char>(plan));
  plan.append(reinterpret_cast<const char*>(&checksum), sizeof checksum);
  write_file(store::with_suffix(store, ".run") / "plan.bin", plan);
}

}  // namespace

TEST_CASE("run: other parameters and other items are refused by name") {
  const StoreHeader header = make_header(20, 4);
  const ScratchFolder folder;
  {
    RunDirectory run(folder / "s.h5", header);
    run.end_item(make_encoded(header, 3));
  }
  const auto message = [&](const std::function<void(StoreHeader&)>& change) {
    StoreHeader other = header;
    change(other);
    const auto [text, kind] = refusal(folder / "s.h5", other);
    CHECK(kind == 0);
    return text;
  };
  using Catch::Matchers::ContainsSubstring;
  CHECK_THAT(message([](StoreHeader& h) { h.samples = 5; }),
             ContainsSubstring("number of samples was 4, now it is 5"));
  CHECK_THAT(message([](StoreHeader& h) { h.seed = 8; }), ContainsSubstring("seed was 7, now it is 8"));
  CHECK_THAT(message([](StoreHeader& h) { h.order = "curve"; }),
             ContainsSubstring("order was progressive, now it is curve"));
  CHECK_THAT(message([](StoreHeader& h) { h.compression = Compression::none; }),
             ContainsSubstring("compression was default"));
  CHECK_THAT(message([](StoreHeader& h) {
               h.parameters_json = R"({"density":"mean","describe":["d2"],"method":"conformal"})";
             }),
             ContainsSubstring(R"(parameter "density" was "uniform", now it is "mean")"));
  CHECK_THAT(message([](StoreHeader& h) {
               h.parameters_json = R"({"density":"uniform","describe":["d2","a,:}3"],"method":"conformal"})";
             }),
             ContainsSubstring(R"(parameter "describe" was ["d2"], now it is ["d2","a,:}3"])"));
  CHECK_THAT(
      message([](StoreHeader& h) { h.parameters_json = R"({"density":"uniform","describe":["d2"]})"; }),
      ContainsSubstring(R"(parameter "method" was "conformal" and is not given now)"));
  CHECK_THAT(message([](StoreHeader& h) {
               h.parameters_json =
                   R"({"a":{"b":[1,{"c":2}]},"density":"uniform","describe":["d2"],"method":"conformal"})";
             }),
             ContainsSubstring(R"(parameter "a" was not given, now it is {"b":[1,{"c":2}]})"));
  CHECK_THAT(message([](StoreHeader& h) { h.descriptors.pop_back(); }),
             ContainsSubstring("were d2(64), a3(5), now they are d2(64)"));
  CHECK_THAT(message([](StoreHeader& h) { h.descriptors[1].attributes[0].second = "other"; }),
             ContainsSubstring("bins of descriptor a3"));
  CHECK_THAT(message([](StoreHeader& h) { h.labels[2] = 99; }),
             ContainsSubstring("label of \"class/m0000002.off\""));
  CHECK_THAT(message([](StoreHeader& h) { h.splits[2] = Split::none; }),
             ContainsSubstring("split of \"class/m0000002.off\" was test, now it is none"));
  CHECK_THAT(message([](StoreHeader& h) { h.label_names.pop_back(); }),
             ContainsSubstring("names of the classes"));
  CHECK_THAT(message([](StoreHeader& h) {
               h.ids.erase(h.ids.begin() + 4, h.ids.begin() + 6);
               h.labels.resize(h.ids.size());
               h.splits.resize(h.ids.size());
             }),
             ContainsSubstring("2 gone (the first is \"class/m0000004.off\")"));
  CHECK_THAT(message([](StoreHeader& h) {
               h.ids.front() = "a.off";
               h.ids.push_back("zebra.off");
               h.labels.push_back(0);
               h.splits.push_back(Split::none);
             }),
             ContainsSubstring(
                 "1 gone (the first is \"class/m0000000-long-name.off\"), 2 new (the first is \"a.off\")"));
  CHECK(refusal(folder / "s.h5", header).second == 2);
}

TEST_CASE("run: a plan damaged at any byte is refused") {
  const StoreHeader header = make_header(2, 4);
  const ScratchFolder folder;
  { const RunDirectory run(folder / "s.h5", header); }
  const fs::path plan = folder / "s.h5.run/plan.bin";
  const std::string bytes = read_file(plan);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << (i % 8)));
    write_file(plan, damaged);
    CHECK(refusal(folder / "s.h5", header).second == 0);
    write_file(plan, bytes.substr(0, i));
    CHECK(refusal(folder / "s.h5", header).second == 0);
  }
}

TEST_CASE("run: a run begun by another version is refused with a message, its plan as a shard's is read") {
  const StoreHeader header = make_header(2, 4);
  const ScratchFolder folder;
  std::string plan = begun_plan(folder / "s.h5", header);
  REQUIRE(plan.starts_with("meander plan 6\n"));
  for (const char version : {'4', '5'}) {
    plan[std::string_view("meander plan ").size()] = version;
    write_plan_text(folder / "s.h5", plan);
    const std::string message = refusal(folder / "s.h5", header).first;
    CHECK_THAT(message, Catch::Matchers::ContainsSubstring("was begun by another version of the program") &&
                            Catch::Matchers::ContainsSubstring("--fresh"));
    if (version == '5')
      CHECK(store::read_plan_of_shard(folder / "s.h5.run").header.ids == header.ids);
    else
      CHECK_THROWS_AS(store::read_plan_of_shard(folder / "s.h5.run"), RunError);
  }
}

TEST_CASE("run: a plan with a valid checksum and wrong counts is refused") {
  const StoreHeader header = make_header(2, 4);
  const ScratchFolder folder;
  const std::string plan = begun_plan(folder / "s.h5", header);
  const auto outcome = [&](const std::string& text) -> std::string {
    write_plan_text(folder / "s.h5", text);
    try {
      return read_run_plan(folder / "s.h5") ? "read" : "none";
    } catch (const RunError& error) {
      return error.kind() == RunError::Kind::unusable ? "refused" : "stopped";
    }
  };
  REQUIRE(outcome(plan) == "read");
  CHECK(outcome(plan + std::string(8, '\0')) == "refused");
  const std::size_t magic = plan.find('\n') + 1;
  std::size_t refused = 0;
  // Every number of the plan is overwritten, counts of lists and lengths of texts among them.
  for (std::size_t at = magic; at + 8 <= plan.size(); ++at)
    for (const std::uint64_t value : {~std::uint64_t{0}, std::uint64_t{1} << 40, std::uint64_t{200}}) {
      std::string wrong = plan;
      std::memcpy(wrong.data() + at, &value, sizeof value);
      const std::string result = outcome(wrong);
      REQUIRE((result == "refused" || result == "read"));
      refused += result == "refused" ? 1 : 0;
    }
  CHECK(refused > plan.size());
  // The last number is the split of the last item: there are four.
  for (const std::uint64_t value : {0, 1, 2, 3, 4, 255}) {
    std::string other = plan;
    std::memcpy(other.data() + other.size() - sizeof value, &value, sizeof value);
    CHECK(outcome(other) == (value < split_names.size() ? "read" : "refused"));
  }
}

TEST_CASE("run: a missing folder is an error") {
  const ScratchFolder folder;
  const auto [message, kind] = refusal(folder / "nowhere/s.h5", make_header(2, 4));
  CHECK(kind == 0);
  CHECK_THAT(message, Catch::Matchers::ContainsSubstring("No such file or directory"));
}

TEST_CASE("run: contradictory headers and rows are internal errors") {
  const ScratchFolder folder;
  StoreHeader header = make_header(4, 2);
  std::swap(header.ids[1], header.ids[2]);
  CHECK_THROWS_AS(RunDirectory(folder / "s.h5", header), ItemError);
  header = make_header(4, 2);
  header.ids[1] = header.ids[0];
  CHECK_THROWS_AS(RunDirectory(folder / "s.h5", header), ItemError);
  header = make_header(4, 2);
  header.labels.pop_back();
  CHECK_THROWS_AS(RunDirectory(folder / "s.h5", header), ItemError);
  header = make_header(4, 0);
  CHECK_THROWS_AS(RunDirectory(folder / "s.h5", header), ItemError);
  header = make_header(4, 2);
  RunDirectory run(folder / "s.h5", header);
  CHECK_THROWS_AS(run.begin_item(4), ItemError);
  CHECK_THROWS_AS(run.done(4), ItemError);
  CHECK_THROWS_AS(run.status(0), ItemError);
  CHECK_THROWS_AS(run.finish(), ItemError);
  EncodedRow encoded = make_encoded(header, 1);
  encoded.row = 2;
  CHECK_THROWS_AS(run.end_item(encoded), ItemError);
}

TEST_CASE("run: dangling links are refused at once") {
  const ScratchFolder folder;
  const StoreHeader header = make_header(5, 2);
  fs::create_symlink(folder / "nowhere", folder / "s.h5.run");
  const auto [message, kind] = refusal(folder / "s.h5", header);
  CHECK(kind == 0);
  CHECK_THAT(message, Catch::Matchers::ContainsSubstring("s.h5.run") &&
                          Catch::Matchers::ContainsSubstring("No such file"));
  fs::create_directory(folder / "t.h5.run");
  fs::create_symlink(folder / "none/nowhere", folder / "t.h5.run/lock");
  CHECK_THAT(refusal(folder / "t.h5", header).first, Catch::Matchers::ContainsSubstring("t.h5.run/lock"));
}
