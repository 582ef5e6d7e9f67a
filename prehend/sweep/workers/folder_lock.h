#pragma once

#include <filesystem>
#include <string>

namespace prehend::sweep {

/// Keeps others from a file while it lives, also over hosts that share the folder.
class FolderLock {
 public:
  /// Several may share it unless somebody has it alone. @throws InputError when others have it:
  /// `what` is in use, and by whom.
  FolderLock(const std::filesystem::path& file, bool is_shared, const std::string& what);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_ = -1;
};

}  // namespace prehend::sweep
