#include "io/json/json_reader.h"

#include <fmt/format.h>

#include <cstddef>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "io/run_error.h"

namespace meander {

namespace {

// Goes through a text and counts the characters taken, whichever of its copies takes them.
class CountingIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  CountingIterator(const char* at, std::size_t& taken) : at_(at), taken_(&taken) {}
  reference operator*() const { return *at_; }
  CountingIterator& operator++() {
    ++at_;
    ++*taken_;
    return *this;
  }
  [[maybe_unused]] CountingIterator operator++(int) {  // which every iterator has
    CountingIterator before = *this;
    ++*this;
    return before;
  }
  bool operator==(const CountingIterator& other) const { return at_ == other.at_; }

 private:
  const char* at_;
  std::size_t* taken_;
};

// Notes where the values of the outermost object begin and end. The parser takes no character ahead, but for
// numbers, whose end only the next one shows.
class MemberScan : public nlohmann::json_sax<nlohmann::json> {
 public:
  MemberScan(std::string_view text, std::map<std::string, std::string>& members)
      : text_(text), members_(members) {}

  bool scan() {
    return nlohmann::json::sax_parse(CountingIterator(text_.data(), taken_),
                                     CountingIterator(text_.data() + text_.size(), taken_), this) &&
           is_object_;
  }
  std::size_t taken() const { return taken_; }

  bool null() override { return value(); }
  bool boolean(bool) override { return value(); }
  bool string(string_t&) override { return value(); }
  bool binary(binary_t&) override { return false; }
  bool number_integer(number_integer_t) override { return value(1); }
  bool number_unsigned(number_unsigned_t) override { return value(1); }
  bool number_float(number_float_t, const string_t&) override { return value(1); }
  bool start_object(std::size_t) override {
    is_object_ = is_object_ || depth_ == 0;
    return open();
  }
  bool end_object() override { return close(); }
  bool start_array(std::size_t) override { return open(); }
  bool end_array() override { return close(); }
  bool key(string_t& name) override {
    if (depth_ != 1) return true;
    name_ = name;
    begin_ = taken_;
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception&) override {
    return false;
  }

 private:
  bool open() {
    ++depth_;
    return is_object_;
  }
  bool close() {
    --depth_;
    return value();
  }
  bool value(std::size_t ahead = 0) {
    if (depth_ != 1) return is_object_;
    // Before the value stands its colon.
    const std::size_t begin = text_.find_first_not_of(" \t\r\n:", begin_);
    members_[name_] = text_.substr(begin, taken_ - ahead - begin);
    return true;
  }

  std::string_view text_;
  std::map<std::string, std::string>& members_;
  std::string name_;
  std::size_t taken_ = 0, begin_ = 0, depth_ = 0;
  bool is_object_ = false;
};

}  // namespace

JsonObject::JsonObject(std::string_view text, std::string source) : source_(std::move(source)) {
  MemberScan members(text, members_);
  if (!members.scan())
    throw RunError(RunError::Kind::unusable, fmt::format("{}: not a JSON object (wrong at byte {} of {})",
                                                         source_, members.taken(), text.size()));
}

std::optional<std::string> JsonObject::text(const std::string& name) const {
  if (!members_.contains(name)) return std::nullopt;
  const auto value = nlohmann::json::parse(members_.at(name), nullptr, false);
  if (!value.is_string())
    throw RunError(RunError::Kind::unusable, fmt::format("{}: \"{}\" is not a text", source_, name));
  return value.get<std::string>();
}

std::optional<std::int64_t> JsonObject::integer(const std::string& name) const {
  if (!members_.contains(name)) return std::nullopt;
  const auto value = nlohmann::json::parse(members_.at(name), nullptr, false);
  // Whole numbers from 2^63 on are the unsigned type of the library.
  if (!value.is_number_integer() || (value.is_number_unsigned() && value.get<std::uint64_t>() > INT64_MAX))
    throw RunError(RunError::Kind::unusable,
                   fmt::format("{}: \"{}\" is not a whole number of 64 bits", source_, name));
  return value.get<std::int64_t>();
}

}  // namespace meander
