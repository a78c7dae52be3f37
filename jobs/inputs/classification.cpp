#include "jobs/inputs/classification.h"

#include <map>
#include <sstream>

#include "io/file/file_error.h"
#include "io/file/read_file.h"
#include "io/utf8.h"
#include "jobs/cli/usage_error.h"

namespace meander {

Classification read_classification(const std::filesystem::path& file) {
  std::istringstream in = [&] {
    try {
      return std::istringstream(std::string(without_byte_order_mark(content_of_file(file))));
    } catch (const FileError& error) {
      throw UsageError("cannot open `" + file.string() + "`: " + error.code().message());
    }
  }();
  std::string magic, version;
  std::uint64_t classes = 0, models = 0;
  if (!(in >> magic >> version >> classes >> models) || magic != "PSB")
    throw UsageError("`" + file.string() + "` is not a Princeton .cla file");
  Classification result;
  std::vector<std::string> parents;
  std::map<std::string, std::size_t> uses;
  for (std::uint64_t c = 0; c < classes; ++c) {
    std::string name, parent;
    std::uint64_t members = 0;
    if (!(in >> name >> parent >> members))
      throw UsageError("`" + file.string() + "` ends in class " + std::to_string(c + 1) + " of " +
                       std::to_string(classes));
    for (std::uint64_t m = 0; m < members; ++m) {
      std::string model;
      if (!(in >> model))
        throw UsageError("`" + file.string() + "`: class `" + name + "` ends before its " +
                         std::to_string(members) + " models");
      result.models.push_back({model, static_cast<std::uint32_t>(c)});
    }
    ++uses[name];
    result.classes.push_back(name);
    parents.push_back(parent);
  }
  for (std::size_t c = 0; c < result.classes.size(); ++c)
    if (uses[result.classes[c]] > 1) result.classes[c] = parents[c] + "/" + result.classes[c];
  if (result.models.size() != models)
    throw UsageError("`" + file.string() + "` promises " + std::to_string(models) + " models and lists " +
                     std::to_string(result.models.size()));
  return result;
}

}  // namespace meander
