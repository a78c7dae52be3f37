// Replacements for functions that older systems do not have (cmake/MeanderSystems.cmake).
#include <sys/random.h>

#include <cstddef>
#include <cstdlib>

// The oldest version for the architecture, which every glibc has. It returns the same values as the newer
// one, which only sets errno by itself.
#if defined(__x86_64__)
__asm__(".symver meander_oldest_hypot, hypot@GLIBC_2.2.5");
#else
__asm__(".symver meander_oldest_hypot, hypot@GLIBC_2.17");
#endif
extern "C" double meander_oldest_hypot(double x, double y);

extern "C" double __wrap_hypot(double x, double y);
double __wrap_hypot(double x, double y) { return meander_oldest_hypot(x, y); }

extern "C" void __wrap_arc4random_buf(void* bytes, std::size_t size);
void __wrap_arc4random_buf(void* bytes, std::size_t size) {
  auto* at = static_cast<unsigned char*>(bytes);
  while (size > 0) {
    const ssize_t made = getrandom(at, size, 0);
    if (made < 0) std::abort();  // as arc4random_buf does
    at += made;
    size -= static_cast<std::size_t>(made);
  }
}
