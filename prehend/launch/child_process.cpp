#include "prehend/launch/child_process.h"

#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>

namespace prehend::launch {
namespace {

[[noreturn]] void throw_errno(int error, const std::string& what) {
  throw std::system_error(error, std::generic_category(), what);
}

std::vector<char*> pointers_to(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

std::vector<std::string> merged_environment(const std::map<std::string, std::string>& added) {
  std::vector<std::string> merged;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string text = *entry;
    if (added.count(text.substr(0, text.find('='))) == 0) merged.push_back(text);
  }
  for (const auto& [name, value] : added) merged.push_back(name + "=" + value);
  return merged;
}

// Where the kernel groups tasks by session (sched(7), autogroup), the nice values within one count
// among themselves, and the group has one of its own. Higher ones need no right. Safe after fork.
void yield_to_others(int nice) {
  ::setpriority(PRIO_PROCESS, 0, nice);
  const std::array<char, 2> digits{static_cast<char>('0' + nice / 10),
                                   static_cast<char>('0' + nice % 10)};
  const int group = ::open("/proc/self/autogroup", O_WRONLY | O_CLOEXEC);
  if (group < 0) return;  // it groups by something else
  [[maybe_unused]] const ssize_t written = ::write(group, digits.data(), digits.size());
  ::close(group);
}

// Runs between fork and exec: only calls that are safe in a child of a process with threads.
[[noreturn]] void become(char* const* arguments, char* const* environment, pid_t parent,
                         const cpu_set_t* cpus, int nice, int input, int output, int failure) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(127);  // the parent died before the line above
  ::setsid();
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  if (nice > 0) yield_to_others(nice);
  const bool placed = cpus == nullptr || ::sched_setaffinity(0, sizeof *cpus, cpus) == 0;
  if (placed && ::dup2(input, STDIN_FILENO) >= 0 && ::dup2(output, STDOUT_FILENO) >= 0 &&
      ::dup2(output, STDERR_FILENO) >= 0) {
    ::execve(arguments[0], arguments, environment);
  }
  const int error = errno;
  [[maybe_unused]] const ssize_t written = ::write(failure, &error, sizeof error);
  ::_exit(127);
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& command,
                           const std::map<std::string, std::string>& environment,
                           const ProcessorShare& share) {
  std::vector<std::string> words = command;
  std::vector<std::string> variables = merged_environment(environment);
  const std::vector<char*> arguments = pointers_to(words);
  const std::vector<char*> environment_pointers = pointers_to(variables);
  std::array<int, 2> output{}, failure{};
  if (::pipe2(output.data(), O_CLOEXEC) != 0) throw_errno(errno, "pipe");
  if (::pipe2(failure.data(), O_CLOEXEC) != 0) throw_errno(errno, "pipe");
  const int input = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  const pid_t parent = ::getpid();
  cpu_set_t cpu_set;
  CPU_ZERO(&cpu_set);
  for (const int cpu : share.cpus) CPU_SET(static_cast<std::size_t>(cpu), &cpu_set);
  const int nice =
      share.nice > 0 ? std::clamp(::getpriority(PRIO_PROCESS, 0) + share.nice, 0, 19) : 0;
  pid_ = ::fork();
  const int fork_error = errno;
  if (pid_ == 0) {
    become(arguments.data(), environment_pointers.data(), parent,
           share.cpus.empty() ? nullptr : &cpu_set, nice, input, output[1], failure[1]);
  }
  ::close(input);
  ::close(output[1]);
  ::close(failure[1]);
  int error = fork_error;
  const bool failed = pid_ < 0 || ::read(failure[0], &error, sizeof error) == sizeof error;
  ::close(failure[0]);
  if (failed) {
    ::close(output[0]);
    if (pid_ > 0) ::waitpid(pid_, nullptr, 0);
    throw_errno(error, "cannot start " + command.at(0));
  }
  output_ = output[0];
  ::fcntl(output_, F_SETFL, O_NONBLOCK);
}

ChildProcess::~ChildProcess() {
  if (!status()) {
    send_signal(SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  ::close(output_);
}

std::string ChildProcess::read_output() {
  std::string text;
  std::array<char, 4096> buffer;
  for (;;) {
    const ssize_t got = ::read(output_, buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return text;
    text.append(buffer.data(), static_cast<std::size_t>(got));
    if (text.size() > (std::size_t{1} << 20)) return text;  // leave time for the others
  }
}

void ChildProcess::send_signal(int signal) {
  if (!status_) ::kill(-pid_, signal);
}

std::optional<int> ChildProcess::status() {
  if (status_) return status_;
  int status = 0;
  rusage usage{};
  if (::wait4(pid_, &status, WNOHANG, &usage) != pid_) return std::nullopt;
  peak_memory_ = std::int64_t{usage.ru_maxrss} * 1024;
  ::kill(-pid_, SIGKILL);
  status_ = status;
  return status_;
}

std::string describe_status(int status) {
  if (!WIFSIGNALED(status)) return "exit code " + std::to_string(WEXITSTATUS(status));
  const char* name = ::sigabbrev_np(WTERMSIG(status));
  return "signal " + (name ? std::string("SIG") + name : std::to_string(WTERMSIG(status)));
}

bool is_success(int status) { return WIFEXITED(status) && WEXITSTATUS(status) == 0; }

}  // namespace prehend::launch
