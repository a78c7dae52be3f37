// Manual pages and completions: of a small command line with awkward texts, and of the program.
#include "jobs/cli/command_pages.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/run_process.h"

using namespace meander;
using namespace meander::test;
namespace fs = std::filesystem;

namespace {

struct Example {
  Example() {
    Command program = line.program();
    program.require_subcommand();
    Command draw = program.add_subcommand("draw", "Draws what's there");
    draw.add_option("FILE", files, "Files").required();
    draw.add_option("-o,--output", output, "Where").required();
    draw.add_option("--form", form, "One [of]: C:\\x or\n.hidden line")
        .show_default()
        .one_of({"round", "square"});
    draw.add_option("-n", count, "How many").show_default();
    draw.add_flag("--bold", bold, "Thick lines");
    draw.under("Colors").add_option("--share", share, "'Part' of it");
    Command ask = program.add_subcommand("ask", "Asks");
    ask.require_subcommand();
    ask.add_subcommand("question", "A question");
    program.add_hidden_subcommand("secret");
    program.add_unlisted_subcommand("unlisted", "Not shown");
  }
  std::map<std::string, std::string> pages() {
    std::map<std::string, std::string> all;
    for (auto& [name, text] : command_pages(line.program().description(), "1.2-3")) all[name] = text;
    return all;
  }

  CommandLine line{"example", "An example", "example 1", "0 all done"};
  std::vector<std::string> files;
  std::string output, form = "round";
  int count = 4;
  double share = 0;
  bool bold = false;
};

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  std::sort(words.begin(), words.end());
  return words;
}

// What bash offers for the words typed, the last of which the cursor is at.
std::vector<std::string> offered(const fs::path& completion, std::string_view program,
                                 const std::vector<std::string>& typed, const fs::path& folder) {
  std::string command = "cd '" + folder.string() + "'; source '" + completion.string() + "'; COMP_WORDS=(" +
                        std::string(program);
  for (const std::string& word : typed) command += " '" + word + "'";
  command += "); COMP_CWORD=" + std::to_string(typed.size()) + "; _" + std::string(program) +
             "; printf '%s\\n' \"${COMPREPLY[@]}\"";
  const ProcessResult result = run_process({"/bin/bash", "--norc", "-c", command});
  CHECK(result.err.empty());
  return words_of(result.out);
}

}  // namespace

TEST_CASE("pages: every visible command has a manual page with all its options") {
  Example example;
  const auto pages = example.pages();
  std::vector<std::string> names;
  for (const auto& [name, text] : pages) names.push_back(name);
  CHECK(names == std::vector<std::string>{
                     "bash-completion/completions/example", "fish/vendor_completions.d/example.fish",
                     "man/man1/example-ask-question.1", "man/man1/example-ask.1", "man/man1/example-draw.1",
                     "man/man1/example.1", "zsh/vendor-completions/_example"});
  for (const auto& [name, text] : pages) {
    CHECK_FALSE(contains(text, "secret"));
    CHECK_FALSE(contains(text, "unlisted"));
  }
  const std::string draw = pages.at("man/man1/example-draw.1");
  CHECK(contains(draw, ".TH \"EXAMPLE\\-DRAW\" 1 \"\" \"example 1.2\\-3\""));
  CHECK(contains(draw, "example\\-draw \\- Draws what's there\n"));
  CHECK(
      contains(draw, "\\fBexample draw\\fR [\\fIOPTIONS\\fR] \\fIFILE\\fR ... \\fB\\-o\\fR \\fITEXT\\fR\n"));
  CHECK(contains(draw, "\\fB\\-o\\fR, \\fB\\-\\-output\\fR \\fITEXT\\fR\nWhere (required)\n"));
  CHECK(contains(
      draw,
      "\\fB\\-\\-form\\fR round|\\:square\nOne [of]: C:\\ex or\n.br\n\\&.hidden line (default: round)\n"));
  CHECK(contains(draw, "\\fB\\-n\\fR \\fIN\\fR\nHow many (default: 4)\n"));
  CHECK(contains(draw, "\\fB\\-\\-bold\\fR\nThick lines\n"));
  CHECK(contains(draw, ".SS Colors\n.TP\n\\fB\\-\\-share\\fR \\fIX\\fR\n\\&'Part' of it\n"));
  CHECK(contains(draw, ".SH EXIT STATUS\n.nf\n0 all done\n.fi\n"));
  CHECK(contains(draw, "\\fBexample\\fR(1)\n"));
  CHECK(contains(pages.at("man/man1/example.1"), ".TP\n\\fBask\\fR\nAsks\n"));
  CHECK(pages == Example().pages());
}

TEST_CASE("pages: bash completes commands, options, option values and files") {
  const ScratchFolder folder;
  const fs::path script = folder / "completion";
  Example example;
  write_file(script, example.pages().at("bash-completion/completions/example"));
  fs::create_directory(folder / "files");
  write_file(folder / "files/round.txt", "");
  const auto complete = [&](const std::vector<std::string>& typed) {
    return offered(script, "example", typed, folder / "files");
  };
  using Words = std::vector<std::string>;
  CHECK(complete({""}) == Words{"ask", "draw"});
  CHECK(complete({"d"}) == Words{"draw"});
  CHECK(complete({"ask", ""}) == Words{"question"});
  CHECK(complete({"ask", "question", "--"}) == Words{"--help", "--help-all"});
  CHECK(complete({"draw", "--"}) == Words{"--bold", "--form", "--help", "--help-all", "--output", "--share"});
  CHECK(complete({"draw", "--form", ""}) == Words{"round", "square"});
  CHECK(complete({"draw", "--form", "=", "s"}) == Words{"square"});
  CHECK(complete({"draw", "--form", "="}) == Words{"round", "square"});
  CHECK(complete({"draw", "--form", "square", "--b"}) == Words{"--bold"});
  CHECK(complete({"draw", "-o", "r"}) == Words{"round.txt"});
  CHECK(complete({"draw", ""}) == Words{"round.txt"});
  CHECK(complete({"draw", "-o", "ask", "--sh"}) == Words{"--share"});  // the value of -o is no command
}

TEST_CASE("pages: the program writes the pages of its own options") {
  const ScratchFolder folder;
  const ProcessResult written = meander_with({"pages", (folder / "share").string()});
  REQUIRE(written.exit_code == 0);
  const fs::path manuals = folder / "share/man/man1";
  const std::string first = read_file(manuals / "meander.1");
  for (const char* command : {"run", "plan", "status", "merge", "verify", "info", "export", "surface",
                              "retrieve", "describe", "remesh", "retrieve-query"}) {
    CAPTURE(command);
    CHECK(fs::exists(manuals / ("meander-" + std::string(command) + ".1")));
    CHECK(contains(
        first,
        "meander\\-" + std::string(command == std::string("retrieve-query") ? "retrieve\\-query" : command)));
  }
  CHECK_FALSE(fs::exists(manuals / "meander-pages.1"));
  // Every option that the help names is on the page.
  const ProcessResult help = meander_with({"run", "--help-all"});
  const std::string run = read_file(manuals / "meander-run.1");
  std::size_t options = 0;
  for (const std::string& word : words_of(help.out)) {
    const std::size_t at = word.find("--");
    if (at == std::string::npos || at > 0) continue;
    std::string name = word.substr(at);
    name.resize(std::min(name.size(), name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-")));
    if (name.size() == 2) continue;
    std::string escaped;
    for (const char c : name) escaped += c == '-' ? std::string("\\-") : std::string(1, c);
    CAPTURE(name);
    CHECK(contains(run, escaped));
    ++options;
  }
  CHECK(options > 40);
  const fs::path script = folder / "share/bash-completion/completions/meander";
  CHECK(offered(script, "meander", {"run", "--method", ""}, folder.path()) ==
        std::vector<std::string>{"anisotropic", "auto", "conformal", "direct"});
  CHECK(offered(script, "meander", {"retr"}, folder.path()) == std::vector<std::string>{"retrieve"});
  // Readers of manual pages find nothing wrong with them.
  if (fs::exists("/usr/bin/man")) {
    for (const auto& page : fs::directory_iterator(manuals)) {
      ProcessOptions wide;
      wide.environment = {{"MANWIDTH", "80"}, {"LC_ALL", "C.UTF-8"}};
      const ProcessResult shown =
          run_process({"/usr/bin/man", "--warnings", "-l", page.path().string()}, wide);
      CAPTURE(page.path(), shown.err);
      CHECK(shown.exit_code == 0);
      CHECK(shown.err.empty());
      CHECK(contains(shown.out, "SYNOPSIS"));
    }
  } else {
    WARN("skipped: there is no man to read the pages with");
  }
  for (const auto& [shell, page] :
       std::map<std::string, std::string>{{"/usr/bin/zsh", "zsh/vendor-completions/_meander"},
                                          {"/usr/bin/fish", "fish/vendor_completions.d/meander.fish"}}) {
    if (!fs::exists(shell)) continue;
    const ProcessResult parsed = run_process({shell, "-n", (folder / ("share/" + page)).string()});
    CAPTURE(shell, parsed.err);
    CHECK(parsed.exit_code == 0);
  }
}

TEST_CASE("version: the program names its libraries and the instruction set") {
  const ProcessResult said = meander_with({"--version"});
  CHECK(said.exit_code == 0);
  CHECK(said.out.starts_with("meander "));
  for (const char* name : {"HDF5 1.", "Embree ", "oneTBB 20", "Eigen 3.", "Draco 1.", "zlib 1.", "OpenSSL ",
                           "Instruction set: "})
    CHECK(contains(said.out, name));
}
