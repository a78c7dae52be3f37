// Reading JSON: objects with typed access to their members. Writing it: io/json_writer.h.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace meander {

// One object, whose members are looked up by name. Errors name `source`, the file or the part of one that the
// text stands in.
class JsonObject {
 public:
  // Throws RunError(unusable) when the text is anything but one JSON object (RFC 8259), blanks around it
  // aside.
  JsonObject(std::string_view text, std::string source);

  // By ascending name, each value exactly as it is written in the text (an object or a list is one value). Of
  // members with the same name the last counts.
  const std::map<std::string, std::string>& members() const { return members_; }

  // Empty where there is no such member; throws RunError(unusable) when its value is of another type, or
  // beyond the range of the type.
  std::optional<std::string> text(const std::string& name) const;
  std::optional<std::int64_t> integer(const std::string& name) const;

 private:
  std::map<std::string, std::string> members_;
  std::string source_;
};

}  // namespace meander
