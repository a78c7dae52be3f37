// The parameters of a store, one line of JSON, as text that can be changed member by member.
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace meander {

// The members of one JSON object, as JsonObject (io/json/json_reader.h) has them.
// Throws RunError(unusable) when the text is not a JSON object.
std::map<std::string, std::string> split_members(std::string_view json);

// The inverse, by ascending name: what JsonWriter writes for the same members.
std::string join_members(const std::map<std::string, std::string>& members);

// What differs between the parameters of two runs, every member, by ascending name: `parameter "seed" was 1,
// now it is 2; parameter "order" was not given, now it is "curve"`. A text that is not an object is shown
// whole. Empty when nothing differs.
std::string parameter_differences(std::string_view before, std::string_view now);

}  // namespace meander
