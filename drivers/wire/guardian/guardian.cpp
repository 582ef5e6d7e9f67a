#include "drivers/wire/guardian/guardian.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "drivers/wire/guardian/guardian_words.h"

namespace prehend::drivers {
namespace {

constexpr auto kPeriod = std::chrono::milliseconds(20);  // of messages of progress
constexpr int kMostUnanswered = 50;                      // 1 s
constexpr double kRestart = 1.0;                         // s between tries to start one

std::string last_error() { return std::strerror(errno); }

}  // namespace

Guardian::Guardian(GuardianProgram program, double patience)
    : program_(std::move(program)), patience_(patience) {
  start();
}

Guardian::~Guardian() {
  const char word = guardian_words::kAllIsWell;
  if (socket_ >= 0 && ::send(socket_, &word, 1, MSG_NOSIGNAL) != 1)
    std::perror(program_.name.c_str());
  end(false);
}

void Guardian::start() {
  last_start_ = steady_now();
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw std::runtime_error("no socket to a guardian: " + last_error());
  }
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string program = (self.parent_path() / program_.name).string();
  std::vector<std::string> words{program};
  words.insert(words.end(), program_.arguments.begin(), program_.arguments.end());
  words.push_back(std::to_string(patience_));
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
    process_ = -1;
    ::close(ends[1]);
    throw std::runtime_error("cannot start " + program + ": " + std::strerror(code));
  }
  socket_ = ends[1];
  unanswered_ = 0;
}

// One that does not end by itself within a second is killed.
void Guardian::end(bool kill) {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
  if (process_ < 0) return;
  constexpr int kTries = 1000;
  for (int i = 0; !kill && i < kTries; ++i) {
    if (::waitpid(process_, nullptr, WNOHANG) != 0) {
      process_ = -1;
      return;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ::kill(process_, SIGKILL);
  ::waitpid(process_, nullptr, 0);
  process_ = -1;
}

void Guardian::replace(const std::string& words, News& news) {
  end(true);
  news.stopped_device |= acts_;
  acts_ = false;
  try {
    start();
    news.problem = words + "; another one was started";
  } catch (const std::runtime_error& error) {
    news.problem = words + ", and there is none now: " + error.what();
  }
}

Guardian::News Guardian::progress(Watch watch) {
  News news;
  const Time now = steady_now();
  if (socket_ < 0) {
    if (now - last_start_ > to_time(kRestart)) replace("the guardian could not be started", news);
    return news;
  }
  if (watch == last_watch_ && last_sent_ != Time::min() && now - last_sent_ < kPeriod) return news;
  // Its answers first: after a stand-still of this process they have long been here.
  std::array<char, 256> answers;
  const ssize_t count = ::recv(socket_, answers.data(), answers.size(), MSG_DONTWAIT);
  for (ssize_t i = 0; i < count; ++i) {
    // Told when it answers again: then it has left the wire.
    const bool has_acted = answers[static_cast<std::size_t>(i)] == guardian_words::kStopped;
    news.stopped_device |= acts_ && !has_acted;
    acts_ = has_acted;
  }
  if (count > 0) unanswered_ = 0;
  const char word = static_cast<char>(watch);
  const bool is_sent = ::send(socket_, &word, 1, MSG_DONTWAIT | MSG_NOSIGNAL) == 1;
  const bool is_gone = count == 0 || (!is_sent && errno != EAGAIN && errno != EINTR);
  last_sent_ = now;
  last_watch_ = watch;
  if (is_gone) {
    replace("the guardian of the " + program_.device + " died", news);
  } else if (++unanswered_ > kMostUnanswered) {
    replace("the guardian of the " + program_.device + " did not react any more", news);
  }
  return news;
}

}  // namespace prehend::drivers
