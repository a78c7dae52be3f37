// What the Python package makes signatures, docstrings and stubs of: the lists behind the command line, as
// JSON.
#pragma once

#include <string>

namespace meander {

// {"version": ..., "surfaces": [names], "descriptors": [names], "columns": [{dataset, array, type, width,
// doc, always, option}], and lists of settings, each {keyword, type, default, words, list, help}:
// "mesh_settings" of meshes that are given as arrays, "file_settings" of meshes that are read from files,
// "surface_settings", "remesh_settings"; and "run_options", the options of `meander run` in the same form,
// with "option" and "truth"}.
std::string about_text();

}  // namespace meander
