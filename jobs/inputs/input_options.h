// The options that say how INPUT arguments are read, and the report on the inputs at the end.
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

// The root of the ids of lists when `store` was made, from STORE.run.json; empty where it does not say.
std::string remembered_root(const std::filesystem::path& store);

// On standard error, a line for each folder that could not be read.
void print_unread(const InputNotes& notes);
// On standard output, what was left out and how items were labelled; nothing where there is nothing to say.
void print_notes(const InputNotes& notes);
// The same as members of the JSON object that is open.
void write_notes(JsonWriter& json, const InputNotes& notes);

}  // namespace meander
