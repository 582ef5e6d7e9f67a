#include "tests/system/two_hosts.h"

#include <fcntl.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <stdexcept>

#include "tests/system/launched.h"

namespace prehend::testing {
namespace {

constexpr const char* kEnter = "/usr/bin/nsenter";
constexpr const char* kCable[2] = {"cable0", "cable1"};

}  // namespace

TwoHosts::TwoHosts() {
  try {
    for (const int host : {0, 1}) hold_namespace(host);
    ip(0, std::string("link add ") + kCable[0] + " type veth peer name " + kCable[1]);
    ip(0, std::string("link set ") + kCable[1] + " netns " + std::to_string(holders_[1]));
    for (const int host : {0, 1}) {
      ip(host, "addr add " + address(host) + "/30 dev " + kCable[host]);
      ip(host, "link set lo up");
    }
    mend_cable();
  } catch (...) {
    for (const pid_t holder : holders_) {
      if (holder > 0) ::kill(holder, SIGKILL), ::waitpid(holder, nullptr, 0);
    }
    throw;
  }
}

TwoHosts::~TwoHosts() {
  for (const pid_t holder : holders_) {
    ::kill(holder, SIGKILL);
    ::waitpid(holder, nullptr, 0);
  }
}

void TwoHosts::hold_namespace(int host) {
  int report[2];
  if (::pipe2(report, O_CLOEXEC) != 0) throw std::runtime_error("pipe failed");
  const pid_t child = ::fork();
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    const int error = ::unshare(CLONE_NEWNET) == 0 ? 0 : errno;
    [[maybe_unused]] const auto written = ::write(report[1], &error, sizeof error);
    while (true) ::pause();
  }
  ::close(report[1]);
  holders_[static_cast<std::size_t>(host)] = child;
  int error = ECHILD;
  [[maybe_unused]] const auto got = ::read(report[0], &error, sizeof error);
  ::close(report[0]);
  if (error != 0) {
    throw std::runtime_error(std::string("no network namespace can be made: ") +
                             std::strerror(error));
  }
}

std::vector<std::string> TwoHosts::on(int host, const std::string& program) const {
  const std::string holder = std::to_string(holders_[static_cast<std::size_t>(host)]);
  return {kEnter, "--net=/proc/" + holder + "/ns/net", program};
}

void TwoHosts::ip(int host, const std::string& arguments) const {
  const auto command = on(host, "/bin/sh");
  const auto outcome = run_program(
      command[0], {command[1], command[2], "-c", "PATH=$PATH:/usr/sbin:/sbin ip " + arguments},
      std::chrono::seconds(20));
  if (outcome.exit_code != 0) {
    throw std::runtime_error("ip " + arguments + " (of package iproute2): " + outcome.output);
  }
}

void TwoHosts::cut_cable() {
  for (const int host : {0, 1}) ip(host, std::string("link set ") + kCable[host] + " down");
}

void TwoHosts::mend_cable() {
  for (const int host : {0, 1}) ip(host, std::string("link set ") + kCable[host] + " up");
}

}  // namespace prehend::testing
