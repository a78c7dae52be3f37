// The fuzz targets over a fixed corpus: seeds and their mutations. A fuzzer that follows the coverage goes
// further (tests/fuzz/run); these cases see that the targets build, hold and keep what was found.
#include <exception>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "seeds.h"
#include "support/catch.h"
#include "support/gltf_files.h"
#include "targets.h"

using namespace meander;
using namespace meander::fuzz;

namespace {

using Random = std::mt19937_64;

constexpr int mutations_of_target = 200;

std::size_t below(Random& random, std::size_t count) { return count == 0 ? 0 : random() % count; }

// Where counts stand and where data do: half of all places are among the first 200 bytes.
std::size_t place(Random& random, const std::string& bytes) {
  return below(random, random() % 2 == 0 ? std::min<std::size_t>(bytes.size(), 200) : bytes.size());
}

void mutate(std::string& bytes, const std::string& other, Random& random) {
  static const std::string words[] = {"nan",
                                      "-1",
                                      "4294967295",
                                      "18446744073709551615",
                                      "1e999",
                                      "0",
                                      " ",
                                      "\n",
                                      std::string(4, '\xFF'),
                                      std::string(8, '\0'),
                                      "\xFF\xFF\xFF\x7F",
                                      "\"",
                                      "../"};
  const std::size_t at = place(random, bytes), count = 1 + below(random, 40);
  switch (random() % 8) {
    case 0:
      if (!bytes.empty()) bytes[at] = static_cast<char>(bytes[at] ^ 1 << random() % 8);
      break;
    case 1:
      if (!bytes.empty()) bytes[at] = static_cast<char>(random());
      break;
    case 2:
      bytes.resize(below(random, bytes.size()));
      break;
    case 3:
      bytes.erase(at, count);
      break;
    case 4:
      bytes.insert(at, bytes.substr(below(random, bytes.size()), count));
      break;
    case 5:
      bytes.replace(at, count, other.substr(below(random, other.size()), count));
      break;
    case 6:
      bytes.insert(at, words[below(random, std::size(words))]);
      break;
    default: {
      const std::string& word = words[below(random, std::size(words))];
      bytes.replace(at, word.size(), word);
    }
  }
}

// What is wrong with the target on these bytes; empty when nothing is.
std::string finding(const Target& target, const std::string& bytes) {
  try {
    target.run(bytes);
    return {};
  } catch (const std::exception& error) {
    return std::string(error.what()) + " [" + std::string(target.name) +
           ", bytes in base64: " + test::base64(bytes) + "]";
  }
}

void run_corpus(const std::set<std::string_view>& names) {
  std::size_t found = 0;
  for (const Target& target : targets()) {
    if (!names.contains(target.name)) continue;
    ++found;
    const std::vector<std::string> seeds = seeds_of(target.name);
    REQUIRE(seeds.size() >= 2);
    for (const std::string& seed : seeds) REQUIRE(finding(target, seed) == "");
    REQUIRE(finding(target, "") == "");
    Random random(1);
    for (int k = 0; k < mutations_of_target; ++k) {
      std::string bytes = seeds[below(random, seeds.size())];
      for (std::size_t times = 1 + below(random, 3); times > 0; --times)
        mutate(bytes, seeds[below(random, seeds.size())], random);
      REQUIRE(finding(target, bytes) == "");
    }
  }
  REQUIRE(found == names.size());
}

}  // namespace

TEST_CASE("campaign: damaged text and binary meshes give a mesh or a status") {
  run_corpus({"off", "obj", "ply", "stl", "mtl"});
}

TEST_CASE("campaign: damaged glTF gives a mesh or a status") { run_corpus({"gltf"}); }

TEST_CASE("campaign: damaged archives give members or a status") { run_corpus({"zip", "tar", "gz"}); }

TEST_CASE("campaign: damaged points, tensors and pictures give values or an error") {
  run_corpus({"points", "npy", "npz", "tensor", "png"});
}

TEST_CASE("campaign: damaged texture images give pixels or an error") {
  run_corpus({"bmp", "gif", "tga", "webp"});
}

TEST_CASE("campaign: damaged plans, journals and labels from other machines give values or an error") {
  run_corpus({"plan", "array", "journal", "json", "labels"});
}

TEST_CASE("campaign: every fuzz target has seeds and reports a broken promise") {
  REQUIRE(targets().size() == 23);
  for (const Target& target : targets()) {
    CAPTURE(target.name);
    std::set<std::string> different;
    for (const std::string& seed : seeds_of(target.name)) different.insert(seed);
    REQUIRE(different.size() == seeds_of(target.name).size());
    for (const char letter : dictionary_of(target.name))
      REQUIRE((letter == '\n' || (letter >= ' ' && letter <= '~')));
  }
  REQUIRE_THROWS_AS(seeds_of("no such target"), std::invalid_argument);
  const Target broken = {"broken", [](std::string_view bytes) { demand(bytes.empty(), "a promise"); }};
  REQUIRE(finding(broken, "").empty());
  REQUIRE_THAT(finding(broken, "abc"), Catch::Matchers::StartsWith("a promise [broken"));
}
