#include "tools/doctor_host.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace prehend::tools {
namespace {

namespace fs = std::filesystem;
using Level = Finding::Level;

Finding open_files() {
  constexpr rlim_t kEnough = 1024, kLeast = 256;  // a peer takes a few sockets and memory files
  rlimit limit{};
  ::getrlimit(RLIMIT_NOFILE, &limit);
  const bool unlimited = limit.rlim_cur == RLIM_INFINITY;
  const std::string what = unlimited ? "no limit" : fmt::format("{} allowed", limit.rlim_cur);
  if (unlimited || limit.rlim_cur >= kEnough) return {Level::kOk, "open files", what, ""};
  return {limit.rlim_cur < kLeast ? Level::kError : Level::kWarning, "open files",
          what + ", a node with many peers needs more",
          "ulimit -n 4096 in the shell that starts the nodes"};
}

// Large messages go to readers on this host through files in memory, opened by /proc/PID/fd/N.
Finding shared_memory() {
  const std::string subject = "shared memory";
  const int file = ::memfd_create("prehend-doctor", MFD_CLOEXEC);
  if (file < 0) {
    return {Level::kWarning, subject,
            std::string("memfd_create fails: ") + std::strerror(errno) +
                "; large messages are copied through sockets instead",
            "allow memfd_create in this container's seccomp profile"};
  }
  const bool opens = ::access(("/proc/self/fd/" + std::to_string(file)).c_str(), R_OK) == 0;
  ::close(file);
  if (opens) return {Level::kOk, subject, "memory files can be made and shared", ""};
  return {Level::kWarning, subject,
          "/proc/PID/fd cannot be read; large messages are copied through sockets instead",
          "mount /proc in this container"};
}

Finding runtime_folder() {
  const std::string subject = "XDG_RUNTIME_DIR";
  const char* folder = std::getenv("XDG_RUNTIME_DIR");
  if (!folder || !*folder) {
    const bool usable = ::access("/tmp", W_OK | X_OK) == 0;
    return {usable ? Level::kOk : Level::kError, subject,
            usable ? "not set, sockets go to /tmp" : "not set, and /tmp cannot be written",
            usable ? "" : "export XDG_RUNTIME_DIR=FOLDER, one of your own"};
  }
  const std::string instead = "; sockets go to /tmp instead";
  const std::string mend = "export XDG_RUNTIME_DIR=/run/user/$(id -u), or unset it";
  struct stat status {};
  if (*folder != '/' || ::stat(folder, &status) != 0 || !S_ISDIR(status.st_mode)) {
    return {Level::kWarning, subject, fmt::format("{} is no folder{}", folder, instead), mend};
  }
  if (::access(folder, W_OK | X_OK) != 0) {
    return {Level::kWarning, subject, fmt::format("{} cannot be written{}", folder, instead), mend};
  }
  if (std::strlen(folder) >= 40) {
    return {Level::kWarning, subject,
            fmt::format("{} is too long for names of sockets{}", folder, instead), mend};
  }
  if (status.st_uid != ::getuid() || (status.st_mode & 077) != 0) {
    return {Level::kWarning, subject, fmt::format("{} is open to other users", folder),
            fmt::format("chmod 700 {}", folder)};
  }
  return {Level::kOk, subject, folder, ""};
}

}  // namespace

Findings examine_host() { return {open_files(), shared_memory(), runtime_folder()}; }

std::vector<std::string> living_registries() {
  std::vector<std::string> found;
  std::error_code ignored;  // processes come and go
  for (const auto& entry : fs::directory_iterator("/proc", ignored)) {
    const std::string pid = entry.path().filename();
    if (!std::all_of(pid.begin(), pid.end(), [](unsigned char c) { return std::isdigit(c); })) {
      continue;
    }
    std::ifstream file(entry.path() / "cmdline", std::ios::binary);
    std::string line{std::istreambuf_iterator<char>(file), {}};
    const std::string program = line.substr(0, line.find('\0'));
    if (fs::path(program).filename() != "registry") continue;
    while (!line.empty() && line.back() == '\0') line.pop_back();
    std::replace(line.begin(), line.end(), '\0', ' ');
    found.push_back(fmt::format("process {} ({})", pid, line.substr(0, 200)));
  }
  return found;
}

}  // namespace prehend::tools
