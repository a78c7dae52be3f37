// Internal to io/image: what libwebp takes for the codes of a lossless stream.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace meander {

// Bytes beside the pixels that libwebp's decoder holds at most: each group of codes has tables of some 12 to
// 20 kB, and a stream of 200 kB can have 65,536 groups. Known when all in front of the groups is read: tables
// of transformations, and in how many tiles the picture is divided, of which each can name a group of its own
// (libwebp's encoder makes 2,600 at most). Throws ItemError(unreadable) for a stream that libwebp refuses
// there. Cost: linear in what is read.
std::uint64_t bytes_of_webp_codes(std::span<const std::byte> stream);

}  // namespace meander
