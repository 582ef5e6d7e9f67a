// What a guardian's process does.

#include "drivers/wire/guardian/guard.h"

#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <thread>

#include "drivers/wire/guardian/guardian_words.h"

namespace prehend::drivers {
namespace {

constexpr double kStandingShare = 5;  // of the patience while the device stands

bool has_input(int socket, std::chrono::milliseconds wait) {
  pollfd file{socket, POLLIN, 0};
  return ::poll(&file, 1, static_cast<int>(wait.count())) > 0;
}

// The message that was answered, or why none was. `socket` -1: the driver is dead.
struct Stopped {
  std::string by, problem = "no answer";
};
Stopped stop_device(const Guarding& guarding, int socket, double seconds) {
  Stopped result;
  const Time end = steady_now() + to_time(seconds);
  while (steady_now() < end) {
    try {
      result.by =
          guarding.stop_device(end, [socket] { return socket >= 0 && has_input(socket, {}); });
      if (!result.by.empty()) return result;
    } catch (const std::runtime_error& error) {
      result.problem = error.what();
    }
    constexpr auto kPause = std::chrono::milliseconds(10);
    if (socket < 0) {
      std::this_thread::sleep_for(kPause);
    } else if (has_input(socket, kPause)) {
      result.problem = "the driver is back";
      return result;
    }
  }
  return result;
}

int driver_died(const Guarding& guarding, double stop_time) {
  const Stopped stopped = stop_device(guarding, -1, stop_time);
  if (!stopped.by.empty()) {
    std::fprintf(stderr, "%s: the driver died; %s was sent and answered\n",
                 guarding.program.c_str(), stopped.by.c_str());
    return 0;
  }
  std::fprintf(stderr, "%s: the driver died and the %s CANNOT BE STOPPED: %s\n",
               guarding.program.c_str(), guarding.device.c_str(), stopped.problem.c_str());
  return 1;
}

void driver_hangs(const Guarding& guarding, int socket, double patience) {
  constexpr double kRound = 1;  // s of trying, then it is told
  std::fprintf(stderr, "%s: the driver makes no progress for %g s: %s is sent\n",
               guarding.program.c_str(), patience, guarding.stop.c_str());
  const char word = guardian_words::kStopped;
  if (::send(socket, &word, 1, MSG_NOSIGNAL | MSG_DONTWAIT) != 1) return;  // it died: read() tells
  bool is_told = false;
  while (true) {
    const Stopped stopped = stop_device(guarding, socket, kRound);
    if (!stopped.by.empty()) {
      std::fprintf(stderr, "%s: %s was answered\n", guarding.program.c_str(), stopped.by.c_str());
      return;
    }
    if (has_input(socket, {})) return;  // it is back, or dead
    if (!is_told) {
      std::fprintf(stderr, "%s: the %s CANNOT BE STOPPED: %s; trying on\n",
                   guarding.program.c_str(), guarding.device.c_str(), stopped.problem.c_str());
    }
    is_told = true;
  }
}

}  // namespace

int guard(int socket, const Guarding& guarding, double patience, double stop_time) {
  Watch watch = Watch::kOff;
  while (true) {
    const double wait = watch == Watch::kMoving ? patience : kStandingShare * patience;
    pollfd file{socket, POLLIN, 0};
    const int ready = ::poll(&file, 1, watch == Watch::kOff ? -1 : static_cast<int>(1e3 * wait));
    if (ready == 0) {
      driver_hangs(guarding, socket, wait);
      watch = Watch::kOff;  // until it speaks again
      continue;
    }
    std::array<char, 256> words;
    const ssize_t count = ::read(socket, words.data(), words.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return driver_died(guarding, stop_time);
    for (ssize_t i = 0; i < count; ++i) {
      const char word = words[static_cast<std::size_t>(i)];
      if (word == guardian_words::kAllIsWell) return 0;
      watch = static_cast<Watch>(word);
    }
    const char heard = guardian_words::kHeard;
    // One that cannot be told has died, which the next read shows.
    [[maybe_unused]] const auto sent = ::send(socket, &heard, 1, MSG_NOSIGNAL | MSG_DONTWAIT);
  }
}

int guard_standard_input(const Guarding& guarding, double patience) {
  ::signal(SIGINT, SIG_IGN);
  ::signal(SIGTERM, SIG_IGN);
  return guard(STDIN_FILENO, guarding, patience);
}

int guard_by_words(int argc, char** argv, std::size_t count,
                   const std::function<Guarding(const std::vector<std::string>&)>& make) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  const double patience = words.size() == count + 1 ? std::strtod(argv[count + 1], nullptr) : 0;
  if (!(patience > 0)) {
    std::fprintf(stderr, "%s is started by its driver's node\n", argv[0]);
    return 2;
  }
  return guard_standard_input(make(words), patience);
}

unsigned number_of(const std::string& word) {
  return static_cast<unsigned>(std::strtoul(word.c_str(), nullptr, 10));
}

}  // namespace prehend::drivers
