// The options for reading INPUT arguments, and the report on the inputs at the end.
#pragma once

#include <filesystem>
#include <string>

#include "io/json_writer.h"
#include "jobs/inputs/inputs.h"

namespace meander {

class Command;

// --root and --null.
void add_list_options(Command& command, InputOptions& options);
// --layout, --labels and --label-from-folder.
void add_label_options(Command& command, InputOptions& options);

// The root that the ids of lists had when `store` was made, from STORE.run.json; empty when that has none.
std::string remembered_root(const std::filesystem::path& store);

// Prints a line on standard error for each folder that could not be read.
void print_unread(const InputNotes& notes);
// Prints on standard output what was left out and how items were labeled, if anything.
void print_notes(const InputNotes& notes);
// Adds the same as members of the JSON object that is open.
void write_notes(JsonWriter& json, const InputNotes& notes);

}  // namespace meander
