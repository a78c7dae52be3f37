#include "jobs/cli/command_line.h"

#include "jobs/cli/settings.h"
#include "jobs/cli/units.h"
#include "jobs/cli/usage_error.h"
#include "kernels/core/spelling.h"
#include "kernels/surface/surface_settings.h"
#include "support/catch.h"

using namespace meander;

namespace {

// A program with one subcommand of every kind of option.
struct Example {
  Example() {
    Command program = line.program();
    program.require_subcommand();
    Command draw = program.add_subcommand("draw", "Draws");
    draw.add_option("FILE", file, "A file").required();
    draw.add_option("--count", count, "How many").range(1, 9).on_given([this] { ++counted; });
    draw.add_option("--share", share, "How much").range(0.0, 1.0);
    draw.add_option("-s,--seed", seed, "Seed");
    draw.add_option("--large", large, "Many").range(1, 1000000);
    draw.add_option("--memory", memory, "Memory").bytes();
    draw.add_option("--timeout", timeout, "Time").seconds();
    draw.add_option("--only", only, "Some").separator(',');
    const Option shape = draw.add_option("--form", form, "Shape").show_default().one_of({"round", "square"});
    const Option thick = draw.add_flag("--bold", bold, "Thick lines").excludes(shape);
    draw.add_flag(
            "--bolder", [this] { ++steps; }, "Thicker lines")
        .needs(thick);
    draw.add_option(
        "--name", [this](const std::string& text) { name = text; }, "Of the picture");
    program.add_hidden_subcommand("secret");
    Command ask = program.add_subcommand("ask", "Asks");
    ask.require_subcommand();
    ask.add_subcommand("question", "A question");
  }

  bool parse(std::vector<std::string> words) {
    words.insert(words.begin(), "example");
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    return line.parse(static_cast<int>(arguments.size()), arguments.data());
  }
  std::string problem(const std::vector<std::string>& words) {
    try {
      parse(words);
    } catch (const UsageError& error) {
      return error.what();
    }
    return "";
  }

  CommandLine line{"example", "An example", "example 1", "The end"};
  std::string file, form = "round", name, memory, timeout;
  int count = 4, counted = 0, steps = 0;
  double share = 0.5;
  std::uint64_t seed = 0;
  std::uint32_t large = 0;
  std::vector<std::string> only;
  bool bold = false;
};

}  // namespace

TEST_CASE("plain_count: expands exponents and units of integers, and leaves anything else unchanged") {
  CHECK(plain_count("1e3") == "1000");
  CHECK(plain_count("2k") == "2000");
  CHECK(plain_count("1.5M") == "1500000");
  CHECK(plain_count("2.048K") == "2048");
  CHECK(plain_count("1.20e1") == "12");
  CHECK(plain_count("1e+2k") == "100000");
  CHECK(plain_count("18446744073709551615") == "18446744073709551615");
  CHECK(plain_count("0k") == "0");
  CHECK(plain_count("007e0") == "7");
  for (const char* text :
       {"", "k", "1.5", "1e-3", "2.5e0", "1kk", "1 k", "-1k", "1e", "1e999", "nan", "0x10", "12q", "1.0001k"})
    CHECK(plain_count(text) == text);
}

TEST_CASE("command line: counts take exponents and units, and are checked as numbers") {
  Example example;
  REQUIRE(example.parse({"draw", "a", "--seed", "2k", "--count", "0.5e1"}));
  CHECK(example.seed == 2000);
  CHECK(example.count == 5);
  CHECK(Example().problem({"draw", "a", "--count", "1k"}) ==
        "--count takes a whole number from 1 to 9, not `1k`");
}

TEST_CASE("command line: a misspelled command gets a suggestion, a missing one is asked for") {
  CHECK(Example().problem({"darw", "a.png"}) == "`darw` is not a command, did you mean `draw`?");
  CHECK(Example().problem({"paint"}) == "`paint` is not a command: the commands are draw, ask");
  CHECK(Example().problem({}) == "a command is missing: draw, ask");
  CHECK(Example().problem({"ask"}) == "a command is missing: question");
  CHECK(Example().problem({"ask", "qeustion"}) == "`qeustion` is not a command, did you mean `question`?");
}

TEST_CASE("command line: options set their variables") {
  Example example;
  REQUIRE(example.parse({"draw", "a.png", "--count=5", "--share", "0.25", "--seed", "18446744073709551615",
                         "--only", "x,y", "--bold", "--bolder", "--name", "n"}));
  CHECK(example.line.program().chose("draw"));
  CHECK_FALSE(example.line.program().chose("ask"));
  CHECK(example.file == "a.png");
  CHECK(example.count == 5);
  CHECK(example.counted == 1);
  CHECK(example.share == 0.25);
  CHECK(example.seed == ~std::uint64_t{0});
  CHECK(example.only == std::vector<std::string>{"x", "y"});
  CHECK(example.bold);
  CHECK(example.steps == 1);
  CHECK(example.name == "n");
  Example untouched;
  REQUIRE(untouched.parse({"draw", "a.png"}));
  CHECK(untouched.count == 4);
  CHECK(untouched.counted == 0);
  CHECK(untouched.form == "round");
}

TEST_CASE("command line: every mistake is a usage error") {
  CHECK(Example().problem({"draw"}) == "FILE is required");
  CHECK(Example().problem({"draw", "a", "--form", "squre"}) ==
        "--form: `squre` is none of round|square; did you mean `square`?");
  CHECK(Example().problem({"draw", "a", "--form", "square", "--bold"}) == "--form excludes --bold");
  CHECK(Example().problem({"draw", "a", "--bolder"}) == "--bolder requires --bold");
  CHECK(Example().problem({"draw", "a", "--shar=1", "b"}) ==
        "unknown option `--shar`, did you mean `--share`?; `b` was not expected");
  CHECK(Example().problem({"ask", "question", "x"}) == "`x` was not expected");
}

TEST_CASE("command line: the error of a number names the option as it was given, and the form") {
  const auto problem = [](const std::string& option, const std::string& text) {
    return Example().problem({"draw", "a", option, text});
  };
  const std::string whole = " takes a whole number such as 2048 or 10k, not ";
  for (const char* text : {"2,5k", "1.5", "-1", "x", "0x10", "1e-3", "", "1 k"}) {
    CHECK(problem("--seed", text) == "--seed" + whole + "`" + text + "`");
    CHECK(problem("-s", text) == "-s" + whole + "`" + text + "`");
  }
  CHECK(Example().problem({"draw", "a", "--seed=2,5k"}) == "--seed" + whole + "`2,5k`");
  CHECK(problem("--seed", "18446744073709551616") ==
        "--seed takes a whole number up to 18446744073709551615, not `18446744073709551616`");
  CHECK(problem("--seed", "18446744073709551615") == "");
  for (const char* text : {"0", "10", "x", "5000000000"})
    CHECK(problem("--count", text) ==
          std::string("--count takes a whole number from 1 to 9, not `") + text + "`");
  CHECK(problem("--large", "2M") ==
        "--large takes a whole number from 1 to 1000000, such as 2048 or 10k, not `2M`");
  for (const char* text : {"1.5", "-0.1", "half", "nan", "0.5x"})
    CHECK(problem("--share", text) == std::string("--share takes a number from 0 to 1, not `") + text + "`");
  CHECK(problem("--share", "1e-3") == "");
  for (const char* text : {"4Q", "-4G", "much", "1e30G"})
    CHECK(problem("--memory", text) ==
          std::string("--memory takes a size such as 4G or 512M (K, M, G, T), not `") + text + "`");
  CHECK(problem("--memory", "1.5GiB") == "");
  for (const char* text : {"5 parsecs", "-1s", "soon"})
    CHECK(problem("--timeout", text) ==
          std::string("--timeout takes a time such as 90s or 2m (ms, s, m, h), not `") + text + "`");
  CHECK(problem("--timeout", "0") == "");
}

TEST_CASE("command line: options may have their British spelling") {
  CommandLine line("example", "An example", "1", "");
  Command program = line.program();
  std::string color, others, form;
  bool normal = false;
  program.add_option("--color", color, "Color");
  program.add_option("--neighbors", others, "Others");
  program.add_flag("--normalize", normal, "Normal");
  program.add_option("--parameterization", form, "Form");
  std::vector<std::string> words = {
      "example", "--colour=--neighbours", "--neighbours", "colour", "--normalise", "--parameterisation", "a"};
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  REQUIRE(line.parse(static_cast<int>(pointers.size()), pointers.data()));
  CHECK(color == "--neighbours");
  CHECK(others == "colour");
  CHECK(normal);
  CHECK(form == "a");
}

TEST_CASE("command line: a hidden subcommand takes any arguments") {
  Example example;
  CHECK(example.parse({"secret", "--help", "--anything", "b"}));
  CHECK(example.line.program().chose("secret"));
}

struct Shape {
  double share = 0.5;
  std::uint32_t count = 4;
  bool bold = false, thin = false;
  CurveKind curve = CurveKind::hilbert;
  std::string names;
};

SettingList<Shape> shape_settings() {
  SettingList<Shape> list;
  list.under("Shape");
  list.word(
      "curve_kind", "--curve", [](auto& s) -> auto& { return s.curve; }, curve_words, "The curve");
  list.number(
      "curves", "--share", [](auto& s) -> auto& { return s.share; }, 0, 1, "How much");
  list.number(
          "count", "-c,--count", [](auto& s) -> auto& { return s.count; }, 1, 8, "How many")
      .acting([](const Shape& s) { return s.bold; }, "applies to bold shapes only");
  list.flag(
      "bold", "--bold", [](auto& s) -> auto& { return s.bold; }, "Thick");
  list.text(
          "names", "--name", [](const Shape& s) { return s.names; },
          [](Shape& s, std::string_view text) {
            s.names = text;
            return text.find('!') == std::string_view::npos ? std::string() : "`!` is no name";
          },
          "Names")
      .list()
      .only_recorded([](const Shape& s) { return !s.names.empty(); });
  list.constant("area", [](const Shape& s) { return 2 * s.share; });
  return list;
}

// What the options of the list set, and the problems.
std::pair<Shape, std::vector<std::string>> shape_of(std::vector<std::string> arguments) {
  const SettingList<Shape> list = shape_settings();
  CommandLine line("example", "An example", "1", "");
  Shape shape;
  SettingOptions options;
  options.add(line.program(), list, shape);
  arguments.insert(arguments.begin(), "example");
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  try {
    const bool is_parsed = line.parse(static_cast<int>(pointers.size()), pointers.data());
    CHECK(is_parsed);
  } catch (const UsageError& error) {
    return {shape, {error.what()}};
  }
  std::vector<std::string> problems;
  options.finish(problems);
  check_ranges(list, shape, problems);
  return {shape, problems};
}

std::string recorded(const Shape& shape) {
  RecordedSettings members;
  record(shape_settings(), shape, members);
  return json_of(std::move(members));
}

TEST_CASE("settings: one row defines an option and a member of the stored parameters") {
  const auto [shape, problems] =
      shape_of({"--curve=peano", "--bold", "-c", "5", "--share", "0.75", "--name", "a,b", "--name", "c"});
  CHECK(problems.empty());
  CHECK(recorded(shape) ==
        R"({"area":1.5,"bold":true,"count":5,"curves":0.75,"curve_kind":"peano","names":"a,b,c"})");
  CHECK(recorded(Shape{}) == R"({"area":1,"bold":false,"count":4,"curves":0.5,"curve_kind":"hilbert"})");
}

TEST_CASE("settings: invalid texts, ranges and settings without effect are problems") {
  CHECK(shape_of({"--name", "a!"}).second == std::vector<std::string>{"--name: `!` is no name"});
  CHECK(shape_of({"--bold", "--count", "9"}).second ==
        std::vector<std::string>{"--count takes a whole number from 1 to 8, not `9`"});
  CHECK(shape_of({"--count", "4"}).second == std::vector<std::string>{"--count applies to bold shapes only"});
  CHECK(shape_of({}).second.empty());
}

TEST_CASE("settings: stored parameters are read back, and differences are noted") {
  Shape shape;
  GivenSettings given;
  const std::map<std::string, std::string> stored = {
      {"area", "1.5"},     {"bold", "true"}, {"count", "4"}, {"curves", "0.75"}, {"curve_kind", "\"peano\""},
      {"names", "\"a,b\""}};
  CHECK(take_recorded(shape_settings(), stored, shape, given) == "");
  CHECK(given == GivenSettings{"bold", "curves", "curve_kind", "names"});
  CHECK(recorded(shape) ==
        R"({"area":1.5,"bold":true,"count":4,"curves":0.75,"curve_kind":"peano","names":"a,b"})");
  CHECK(take_recorded(shape_settings(), {{"count", "0"}}, shape, given) ==
        "parameter \"count\": it is 0, must be 1 to 8");
  CHECK(take_recorded(shape_settings(), {{"curve_kind", "\"peanno\""}}, shape, given) ==
        "parameter \"curve_kind\": `peanno` is none of hilbert|peano|peano-meander; did you mean `peano`?");
}

TEST_CASE("command line: parses bytes and seconds, and suggests the nearest word") {
  CHECK(parse_bytes("512M") == std::uint64_t{512} << 20);
  CHECK(parse_bytes("1.5GiB") == std::uint64_t{3} << 29);
  CHECK(parse_bytes("100") == 100);
  CHECK_THROWS(parse_bytes("12Q"));
  CHECK_THROWS(parse_bytes("-4G"));
  CHECK(parse_seconds("120s") == 120);
  CHECK(parse_seconds("2m") == 120);
  CHECK(parse_seconds("0") == 0);
  CHECK_THROWS(parse_seconds("5 parsecs"));
  CHECK(nearest("progresive", std::vector<std::string>{"curve", "progressive"}) == "progressive");
  CHECK(nearest("xyzzy", std::vector<std::string>{"curve", "progressive"}).empty());
  CHECK(edit_distance("abcd", "abdc") == 1);
}
