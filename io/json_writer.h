// Writing JSON, one value after the other; numbers as shortest round-trip decimals, strings as UTF-8 (bytes
// that are not UTF-8 are escaped as U+FFFD so that the result is always valid).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace meander {

// Builds one JSON text. Commas and colons are placed by the writer:
//   JsonWriter json; json.begin_object(); json.key("n"); json.value(3); json.end_object(); json.text() ==
//   R"({"n":3})"
class JsonWriter {
 public:
  void begin_object() { open('{'); }
  void end_object() { close('}'); }
  void begin_array() { open('['); }
  void end_array() { close(']'); }
  void key(std::string_view name);
  void value(std::string_view text);
  void value(const char* text) { value(std::string_view(text)); }
  void value(const std::string& text) { value(std::string_view(text)); }
  void value(bool flag);
  void null();
  void value(double number);  // null when not finite: JSON has no NaN
  void value(std::uint64_t number);
  void value(std::int64_t number);
  void value(std::uint32_t number) { value(std::uint64_t{number}); }
  void value(std::int32_t number) { value(std::int64_t{number}); }
  template <class T>
  void member(std::string_view name, const T& content) {
    key(name);
    value(content);
  }
  // A member that is an object, whose own members `write` adds.
  template <class Write>
  void object(std::string_view name, const Write& write) {
    key(name);
    begin_object();
    write();
    end_object();
  }
  // A member that is an array of values.
  template <class List>
  void list(std::string_view name, const List& values) {
    key(name);
    begin_array();
    for (const auto& one : values) value(one);
    end_array();
  }
  // A member that is an array of objects: `write` adds the members of each.
  template <class List, class Write>
  void list(std::string_view name, const List& values, const Write& write) {
    key(name);
    begin_array();
    for (const auto& one : values) {
      begin_object();
      write(one);
      end_object();
    }
    end_array();
  }
  const std::string& text() const { return text_; }

 private:
  void open(char bracket);
  void close(char bracket);
  void separate();
  std::string text_;
  bool first_ = true;  // nothing stands before the next value in the innermost bracket
  bool after_key_ = false;
};

// The text of one object, whose members `write(json)` adds.
template <class Write>
std::string json_object(const Write& write) {
  JsonWriter json;
  json.begin_object();
  write(json);
  json.end_object();
  return json.text();
}

}  // namespace meander
