#include "io/archive/archive_member.h"

#include <fmt/format.h>

#include <map>
#include <utility>

namespace meander {

MemberPath member_path(std::string_view stored) {
  MemberPath result;
  if (stored.starts_with('/')) {
    result.path = "%2F";
    result.leads_out = true;
  }
  bool first = true;
  while (!stored.empty()) {
    const std::size_t end = std::min(stored.find('/'), stored.size());
    const std::string_view part = stored.substr(0, end);
    stored.remove_prefix(std::min(end + 1, stored.size()));
    if (part.empty() || part == ".") continue;
    if (!std::exchange(first, false)) result.path += '/';
    result.leads_out |= part == "..";
    result.path += part == ".." ? "%2E%2E" : part;
  }
  return result;
}

void name_member(ArchiveMember& member, std::string_view stored) {
  MemberPath path = member_path(stored);
  member.name = std::move(path.path);
  if (member.name.empty()) {  // the archive itself, if anything
    member.name = "%2E";
    member.refuse(Status::unreadable, "its name in the archive is no name of a file");
  }
  if (path.leads_out)
    member.refuse(Status::unreadable,
                  "its name in the archive leads out of the archive (`..` or a leading /)");
}

void refuse_duplicates(std::vector<ArchiveMember>& members) {
  std::map<std::string_view, std::size_t> counts;
  for (const ArchiveMember& member : members) ++counts[member.name];
  if (counts.size() == members.size()) return;
  std::vector<ArchiveMember> kept;
  std::map<std::string, bool> seen;
  for (const ArchiveMember& member : members) {
    const std::size_t count = counts[member.name];
    if (count > 1 && !seen.emplace(member.name, true).second) continue;
    kept.push_back(member);
    if (count == 1) continue;
    kept.back().status = Status::unreadable;
    kept.back().reason = fmt::format("the archive has {} members of this name", count);
  }
  members = std::move(kept);
}

std::string bomb_reason(std::uint64_t packed_bytes, std::uint64_t bytes) {
  return fmt::format(
      "{} bytes unpack to {} or more: beyond {} MiB at most {} times the packed bytes are taken; unpack it "
      "beforehand if it is not a decompression bomb",
      packed_bytes, bytes, most_free_bytes >> 20, most_unpacked_ratio);
}

}  // namespace meander
