// The files beside a store, STORE.words and STORE.graph: what is under their names is whole, whatever kills
// the command, depends on the models alone, and follows a store that grows.
#include <sched.h>

#include <chrono>
#include <filesystem>

#include "io/sealed_file.h"
#include "support/catch.h"
#include "support/meander_program.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

// Twenty-four models that differ, in two classes; `name` says what each is called.
template <class Name>
void write_models(const fs::path& folder, int first, int last, const Name& name) {
  fs::create_directories(folder / "ring");
  fs::create_directories(folder / "round");
  for (int i = first; i < last; ++i) {
    const std::string file = name(i) + ".off";
    if (i % 2 == 0)
      write_mesh(folder / "ring" / file, torus(16, 8, 1, 0.2 + 0.02 * i));
    else
      write_mesh(folder / "round" / file, moved(icosphere(2), 1 + 0.1 * i, 0, 0, i));
  }
}

std::string in_order(int i) { return "m" + std::to_string(100 + i); }
std::string reversed(int i) { return "m" + std::to_string(900 - i); }

struct SampledModels {
  ScratchFolder scratch;
  std::string path(const char* name) const { return scratch / name; }

  void sample(const char* models, const char* store) const {
    const ProcessResult result =
        meander_with({"run", path(models), "-o", path(store), "-n", "120", "--describe", "pairs",
                      "--label-from-folder", "--progress", "none"});
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
  }
  ProcessResult retrieve(const char* command, const char* store, const Words& more = {},
                         const ProcessOptions& options = {}) const {
    Words arguments = {"retrieve", command, path(store)};
    if (command == std::string("words"))
      arguments.insert(arguments.end(), {"--local-points", "20"});  // quick
    arguments.insert(arguments.end(), more.begin(), more.end());
    return meander_with(arguments, options);
  }
  std::string made(const char* command, const char* store, const Words& more = {},
                   const ProcessOptions& options = {}) const {
    const ProcessResult result = retrieve(command, store, more, options);
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
    return read_file(path(store) + "." + command);
  }
};

// The file with another number where its version stands, behind a magic of `magic` bytes, sealed as before.
std::string of_another_version(std::string bytes, std::size_t magic) {
  bytes.resize(bytes.size() - sizeof(Seal));
  bytes[magic] = static_cast<char>(bytes[magic] + 1);
  const Seal seal = seal_of(bytes);
  bytes.append(reinterpret_cast<const char*>(seal.data()), seal.size());
  return bytes;
}

}  // namespace

TEST_CASE("retrieve words and graph: a kill at any moment leaves no file or a whole one", "[release]") {
  const SampledModels models;
  write_models(models.scratch / "in", 0, 24, in_order);
  models.sample("in", "s.h5");
  for (const char* const command : {"words", "graph"}) {
    INFO(command);
    const auto start = std::chrono::steady_clock::now();
    const std::string whole = models.made(command, "s.h5");
    const auto whole_time = std::chrono::steady_clock::now() - start;
    const std::string file = models.path("s.h5") + "." + command;
    for (int part = 1; part <= 4; ++part) {
      // Every second time an earlier file is there.
      if (part % 2 == 0) fs::remove(file);
      ProcessOptions killed;
      killed.signal_after = std::chrono::duration_cast<std::chrono::milliseconds>(whole_time * part / 4);
      models.retrieve(command, "s.h5",
                      command == std::string("words") ? Words{"--replace"} : Words{"--descriptor", "pairs"},
                      killed);
      if (fs::exists(file) && command == std::string("words")) CHECK(read_file(file) == whole);
      CHECK(
          models.retrieve("query", "s.h5", {"0", "--descriptor", "pairs", "--rank", "diffusion"}).exit_code ==
          0);
    }
    CHECK(models.made(command, "s.h5") == whole);
  }
}

TEST_CASE("retrieve words and graph: other threads, names and orders of rows give the same", "[release]") {
  const SampledModels models;
  write_models(models.scratch / "in", 0, 24, in_order);
  write_models(models.scratch / "other", 0, 24, reversed);
  models.sample("in", "s.h5");
  models.sample("other", "t.h5");
  const std::string words = models.made("words", "s.h5"), graph = models.made("graph", "s.h5");
  CHECK(models.made("words", "t.h5") == words);
  ProcessOptions alone;
  alone.in_child = [] {
    cpu_set_t first;
    CPU_ZERO(&first);
    CPU_SET(0, &first);
    sched_setaffinity(0, sizeof first, &first);
  };
  CHECK(models.made("words", "s.h5", {"--replace"}, alone) == words);
  CHECK(models.made("graph", "s.h5", {}, alone) == graph);
  // The graph is of rows; what it finds is not.
  models.made("graph", "t.h5");
  const auto scores = [&](const char* store) {
    const std::string out = models.retrieve("evaluate", store, {"--csv", models.path("e.csv")}).out;
    CHECK(contains(out, "descriptor pairs+local-pairs"));
    return read_file(models.path("e.csv"));
  };
  CHECK(scores("s.h5") == scores("t.h5"));
}

TEST_CASE("retrieve words and graph: a store that grew has what one run gives, or says why not") {
  const SampledModels models;
  write_models(models.scratch / "whole", 0, 24, in_order);
  models.sample("whole", "one.h5");
  const std::string words = models.made("words", "one.h5"),
                    of_pairs = models.made("graph", "one.h5", {"--descriptor", "pairs"}),
                    graph = models.made("graph", "one.h5");
  write_models(models.scratch / "in", 0, 20, in_order);
  models.sample("in", "s.h5");
  models.made("words", "s.h5");
  models.made("graph", "s.h5");
  write_models(models.scratch / "in", 20, 24, in_order);
  models.sample("in", "s.h5");
  REQUIRE(read_file(models.path("s.h5")) == read_file(models.path("one.h5")));
  CHECK(models.made("graph", "s.h5", {"--descriptor", "pairs"}) == of_pairs);
  // The words are those of twenty models, and that is said; learned anew, all is as of one run.
  const ProcessResult kept = models.retrieve("words", "s.h5");
  CHECK(contains(kept.out, "kept 6 words from 20 models"));
  CHECK(contains(kept.out, "the store as it is gives other words: --replace learns them"));
  CHECK(contains(models.retrieve("words", "s.h5", {"--json"}).out, R"("words_of_this_store":false)"));
  CHECK(read_file(models.path("s.h5.words")) != words);
  CHECK(models.made("graph", "s.h5") != graph);
  CHECK(models.made("words", "s.h5", {"--replace"}) == words);
  CHECK(models.made("graph", "s.h5") == graph);
  CHECK(contains(models.retrieve("words", "s.h5", {"--json"}).out, R"("words_of_this_store":true)"));
}

TEST_CASE("retrieve words and graph: cut and foreign files are refused by name") {
  const SampledModels models;
  write_models(models.scratch / "in", 0, 24, in_order);
  models.sample("in", "s.h5");
  models.made("words", "s.h5");
  models.made("graph", "s.h5");
  const auto refused = [&](const std::string& file, const char* why) {
    const ProcessResult result = models.retrieve("query", "s.h5", {"0"});
    INFO(result.err);
    CHECK(result.exit_code == 2);
    CHECK(contains(result.err, "`" + file + "` is not "));
    CHECK(contains(result.err, why));
  };
  for (const std::string kind : {"words", "graph"}) {
    INFO(kind);
    const std::string file = models.path("s.h5") + "." + kind, whole = read_file(file);
    const std::size_t magic = whole.find('\n') + 1;
    for (const std::size_t length : {std::size_t{0}, magic, whole.size() / 3, whole.size() - 1}) {
      write_file(file, whole.substr(0, length));
      refused(file, length < magic + sizeof(Seal) ? "it does not begin like one" : "it is damaged");
    }
    write_file(file, of_another_version(whole, magic));
    refused(file, "of another version");
    refused(file, kind == "words" ? "`meander retrieve words --replace` makes it anew"
                                  : "`meander retrieve graph` makes it anew");
    write_file(file, whole);
    CHECK(models.retrieve("query", "s.h5", {"0"}).exit_code == 0);
  }
}

TEST_CASE("retrieve words: other histograms are learned anew, and codes of one kind are kept") {
  const SampledModels models;
  write_models(models.scratch / "in", 0, 4, in_order);
  models.sample("in", "s.h5");
  const std::string words = models.made("words", "s.h5");
  const Words spacings = {"--radius", "6", "--radius-unit", "spacing"};
  const ProcessResult refused = models.retrieve("words", "s.h5", spacings);
  CHECK(refused.exit_code == 2);
  CHECK(contains(refused.err,
                 "has words of other histograms (20 points a model, radius 0.7 x size): --replace learns "
                 "words of 20 points a model, radius 6 x spacing"));
  CHECK(read_file(models.path("s.h5.words")) == words);
  CHECK(models.made("words", "s.h5", {"--radius", "6", "--radius-unit", "spacing", "--replace"}) != words);
  // A mesh is coded as the store is: it finds itself.
  REQUIRE(models
              .retrieve("query", "s.h5",
                        {"--mesh", models.path("in"), "-k", "1", "--descriptor", "local-pairs", "--csv",
                         models.path("q.csv")})
              .exit_code == 0);
  CHECK(contains(read_file(models.path("q.csv")), "ring/m100.off,1,0,ring/m100.off,ring,0\n"));
}

TEST_CASE("export: codes of local pairs like any descriptor") {
  const SampledModels models;
  write_models(models.scratch / "in", 0, 6, in_order);
  models.sample("in", "s.h5");
  const auto exported = [&](const char* descriptors, const char* file) {
    return meander_with(
        {"export", models.path("s.h5"), "--descriptors", descriptors, "-o", models.path(file)});
  };
  const ProcessResult none = exported("local-pairs", "c.npy");
  CHECK(none.exit_code == 2);
  CHECK(contains(none.err, "s.h5.words`: `meander retrieve words "));
  models.made("words", "s.h5");
  const ProcessResult npy = exported("local-pairs", "c.npy");
  INFO(npy.err);
  REQUIRE(npy.exit_code == 0);
  CHECK(contains(npy.out, "6 rows of 64 values"));
  // As vectors of another program they are at the same distances; by l1, the default, codes count by cosine.
  const auto found = [&](const Words& more) {
    Words arguments = {"0", "-k", "5", "--csv", models.path("q.csv")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    CHECK(models.retrieve("query", "s.h5", arguments).exit_code == 0);
    return read_file(models.path("q.csv"));
  };
  const std::string by_cosine = found({"--descriptor", "local-pairs", "--distance", "cosine"});
  CHECK(found({"--vectors", models.path("c.npy"), "--ids", models.path("c.npy.ids.csv"), "--distance",
               "cosine"}) == by_cosine);
  CHECK(found({"--descriptor", "local-pairs"}) == by_cosine);
  CHECK(found({"--descriptor", "local-pairs", "--distance", "l2"}) != by_cosine);
  REQUIRE(exported("pairs+local-pairs", "c.csv").exit_code == 0);
  CHECK(contains(read_file(models.path("c.csv")), "local-pairs_b63"));
  CHECK(contains(exported("pairs=2+local-pairs", "w.csv").err, "local-pairs is compared by cosine"));
}
