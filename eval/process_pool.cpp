#include "eval/process_pool.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <stdexcept>
#include <system_error>
#include <thread>

#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace prehend::eval {
namespace {

constexpr int kIdle = -1;
constexpr int kTaskFailed = 70;  // exit status of a child whose task threw (EX_SOFTWARE)
constexpr int kNoOutput = 73;    // of one that could not open the output (EX_CANTCREAT)

// What parent and children share: the next task, how many are done and what each child is at.
class SharedState {
 public:
  explicit SharedState(int children) : bytes_(sizeof(std::atomic<int>) * (2 + children)) {
    void* memory = mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) {
      throw std::system_error(errno, std::generic_category(), "shared memory for child processes");
    }
    counters_ = static_cast<std::atomic<int>*>(memory);
    for (int i = 0; i < 2 + children; ++i) new (counters_ + i) std::atomic<int>(i < 2 ? 0 : kIdle);
  }
  ~SharedState() { munmap(counters_, bytes_); }
  SharedState(const SharedState&) = delete;
  SharedState& operator=(const SharedState&) = delete;

  std::atomic<int>& next() { return counters_[0]; }
  std::atomic<int>& done() { return counters_[1]; }
  std::atomic<int>& task_of(int child) { return counters_[2 + child]; }

 private:
  std::size_t bytes_;
  std::atomic<int>* counters_ = nullptr;
};

[[noreturn]] void run_child(SharedState& state, int child, int count,
                            const std::filesystem::path& output,
                            const std::function<void(int)>& task) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (std::freopen(output.c_str(), "a", stdout) == nullptr ||
      std::freopen(output.c_str(), "a", stderr) == nullptr) {
    _exit(kNoOutput);
  }
  for (int i = state.next()++; i < count; i = state.next()++) {
    state.task_of(child) = i;
    try {
      task(i);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "task %d: %s\n", i, error.what());
      std::fflush(nullptr);
      _exit(kTaskFailed);
    }
    state.task_of(child) = kIdle;
    ++state.done();
  }
  // Destructors belong to the parent.
  std::fflush(nullptr);
  _exit(0);
}

std::string describe(int status) {
  if (WIFSIGNALED(status)) {
    return "signal " + std::to_string(WTERMSIG(status)) + " (" + strsignal(WTERMSIG(status)) + ")";
  }
  return "exit status " + std::to_string(WEXITSTATUS(status));
}

}  // namespace

std::vector<CrashedTask> run_in_processes(
    int count, int processes, const std::filesystem::path& output,
    const std::function<void(int)>& task,
    const std::function<void(const PoolProgress&)>& progress) {
  if (processes < 1) throw std::invalid_argument("run_in_processes: processes must be positive");
  processes = std::max(1, std::min(processes, count));
  SharedState state(processes);
  std::vector<pid_t> children(processes, 0);
  const auto start_child = [&](int child) {
    std::fflush(nullptr);  // else the child would write what is buffered once more
    const pid_t pid = fork();
    if (pid < 0) throw std::system_error(errno, std::generic_category(), "fork");
    if (pid == 0) run_child(state, child, count, output, task);
    children[child] = pid;
  };
  for (int child = 0; child < processes; ++child) start_child(child);

  const auto start = std::chrono::steady_clock::now();
  const auto report = [&] {
    if (!progress) return;
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    progress({state.done(), count, elapsed.count()});
  };
  std::vector<CrashedTask> crashed;
  for (int running = processes; running > 0;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    for (int child = 0; child < processes; ++child) {
      int status = 0;
      if (children[child] == 0 || waitpid(children[child], &status, WNOHANG) != children[child]) {
        continue;
      }
      children[child] = 0;
      --running;
      if (WIFEXITED(status) && WEXITSTATUS(status) == kNoOutput) {
        throw std::runtime_error("cannot write '" + output.string() + "'");
      }
      const int at = state.task_of(child).exchange(kIdle);
      if (at == kIdle) continue;
      crashed.push_back({at, describe(status)});
      ++state.done();
      if (state.next() < count) {
        start_child(child);
        ++running;
      }
    }
    report();
  }
  std::sort(crashed.begin(), crashed.end(),
            [](const CrashedTask& a, const CrashedTask& b) { return a.task < b.task; });
  return crashed;
}

}  // namespace prehend::eval
