#pragma once

#include <cstdint>
#include <string>

namespace prehend::recording {

/// A file to be read at any place. Errors name the file.
class ByteFile {
 public:
  /// Throws McapError when there is no such regular file or it cannot be opened.
  explicit ByteFile(const std::string& path);
  ~ByteFile();
  ByteFile(const ByteFile&) = delete;
  ByteFile& operator=(const ByteFile&) = delete;

  const std::string& path() const { return path_; }
  /// [bytes] when it was opened.
  std::uint64_t size() const { return size_; }

  /// Never allocates more than the file has, so a false length cannot cost memory. Throws McapError
  /// when the bytes run past the file's end or cannot be read.
  std::string read(std::uint64_t offset, std::uint64_t length) const;

 private:
  const std::string path_;
  int file_ = -1;
  std::uint64_t size_ = 0;
};

/// " at byte 17", for messages.
std::string at_byte(std::uint64_t offset);

}  // namespace prehend::recording
