#include "prehend/robot/formats/file_text.h"

#include <fstream>
#include <sstream>

#include "prehend/geometry/errors.h"

namespace prehend::robot::formats {

using geometry::InputError;

std::string whole_file(const std::filesystem::path& file) {
  constexpr std::uintmax_t kMostFileBytes = 64 << 20;
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  if (error || !std::filesystem::is_regular_file(file)) {
    throw InputError("'" + file.string() + "' cannot be read", "Check the path");
  }
  if (size > kMostFileBytes) {
    throw InputError(file.string() + " is larger than 64 MiB: no robot's file", "Check the path");
  }
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  if (!stream || !(text << stream.rdbuf())) {
    throw InputError("'" + file.string() + "' cannot be read, or is empty", "Check the path");
  }
  return text.str();
}

std::string head_of_file(const std::filesystem::path& file, std::size_t most) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return {};
  std::ifstream stream(file, std::ios::binary);
  std::string head(most, '\0');
  stream.read(head.data(), static_cast<std::streamsize>(most));
  head.resize(static_cast<std::size_t>(stream.gcount()));
  return head;
}

void FileBudget::spend(const std::filesystem::path& file) {
  constexpr std::size_t kMostFiles = 10000;
  constexpr std::uintmax_t kMostBytes = 256 << 20;
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  bytes_ += error ? 0 : size;
  if (++files_ <= kMostFiles && bytes_ <= kMostBytes) return;
  throw InputError(file.string() + ": the robot is read from more than 10,000 files, or 256 MiB",
                   "Look whether its files name one another again and again");
}

}  // namespace prehend::robot::formats
