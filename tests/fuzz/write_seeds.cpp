// fuzz_seeds FOLDER: writes FOLDER/TARGET/seed-K for every target, and FOLDER/TARGET.dict.
#include <exception>
#include <filesystem>
#include <iostream>

#include "seeds.h"
#include "support/mesh_files.h"
#include "targets.h"

int main(int count, char** arguments) try {
  if (count != 2) {
    std::cerr << "usage: fuzz_seeds FOLDER\n";
    return 2;
  }
  const std::filesystem::path folder = arguments[1];
  for (const meander::fuzz::Target& target : meander::fuzz::targets()) {
    const std::string name(target.name);
    std::filesystem::create_directories(folder / name);
    std::size_t number = 0;
    for (const std::string& seed : meander::fuzz::seeds_of(name))
      meander::test::write_file(folder / name / ("seed-" + std::to_string(number++)), seed);
    meander::test::write_file(folder / (name + ".dict"), meander::fuzz::dictionary_of(name));
  }
  return 0;
} catch (const std::exception& error) {
  std::cerr << "fuzz_seeds: " << error.what() << "\n";
  return 1;
}
