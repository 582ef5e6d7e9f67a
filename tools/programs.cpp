#include "tools/programs.h"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace prehend::tools {

std::string program_folder() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path().string();
}

std::string node_path() {
  const char* more = std::getenv("PREHEND_NODE_PATH");
  return program_folder() + (more && *more ? std::string(":") + more : "");
}

void become_program(const std::string& name, const std::vector<std::string>& arguments) {
  std::vector<std::string> words{program_folder() + "/" + name};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  ::execv(pointers[0], pointers.data());
  throw std::runtime_error("cannot start " + words[0] + ": " + std::strerror(errno));
}

}  // namespace prehend::tools
