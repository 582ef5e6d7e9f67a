#include "prehend/sweep/workers/case_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>
#include <limits>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "prehend/sweep/collect.h"
#include "prehend/text/input_error.h"

namespace prehend::sweep {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr double kGrace = 3;      // s, from SIGTERM to SIGKILL
constexpr int kNotStarted = 127;  // as shells have it
constexpr int kThrew = 70;        // EX_SOFTWARE

sigset_t held_signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGCHLD, SIGINT, SIGTERM, SIGHUP}) sigaddset(&set, signal);
  return set;
}

std::vector<char*> environment_of_case() {
  std::vector<char*> kept;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text = *entry;
    const std::array<std::string_view, 4> of_ranks{"OMPI_", "PMIX_", "PMI_", "PMI2_"};
    const bool is_ours = std::any_of(of_ranks.begin(), of_ranks.end(),
                                     [&](std::string_view one) { return text.starts_with(one); });
    if (!is_ours) kept.push_back(*entry);
  }
  kept.push_back(nullptr);
  return kept;
}

// A child's streams and signals, and its end when its parent's comes.
void settle_child(int output, pid_t parent) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(kNotStarted);  // it ended before that
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  const int input = open("/dev/null", O_RDONLY);
  if (input < 0 || dup2(input, 0) < 0 || dup2(output, 1) < 0 || dup2(output, 2) < 0) {
    _exit(kNotStarted);
  }
}

[[noreturn]] void run_child(const CaseOrder& order, const CaseBody& body) {
  int code = 0;
  try {
    body(order);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    code = kThrew;
  }
  // Destructors belong to the parent.
  std::fflush(nullptr);
  _exit(code);
}

// Programs do not end themselves by these: the user does, Slurm, or the kernel for want of memory.
bool is_from_outside(int status) {
  if (!WIFSIGNALED(status)) return false;
  const int signal = WTERMSIG(status);
  return signal == SIGKILL || signal == SIGTERM || signal == SIGINT || signal == SIGHUP;
}

std::string said(int status) {
  if (WIFSIGNALED(status)) {
    return fmt::format("signal {} ({})", WTERMSIG(status), strsignal(WTERMSIG(status)));
  }
  return fmt::format("exit status {}", WEXITSTATUS(status));
}

}  // namespace

void run_program(const CaseOrder& order) {
  std::vector<std::string> own = order.words;
  std::vector<char*> words, environment = environment_of_case();
  for (std::string& word : own) words.push_back(word.data());
  words.push_back(nullptr);
  execve(words[0], words.data(), environment.data());
  std::fprintf(stderr, "cannot start %s: %s\n", words[0], std::strerror(errno));
  std::fflush(nullptr);
  _exit(kNotStarted);
}

CaseProcess::CaseProcess(CaseOrder order, const CaseBody& body) : order_(std::move(order)) {
  const fs::path folder = order_.folder;
  std::error_code error;
  fs::remove_all(folder, error);  // what an earlier attempt left
  if (!error) fs::create_directories(folder, error);
  output_ = folder / "output.txt";
  const int output =
      error ? -1 : open(output_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (output < 0) {
    if (!error) error.assign(errno, std::generic_category());
    throw text::InputError("'" + folder.string() + "' cannot be made: " + error.message(),
                           "Name another --out");
  }
  std::fflush(nullptr);  // else the child would write what is buffered once more
  const pid_t parent = getpid();
  start_ = Clock::now();
  process_ = fork();
  if (process_ == 0) {
    settle_child(output, parent);
    run_child(order_, body);
  }
  const int why = errno;
  close(output);
  if (process_ < 0) throw std::system_error(why, std::generic_category(), "fork");
  setpgid(process_, process_);  // here, too, as either may come first
}

CaseProcess::~CaseProcess() {
  if (process_ < 0) return;
  kill(-process_, SIGTERM);
  const Clock::time_point end = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                                   std::chrono::duration<double>(kGrace));
  while (!has_ended() && Clock::now() < end) usleep(5000);
  kill(-process_, SIGKILL);  // it, or what it started and left
  waitpid(process_, nullptr, 0);
}

bool CaseProcess::has_ended() const {
  siginfo_t info{};
  return waitid(P_PID, static_cast<id_t>(process_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
         info.si_pid == process_;
}

void CaseProcess::ask_to_end() const { kill(-process_, SIGTERM); }

double CaseProcess::seconds() const {
  return std::chrono::duration<double>(Clock::now() - start_).count();
}

double CaseProcess::seconds_left() const {
  if (order_.timeout <= 0 || is_killed_) return std::numeric_limits<double>::infinity();
  return std::max(0.0, order_.timeout + (is_late_ ? kGrace : 0) - seconds());
}

std::optional<CaseEnd> CaseProcess::poll() {
  if (has_ended()) {
    kill(-process_, SIGKILL);  // what it started and left; its number is its own until it is reaped
    int status = 0;
    waitpid(process_, &status, 0);
    process_ = -1;
    return ended(status);
  }
  if (seconds_left() <= 0) {
    is_killed_ = is_late_;
    kill(-process_, is_late_ ? SIGKILL : SIGTERM);
    is_late_ = true;
  }
  return std::nullopt;
}

CaseEnd CaseProcess::ended(int status) {
  CaseEnd end;
  end.index = order_.index;
  if (!is_late_ && is_from_outside(status)) return end;
  CaseResult& result = end.result.emplace();
  result.name = order_.name;
  result.seconds = seconds();
  result.worker = this_worker();
  if (is_late_) {
    result.problem = fmt::format("It took longer than {} s", order_.timeout);
  } else if (status != 0) {
    result.problem = said(status);
  } else {
    try {
      result.rows = collect(order_.results, order_.folder, output_);
    } catch (const text::InputError& error) {
      result.problem = error.problem();
    }
  }
  if (result.failed()) {
    result.output = last_lines(output_);
  } else if (!order_.keep) {
    std::error_code ignored;  // a folder that stays does no harm
    fs::remove_all(order_.folder, ignored);
  }
  return end;
}

void hold_signals() {
  const sigset_t set = held_signals();
  sigprocmask(SIG_BLOCK, &set, nullptr);
}

bool wait_for_signal(double seconds) {
  const sigset_t set = held_signals();
  const double at_most = std::min(std::max(seconds, 0.0), 3600.0);
  timespec time{};
  time.tv_sec = static_cast<time_t>(at_most);
  time.tv_nsec = static_cast<long>((at_most - std::floor(at_most)) * 1e9);
  const int signal = sigtimedwait(&set, nullptr, &time);
  return signal == SIGINT || signal == SIGTERM || signal == SIGHUP;
}

std::string this_worker() {
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  return fmt::format("{}:{}", host.data(), getpid());
}

}  // namespace prehend::sweep
