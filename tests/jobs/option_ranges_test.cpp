// The ranges that help and documents state are those that are checked.
#include <filesystem>
#include <regex>
#include <sstream>

#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

using Words = std::vector<std::string>;

// "LOW to HIGH" behind an option in the help of its command.
std::pair<double, double> stated_range(const std::string& command, const std::string& option) {
  const std::string help = meander_with({command, "--help-all"}).out;
  const std::regex pattern(option + R"( [\s\S]*?([-+.0-9e]+)\s+to\s+([-+.0-9e]+))");
  std::smatch found;
  REQUIRE(std::regex_search(help, found, pattern));
  return {std::stod(found[1]), std::stod(found[2])};
}

// The rows of the tables of a document, cell by cell.
std::vector<Words> table_rows(const std::string& name) {
  std::vector<Words> rows;
  std::istringstream lines(read_file(std::string(MEANDER_SOURCE_DIR) + "/docs/" + name));
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("| ")) continue;
    std::istringstream cells(line.substr(1));
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, '|');) rows.back().push_back(cell);
  }
  return rows;
}

// The text between the first two backticks.
std::string quoted(const std::string& cell) {
  const std::size_t begin = cell.find('`');
  if (begin == std::string::npos) return "";
  return cell.substr(begin + 1, cell.find('`', begin + 1) - begin - 1);
}

// `step`: how far outside the range is refused. Only `run` can try values without computing.
void check_option(Words arguments, const std::string& option, double step) {
  const auto [low, high] = stated_range(arguments.front(), option);
  const auto ends_with = [&](double value, int exit_code) {
    std::ostringstream assignment;
    assignment.precision(15);
    assignment << option << '=' << value;
    Words all = arguments;
    all.push_back(assignment.str());
    INFO(Catch::StringMaker<Words>::convert(all));
    CHECK(meander_with(all).exit_code == exit_code);
  };
  ends_with(low - step, 2);
  ends_with(high + step, 2);
  if (arguments.front() != "run") return;
  ends_with(low, 0);
  ends_with(high, 0);
}

}  // namespace

TEST_CASE("options: the help states the ranges that are checked") {
  const ScratchFolder scratch;
  write_mesh(scratch / "a.off", cube());
  const auto run = [&](Words more) {
    Words all = {"run", scratch / "a.off", "-o", scratch / "s.h5", "--dry-run"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  check_option(run({"--density", "mean"}), "--density-floor", 1e-7);
  check_option(run({"--density", "mean"}), "--density-exponent", 0.01);
  check_option(run({"--method", "anisotropic"}), "--tensor-ratio", 0.01);
  check_option(run({"--method", "anisotropic"}), "--tensor-smoothing", 1);
  check_option(run({"--describe", "d2"}), "--bins", 1);
  const Words surface = {"surface", "sphere", "-o", scratch / "s.h5", "--density", "mean"};
  check_option(surface, "--density-floor", 1e-7);
  check_option(surface, "--density-exponent", 0.01);
  check_option(surface, "--tolerance", 1e-9);
  check_option(surface, "--leaves-per-sample", 0.01);
  check_option(surface, "--max-depth", 1);
  CHECK_FALSE(std::filesystem::exists(scratch / "s.h5"));
}

TEST_CASE("options: the documents state the options and ranges of the help") {
  const std::string help = meander_with({"run", "--help-all"}).out;
  const std::regex range("([-+.0-9e]+) to ([-+.0-9e]+)");
  int options = 0, ranges = 0;
  for (const Words& row : table_rows("ANISOTROPIC.md")) {
    const std::string option = quoted(row[0]).substr(0, quoted(row[0]).find(' '));
    if (!option.starts_with("--")) continue;
    INFO(option);
    ++options;
    CHECK(contains(help, option + " "));
    std::smatch stated;
    if (!std::regex_search(row.at(1), stated, range)) continue;
    ++ranges;
    CHECK(stated_range("run", option) == std::pair(std::stod(stated[1]), std::stod(stated[2])));
  }
  CHECK(options >= 7);
  CHECK(ranges >= 2);
}

TEST_CASE("options: METHODS.md lists the values of --sequence in order, and its default") {
  std::string words, standard;
  bool inside = false;
  for (const Words& row : table_rows("METHODS.md")) {
    if (quoted(row[0]).empty()) inside = row.size() > 1 && row[1] == " t_i ";  // the head of a table
    if (!inside || quoted(row[0]).empty()) continue;
    words += (words.empty() ? "" : "|") + quoted(row[0]);
    if (row.at(2).starts_with(" default")) standard = quoted(row[0]);
  }
  INFO(words << ", default " << standard);
  const std::string help = meander_with({"run", "--help-all"}).out;
  const std::size_t at = help.find("--sequence " + words);
  REQUIRE(at != std::string::npos);
  CHECK(help.find("(default: " + standard + ")", at) < help.find("\n  -", at));
}
