#include "io/archive/zip_directory.h"

#include <fmt/format.h>
#include <libdeflate.h>

#include <algorithm>
#include <memory>
#include <new>
#include <numeric>
#include <optional>

#include "io/archive/little_endian.h"

namespace meander {

namespace {

constexpr std::string_view end_mark = "PK\5\6", end64_mark = "PK\6\6", locator_mark = "PK\6\7",
                           entry_mark = "PK\1\2", local_mark = "PK\3\4";
constexpr std::size_t end_bytes = 22, locator_bytes = 20, end64_bytes = 56, entry_bytes = 46,
                      local_bytes = 30;
constexpr std::uint64_t in_zip64 = 0xFFFFFFFF;  // the 32-bit field of what stands in the zip64 part

// Where the central directory is.
struct Directory {
  std::uint64_t offset = 0, bytes = 0, members = 0;
  std::uint64_t shift = 0;  // of all offsets in it: bytes in front of the archive
  bool wide = false;        // zip64: the number of members is not modulo 2^16
};

// The record that an archive ends with: where it stands and what it says.
struct EndRecord {
  std::uint64_t at = 0;
  std::string bytes;
};

std::optional<EndRecord> find_end(const ByteSource& archive) {
  constexpr std::size_t most_comment = 65535;
  const std::uint64_t size = archive.bytes();
  const std::uint64_t begin = size - std::min<std::uint64_t>(size, end_bytes + most_comment);
  const std::string tail = archive.read(begin, static_cast<std::size_t>(size - begin));
  if (tail.size() < end_bytes) return std::nullopt;
  for (std::size_t at = tail.size() - end_bytes + 1; at-- > 0;) {
    const std::string_view rest = std::string_view(tail).substr(at);
    if (rest.starts_with(end_mark) && end_bytes + little_endian(rest, 20, 2) <= rest.size())
      return EndRecord{begin + at, std::string(rest.substr(0, end_bytes))};
  }
  return std::nullopt;
}

// The zip64 record before the end, if there is one.
std::optional<EndRecord> find_end64(const ByteSource& archive, std::uint64_t end) {
  if (end < locator_bytes + end64_bytes) return std::nullopt;
  const std::uint64_t locator = end - locator_bytes;
  const std::string bytes = archive.read(locator, locator_bytes);
  if (!bytes.starts_with(locator_mark) || bytes.size() < locator_bytes) return std::nullopt;
  // Where it is said to be; in an archive behind other data directly in front of its locator.
  for (const std::uint64_t at : {little_endian(bytes, 8, 8), locator - end64_bytes}) {
    if (at > locator - end64_bytes) continue;
    std::string record = archive.read(at, end64_bytes);
    if (record.size() == end64_bytes && record.starts_with(end64_mark))
      return EndRecord{at, std::move(record)};
  }
  return std::nullopt;
}

// Throws ItemError where there is none.
Directory find_directory(const ByteSource& archive) {
  const auto damaged = [](const char* what) { return ItemError(Status::unreadable, what); };
  const std::optional<EndRecord> end = find_end(archive);
  if (!end)
    throw damaged("this is no zip archive, or its end is missing: the directory of the members is not there");
  Directory directory;
  directory.members = little_endian(end->bytes, 10, 2);
  directory.bytes = little_endian(end->bytes, 12, 4);
  directory.offset = little_endian(end->bytes, 16, 4);
  std::uint64_t limit = end->at;
  if (const std::optional<EndRecord> wide = find_end64(archive, end->at)) {
    directory.wide = true;
    directory.members = little_endian(wide->bytes, 32, 8);
    directory.bytes = little_endian(wide->bytes, 40, 8);
    directory.offset = little_endian(wide->bytes, 48, 8);
    limit = wide->at;
  }
  if (directory.bytes > limit || directory.offset > limit - directory.bytes)
    throw damaged("damaged: the directory of the zip archive is not where its end says");
  directory.shift = limit - directory.bytes - directory.offset;
  return directory;
}

// The values that the zip64 part of the extra field replaces; false when one is missing.
bool take_zip64(std::string_view extra, std::initializer_list<std::uint64_t*> values) {
  const bool needed = std::any_of(values.begin(), values.end(), [](const auto* v) { return *v == in_zip64; });
  if (!needed) return true;
  while (extra.size() >= 4) {
    const std::uint64_t kind = little_endian(extra, 0, 2), length = little_endian(extra, 2, 2);
    if (length > extra.size() - 4) return false;
    if (kind != 1) {
      extra.remove_prefix(4 + static_cast<std::size_t>(length));
      continue;
    }
    std::string_view part = extra.substr(4, static_cast<std::size_t>(length));
    for (std::uint64_t* value : values) {
      if (*value != in_zip64) continue;
      if (part.size() < 8) return false;
      *value = little_endian(part, 0, 8);
      part.remove_prefix(8);
    }
    return true;
  }
  return false;
}

std::string_view name_of_method(std::uint64_t method) {
  switch (method) {
    case 9:
      return "Deflate64";
    case 12:
      return "bzip2";
    case 14:
      return "LZMA";
    case 93:
      return "Zstandard";
    case 95:
      return "XZ";
    default:
      return "unknown";
  }
}

void check_member(ArchiveMember& member, std::uint64_t flags, std::uint64_t method) {
  if ((flags & 1) != 0) member.refuse(Status::unsupported_format, "encrypted: unpack the archive beforehand");
  if (method != 0 && method != 8)
    member.refuse(Status::unsupported_format,
                  fmt::format("packed by method {} ({}) of zip: only stored and deflated members are read",
                              method, name_of_method(method)));
  if (method == 0 && member.bytes != member.packed_bytes)
    member.refuse(Status::unreadable, "damaged: a stored member whose two sizes differ");
  if (is_bomb(member.packed_bytes, member.bytes))
    member.refuse(Status::unreadable, bomb_reason(member.packed_bytes, member.bytes));
}

// One entry at the front of `entries`, without its mark; empty: a folder. Returns its length, 0 when it is
// cut or damaged.
std::size_t take_entry(std::string_view entries, const Directory& directory,
                       std::optional<ArchiveMember>& member) {
  if (entries.size() < entry_bytes || !entries.starts_with(entry_mark)) return 0;
  const std::size_t name_bytes = little_endian(entries, 28, 2), extra_bytes = little_endian(entries, 30, 2);
  const std::size_t length = entry_bytes + name_bytes + extra_bytes + little_endian(entries, 32, 2);
  if (length > entries.size()) return 0;
  std::string name(entries.substr(entry_bytes, name_bytes));
  const std::uint64_t host = little_endian(entries, 5, 1);
  if (host == 0 && name.find('/') == std::string::npos) std::replace(name.begin(), name.end(), '\\', '/');
  if (name.ends_with('/')) return length;
  ArchiveMember& made = member.emplace();
  name_member(made, name);
  made.crc32 = static_cast<std::uint32_t>(little_endian(entries, 16, 4));
  made.packed_bytes = little_endian(entries, 20, 4);
  made.bytes = little_endian(entries, 24, 4);
  made.offset = little_endian(entries, 42, 4);
  const std::uint64_t method = little_endian(entries, 10, 2);
  made.deflated = method == 8;
  if (!take_zip64(entries.substr(entry_bytes + name_bytes, extra_bytes),
                  {&made.bytes, &made.packed_bytes, &made.offset}))
    made.refuse(Status::unreadable, "damaged: its zip64 sizes are missing");
  if (made.offset > directory.offset || made.packed_bytes > directory.offset - made.offset)
    made.refuse(Status::unreadable, "damaged: its bytes lie outside the archive");
  made.offset += directory.shift;
  constexpr std::uint64_t unix_host = 3, type_mask = 0170000, link_type = 0120000;
  if (host == unix_host && (little_endian(entries, 40, 2) & type_mask) == link_type)
    made.refuse(Status::unreadable, "a symbolic link: links in archives are not followed");
  check_member(made, little_endian(entries, 8, 2), method);
  return length;
}

// Members of which several take their bytes from one place.
void refuse_overlaps(std::vector<ArchiveMember>& members) {
  std::vector<std::size_t> order(members.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return members[a].offset != members[b].offset ? members[a].offset < members[b].offset : a < b;
  });
  std::uint64_t end = 0;
  std::size_t longest = 0;
  for (const std::size_t i : order) {
    ArchiveMember& member = members[i];
    if (member.status == Status::unreadable) continue;  // its place may be anything
    const auto overlaps = "damaged: its bytes overlap those of another member";
    if (member.offset < end) {
      member.refuse(Status::unreadable, overlaps);
      members[longest].refuse(Status::unreadable, overlaps);
    }
    const std::uint64_t own_end = member.offset + local_bytes + member.packed_bytes;
    if (own_end <= end) continue;
    end = own_end;
    longest = i;
  }
}

}  // namespace

ArchiveListing read_zip_directory(const ByteSource& archive, std::uint64_t most_bytes) {
  const Directory directory = find_directory(archive);
  if (directory.bytes > most_bytes)
    throw ItemError(Status::too_large, fmt::format("its directory has {} MiB, at most {} MiB are taken",
                                                   directory.bytes >> 20, most_bytes >> 20));
  const std::string bytes =
      archive.read(directory.shift + directory.offset, static_cast<std::size_t>(directory.bytes));
  ArchiveListing listing;
  std::string_view rest = bytes;
  std::uint64_t entries = 0;
  while (!rest.empty()) {
    std::optional<ArchiveMember> member;
    const std::size_t length = take_entry(rest, directory, member);
    if (length == 0) break;
    ++entries;
    rest.remove_prefix(length);
    if (member) listing.members.push_back(std::move(*member));
  }
  if (!rest.empty() || (directory.wide ? entries : entries & 0xFFFF) != directory.members)
    listing.problem = fmt::format("its directory is damaged after {} members", entries);
  refuse_overlaps(listing.members);
  return listing;
}

std::uint64_t zip_data_offset(const ByteSource& archive, const ArchiveMember& member) {
  const std::string header = archive.read(member.offset, local_bytes);
  if (header.size() < local_bytes || !header.starts_with(local_mark))
    throw ItemError(Status::unreadable, "damaged: the archive has no member where its directory says");
  const std::uint64_t offset =
      member.offset + local_bytes + little_endian(header, 26, 2) + little_endian(header, 28, 2);
  if (offset > archive.bytes() || member.packed_bytes > archive.bytes() - offset)
    throw ItemError(Status::unreadable, "damaged: its bytes lie outside the archive");
  return offset;
}

namespace {

[[noreturn]] void throw_cut_member() {
  throw ItemError(Status::unreadable, "cut: the archive ends within it");
}

}  // namespace

std::string inflate_zip_member(const ByteSource& archive, const ArchiveMember& member) {
  const std::string packed =
      archive.read(zip_data_offset(archive, member), static_cast<std::size_t>(member.packed_bytes));
  if (packed.size() < member.packed_bytes) throw_cut_member();
  std::string bytes(static_cast<std::size_t>(member.bytes), '\0');
  const std::unique_ptr<libdeflate_decompressor, void (*)(libdeflate_decompressor*)> unpacker(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  if (!unpacker) throw std::bad_alloc();
  switch (libdeflate_deflate_decompress(unpacker.get(), packed.data(), packed.size(), bytes.data(),
                                        bytes.size(), nullptr)) {
    case LIBDEFLATE_SUCCESS:
      return bytes;
    case LIBDEFLATE_SHORT_OUTPUT:
      throw ItemError(Status::unreadable, "damaged: it unpacks to less than the archive states");
    case LIBDEFLATE_INSUFFICIENT_SPACE:
      throw ItemError(Status::unreadable, "damaged: it unpacks to more than the archive states");
    default:
      throw ItemError(Status::unreadable, "damaged: the packed data are not what gzip and zip write");
  }
}

std::string unpack_zip_member(const ByteSource& archive, const ArchiveMember& member) {
  if (member.status != Status::ok) throw ItemError(member.status, member.reason);
  const std::string bytes = member.deflated ? inflate_zip_member(archive, member)
                                            : archive.read(zip_data_offset(archive, member),
                                                           static_cast<std::size_t>(member.bytes));
  if (bytes.size() < member.bytes) throw_cut_member();
  if (member.crc32 && libdeflate_crc32(0, bytes.data(), bytes.size()) != *member.crc32)
    throw ItemError(Status::unreadable, "damaged: its checksum differs from that in the archive");
  return bytes;
}

}  // namespace meander
