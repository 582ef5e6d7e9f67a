#include "tests/system/traffic_state.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <new>
#include <system_error>

namespace prehend::testing {

TrafficFile::TrafficFile(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (file < 0 || ::ftruncate(file, sizeof(TrafficState)) != 0) {
    throw std::system_error(errno, std::generic_category(), "cannot make " + path.string());
  }
  void* memory = ::mmap(nullptr, sizeof(TrafficState), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  ::close(file);
  if (memory == MAP_FAILED) throw std::system_error(errno, std::generic_category(), "mmap");
  state_ = static_cast<TrafficState*>(memory);  // a new file's zeros are a state at its start
}

TrafficFile::~TrafficFile() { ::munmap(state_, sizeof(TrafficState)); }

void TrafficFile::clear() { new (state_) TrafficState; }

}  // namespace prehend::testing
