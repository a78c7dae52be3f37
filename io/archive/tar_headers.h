// The headers of a tar archive.
#pragma once

#include "io/archive/archive_member.h"
#include "io/file/byte_source.h"

namespace meander {

// Goes through the archive once, from front to back, and reads the headers alone; `archive` needs no bytes()
// and is asked for ascending offsets. V7, ustar, GNU (long names, sizes in base 256) and pax (path, linkpath,
// size). Hard links are members with the bytes of the one that they link to. Refused: symbolic links,
// devices, names that lead out of the archive, a member whose end is missing (unreadable); sparse files
// (unsupported_format). Where a header is damaged, or the archive ends without its end mark, the members
// before stay, with a problem; so it is where the source throws ItemError half-way. Throws ItemError
// (unreadable) where not even the first header is one.
ArchiveListing read_tar_headers(const ByteSource& archive);

}  // namespace meander
