// Classification files of the Princeton Shape Benchmark (.cla).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace meander {

struct Classification {
  struct Model {
    std::string name;  // as written: a number in the benchmark itself, any word in its followers
    std::uint32_t label = 0;
  };
  // As written; a name that several classes bear has its parent before it (`parent/name`).
  std::vector<std::string> classes;
  std::vector<Model> models;  // in the order of the file
};

// `PSB 1`, then `classes models`, then per class: `name parent count` and `count` model names. Free white
// space. Throws UsageError with the place of the mistake.
Classification read_classification(const std::filesystem::path& file);

}  // namespace meander
