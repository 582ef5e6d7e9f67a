#include "prehend/recording/recording_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <filesystem>
#include <system_error>

#include "prehend/recording/mcap_records.h"

namespace prehend::recording {
namespace {

namespace fs = std::filesystem;

constexpr int kMostLeftOver = 99;  // partial recordings of one name

// Whether a living writer holds its lock on the file, see McapWriter.
bool is_being_written(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return false;
  const bool locked = ::flock(file, LOCK_EX | LOCK_NB) != 0;
  ::close(file);
  return locked;
}

void rename_file(const std::string& from, const std::string& to, const std::string& otherwise) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error) {
    throw McapError("cannot rename " + from + " to " + to + ": " + error.message() + otherwise);
  }
}

}  // namespace

std::string partial_path(const std::string& path) { return path + ".partial"; }

std::string make_way(const std::string& path) {
  const std::string partial = partial_path(path);
  for (const std::string& name : {path, partial}) {
    std::error_code error;
    const auto status = fs::status(name, error);
    if (fs::exists(status) && !fs::is_regular_file(status)) {
      throw McapError("cannot record to " + name + ": there is something that is no file");
    }
  }
  if (!fs::exists(partial)) return "";
  if (is_being_written(partial)) {
    throw McapError("cannot record to " + path +
                    ": another recorder is writing it; give another file");
  }
  for (int number = 1; number <= kMostLeftOver; ++number) {
    const std::string kept = partial + "." + std::to_string(number);
    if (fs::exists(kept)) continue;
    rename_file(partial, kept, "");
    return kept;
  }
  throw McapError("cannot record to " + path + ": " + std::to_string(kMostLeftOver) +
                  " recordings were left unfinished there (" + partial +
                  ".1 ...); recover or remove them");
}

void set_aside(const std::string& path, const std::string& otherwise) {
  if (fs::exists(path)) rename_file(path, path + ".1", otherwise);
}

void give_name(const std::string& path) {
  const std::string partial = partial_path(path);
  const std::string otherwise = "; the recording is whole, and is " + partial;
  set_aside(path, otherwise);
  rename_file(partial, path, otherwise);
}

}  // namespace prehend::recording
