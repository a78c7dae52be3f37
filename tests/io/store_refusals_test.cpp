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

// The plan as the version before wrote it: what it is for by a phrase, columns by numbers.
std::string earlier_plan(const StoreHeader& header, std::string_view phrase, std::string_view root = "") {
  std::string plan = "meander plan 6\n";
  const auto number = [&](std::uint64_t value) {
    plan.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  const auto text = [&](std::string_view value) {
    number(value.size());
    plan += value;
  };
  const auto texts = [&](const std::vector<std::string>& values) {
    number(values.size());
    for (const std::string& value : values) text(value);
  };
  number(store_format_version);
  number(header.method_version);
  text(phrase);
  text(root);
  const StoreColumns& columns = *header.columns;
  number(static_cast<std::uint64_t>(columns.rows));
  number(columns.tensors);
  number(columns.asked[&Samples::rgb]);
  number(columns.asked[&Samples::texcoord]);
  std::uint64_t left_out = 0, bit = 1;
  for (const char* word :
       {"normals", "face", "corners", "barycentric", "uv", "curve_rank", "density", "tensor"}) {
    for (std::size_t c = 0; c < sample_columns.size(); ++c)
      if (columns.left_out[c] && sample_columns[c].recorded_word() == word) left_out |= bit;
    bit *= 2;
  }
  number(left_out);
  number(columns.attributes.size());
  for (const AttributeColumn& column : columns.attributes) {
    text(column.name);
    number(column.width);
    number(static_cast<std::uint64_t>(column.kind));
  }
  number(header.samples);
  number(static_cast<std::uint64_t>(header.compression));
  number(header.seed);
  text(header.order);
  text(header.parameters_json);
  texts(header.label_names);
  number(header.descriptors.size());
  for (const DescriptorSchema& descriptor : header.descriptors) {
    text(descriptor.group);
    text(descriptor.name);
    number(descriptor.width);
    number(descriptor.attributes.size());
    for (const auto& [name, value] : descriptor.attributes) {
      text(name);
      text(value);
    }
  }
  texts(header.ids);
  for (const std::int32_t label : header.labels) number(static_cast<std::uint32_t>(label));
  for (std::uint64_t row = 0; row < header.ids.size(); ++row)
    number(static_cast<std::uint64_t>(header.split(row)));
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
  REQUIRE(begun_plan(folder / "s.h5", header).starts_with("meander plan 7\n"));
  std::string plan = earlier_plan(header, "sample");
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

TEST_CASE("run: a run begun by the version before is continued, whatever its purpose") {
  StoreHeader header = make_header(2, 4);
  StoreColumns columns{.tensors = true, .asked = ColumnSet(&Samples::rgb, &Samples::texcoord)};
  columns.left_out = ColumnSet(&Samples::density, &Samples::tensor_direction, &Samples::tensor_spacing);
  columns.attributes = {{"flow", 3}, {"part", 1, AttributeKind::classes}};
  for (const StoreColumns& of : {StoreColumns{}, StoreColumns{.rows = RowKind::surfaces}, columns}) {
    header.columns = of;
    const ScratchFolder folder;
    begun_plan(folder / "s.h5", header);
    write_plan_text(folder / "s.h5", earlier_plan(header, "sample"));
    CHECK(refusal(folder / "s.h5", header).second == 2);
    CHECK(*read_run_plan(folder / "s.h5")->header.columns == of);
  }
  const ScratchFolder folder;
  begun_plan(folder / "s.h5", header);
  const auto purpose = [&](std::string_view phrase) {
    write_plan_text(folder / "s.h5", earlier_plan(header, phrase, "/models"));
    const RunPlan plan = *read_run_plan(folder / "s.h5");
    CHECK(plan.root == "/models");
    CHECK(purpose_text(plan) == phrase);
    return std::pair(plan.purpose, plan.retry);
  };
  using Purpose = std::pair<RunPurpose, std::string>;
  CHECK(purpose("sample") == Purpose(RunPurpose::sample, ""));
  CHECK(purpose("replace the store") == Purpose(RunPurpose::replace, ""));
  CHECK(purpose("update the store") == Purpose(RunPurpose::update, ""));
  CHECK(purpose("update the store with --retry timeout,changed") ==
        Purpose(RunPurpose::update, "timeout,changed"));
  CHECK(purpose("describe its rows") == Purpose(RunPurpose::describe, ""));
  CHECK(purpose("merge stores") == Purpose(RunPurpose::merge, ""));
  CHECK(purpose("sample surfaces") == Purpose(RunPurpose::surfaces, ""));
  write_plan_text(folder / "s.h5", earlier_plan(header, "write a sonnet"));
  CHECK_THROWS_AS(read_run_plan(folder / "s.h5"), RunError);
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
