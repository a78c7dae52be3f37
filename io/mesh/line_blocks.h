// Internal to the mesh readers: text with one element per line, read in parallel blocks.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <string_view>
#include <vector>

#include "io/mesh/text_cursor.h"
#include "kernels/core/cancel.h"
#include "kernels/core/parallel.h"

namespace meander::text {

// Where blocks of about `block` bytes begin when they may only begin at line starts: first the start of
// `body`, last its end, ascending (a block may be empty). continued(line end) says that the next line belongs
// to this one.
template <class Continued>
std::vector<const char*> split_lines(std::string_view body, std::size_t block, const Continued& continued) {
  const char* const end = body.data() + body.size();
  std::vector<const char*> starts{body.data()};
  for (std::size_t at = block; at < body.size(); at += block) {
    const char* p = std::max(starts.back(), body.data() + at - 1);
    do {
      p = find_line_end(p, end);
      if (p < end) ++p;
    } while (p < end && continued(p - 1));
    starts.push_back(p);
  }
  starts.push_back(end);
  return starts;
}

// Where the elements of a text are one line each, with nothing but blank lines (and # comments where the
// format has them) between them, calls row(block, ordinal, cursor over that line alone) for all `expected` of
// them, in parallel blocks. Returns false (at any time, in unspecified order) when there are more or fewer
// lines or a row says false: then the caller reads the text from its beginning without this assumption.
// begin_blocks(count) is called first.
template <class BeginBlocks, class Row>
bool for_each_line(std::string_view body, std::uint64_t expected, bool hash_comments, std::size_t block_bytes,
                   const CancelToken& cancel, const BeginBlocks& begin_blocks, const Row& row) {
  const std::vector<const char*> starts = split_lines(body, block_bytes, [](const char*) { return false; });
  const std::size_t blocks = starts.size() - 1;
  // The next line with an element on it, as a cursor over that line; false at the end of the block.
  const auto next_line = [hash_comments](TextCursor& block, TextCursor& line) {
    if (!block.skip_to_token()) return false;
    line = {block.at, find_line_end(block.at, block.end), hash_comments};
    block.at = line.end;
    return true;
  };
  std::vector<std::uint64_t> first(blocks + 1, 0);
  parallel_blocks(body.size(), block_bytes, [&](std::size_t begin, std::size_t) {
    cancel.check();
    const std::size_t b = begin / block_bytes;
    TextCursor block{starts[b], starts[b + 1], hash_comments}, line{};
    while (next_line(block, line)) ++first[b + 1];
  });
  std::partial_sum(first.begin(), first.end(), first.begin());
  if (first.back() != expected) return false;
  begin_blocks(blocks);
  std::atomic<bool> regular{true};
  parallel_blocks(body.size(), block_bytes, [&](std::size_t begin, std::size_t) {
    cancel.check();
    const std::size_t b = begin / block_bytes;
    TextCursor block{starts[b], starts[b + 1], hash_comments}, line{};
    for (std::uint64_t ordinal = first[b]; regular.load(std::memory_order_relaxed) && next_line(block, line);
         ++ordinal)
      if (!row(b, ordinal, line)) regular.store(false, std::memory_order_relaxed);
  });
  return regular.load();
}

}  // namespace meander::text
