#pragma once

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace prehend::eval::testing {

/// A private folder that goes with its owner.
struct TemporaryFolder {
  std::filesystem::path path;
  TemporaryFolder() {
    std::string pattern = std::filesystem::temp_directory_path() / "prehend-eval-XXXXXX";
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;  // a left-over in /tmp is no reason to fail
    std::filesystem::remove_all(path, ignored);
  }
};

}  // namespace prehend::eval::testing
