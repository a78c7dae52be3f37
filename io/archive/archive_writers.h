// Archives as outputs: members without compression, and nothing in them that changes from run to run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

namespace meander {

// Takes the bytes of an archive, one piece behind the other.
using PutBytes = std::function<void(std::string_view)>;

// A tar archive (POSIX.1-1988 ustar) of regular files of mode 644, of nobody and of 1 January 1970.
class TarWriter {
 public:
  explicit TarWriter(PutBytes put) : put_(std::move(put)) {}
  // A member of these pieces. The name has 1 to 100 bytes. Members of 8 GiB and more are no ustar:
  // std::invalid_argument for both.
  void add(std::string_view name, std::initializer_list<std::string_view> pieces);
  void finish();  // once, behind the last member
  // What a member of that many bytes takes in the archive.
  static std::uint64_t member_bytes(std::uint64_t bytes);

 private:
  PutBytes put_;
};

// A zip archive of stored members of 1 January 1980. As without ZIP64 nothing reaches 4 GiB: add() and
// finish() throw std::length_error where a member or the archive would.
class StoredZipWriter {
 public:
  explicit StoredZipWriter(PutBytes put) : put_(std::move(put)) {}
  void add(std::string_view name, std::initializer_list<std::string_view> pieces);
  void finish();

 private:
  void put(std::string_view bytes);

  PutBytes put_;
  std::string directory_;
  std::uint64_t written_ = 0;
  std::uint16_t members_ = 0;
};

}  // namespace meander
