// Scripts that run an array of `meander plan` under a scheduler.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace meander {

// What a script is to run. A scheduler starts it in a folder, and with variables, of its own: both paths are
// absolute.
struct ArrayScript {
  std::filesystem::path program, store;
  std::uint64_t shards = 1, shards_per_task = 1;
};

// The schedulers that there are scripts for.
std::vector<std::string> script_schedulers();

// The script for one of them. Throws UsageError where it cannot name a path: Kubernetes takes UTF-8 alone.
std::string array_script(const std::string& scheduler, const ArrayScript& run);

// The file of the program that this process runs, absolute and without links, however it was started. Throws
// UsageError where it is not known: it was replaced or removed meanwhile, or there is no /proc.
std::filesystem::path running_program();

// The text as one word of a shell: in single quotes where any character needs them.
std::string shell_word(const std::string& text);

// The text, UTF-8, as a string that JSON and YAML read alike. Kubernetes replaces $(NAME) in commands, so a $
// is doubled.
std::string kubernetes_word(const std::string& text);

}  // namespace meander
