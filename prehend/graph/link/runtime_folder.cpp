#include "prehend/graph/link/runtime_folder.h"

#include <signal.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <system_error>

namespace prehend::graph {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPrefix = "prehend-";

std::string base_folder() {
  const char* folder = std::getenv("XDG_RUNTIME_DIR");
  // Socket paths are short; a deep runtime folder is of no use.
  const bool fits = folder && *folder == '/' && std::string(folder).size() < 40;
  return fits && ::access(folder, W_OK | X_OK) == 0 && fs::is_directory(folder) ? folder : "/tmp";
}

// The pid in NAME-PID-TAIL; 0 when there is none.
std::int64_t pid_in(const std::string& name) {
  const std::size_t end = name.rfind('-');
  if (end == std::string::npos || end == 0) return 0;
  const std::size_t begin = name.rfind('-', end - 1);
  if (begin == std::string::npos) return 0;
  std::int64_t pid = 0;
  const char* last = name.data() + end;
  const auto [stop, error] = std::from_chars(name.data() + begin + 1, last, pid);
  return error == std::errc() && stop == last ? pid : 0;
}

std::string registry_file(const std::string& folder) {
  return folder + "/registry-" + std::to_string(::getpid()) + "-lives";
}

}  // namespace

std::string make_runtime_folder() {
  std::string path = base_folder() + "/" + kPrefix + std::to_string(::getpid()) + "-XXXXXX";
  if (!::mkdtemp(path.data())) {
    throw std::system_error(errno, std::generic_category(), "cannot make the folder " + path);
  }
  std::ofstream(registry_file(path)) << "The registry of this graph lives.\n";
  return path;
}

void leave_runtime_folder(const std::string& folder) {
  ::unlink(registry_file(folder).c_str());
  clean_runtime_folder(folder);
  clean_stale_runtime_folders();  // of killed registries, whose nodes may have ended since
}

std::string socket_path(const std::string& folder, const std::string& instance) {
  std::string path = folder + "/" + instance;
  if (path.size() >= sizeof(sockaddr_un::sun_path)) {
    throw std::runtime_error("socket path " + path + " is too long: use a shorter node name");
  }
  return path;
}

void clean_runtime_folder(const std::string& folder) {
  std::error_code ignored;  // others clean at the same time; what is left is found at next start
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::int64_t pid = pid_in(entry.path().filename());
    if (pid > 0 && !is_process_alive(pid)) fs::remove(entry.path(), ignored);
  }
  fs::remove(folder, ignored);  // fails unless it is empty
}

void clean_stale_runtime_folders() {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(base_folder(), ignored)) {
    const std::string name = entry.path().filename();
    if (name.rfind(kPrefix, 0) != 0) continue;
    const std::int64_t owner = pid_in(name);
    if (owner > 0 && !is_process_alive(owner)) clean_runtime_folder(entry.path());
  }
}

std::string process_space() {
  std::ifstream file("/proc/sys/kernel/random/boot_id");
  std::string boot;
  std::getline(file, boot);
  std::error_code error;
  const fs::path space = fs::read_symlink("/proc/self/ns/pid", error);
  return boot + " " + space.string();
}

bool is_process_alive(std::int64_t pid) {
  if (pid <= 0 || pid > std::numeric_limits<pid_t>::max()) return false;
  if (::kill(static_cast<pid_t>(pid), 0) != 0) return errno == EPERM;
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  std::getline(file, text);
  const std::size_t name_end = text.rfind(')');
  return name_end == std::string::npos || name_end + 2 >= text.size() ||
         (text[name_end + 2] != 'Z' && text[name_end + 2] != 'X');
}

}  // namespace prehend::graph
