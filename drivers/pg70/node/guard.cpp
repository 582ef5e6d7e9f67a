// What the guardian's process does.

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>

#include "drivers/pg70/codec/request.h"
#include "drivers/pg70/codec/response.h"
#include "drivers/pg70/node/guardian.h"
#include "drivers/pg70/node/guardian_words.h"

namespace prehend::drivers::pg70 {
namespace {

constexpr double kStandingShare = 5;  // of the patience while the gripper stands
constexpr int kStops = 3;             // without an answer, then CMD FAST STOP goes with each

bool has_input(int socket, std::chrono::milliseconds wait) {
  pollfd file{socket, POLLIN, 0};
  return ::poll(&file, 1, static_cast<int>(wait.count())) > 0;
}

// "CMD STOP", "CMD FAST STOP": the one that was answered; empty when none was before `end`, or the
// driver spoke again on `socket` (-1: it is dead).
std::string stop_module(Link& link, int socket, Time end) {
  const Content stop = encode(PlainRequest{Command::kStop});
  const Content fast_stop = encode(PlainRequest{Command::kFastStop});
  constexpr auto kReplyTime = std::chrono::milliseconds(50);
  for (int tries = 1; steady_now() < end; ++tries) {
    if (socket >= 0 && has_input(socket, {})) return {};
    if (!link.send(Direction::kCommand, stop).empty()) return {};
    if (tries > kStops && !link.send(Direction::kCommand, fast_stop).empty()) return {};
    const Time again = steady_now() + kReplyTime;
    while (steady_now() < again) {
      const auto input = link.receive(again - steady_now());
      if (!input) break;
      if (const auto* event = std::get_if<LinkEvent>(&*input)) {
        if (event->kind == LinkEvent::Kind::kClosed) return {};
        continue;
      }
      const Content& content = std::get<Incoming>(*input).content;
      if (content.command() == stop.command()) return "CMD STOP";
      const Response response = decode_response(content, kWithAll);
      const auto* fault = std::get_if<Fault>(&response);
      if (fault && fault->code == ErrorCode::kFastStop) return "CMD FAST STOP";
    }
  }
  return {};
}

// Opens the wire and stops the gripper; the message that was answered, or why none was.
struct Stopped {
  std::string by, problem = "no answer";
};
Stopped stop_gripper(const LinkAddress& address, int socket, double seconds) {
  Stopped result;
  const Time end = steady_now() + to_time(seconds);
  while (steady_now() < end) {
    try {
      result.by = stop_module(*open_link(address), socket, end);
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

int driver_died(const LinkAddress& address, double stop_time) {
  const Stopped stopped = stop_gripper(address, -1, stop_time);
  if (!stopped.by.empty()) {
    std::fprintf(stderr, "pg70_guardian: the driver died; %s was sent and answered\n",
                 stopped.by.c_str());
    return 0;
  }
  std::fprintf(stderr, "pg70_guardian: the driver died and the gripper CANNOT BE STOPPED: %s\n",
               stopped.problem.c_str());
  return 1;
}

void driver_hangs(const LinkAddress& address, int socket, double patience) {
  constexpr double kRound = 1;  // s of trying, then it is told
  std::fprintf(stderr, "pg70_guardian: the driver makes no progress for %g s: CMD STOP is sent\n",
               patience);
  const char word = guardian_words::kStopped;
  if (::send(socket, &word, 1, MSG_NOSIGNAL | MSG_DONTWAIT) != 1) return;  // it died: read() tells
  bool is_told = false;
  while (true) {
    const Stopped stopped = stop_gripper(address, socket, kRound);
    if (!stopped.by.empty()) {
      std::fprintf(stderr, "pg70_guardian: %s was answered\n", stopped.by.c_str());
      return;
    }
    if (has_input(socket, {})) return;  // it is back, or dead
    if (!is_told) {
      std::fprintf(stderr, "pg70_guardian: the gripper CANNOT BE STOPPED: %s; trying on\n",
                   stopped.problem.c_str());
    }
    is_told = true;
  }
}

}  // namespace

int guard(int socket, const LinkAddress& address, double patience, double stop_time) {
  Watch watch = Watch::kOff;
  while (true) {
    const double wait = watch == Watch::kMoving ? patience : kStandingShare * patience;
    pollfd file{socket, POLLIN, 0};
    const int ready = ::poll(&file, 1, watch == Watch::kOff ? -1 : static_cast<int>(1e3 * wait));
    if (ready == 0) {
      driver_hangs(address, socket, wait);
      watch = Watch::kOff;  // until it speaks again
      continue;
    }
    std::array<char, 256> words;
    const ssize_t count = ::read(socket, words.data(), words.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return driver_died(address, stop_time);
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

}  // namespace prehend::drivers::pg70
