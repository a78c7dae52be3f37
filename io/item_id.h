// Ids of items: paths as text that is valid UTF-8 whatever bytes a file system allows in a name.
#pragma once

#include <string>
#include <string_view>

namespace meander {

// The id of a path, and the text of any name that goes into a store. Bytes that are not part of well-formed
// UTF-8, and those of control characters (U+0000 to U+001F, U+007F to U+009F), become %XX with two upper-case
// hexadecimal digits. A % becomes %25 only where it would be taken for such an escape: %00 to %1F, %25, and
// %7F to %FF. All other text, `a 50%.off` or `a%20b.off`, stays as it is. Different paths have different ids.
std::string escape_id(std::string_view path);

// The inverse: unescape_id(escape_id(path)) == path for any bytes.
std::string unescape_id(std::string_view id);

}  // namespace meander
