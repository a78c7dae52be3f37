// The help: of a small command line at many widths, and of every command of the program.
#include "jobs/cli/command_help.h"

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "jobs/cli/jobs.h"
#include "jobs/rows/laboratory.h"
#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/pseudo_terminal.h"

using namespace meander;
using namespace meander::test;

namespace {

using Words = std::vector<std::string>;

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    if (line.ends_with('\r')) line.pop_back();
    lines.push_back(line);
  }
  return lines;
}

std::size_t longest_line(const std::string& text) {
  std::size_t longest = 0;
  for (const std::string& line : lines_of(text)) longest = std::max(longest, line.size());
  return longest;
}

// Nor the backslashes at the ends of the lines of commands.
std::string without_blanks(std::string text) {
  std::erase_if(text, [](char c) { return c == ' ' || c == '\n' || c == '\\'; });
  return text;
}

// The program with all its commands.
struct WholeProgram {
  WholeProgram() {
    program.require_subcommand();
    jobs = add_jobs(program, program_laboratory(), hook, arguments);
  }
  CommandLine line{"meander", "Help", "1", ""};
  Command program = line.program();
  StageHook hook;
  Words arguments;
  std::vector<Job> jobs;
};

// The arguments of a command line in the form of a shell, up to a redirection.
Words arguments_of(const std::string& line) {
  Words words(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ' ' && !quoted)
      words.emplace_back();
    else
      words.back() += c;
  }
  words.erase(std::find(words.begin(), words.end(), ">"), words.end());
  return words;
}

void parse(CommandLine& line, Words words) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  CHECK(line.parse(static_cast<int>(pointers.size()), pointers.data()));
}

// Calls check(command, words that lead to it) for the program and all commands below it.
template <class Check>
void for_each_command(const CommandDescription& command, const Words& before, const Check& check) {
  Words words = before;
  words.push_back(command.name);
  check(command, words);
  for (const CommandDescription& subcommand : command.subcommands) for_each_command(subcommand, words, check);
}

template <class Texts>
std::string joined(const Texts& texts) {
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : " ") + text;
  return all;
}

}  // namespace

TEST_CASE("help: lines are broken between words, and long lists behind commas and bars") {
  CommandDescription command;
  command.name = "draw";
  command.help = "Draw all of the shapes that a file has, one beside the other";
  command.footer =
      "Exit codes:\n  0 all done, of which there is a long line that goes on and on until it ends";
  command.examples = {{"draw shapes.txt -o shapes.png --form round", "All shapes as discs"}};
  OptionDescription option;
  option.value = "FILE";
  option.help =
      "The shapes:\n  one: a shape\n  two: another one, of which there is more to be said than of it";
  option.required = true;
  command.options.push_back(option);
  option = {};
  option.flags = {"-f", "--form"};
  option.words = {"round", "square", "triangular", "pentagonal", "hexagonal", "heptagonal"};
  option.help = "Of alpha,beta,gamma,delta,epsilon,zeta,eta,theta,iota,kappa,lambda,mu,nu,xi,omicron,pi";
  option.initial = "round";
  option.excludes = {"--formless"};
  option.heading = "Options";
  command.options.push_back(option);
  const auto at = [&](int width) { return command_help(command, "x draw", HelpScope::all, width); };
  for (const int width : {30, 40, 59, 60, 72, 80, 100, 120}) {
    INFO(at(width));
    CHECK(longest_line(at(width)) <= static_cast<std::size_t>(width));
    CHECK(without_blanks(at(width)) == without_blanks(at(120)));
    for (const std::string& line : lines_of(at(width))) CHECK_FALSE(line.ends_with(' '));
  }
  CHECK(at(60) ==
        "Draw all of the shapes that a file has, one beside the other\n"
        "\n"
        "  draw shapes.txt -o shapes.png --form round\n"
        "      All shapes as discs\n"
        "\n"
        "Usage: x draw [OPTIONS] FILE\n"
        "\n"
        "Arguments:\n"
        "  FILE                    The shapes:\n"
        "                            one: a shape\n"
        "                            two: another one, of which there\n"
        "                              is more to be said than of it\n"
        "\n"
        "Options:\n"
        "  -f, --form round|square|triangular|pentagonal|hexagonal|\n"
        "        heptagonal\n"
        "                          Of alpha,beta,gamma,delta,epsilon,\n"
        "                          zeta,eta,theta,iota,kappa,lambda,\n"
        "                          mu,nu,xi,omicron,pi (default:\n"
        "                          round; not with --formless)\n"
        "\n"
        "Exit codes:\n"
        "  0 all done, of which there is a long line that goes on and\n"
        "    on until it ends\n");
}

TEST_CASE("help: the short one has arguments, required options and those that are marked") {
  CommandLine line("example", "An example", "example 1", "The end");
  Command program = line.program();
  Command draw = program.add_subcommand("draw", "Draws");
  Command paint = program.add_subcommand("paint", "Paints");
  std::string text;
  bool flag = false;
  for (Command* command : {&draw, &paint}) {
    command->add_option("FILE", text, "A file");
    command->add_option("-o,--output", text, "Where").required();
    command->add_option("--rare", text, "Seldom");
  }
  draw.add_option("--often", text, "Common").common();
  draw.under("Lines").add_flag("--bold", flag, "Thick").common();
  draw.under("Lines").add_flag("--thin", flag, "Thin");
  const CommandDescription all = program.description();
  const std::string brief = command_help(all.subcommands[0], "example draw", HelpScope::common, 80);
  for (const char* shown : {"FILE", "--output", "--often", "--bold",
                            "Common options:", "`example draw --help-all` shows 4 more options."})
    CHECK(contains(brief, shown));
  for (const char* hidden : {"--rare", "--thin", "Lines:"}) CHECK_FALSE(contains(brief, hidden));
  const std::string whole = command_help(all.subcommands[0], "example draw", HelpScope::all, 80);
  for (const char* shown : {"--rare", "--thin", "Lines:", "--help-all", "--often"})
    CHECK(contains(whole, shown));
  CHECK_FALSE(contains(whole, "more option"));
  // Without marks all options are shown.
  CHECK(contains(command_help(all.subcommands[1], "example paint", HelpScope::common, 80), "--rare"));
}

TEST_CASE("help: examples of several lines are one command for a shell, options beside their values") {
  CommandDescription command;
  command.name = "draw";
  command.examples = {
      {"x draw shapes.txt -o shapes.png --form round --all --size 640", "All shapes as discs"}};
  CHECK(contains(command_help(command, "x draw", HelpScope::all, 40),
                 "  x draw shapes.txt -o shapes.png \\\n    --form round --all --size 640\n      All"));
  CHECK(contains(
      command_help(command, "x draw", HelpScope::all, 30),
      "  x draw shapes.txt \\\n    -o shapes.png \\\n    --form round --all \\\n    --size 640\n      All"));
  CHECK(contains(command_help(command, "x draw", HelpScope::all, 80), "--all --size 640\n"));
}

TEST_CASE("help: every command begins with examples, and the program accepts each of them") {
  WholeProgram whole;
  std::size_t commands = 0;
  for_each_command(
      whole.program.description(), {}, [&](const CommandDescription& command, const Words& words) {
        const std::string name = joined(words);
        INFO(name);
        ++commands;
        CHECK(command.examples.size() == (words.size() == 1 ? 3 : 2));
        const std::string help = command_help(command, name, HelpScope::common, 80);
        CHECK(help.find(command.examples.front().line) < help.find("Usage:"));
        for (const CommandExample& example : command.examples) {
          INFO(example.line);
          CHECK(example.line.starts_with(words.size() == 2 && words[1] == "help" ? "meander help" : name));
          WholeProgram fresh;
          CHECK_NOTHROW(parse(fresh.line, arguments_of(example.line)));
        }
      });
  CHECK(commands >= 15);
}

TEST_CASE("help: no line of any command is longer than the terminal is wide") {
  WholeProgram whole;
  for_each_command(whole.program.description(), {},
                   [&](const CommandDescription& command, const Words& words) {
                     INFO(joined(words));
                     for (const int width : {40, 60, 80, 100, 120})
                       for (const HelpScope scope : {HelpScope::common, HelpScope::all})
                         CHECK(longest_line(command_help(command, joined(words), scope, width)) <=
                               static_cast<std::size_t>(width));
                   });
  // The program asks for the width: of the terminal, of COLUMNS, and takes 80 where there is neither.
  const auto columns = [](const char* value) {
    ProcessOptions options;
    options.environment = {{"COLUMNS", value}};
    return longest_line(meander_with({"run", "--help-all"}, options).out);
  };
  const auto terminal = [](int width) {
    const ProcessResult help = run_in_terminal({program, "run", "--help-all"}, width, STDOUT_FILENO);
    CHECK(help.exit_code == 0);
    return longest_line(help.out);
  };
  const auto is_near = [](std::size_t longest, std::size_t width) {
    return longest <= width && longest + 5 > width;
  };
  CHECK(is_near(columns("70"), 70));
  CHECK(is_near(columns("100"), 100));
  CHECK(is_near(columns(""), 80));
  CHECK(is_near(columns("many"), 80));
  CHECK(is_near(columns("500"), 120));
  CHECK(is_near(terminal(40), 40));
  CHECK(is_near(terminal(66), 66));
  CHECK(is_near(terminal(110), 110));
}

TEST_CASE("help: run shows about a dozen options, and --help-all every one") {
  const auto options_in = [](const std::string& help) {
    std::size_t count = 0;
    for (const std::string& line : lines_of(help)) count += line.starts_with("  -");
    return count;
  };
  const std::string brief = meander_with({"run", "--help"}).out;
  CHECK(options_in(brief) >= 10);
  CHECK(options_in(brief) <= 16);
  const ProcessResult all = meander_with({"run", "--help-all"});
  CHECK(all.exit_code == 0);
  WholeProgram whole;
  const std::vector<CommandDescription> commands = whole.program.description().subcommands;
  const auto run =
      std::find_if(commands.begin(), commands.end(), [](const auto& c) { return c.name == "run"; });
  REQUIRE(run != commands.end());
  std::size_t options = 0;
  for (const OptionDescription& option : run->options) {
    options += !option.flags.empty();
    for (const std::string& flag : option.flags) CHECK(contains(all.out, flag));
  }
  CHECK(options_in(all.out) == options);
  CHECK(options > 50);
}

TEST_CASE("help: `meander help` shows what --help shows, and names the command that was meant") {
  const auto out = [](const Words& words) {
    const ProcessResult result = meander_with(words);
    CHECK(result.exit_code == 0);
    CHECK(result.err.empty());
    return result.out;
  };
  CHECK(out({"help"}) == out({"--help"}));
  CHECK(out({"help", "run"}) == out({"run", "--help"}));
  CHECK(out({"help", "run", "--all"}) == out({"run", "--help-all"}));
  CHECK(out({"help", "retrieve", "query"}) == out({"retrieve", "query", "--help"}));
  CHECK(out({"help", "retrieve"}) == out({"retrieve", "--help"}));
  CHECK(contains(out({"--help"}), "Show the help of a command"));
  const auto refused = [](const Words& words) {
    const ProcessResult result = meander_with(words);
    CHECK(result.exit_code == 2);
    CHECK(result.out.empty());
    return result.err;
  };
  CHECK(refused({"help", "rnu"}) == "meander: `rnu` is not a command, did you mean `run`?\n");
  CHECK(refused({"help", "run", "fast"}) == "meander: `run` has no command `fast`\n");
}

TEST_CASE("help: without arguments the program shows three commands to begin with") {
  const ProcessResult result = meander_with({});
  CHECK(result.exit_code == 2);
  CHECK(result.out.empty());
  CHECK(result.err.starts_with("meander: a command is missing. To begin with:\n\n  meander run "));
  std::size_t commands = 0;
  for (const std::string& line : lines_of(result.err)) commands += line.starts_with("  meander ");
  CHECK(commands == 3);
  CHECK(longest_line(result.err) <= 80);
}
