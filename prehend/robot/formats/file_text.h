#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace prehend::robot::formats {

/// A file's bytes. @throws geometry::InputError naming one that cannot be read, is empty, or is
/// larger than 64 MiB
std::string whole_file(const std::filesystem::path& file);
/// Its first bytes, at most `most`; empty where it cannot be read.
std::string head_of_file(const std::filesystem::path& file, std::size_t most = 4096);

/// What files that name others, again and again, may bring together.
class FileBudget {
 public:
  /// @throws geometry::InputError when it is more than 10,000 files, or 256 MiB
  void spend(const std::filesystem::path& file);

 private:
  std::size_t files_ = 0;
  std::uintmax_t bytes_ = 0;
};

}  // namespace prehend::robot::formats
