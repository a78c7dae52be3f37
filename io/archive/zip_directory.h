// The central directory of a zip archive.
#pragma once

#include "io/archive/archive_member.h"
#include "io/file/byte_source.h"

namespace meander {

// Reads the end of the archive and the central directory: zip64, archives behind other data (self-extracting
// ones) and names with backslashes from DOS included. Every offset and size is checked before it is used;
// where the directory ends too early the members before stay, with a problem. Refused members: encrypted ones
// and methods other than stored and deflate (unsupported_format); links, names that lead out of the archive,
// data that overlap those of another member or lie outside the archive, and sizes as those of decompression
// bombs (unreadable). Throws ItemError(unreadable) where the source cannot be read, and too_large where the
// directory has more than `most_bytes`, before they are taken. Memory: the directory.
ArchiveListing read_zip_directory(const ByteSource& archive, std::uint64_t most_bytes = ~std::uint64_t{0});

// Where the bytes of a member begin, from its local header. Throws ItemError(unreadable) where there is none,
// or the bytes would not lie in the archive.
std::uint64_t zip_data_offset(const ByteSource& archive, const ArchiveMember& member);

// The unpacked bytes of a deflated member that is not refused. Throws ItemError(unreadable) when they are
// cut, or not of the stated size. Memory: packed and unpacked.
std::string inflate_zip_member(const ByteSource& archive, const ArchiveMember& member);
// The bytes of any member, checked against its size and, where it has one, its checksum. Throws ItemError:
// the status of a refused member; unreadable when they are damaged or cut.
std::string unpack_zip_member(const ByteSource& archive, const ArchiveMember& member);

}  // namespace meander
