#pragma once

#include <string>
#include <vector>

namespace prehend::drivers {

/// A process that has a line open.
struct LineUser {
  int pid = 0;
  std::string program;
};

/// Other processes that have the device file `device` (links are followed) open, as far as this
/// user may see them in /proc. Who serves the far end of an emulated line does not count.
std::vector<LineUser> users_of_line(const std::string& device);

}  // namespace prehend::drivers
