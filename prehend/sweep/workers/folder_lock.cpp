#include "prehend/sweep/workers/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include <fmt/format.h>

#include "prehend/sweep/workers/case_process.h"
#include "prehend/text/input_error.h"

namespace prehend::sweep {

FolderLock::FolderLock(const std::filesystem::path& file, bool is_shared, const std::string& what) {
  file_ = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (file_ < 0) {
    throw text::InputError("'" + file.string() + "' cannot be opened: " + std::strerror(errno),
                           "Check the folder, or name another --out");
  }
  if (flock(file_, (is_shared ? LOCK_SH : LOCK_EX) | LOCK_NB) != 0) {
    std::array<char, 256> who{};
    const bool known = pread(file_, who.data(), who.size() - 1, 0) > 0;
    close(file_);
    throw text::InputError(fmt::format("{} is in use by another run{}", what,
                                       known ? fmt::format(" ({})", who.data()) : ""),
                           "Wait until that ends, or stop it");
  }
  const std::string me = this_worker();
  // Only what the message above says: failing to write it is no reason to stop.
  if (ftruncate(file_, 0) == 0 && pwrite(file_, me.data(), me.size(), 0) < 0) return;
}

FolderLock::~FolderLock() { close(file_); }

}  // namespace prehend::sweep
