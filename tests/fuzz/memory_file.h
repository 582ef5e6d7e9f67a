#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <string>
#include <string_view>

#include "tests/fuzz/fuzz_input.h"

namespace prehend::fuzz {

/// A file in memory with a path, for readers that want one.
class MemoryFile {
 public:
  explicit MemoryFile(std::string_view content) : file_(::memfd_create("fuzz", MFD_CLOEXEC)) {
    FUZZ_CHECK(file_ >= 0);
    while (!content.empty()) {
      const ssize_t written = ::write(file_, content.data(), content.size());
      FUZZ_CHECK(written > 0);
      content.remove_prefix(static_cast<std::size_t>(written));
    }
  }
  ~MemoryFile() { ::close(file_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  std::string path() const { return "/proc/self/fd/" + std::to_string(file_); }

 private:
  int file_;
};

}  // namespace prehend::fuzz
