#include "bench/graph/channel.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>

#include "bench/graph/job.h"

namespace prehend::bench {
namespace {

constexpr const char* kGone = "the other process of the pair has ended early";

enum class Ready { kYes, kTimeout };

Ready wait_readable(int descriptor, std::chrono::milliseconds timeout) {
  pollfd entry{descriptor, POLLIN, 0};
  const int count = poll(&entry, 1, static_cast<int>(timeout.count()));
  return count > 0 ? Ready::kYes : Ready::kTimeout;
}

}  // namespace

Channel::~Channel() { close(descriptor_); }

void Channel::write_line(const std::string& line) {
  const std::string text = line + "\n";
  const ssize_t sent = send(descriptor_, text.data(), text.size(), MSG_NOSIGNAL);
  if (sent != static_cast<ssize_t>(text.size())) throw BenchError(kGone);
}

std::string Channel::read_line(std::chrono::milliseconds timeout) {
  std::string line;
  for (;;) {
    if (wait_readable(descriptor_, timeout) == Ready::kTimeout) {
      throw BenchError(interrupted ? "interrupted"
                                   : "the other process of the pair does not start");
    }
    char character = 0;
    if (recv(descriptor_, &character, 1, 0) <= 0) throw BenchError(kGone);
    if (character == '\n') return line;
    line += character;
  }
}

void Channel::acknowledge() {
  const char byte = 1;
  [[maybe_unused]] const ssize_t sent = send(descriptor_, &byte, 1, MSG_NOSIGNAL);
}

std::size_t Channel::wait_for_acknowledgement(std::chrono::milliseconds timeout) {
  if (wait_readable(descriptor_, timeout) == Ready::kTimeout) return 0;
  char bytes[256];
  const ssize_t count = recv(descriptor_, bytes, sizeof(bytes), 0);
  if (count <= 0) throw BenchError(kGone);
  return static_cast<std::size_t>(count);
}

void Channel::wait_for_end() {
  char byte = 0;
  while (!interrupted && recv(descriptor_, &byte, 1, 0) > 0) {
  }
}

ChannelEnds make_channel() {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
    throw BenchError("no socket pair: out of file descriptors?");
  }
  return {ends[0], ends[1]};
}

void close_ends(const ChannelEnds& ends) {
  close(ends.sender);
  close(ends.receiver);
}

}  // namespace prehend::bench
