// Small files of values that stand beside a store: a magic, values in the order they were put in,
// little-endian, and the SHA-256 of all before it. A file that is cut short, damaged or of another kind is
// refused.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace meander {

using Seal = std::array<std::uint8_t, 32>;
Seal seal_of(std::string_view bytes);

// Values that can be copied byte by byte, one behind the other.
class ValueBytes {
 public:
  explicit ValueBytes(std::string_view begin = {}) : bytes_(begin) {}

  template <class Value>
  void put(const Value& value) {
    static_assert(std::is_trivially_copyable_v<Value>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  template <class Value>
  void put_all(std::span<const Value> values) {
    static_assert(std::is_trivially_copyable_v<Value>);
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  }
  void put_text(std::string_view text) { bytes_ += text; }
  Seal seal() const { return seal_of(bytes_); }
  // Adds the seal and writes all in place of the file. Throws FileError.
  void write_sealed(const std::filesystem::path& path);

 private:
  std::string bytes_;
};

// How a file is refused: "`PATH` is not KIND: WHY", and what helps.
struct SealedKind {
  std::string_view magic, kind, help = {};
};

// Takes the values of such a file from the front. `bytes`: its content, which must live as long. Throws
// RunError(unusable), at once where the magic or the seal is another.
class SealedBytes {
 public:
  SealedBytes(const std::filesystem::path& path, const SealedKind& kind, std::string_view bytes);

  template <class Value>
  Value take() {
    Value value;
    std::memcpy(&value, take_bytes(sizeof value, 1).data(), sizeof value);
    return value;
  }
  template <class Value>
  std::vector<Value> take_all(std::uint64_t count) {
    const std::string_view bytes = take_bytes(sizeof(Value), count);
    std::vector<Value> values(count);
    if (count > 0) std::memcpy(values.data(), bytes.data(), bytes.size());
    return values;
  }
  // Refuses a file that goes on: "something follows its last WHAT".
  void end(std::string_view what) const;
  [[noreturn]] void refuse(const std::string& why) const;

 private:
  std::string_view take_bytes(std::size_t each, std::uint64_t count);

  std::filesystem::path path_;
  SealedKind kind_;
  std::string_view rest_;
};

}  // namespace meander
