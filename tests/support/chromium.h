// The browser that tests open pages in, where there is one.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <string>

#include "support/run_process.h"

namespace meander::test {

// Empty where it is not installed.
inline std::string chromium() {
  const char* folders = std::getenv("PATH");
  std::string rest = folders ? folders : "";
  while (!rest.empty()) {
    const std::string folder = rest.substr(0, rest.find(':'));
    rest.erase(0, std::min(rest.size(), folder.size() + 1));
    for (const char* name : {"/chromium", "/chromium-browser", "/google-chrome"})
      if (::access((folder + name).c_str(), X_OK) == 0) return folder + name;
  }
  return {};
}

#define MEANDER_NEEDS_CHROMIUM()                        \
  if (chromium().empty()) {                             \
    WARN("skipped: no Chromium (.ci/install browser)"); \
    return;                                             \
  }

// Opens an address without network and draws in software. `what`: "--dump-dom", or "--screenshot=FILE";
// `size`: of the window, "900,700"; `profile`: a folder of its own.
inline ProcessResult open_page(const std::string& address, const std::string& what, const std::string& size,
                               const std::string& profile) {
  return run_process({chromium(), "--headless=new", "--no-sandbox", "--use-angle=swiftshader",
                      "--enable-unsafe-swiftshader", "--hide-scrollbars", "--no-first-run",
                      "--disable-extensions", "--force-device-scale-factor=1", "--user-data-dir=" + profile,
                      "--window-size=" + size, "--virtual-time-budget=5000",
                      "--host-resolver-rules=MAP * ~NOTFOUND", "--enable-logging=stderr", what, address});
}

}  // namespace meander::test
