#include "drivers/pg70/node/guardian.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "drivers/pg70/codec/request.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::pg70 {
namespace {

constexpr char kAllIsWell = 'w';

// True when a stop, or anything that is said of one, was answered.
bool stop_module(Link& link, Time end) {
  const Content stop = encode(PlainRequest{Command::kStop});
  constexpr auto kReplyTime = std::chrono::milliseconds(50);
  while (steady_now() < end) {
    if (!link.send(Direction::kCommand, stop).empty()) return false;
    const Time again = steady_now() + kReplyTime;
    while (steady_now() < again) {
      const auto input = link.receive(again - steady_now());
      if (!input) break;
      const auto* incoming = std::get_if<Incoming>(&*input);
      if (incoming && incoming->content.command() == stop.command()) return true;
      if (!incoming && std::get<LinkEvent>(*input).kind == LinkEvent::Kind::kClosed) return false;
    }
  }
  return false;
}

}  // namespace

Guardian::Guardian(const LinkAddress& address) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) {
    throw std::runtime_error(std::string("no pipe to a guardian: ") + std::strerror(errno));
  }
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string program = (self.parent_path() / "pg70_guardian").string();
  std::vector<std::string> words{program, address.line, std::to_string(address.bit_rate),
                                 std::to_string(address.module)};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[0], STDIN_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  // A session of its own: what kills this process' group must not kill it, too.
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
  const int code =
      ::posix_spawn(&process_, program.c_str(), &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  ::close(ends[0]);
  if (code != 0) {
    ::close(ends[1]);
    throw std::runtime_error("cannot start " + program + ": " + std::strerror(code));
  }
  pipe_ = ends[1];
}

Guardian::~Guardian() {
  if (::write(pipe_, &kAllIsWell, 1) != 1) std::perror("pg70 guardian");
  ::close(pipe_);
  ::waitpid(process_, nullptr, 0);
}

int guard(int input, const LinkAddress& address, double patience) {
  char byte = 0;
  while (true) {
    const ssize_t count = ::read(input, &byte, 1);
    if (count == 1 && byte == kAllIsWell) return 0;
    if (count == 0 || (count < 0 && errno != EINTR)) break;
  }
  const Time end = steady_now() + to_time(patience);
  std::string problem = "no answer";
  while (steady_now() < end) {
    try {
      if (stop_module(*open_link(address), end)) {
        std::fprintf(stderr, "pg70_guardian: the driver died; CMD STOP was sent and answered\n");
        return 0;
      }
    } catch (const std::runtime_error& error) {
      problem = error.what();
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  std::fprintf(stderr, "pg70_guardian: the driver died and the gripper CANNOT BE STOPPED: %s\n",
               problem.c_str());
  return 1;
}

}  // namespace prehend::drivers::pg70
