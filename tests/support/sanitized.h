// Whether this is a build with AddressSanitizer or ThreadSanitizer.
#pragma once

namespace meander::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool sanitized = true;
#else
inline constexpr bool sanitized = false;
#endif

}  // namespace meander::test
