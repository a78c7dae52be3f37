#include "io/json/json_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "kernels/core/status.h"

namespace meander {

// Takes the values as the parser meets them.
class TreeBuilder : public nlohmann::json_sax<nlohmann::json> {
 public:
  explicit TreeBuilder(JsonTree& tree) : tree_(tree) {}
  const std::string& problem() const { return problem_; }

  bool null() override { return add(JsonTree::Kind::null); }
  bool boolean(bool value) override {
    add(JsonTree::Kind::truth);
    tree_.nodes_.back().truth = value;
    return true;
  }
  bool number_integer(number_integer_t value) override { return add_number(static_cast<double>(value)); }
  bool number_unsigned(number_unsigned_t value) override { return add_number(static_cast<double>(value)); }
  bool number_float(number_float_t value, const string_t&) override { return add_number(value); }
  bool string(string_t& value) override {
    add(JsonTree::Kind::text);
    tree_.nodes_.back().text = keep(value);
    return true;
  }
  bool binary(binary_t&) override { return false; }
  bool start_object(std::size_t) override { return open(JsonTree::Kind::object); }
  bool end_object() override { return close(); }
  bool start_array(std::size_t) override { return open(JsonTree::Kind::array); }
  bool end_array() override { return close(); }
  bool key(string_t& name) override {
    name_ = keep(name);
    return true;
  }
  bool parse_error(std::size_t at, const std::string&, const nlohmann::detail::exception&) override {
    problem_ = fmt::format("not valid JSON (wrong at byte {})", at);
    return false;
  }

 private:
  JsonTree::Text keep(const std::string& text) {
    const JsonTree::Text kept{static_cast<std::uint32_t>(tree_.characters_.size()),
                              static_cast<std::uint32_t>(text.size())};
    tree_.characters_ += text;
    return kept;
  }
  bool add(JsonTree::Kind kind) {
    JsonTree::Node& node = tree_.nodes_.emplace_back();
    node.kind = kind;
    node.name = name_;
    node.end = static_cast<std::uint32_t>(tree_.nodes_.size());
    name_ = {};
    return true;
  }
  bool add_number(double value) {
    add(JsonTree::Kind::number);
    tree_.nodes_.back().number = value;
    return true;
  }
  bool open(JsonTree::Kind kind) {
    if (open_.size() == JsonTree::most_depth) {
      problem_ = fmt::format("its JSON nests deeper than {} levels", JsonTree::most_depth);
      return false;
    }
    add(kind);
    open_.push_back(tree_.nodes_.size() - 1);
    return true;
  }
  bool close() {
    tree_.nodes_[open_.back()].end = static_cast<std::uint32_t>(tree_.nodes_.size());
    open_.pop_back();
    return true;
  }

  JsonTree& tree_;
  JsonTree::Text name_;
  std::vector<std::size_t> open_;
  std::string problem_;
};

JsonTree::JsonTree(std::string_view text) {
  if (text.size() >= ~std::uint32_t{0})
    throw ItemError(Status::unsupported_format, "4 GiB of JSON or more are not read");
  // No value begins without one of these in front, but the first.
  nodes_.reserve(1 + static_cast<std::size_t>(std::count_if(
                         text.begin(), text.end(), [](char c) { return c == ',' || c == '[' || c == '{'; })));
  TreeBuilder builder(*this);
  if (!nlohmann::json::sax_parse(text.begin(), text.end(), &builder))
    throw ItemError(Status::unreadable, builder.problem());
}

std::vector<std::string_view> JsonTree::members_of_all(std::string_view name,
                                                       std::string_view skipped) const {
  std::vector<std::string_view> names;
  for (std::uint32_t at = 0; at < nodes_.size();) {
    const Node& node = nodes_[at];
    const std::string_view own = characters(node.name);
    if (own == name && node.kind == Kind::object)
      for (std::uint32_t member = at + 1; member < node.end; member = nodes_[member].end)
        names.push_back(characters(nodes_[member].name));
    at = own == skipped ? node.end : at + 1;
  }
  return names;
}

bool JsonValue::is_object() const {
  return tree_ != nullptr && tree_->nodes_[node_].kind == JsonTree::Kind::object;
}

bool JsonValue::is_array() const {
  return tree_ != nullptr && tree_->nodes_[node_].kind == JsonTree::Kind::array;
}

JsonValue JsonValue::member(std::string_view name) const {
  if (!is_object()) return {};
  const std::uint32_t end = tree_->nodes_[node_].end;
  for (std::uint32_t at = node_ + 1; at < end; at = tree_->nodes_[at].end)
    if (tree_->characters(tree_->nodes_[at].name) == name) return {tree_, at};
  return {};
}

std::vector<JsonValue> JsonValue::items() const {
  std::vector<JsonValue> values;
  if (!is_object() && !is_array()) return values;
  const std::uint32_t end = tree_->nodes_[node_].end;
  for (std::uint32_t at = node_ + 1; at < end; at = tree_->nodes_[at].end) values.push_back({tree_, at});
  return values;
}

std::string_view JsonValue::name() const {
  return tree_ == nullptr ? std::string_view() : tree_->characters(tree_->nodes_[node_].name);
}

std::optional<std::string_view> JsonValue::text() const {
  if (tree_ == nullptr || tree_->nodes_[node_].kind != JsonTree::Kind::text) return std::nullopt;
  return tree_->characters(tree_->nodes_[node_].text);
}

std::optional<double> JsonValue::number() const {
  if (tree_ == nullptr || tree_->nodes_[node_].kind != JsonTree::Kind::number) return std::nullopt;
  return tree_->nodes_[node_].number;
}

std::optional<bool> JsonValue::truth() const {
  if (tree_ == nullptr || tree_->nodes_[node_].kind != JsonTree::Kind::truth) return std::nullopt;
  return tree_->nodes_[node_].truth;
}

std::optional<std::uint64_t> JsonValue::count() const {
  const std::optional<double> value = number();
  if (!value || !(*value >= 0 && *value <= 9007199254740992.0) || std::floor(*value) != *value)
    return std::nullopt;
  return static_cast<std::uint64_t>(*value);
}

}  // namespace meander
