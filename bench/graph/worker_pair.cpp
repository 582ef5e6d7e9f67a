#include "bench/graph/worker_pair.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <sstream>
#include <thread>

#include "bench/graph/channel.h"

namespace prehend::bench {
namespace {

using namespace std::chrono_literals;

[[noreturn]] void become(const std::string& program, const std::vector<std::string>& arguments,
                         int output, int channel_end, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(1);  // it died before prctl
  dup2(output, STDOUT_FILENO);
  if (channel_end == WorkerProcess::kChannelDescriptor) {
    fcntl(channel_end, F_SETFD, 0);  // dup2 onto itself would leave it close-on-exec
  } else if (channel_end >= 0) {
    dup2(channel_end, WorkerProcess::kChannelDescriptor);
  }
  std::vector<char*> argv = {const_cast<char*>(program.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  execv(program.c_str(), argv.data());
  _exit(127);
}

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
}

}  // namespace

void parse_output(const std::string& text, WorkerOutput& output) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string key;
    words >> key;
    if (key == "latency_ns") {
      for (std::int64_t value = 0; words >> value;) output.latencies.push_back(value);
    } else if (double value = 0.0; words >> value) {
      output.figures[key] = value;
    }
  }
}

namespace {

/// Reads all workers' output until they have ended or the time is over.
void collect(const std::vector<std::unique_ptr<WorkerProcess>>& workers, std::int64_t deadline) {
  std::vector<WorkerProcess*> open;
  for (const auto& worker : workers) open.push_back(worker.get());
  while (!open.empty() && monotonic_now() < deadline && !interrupted) {
    std::vector<pollfd> entries;
    for (const WorkerProcess* worker : open) entries.push_back({worker->output(), POLLIN, 0});
    if (poll(entries.data(), entries.size(), 200) <= 0) continue;
    std::vector<WorkerProcess*> still_open;
    for (std::size_t i = 0; i < open.size(); ++i) {
      if (entries[i].revents == 0 || open[i]->read_output()) still_open.push_back(open[i]);
    }
    open = still_open;
  }
}

}  // namespace

WorkerProcess::WorkerProcess(const std::string& program, const std::vector<std::string>& arguments,
                             int channel_end) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw BenchError("no pipe: out of file descriptors?");
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ == 0) become(program, arguments, ends[1], channel_end, parent);
  close(ends[1]);
  output_ = ends[0];
  if (pid_ < 0) {
    close(output_);
    throw BenchError("no new process: out of processes or memory?");
  }
}

WorkerProcess::~WorkerProcess() {
  finish(0);
  close(output_);
}

bool WorkerProcess::read_output() {
  char buffer[65536];
  const ssize_t count = read(output_, buffer, sizeof(buffer));
  if (count > 0) text_.append(buffer, static_cast<std::size_t>(count));
  return count > 0 || (count < 0 && errno == EINTR);
}

bool WorkerProcess::finish(std::int64_t deadline) {
  if (pid_ < 0) return false;
  int status = 0;
  rusage usage{};
  pid_t done = 0;
  bool told = false;
  while ((done = wait4(pid_, &status, WNOHANG, &usage)) == 0 && monotonic_now() < deadline) {
    if (interrupted && !told) told = kill(pid_, SIGTERM) == 0;
    std::this_thread::sleep_for(2ms);
  }
  if (done == 0) {
    kill(pid_, SIGKILL);
    wait4(pid_, &status, 0, &usage);
  }
  pid_ = -1;
  cpu_seconds_ = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

WorkerOutput run_workers(const std::string& program, const Job& job, bool same_process) {
  std::vector<std::unique_ptr<WorkerProcess>> workers;
  const auto start = [&](const std::string& role, int channel_end) {
    workers.push_back(
        std::make_unique<WorkerProcess>(program, worker_arguments(role, job), channel_end));
  };
  if (same_process) {
    start("both", -1);
  } else {
    const ChannelEnds ends = make_channel();
    start("receiver", ends.receiver);
    start("sender", ends.sender);
    close_ends(ends);
  }
  const std::int64_t deadline =
      monotonic_now() + static_cast<std::int64_t>((job.seconds + 40.0) * 1e9);
  collect(workers, deadline);
  WorkerOutput output;
  output.ok = true;
  for (const auto& worker : workers) {
    output.ok = worker->finish(monotonic_now() + 3'000'000'000) && output.ok;
    output.cpu_seconds += worker->cpu_seconds();
    parse_output(worker->text(), output);
  }
  return output;
}

std::vector<std::string> worker_arguments(const std::string& role, const Job& job) {
  return {"--worker",
          role,
          job.peer,
          std::to_string(job.bytes),
          std::to_string(job.seconds),
          std::to_string(job.message_limit)};
}

WorkerCommand parse_worker_arguments(int argc, char** argv) {
  if (argc != 7 || argv[1] != std::string("--worker")) {
    throw BenchError("--worker is for bench_graph's own use; see --help");
  }
  try {
    return {argv[2], {argv[3], std::stoull(argv[4]), std::stod(argv[5]), std::stoi(argv[6])}};
  } catch (const std::logic_error&) {
    throw BenchError("--worker is for bench_graph's own use; see --help");
  }
}

}  // namespace prehend::bench
