#include "prehend/graph/stop_signals.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <system_error>
#include <utility>

namespace prehend::graph {
namespace {

constexpr char kStop = 's';
constexpr char kEnd = 'e';

std::array<int, 2> stop_pipe{-1, -1};  // a signal handler can do no more than write to it
std::atomic<bool> is_stop_requested{false};

void write_byte(char byte) {
  const int kept = errno;
  [[maybe_unused]] const auto written = ::write(stop_pipe[1], &byte, 1);
  errno = kept;
}

char read_byte() {
  char byte = kEnd;
  while (::read(stop_pipe[0], &byte, 1) < 0 && errno == EINTR) {
  }
  return byte;
}

}  // namespace

bool stop_requested() { return is_stop_requested; }

void request_stop() { write_byte(kStop); }

StopSignals::StopSignals(std::function<void()> on_stop) {
  if (::pipe2(stop_pipe.data(), O_CLOEXEC) != 0) {
    throw std::system_error(errno, std::generic_category(), "pipe");
  }
  is_stop_requested = false;
  thread_ = std::thread([on_stop = std::move(on_stop)] {
    if (read_byte() != kStop) return;
    is_stop_requested = true;
    on_stop();
  });
  struct sigaction action = {};
  action.sa_handler = [](int) { write_byte(kStop); };
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
}

StopSignals::~StopSignals() {
  ::signal(SIGINT, SIG_IGN);
  ::signal(SIGTERM, SIG_IGN);
  write_byte(kEnd);
  thread_.join();
  for (int& end : stop_pipe) ::close(std::exchange(end, -1));
}

}  // namespace prehend::graph
