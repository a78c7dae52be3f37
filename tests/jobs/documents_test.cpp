// The documents against the tree.
#include <algorithm>
#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include "support/catch.h"
#include "support/scratch_files.h"

using namespace meander;
using namespace meander::test;

namespace fs = std::filesystem;

TEST_CASE("documents: every path of a source that they name exists") {
  const fs::path root = MEANDER_SOURCE_DIR;
  // Relative to the root, to kernels, or, of a test or a source named beside others, to the folder of the
  // test.
  const std::vector<fs::path> folders = {root, root / "kernels", root / "docs", root / "bench",
                                         root / "jobs"};
  const std::regex path("`([a-z_0-9]+/[a-z_0-9/]*[a-z_0-9]+\\.(?:h|cpp|py|cmake))`");
  std::vector<fs::path> documents = {root / "README.md", root / "CONTRIBUTING.md", root / "bench/README.md"};
  for (const auto& entry : fs::directory_iterator(root / "docs"))
    if (entry.path().extension() == ".md") documents.push_back(entry.path());
  std::size_t named = 0;
  for (const fs::path& document : documents) {
    const std::string text = read_file(document);
    for (std::sregex_iterator at(text.begin(), text.end(), path), end; at != end; ++at, ++named) {
      const std::string name = (*at)[1];
      INFO(document.filename().string() << " names " << name);
      CHECK(std::any_of(folders.begin(), folders.end(),
                        [&](const fs::path& folder) { return fs::exists(folder / name); }));
    }
  }
  CHECK(named > 100);
}
