#include "prehend/text/plug_ins.h"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdlib>
#include <sstream>
#include <system_error>

#include <dlfcn.h>

namespace prehend::text {

namespace fs = std::filesystem;

std::vector<fs::path> plug_in_folders(const std::string& kind) {
  std::string variable = "PREHEND_" + kind + "S";
  for (char& letter : variable) {
    letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
  }
  std::vector<fs::path> folders;
  if (const char* value = std::getenv(variable.c_str())) {
    std::istringstream list(value);
    for (std::string folder; std::getline(list, folder, ':');) {
      if (!folder.empty()) folders.emplace_back(folder);
    }
  }
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (error) return folders;
  const fs::path shipped = program.parent_path().parent_path() / "lib/prehend" / (kind + "s");
  const bool is_named = std::any_of(folders.begin(), folders.end(), [&](const fs::path& folder) {
    std::error_code absent;
    return fs::equivalent(folder, shipped, absent);
  });
  if (!is_named) folders.push_back(shipped);
  return folders;
}

std::vector<PlugIn> load_plug_ins(const std::string& kind, int interface,
                                  const std::vector<fs::path>& folders,
                                  std::vector<PlugInProblem>* problems) {
  std::vector<fs::path> files;
  for (const auto& folder : folders) {
    std::error_code error;
    const auto first = static_cast<std::ptrdiff_t>(files.size());
    for (const auto& entry : fs::directory_iterator(folder, error)) {
      if (entry.path().extension() == ".so") files.push_back(entry.path());
    }
    std::sort(files.begin() + first, files.end());
  }
  const std::string says = "prehend_" + kind + "_interface", makes = "prehend_create_" + kind;
  std::vector<PlugIn> plug_ins;
  for (const auto& file : files) {
    void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library) {
      problems->push_back({file, dlerror()});
      continue;
    }
    const auto built_for = reinterpret_cast<int (*)()>(dlsym(library, says.c_str()));
    void* create = dlsym(library, makes.c_str());
    if (!built_for || !create) {
      problems->push_back({file, "exports no " + says + " and " + makes});
      continue;
    }
    if (built_for() != interface) {
      problems->push_back({file, "is built for interface " + std::to_string(built_for()) +
                                     ", this prehend has " + std::to_string(interface)});
      continue;
    }
    plug_ins.push_back({file, create});
  }
  return plug_ins;
}

}  // namespace prehend::text
