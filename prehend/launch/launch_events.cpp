#include "prehend/launch/launch_events.h"

#include <poll.h>
#include <signal.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <system_error>

namespace prehend::launch {

SignalSource::SignalSource() {
  sigset_t signals;
  ::sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGCHLD}) ::sigaddset(&signals, signal);
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  file_ = ::signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK);
  if (file_ < 0) throw std::system_error(errno, std::generic_category(), "signalfd");
}

SignalSource::~SignalSource() { ::close(file_); }

int SignalSource::take_stop() const {
  signalfd_siginfo info;
  while (::read(file_, &info, sizeof info) == sizeof info) {
    if (info.ssi_signo != SIGCHLD) return static_cast<int>(info.ssi_signo);
  }
  return 0;
}

void wait_for_events(const SignalSource& signals, const std::vector<SupervisedProcess*>& processes,
                     SupervisedProcess::Clock::time_point deadline) {
  std::vector<pollfd> files{{signals.file(), POLLIN, 0}};
  for (SupervisedProcess* process : processes) {
    if (process->running()) files.push_back({process->child()->output(), POLLIN, 0});
  }
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
                        deadline - SupervisedProcess::Clock::now())
                        .count() +
                    1;
  ::poll(files.data(), files.size(), static_cast<int>(std::max<long long>(0, left)));
  // A closed pipe polls as ready until its process is reaped; do not spin on it.
  const bool only_closed = std::all_of(files.begin(), files.end(), [](const pollfd& file) {
    return file.revents == 0 || file.revents == POLLHUP;
  });
  const bool some_closed = std::any_of(files.begin(), files.end(),
                                       [](const pollfd& file) { return file.revents == POLLHUP; });
  if (only_closed && some_closed) ::poll(files.data(), 1, 10);
}

}  // namespace prehend::launch
