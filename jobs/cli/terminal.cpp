#include "jobs/cli/terminal.h"

#include <sys/ioctl.h>

#include <algorithm>
#include <cstdlib>

#include "jobs/cli/units.h"

namespace meander {

int terminal_width(int stream) {
  constexpr int usual = 80, narrowest = 20, widest = 120;
  int width = 0;  // unknown
  winsize size{};
  if (::ioctl(stream, TIOCGWINSZ, &size) == 0) width = size.ws_col;
  const char* const columns = std::getenv("COLUMNS");
  const auto wanted = number_in(columns == nullptr ? "" : columns);
  if (wanted && *wanted > 0 && (width == 0 || *wanted < static_cast<unsigned>(width)))
    width = static_cast<int>(std::min<std::uint64_t>(*wanted, widest));
  return std::clamp(width == 0 ? usual : width, narrowest, widest);
}

}  // namespace meander
