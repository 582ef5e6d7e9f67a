#include "prehend/graph/stop_signals.h"

#include <fcntl.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <system_error>
#include <utility>

namespace prehend::graph {
namespace {

constexpr char kStop = 's';
constexpr char kEnd = 'e';

std::array<int, 2> stop_pipe{-1, -1};  // a signal handler can do no more than write to it
std::atomic<bool> is_stop_requested{false};
std::atomic<std::int64_t> stop_grace{0};               // ms
std::array<std::atomic<std::int64_t>, NSIG> first_at;  // when each signal came first [ms], 0: never
static_assert(std::atomic<std::int64_t>::is_always_lock_free, "used in a signal handler");

void write_byte(char byte) {
  const int kept = errno;
  [[maybe_unused]] const auto written = ::write(stop_pipe[1], &byte, 1);
  errno = kept;
}

std::int64_t milliseconds_now() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1000 + now.tv_nsec / 1'000'000;
}

// Everything in it is async-signal-safe.
void handle_stop(int signal) {
  std::atomic<std::int64_t>& first = first_at[static_cast<std::size_t>(signal)];
  const std::int64_t now = milliseconds_now();
  if (first == 0) {
    first = now;
    return write_byte(kStop);
  }
  if (now - first < stop_grace) return;
  ::signal(signal, SIG_DFL);
  ::raise(signal);
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

StopSignals::StopSignals(std::function<void()> on_stop, std::chrono::milliseconds grace) {
  if (::pipe2(stop_pipe.data(), O_CLOEXEC) != 0) {
    throw std::system_error(errno, std::generic_category(), "pipe");
  }
  is_stop_requested = false;
  stop_grace = grace.count();
  for (auto& first : first_at) first = 0;
  thread_ = std::thread([on_stop = std::move(on_stop)] {
    if (read_byte() != kStop) return;
    is_stop_requested = true;
    on_stop();
  });
  struct sigaction action = {};
  action.sa_handler = handle_stop;
  action.sa_flags = SA_RESTART;
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
