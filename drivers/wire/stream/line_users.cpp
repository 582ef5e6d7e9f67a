#include "drivers/wire/stream/line_users.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

namespace prehend::drivers {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

struct Use {
  bool has_line = false;
  bool serves_it = false;  // has the other end of this pseudo-terminal
};

// `index` is N of /dev/pts/N, else empty.
Use use_by(const fs::path& process, const fs::path& device, const std::string& index) {
  Use use;
  std::error_code ignored;  // processes come and go, and some are not ours to look into
  for (const auto& entry : fs::directory_iterator(process / "fd", ignored)) {
    const fs::path target = fs::read_symlink(entry.path(), ignored);
    use.has_line = use.has_line || target == device;
    if (index.empty() || target.filename() != "ptmx") continue;
    const std::string facts = text_of(process / "fdinfo" / entry.path().filename());
    use.serves_it = use.serves_it || facts.find("tty-index:\t" + index + "\n") != std::string::npos;
  }
  return use;
}

}  // namespace

std::vector<LineUser> users_of_line(const std::string& device) {
  std::error_code ignored;
  const fs::path file = fs::canonical(device, ignored);
  std::vector<LineUser> users;
  if (file.empty()) return users;
  const std::string index = file.parent_path() == "/dev/pts" ? file.filename().string() : "";
  for (const auto& entry : fs::directory_iterator("/proc", ignored)) {
    const std::string pid = entry.path().filename();
    const bool is_process =
        std::all_of(pid.begin(), pid.end(), [](unsigned char c) { return std::isdigit(c); });
    if (!is_process || pid == std::to_string(::getpid())) continue;
    const Use use = use_by(entry.path(), file, index);
    if (!use.has_line || use.serves_it) continue;
    std::string program = text_of(entry.path() / "comm");
    while (!program.empty() && program.back() == '\n') program.pop_back();
    users.push_back({std::stoi(pid), program});
  }
  return users;
}

}  // namespace prehend::drivers
