// Archives: their directories, and the unpacking of their members.
#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "io/archive/archive.h"
#include "io/archive/tar_headers.h"
#include "io/archive/zip_directory.h"
#include "scratch_file.h"
#include "support/archive_files.h"
#include "targets.h"

namespace meander::fuzz {

namespace {

constexpr std::size_t most_members_unpacked = 12;
constexpr std::uint64_t most_unpacked = std::uint64_t{1} << 20;

bool is_of_an_archive(const ItemError& error) {
  return (error.status() == Status::unreadable || error.status() == Status::unsupported_format ||
          error.status() == Status::too_large) &&
         std::string_view(error.what()).size() > 10;
}

void demand_listing(const ArchiveListing& listing) {
  for (const ArchiveMember& member : listing.members) {
    demand(static_cast<std::size_t>(member.status) < status_names.size(), "the status of a member is known");
    demand(member.status == Status::ok || member.reason.size() > 10, "a refused member has a reason");
    demand(member.status == Status::ok || member.status == Status::unreadable ||
               member.status == Status::unsupported_format,
           "the status of a member is documented");
    demand(!member.name.empty() && member.name.front() != '/', "a name is a path below the archive");
    for (const std::filesystem::path& part : std::filesystem::path(member.name))
      demand(part != ".." && part != ".", "a name does not lead out of the archive");
  }
}

// Members that are ok lie in the archive, and none on another.
void demand_apart(const ArchiveListing& listing, std::uint64_t archive_bytes) {
  std::vector<std::pair<std::uint64_t, std::uint64_t>> taken;
  for (const ArchiveMember& member : listing.members) {
    if (member.status != Status::ok) continue;
    demand(member.offset <= archive_bytes && member.packed_bytes <= archive_bytes - member.offset,
           "a member lies in the archive");
    demand(!is_bomb(member.packed_bytes, member.bytes), "a member that is a bomb is refused");
    if (member.packed_bytes > 0) taken.emplace_back(member.offset, member.offset + member.packed_bytes);
  }
  std::sort(taken.begin(), taken.end());
  for (std::size_t k = 1; k < taken.size(); ++k)
    demand(taken[k].first >= taken[k - 1].second, "members do not overlap");
}

// Reads a member as a whole and in pieces; both give the same bytes, or both fail.
void unpack_member(const Archive& archive, std::size_t number) {
  const ArchiveMember& member = archive.members()[number];
  std::string whole;
  bool is_whole = false;
  try {
    whole = archive.unpack(number, most_unpacked);
    is_whole = true;
    demand(member.status == Status::ok, "a refused member is not unpacked");
    demand(whole.size() <= most_unpacked, "unpacking stops at the bound");
    demand(archive.kind() == ArchiveKind::gzip || whole.size() == member.bytes,
           "a member has the size it states");
  } catch (const ItemError& error) {
    demand(is_of_an_archive(error), std::string("unpacking: ") + error.what());
  }
  try {
    archive.look_at(number, [&](const ByteSource& source) {
      std::string pieces;
      for (std::uint64_t at = 0;; at += 1000) {
        const std::string piece = source.read(at, 1000);
        demand(piece.size() <= 1000, "a read gives no more than was asked for");
        pieces += piece;
        if (piece.size() < 1000 || pieces.size() > most_unpacked) break;
      }
      demand(!is_whole || pieces == whole, "a member read in pieces has the same bytes");
      demand(source.read(0, 100) == pieces.substr(0, 100), "a source can be read again");
    });
  } catch (const ItemError& error) {
    demand(is_of_an_archive(error), std::string("looking: ") + error.what());
    demand(!is_whole, std::string("a whole member is not read in pieces: ") + error.what());
  }
}

// A member that is an archive itself by its name.
void open_inner(const std::shared_ptr<const Archive>& outer, std::size_t member) {
  const auto kind = archive_kind_of(outer->members()[member].name);
  if (!kind || *kind == ArchiveKind::gzip) return;
  try {
    const Archive archive(outer, member);
    for (std::size_t k = 0; k < std::min(archive.members().size(), most_members_unpacked); ++k)
      unpack_member(archive, k);
  } catch (const ItemError&) {
    // The reason of the member, or of its listing.
  }
}

void run_archive(std::string_view name, std::string_view bytes) {
  const std::filesystem::path path = scratch_file(name, bytes);
  try {
    const auto opened = std::make_shared<const Archive>(path);
    const Archive& archive = *opened;
    std::set<std::string_view> names;
    for (std::size_t k = 0; k < archive.members().size(); ++k) {
      const ArchiveMember& member = archive.members()[k];
      demand(names.insert(member.name).second, "names are unique");
      demand(archive.find(member.name).has_value(), "a member is found by its name");
      if (k >= most_members_unpacked) continue;
      unpack_member(archive, k);
      open_inner(opened, k);
    }
    demand(!archive.find("no such name").has_value() || names.contains("no such name"),
           "what is not there is not found");
  } catch (const ItemError& error) {
    demand(error.status() == Status::unreadable, std::string("listing: ") + error.what());
  }
}

// The listing of the same bytes as a source; none where they are no archive.
template <class Read>
ArchiveListing listing_of(std::string_view bytes, const Read& read) {
  try {
    ArchiveListing listing = read(MemorySource(bytes));
    demand_listing(listing);
    return listing;
  } catch (const ItemError& error) {
    demand(error.status() == Status::unreadable, std::string("listing: ") + error.what());
    return {};
  }
}

}  // namespace

void run_zip(std::string_view bytes) {
  const ArchiveListing listing =
      listing_of(bytes, [](const ByteSource& source) { return read_zip_directory(source); });
  demand_apart(listing, bytes.size());
  for (const ArchiveMember& member : listing.members) {
    if (member.status != Status::ok) continue;
    try {
      const std::uint64_t begin = zip_data_offset(MemorySource(bytes), member);
      demand(begin <= bytes.size() && member.packed_bytes <= bytes.size() - begin,
             "the data of a member lie in the archive");
    } catch (const ItemError& error) {
      demand(error.status() == Status::unreadable, std::string("local header: ") + error.what());
    }
  }
  run_archive("a.zip", bytes);
}

// And packed as a whole: the members are the same.
void run_tar(std::string_view bytes) {
  const ArchiveListing listing = listing_of(bytes, read_tar_headers);
  for (const ArchiveMember& member : listing.members)
    demand(member.status != Status::ok ||
               (member.offset <= bytes.size() && member.bytes <= bytes.size() - member.offset),
           "a member lies in the archive");
  run_archive("a.tar", bytes);
  const std::string packed = test::gzip_bytes(bytes, 1);
  try {
    const Archive archive(scratch_file("packed.tar.gz", packed));
    demand(archive.members().size() == Archive(scratch_folder() / "a.tar").members().size(),
           "a packed archive has the same members");
    for (std::size_t k = 0; k < std::min(archive.members().size(), most_members_unpacked); ++k)
      unpack_member(archive, k);
  } catch (const ItemError& error) {
    demand(error.status() == Status::unreadable && listing.members.empty(),
           std::string("only the packed archive cannot be listed: ") + error.what());
  }
}

void run_gz(std::string_view bytes) {
  run_archive("a.off.gz", bytes);
  run_archive("a.tar.gz", bytes);
}

}  // namespace meander::fuzz
