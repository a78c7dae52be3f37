// What the directory of an archive says of its members.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/core/status.h"

namespace meander {

// One file in an archive.
struct ArchiveMember {
  std::string name;  // path below the archive, see member_path
  // Where it begins in the archive (in the unpacked bytes of a .tar.gz): the local header of a zip member,
  // the first byte of any other.
  std::uint64_t offset = 0;
  std::uint64_t packed_bytes = 0;  // in the archive
  std::uint64_t bytes = 0;         // unpacked
  bool deflated = false;           // else stored
  std::optional<std::uint32_t> crc32;
  // Not ok: the member is there, and this is why it is not unpacked, in one sentence.
  Status status = Status::ok;
  std::string reason;

  void refuse(Status why, std::string sentence) {
    if (status != Status::ok) return;
    status = why;
    reason = std::move(sentence);
  }
};

// A damaged archive has the members that could be listed, and a problem.
struct ArchiveListing {
  std::vector<ArchiveMember> members;  // in the order of the archive; folders are left out
  std::string problem;                 // why there may be more than these members; empty: these are all
};

// A stored name as the path below the archive: parts are separated by /, without empty parts and dots. A name
// that leads out of the archive has its `..` parts as %2E%2E and a leading / as %2F, and `leads_out` is set.
struct MemberPath {
  std::string path;
  bool leads_out = false;
};
MemberPath member_path(std::string_view stored);

// Sets the name of the member, and its status where the name leads out of the archive, or is none: then it is
// called %2E.
void name_member(ArchiveMember& member, std::string_view stored);

// Members of one name: the first stays and is refused, the others are taken out.
void refuse_duplicates(std::vector<ArchiveMember>& members);

// Larger than this, and more than so many times their packed bytes, members are refused: meshes, regular
// grids in text among them, are packed by less.
inline constexpr std::uint64_t most_free_bytes = std::uint64_t{64} << 20, most_unpacked_ratio = 200;
constexpr bool is_bomb(std::uint64_t packed_bytes, std::uint64_t bytes) {
  return bytes > most_free_bytes && bytes / most_unpacked_ratio > packed_bytes;
}
std::string bomb_reason(std::uint64_t packed_bytes, std::uint64_t bytes);

}  // namespace meander
