#include "prehend/text/tree_file.h"

#include <cstdlib>
#include <filesystem>

namespace prehend::text {

std::string tree_file(const std::string& name) {
  namespace fs = std::filesystem;
  std::error_code error;  // a folder that cannot be looked into has no file
  if (fs::exists(name, error)) return name;
  if (const char* root = std::getenv("PREHEND_ROOT"); root && *root) {
    const fs::path file = fs::absolute(fs::path(root) / name);
    if (fs::exists(file, error)) return file.string();
  }
  fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
  while (!folder.empty() && folder != folder.root_path()) {
    if (fs::exists(folder / name, error)) return (folder / name).string();
    folder = folder.parent_path();
  }
  return name;
}

}  // namespace prehend::text
