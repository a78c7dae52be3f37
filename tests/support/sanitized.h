// Whether this is a build with AddressSanitizer or ThreadSanitizer, which takes several times as long.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace meander::test {

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define MEANDER_SANITIZED
#endif
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define MEANDER_SANITIZED
#endif
#ifdef MEANDER_SANITIZED
inline constexpr bool sanitized = true;
#undef MEANDER_SANITIZED
#else
inline constexpr bool sanitized = false;
#endif

// All values; with sanitizers only the first `count` of them: release builds take the others.
template <typename Value>
std::vector<Value> thinned(std::size_t count, std::vector<Value> all) {
  if (sanitized) all.resize(std::min(count, all.size()));
  return all;
}

}  // namespace meander::test
