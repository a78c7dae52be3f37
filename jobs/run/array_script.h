// Scripts that run an array of `meander plan` under a scheduler.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace meander {

// The run of a script. Both paths are absolute, since a scheduler starts the script in a folder of its own.
struct ArrayScript {
  std::filesystem::path program, store;
  std::uint64_t shards = 1, shards_per_task = 1;
};

// The schedulers that have scripts.
std::vector<std::string> script_schedulers();

// The script for one of them. Throws UsageError when it cannot name a path: Kubernetes accepts only UTF-8.
std::string array_script(const std::string& scheduler, const ArrayScript& run);

// The file of the running program, absolute and without links. Throws UsageError when it is not known,
// because it was replaced or removed meanwhile, or there is no /proc.
std::filesystem::path running_program();

// The text as one word of a shell, in single quotes if any character needs them.
std::string shell_word(const std::string& text);

// The UTF-8 text as a string that JSON and YAML read alike. Every $ is doubled, since Kubernetes replaces
// $(NAME) in commands.
std::string kubernetes_word(const std::string& text);

}  // namespace meander
