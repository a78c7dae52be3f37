// The 128-bit intrinsics of x86-64-v2 and its CRC32. Other architectures take those of SIMDe, which give the
// same bits.
#pragma once

#if defined(__x86_64__)
#include <nmmintrin.h>
#else
#define SIMDE_ENABLE_NATIVE_ALIASES
#include <simde/x86/sse4.2.h>
#endif
