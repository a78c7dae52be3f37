// A JSON text as a tree of values, for files of models: bounded in depth and memory, whatever the text says.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace meander {

class JsonTree;

// One value of a tree, or none (of a member that is not there). Valid as long as its tree.
class JsonValue {
 public:
  JsonValue() = default;

  explicit operator bool() const { return tree_ != nullptr; }
  bool is_object() const;
  bool is_array() const;
  // The member of an object; an empty value if there is none, or if this is no object. The first counts if
  // several share the name. Cost: the number of members.
  JsonValue member(std::string_view name) const;
  // The values of an array, or of the members of an object, in the order of the text; empty of any other
  // value.
  std::vector<JsonValue> items() const;
  // The name of this value in its object; empty in an array.
  std::string_view name() const;
  // Empty when the value is of another type.
  std::optional<std::string_view> text() const;
  std::optional<double> number() const;
  std::optional<bool> truth() const;
  // Whole numbers from 0 to 2^53, which double has exactly; also written as 3.0.
  std::optional<std::uint64_t> count() const;

 private:
  friend class JsonTree;
  JsonValue(const JsonTree* tree, std::uint32_t node) : tree_(tree), node_(node) {}

  const JsonTree* tree_ = nullptr;
  std::uint32_t node_ = 0;
};

class JsonTree {
 public:
  static constexpr std::size_t most_depth = 200;
  // What the tree of a text can take beside the text: each value is two characters or more.
  static constexpr std::uint64_t most_bytes_per_character = 16;

  // Throws ItemError(unreadable) when the text is not one JSON value (RFC 8259) with numbers that double can
  // hold, or nests deeper than most_depth; unsupported_format from 2^32 characters on.
  explicit JsonTree(std::string_view text);
  JsonTree(const JsonTree&) = delete;
  JsonTree& operator=(const JsonTree&) = delete;

  JsonValue root() const { return {this, 0}; }
  // The names of the members of all objects of this name, each once per object, in the order of the text, but
  // of those inside a value named `skipped`. O(values).
  std::vector<std::string_view> members_of_all(std::string_view name, std::string_view skipped) const;
  std::uint64_t memory_bytes() const { return nodes_.capacity() * sizeof(Node) + characters_.capacity(); }

 private:
  friend class JsonValue;
  friend class TreeBuilder;
  enum class Kind : std::uint8_t { null, truth, number, text, array, object };
  struct Text {
    std::uint32_t begin = 0, bytes = 0;
  };
  // In the order of the text; the values inside one follow it, up to `end`.
  struct Node {
    Text name;
    union {
      double number;
      Text text;
    };
    std::uint32_t end = 0;
    Kind kind = Kind::null;
    bool truth = false;

    Node() : number(0) {}
  };

  std::string_view characters(Text text) const {
    return std::string_view(characters_).substr(text.begin, text.bytes);
  }

  std::vector<Node> nodes_;
  std::string characters_;  // of all names and texts
};

}  // namespace meander
