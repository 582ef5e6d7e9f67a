#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "tests/fuzz/fuzz_input.h"

namespace prehend::fuzz {

/// A folder of its own in the system's temporary one, for readers whose files name others.
class Folder {
 public:
  Folder() {
    std::string pattern = std::filesystem::temp_directory_path() / "prehend-fuzz-XXXXXX";
    FUZZ_CHECK(::mkdtemp(pattern.data()) != nullptr);
    root_ = pattern;
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(root_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  /// Writes a file, and the folders above it. @returns its path
  std::filesystem::path write(const std::string& name, std::string_view content) const {
    const std::filesystem::path path = root_ / name;
    std::error_code ignored;  // the file that cannot be written says it
    std::filesystem::create_directories(path.parent_path(), ignored);
    std::ofstream stream(path, std::ios::binary);
    FUZZ_CHECK(static_cast<bool>(stream << content));
    return path;
  }
  void remove(const std::string& name) const {
    std::error_code ignored;  // it need not be there
    std::filesystem::remove(root_ / name, ignored);
  }
  const std::filesystem::path& path() const { return root_; }

 private:
  std::filesystem::path root_;
};

}  // namespace prehend::fuzz
