#include "prehend/recording/byte_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "prehend/recording/mcap_records.h"
#include "prehend/recording/recording_file.h"

namespace prehend::recording {

std::string at_byte(std::uint64_t offset) { return " at byte " + std::to_string(offset); }

ByteFile::ByteFile(const std::string& path) : path_(path) {
  file_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file_ < 0) {
    const int error = errno;
    const std::string partial = partial_path(path_);
    const bool is_left = error == ENOENT && ::access(partial.c_str(), F_OK) == 0;
    throw McapError("cannot open " + path_ + ": " + std::strerror(error) +
                    (is_left ? "; there is " + partial +
                                   ", which is being written, or its recorder was killed: prehend "
                                   "bag recover mends it"
                             : ""));
  }
  struct stat status {};
  if (::fstat(file_, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(file_);
    throw McapError(path_ + " is not a file");
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
}

ByteFile::~ByteFile() { ::close(file_); }

std::string ByteFile::read(std::uint64_t offset, std::uint64_t length) const {
  if (offset > size_ || length > size_ - offset) {
    throw McapError(std::to_string(length) + " bytes" + at_byte(offset) +
                    " run past the file's end");
  }
  std::string bytes(length, '\0');
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t got =
        ::pread(file_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw McapError("cannot read " + path_ + ": " + std::strerror(errno));
    if (got == 0) throw McapError(path_ + " became shorter while it was read");
    done += static_cast<std::size_t>(got);
  }
  return bytes;
}

}  // namespace prehend::recording
