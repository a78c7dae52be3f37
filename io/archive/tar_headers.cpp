#include "io/archive/tar_headers.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>

namespace meander {

namespace {

constexpr std::uint64_t block = 512;
constexpr std::uint64_t most_header_bytes = std::uint64_t{1} << 20;  // of long names and pax headers
constexpr std::uint64_t most_bytes = std::uint64_t{1} << 60;         // beyond this, sizes are damage

struct Damaged {
  std::string what;
};

std::string_view field(std::string_view header, std::size_t at, std::size_t length) {
  const std::string_view whole = header.substr(at, length);
  return whole.substr(0, whole.find('\0'));
}

// Octal digits between blanks, or base 256 behind a first byte of 0x80.
std::uint64_t number(std::string_view header, std::size_t at, std::size_t length) {
  const std::string_view bytes = header.substr(at, length);
  std::uint64_t value = 0;
  if ((static_cast<unsigned char>(bytes[0]) & 0x80) != 0) {
    if (static_cast<unsigned char>(bytes[0]) != 0x80) throw Damaged{"a size is negative"};
    for (const char c : bytes.substr(1)) {
      if (value >= most_bytes >> 8) throw Damaged{"a size is too large"};
      value = value << 8 | static_cast<unsigned char>(c);
    }
    return value;
  }
  std::string_view digits = field(header, at, length);
  while (digits.starts_with(' ')) digits.remove_prefix(1);
  while (digits.ends_with(' ')) digits.remove_suffix(1);
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value, 8);
  if (!digits.empty() && (error != std::errc() || end != digits.data() + digits.size()))
    throw Damaged{"a size is not a number"};
  return value;
}

bool has_checksum(std::string_view header) {
  constexpr std::size_t at = 148, length = 8;
  std::uint64_t sum = 0, signed_bytes = 0;  // of bytes >= 0x80, that some programs count as negative
  for (std::size_t i = 0; i < block; ++i) {
    const bool in_field = i >= at && i < at + length;
    const unsigned value = in_field ? ' ' : static_cast<unsigned char>(header[i]);
    sum += value;
    signed_bytes += value >= 0x80;
  }
  try {
    const std::uint64_t stated = number(header, at, length);
    return stated == sum || stated + 256 * signed_bytes == sum;
  } catch (const Damaged&) {
    return false;
  }
}

// What the headers in front of a member say of it.
struct Extended {
  std::string path, link;
  bool has_path = false, has_link = false, has_bytes = false, sparse = false;
  std::uint64_t bytes = 0;
};

void take_pax_record(std::string_view key, std::string_view value, Extended& extended) {
  if (key == "path") {
    extended.path = value;
    extended.has_path = true;
  } else if (key == "linkpath") {
    extended.link = value;
    extended.has_link = true;
  } else if (key == "size") {
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), extended.bytes);
    if (error != std::errc() || end != value.data() + value.size()) throw Damaged{"a size is not a number"};
    extended.has_bytes = true;
  } else if (key.starts_with("GNU.sparse.")) {
    extended.sparse = true;
  }
}

// Records as "LENGTH KEY=VALUE\n", the length being that of the record.
void take_pax(std::string_view records, Extended& extended) {
  while (!records.empty()) {
    std::size_t length = 0;
    const char* const begin = records.data();
    const auto [end, error] = std::from_chars(begin, begin + records.size(), length);
    const auto digits = static_cast<std::size_t>(end - begin);
    if (error != std::errc() || length > records.size() || length < digits + 3 || records[digits] != ' ' ||
        records[length - 1] != '\n')
      throw Damaged{"a pax header is damaged"};
    const std::string_view record = records.substr(digits + 1, length - digits - 2);
    const std::size_t equals = record.find('=');
    if (equals == std::string_view::npos) throw Damaged{"a pax header is damaged"};
    take_pax_record(record.substr(0, equals), record.substr(equals + 1), extended);
    records.remove_prefix(length);
  }
}

class TarPass {
 public:
  explicit TarPass(const ByteSource& archive) : archive_(archive) {}

  ArchiveListing run() {
    try {
      while (take_block()) {
      }
    } catch (const Damaged& damage) {
      if (!begun_) throw ItemError(Status::unreadable, "this is no tar archive");
      stop(damage.what);
    } catch (const ItemError& error) {
      if (!begun_) throw;
      stop(error.what());
    }
    return std::move(listing_);
  }

 private:
  void stop(const std::string& what) {
    listing_.problem = fmt::format("{}, at byte {} of the archive", what, at_);
    if (open_) open_->refuse(Status::unreadable, "damaged or cut: the archive cannot be read to its end");
  }

  // One header and what belongs to it; false at the end.
  bool take_block() {
    const std::string header = archive_.read(at_, block);
    if (header.size() < block) {
      throw Damaged{header.empty() ? "it ends without an end mark" : "it ends within a header"};
    }
    if (header.find_first_not_of('\0') == std::string::npos) {  // an archive may be empty
      begun_ = true;
      return false;
    }
    if (!has_checksum(header)) throw Damaged{"a header is damaged"};
    begun_ = true;
    const char type = header[156];
    const bool extends = type == 'x' || type == 'g' || type == 'L' || type == 'K';
    std::uint64_t bytes = number(header, 124, 12);
    if (!extends && extended_.has_bytes) bytes = extended_.bytes;
    if (bytes > most_bytes) throw Damaged{"a size is too large"};
    const std::uint64_t data = at_ + block;
    if (extends) {
      take_extension(type, data, bytes);
    } else {
      // Links and folders have no bytes, whatever size is stated.
      if (type >= '1' && type <= '6') bytes = 0;
      add_member(header, type, data, bytes);
      extended_ = {};
      skip(data, bytes);
    }
    at_ = data + (bytes + block - 1) / block * block;
    open_ = nullptr;
    return true;
  }

  void take_extension(char type, std::uint64_t data, std::uint64_t bytes) {
    if (bytes > most_header_bytes) throw Damaged{"a header is too long"};
    const std::string text = archive_.read(data, static_cast<std::size_t>(bytes));
    if (text.size() < bytes) throw Damaged{"it ends within a header"};
    if (type == 'x') take_pax(text, extended_);
    if (type == 'L') {
      extended_.path = text.substr(0, text.find('\0'));
      extended_.has_path = true;
    }
    if (type == 'K') {
      extended_.link = text.substr(0, text.find('\0'));
      extended_.has_link = true;
    }
  }

  void add_member(std::string_view header, char type, std::uint64_t data, std::uint64_t bytes) {
    std::string path(field(header, 0, 100));
    if (header.substr(257, 6) == std::string_view("ustar\0", 6) && header[345] != '\0')
      path = std::string(field(header, 345, 155)) + "/" + path;
    if (extended_.has_path) path = extended_.path;
    if (type == '5' || path.ends_with('/')) return;
    ArchiveMember member;
    name_member(member, path);
    member.offset = data;
    member.bytes = member.packed_bytes = bytes;
    switch (type) {
      case '0':
      case '7':
      case '\0':
        if (extended_.sparse) member.refuse(Status::unsupported_format, "a sparse file in a tar archive");
        break;
      case '1':
        link(member, extended_.has_link ? extended_.link : std::string(field(header, 157, 100)));
        break;
      case '2':
        member.refuse(Status::unreadable, "a symbolic link: links in archives are not followed");
        break;
      case 'S':
        member.refuse(Status::unsupported_format, "a sparse file in a tar archive");
        break;
      case '3':
      case '4':
      case '6':
        member.refuse(Status::unreadable, "not a regular file");
        break;
      default:  // volume labels and the like
        return;
    }
    listing_.members.push_back(std::move(member));
    open_ = &listing_.members.back();
    position_[open_->name] = listing_.members.size() - 1;
  }

  void link(ArchiveMember& member, const std::string& target) {
    const auto found = position_.find(member_path(target).path);
    if (found == position_.end()) {
      member.refuse(Status::unreadable, "a link to a file that the archive does not have before it");
      return;
    }
    const ArchiveMember& other = listing_.members[found->second];
    member.offset = other.offset;
    member.bytes = member.packed_bytes = other.bytes;
    if (other.status != Status::ok) member.refuse(other.status, other.reason);
  }

  // Makes sure that the bytes are there.
  void skip(std::uint64_t data, std::uint64_t bytes) {
    if (bytes > 0 && archive_.read(data + bytes - 1, 1).empty()) throw Damaged{"it ends within a member"};
  }

  const ByteSource& archive_;
  ArchiveListing listing_;
  std::map<std::string, std::size_t> position_;  // of members, by name
  ArchiveMember* open_ = nullptr;                // whose bytes have not been seen yet
  Extended extended_;
  std::uint64_t at_ = 0;
  bool begun_ = false;  // the first header is one
};

}  // namespace

ArchiveListing read_tar_headers(const ByteSource& archive) { return TarPass(archive).run(); }

}  // namespace meander
