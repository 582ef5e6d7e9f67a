#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace prehend::eval {

struct PoolProgress {
  int done = 0;  // of the total, crashed ones included
  int total = 0;
  double seconds = 0;  // since the start
};

/// What became of a task whose process ended in it.
struct CrashedTask {
  int task = 0;
  std::string how;  // "signal 11 (Segmentation fault)", "exit status 3"
};

/// Runs task(0) ... task(count - 1), each once, in `processes` forked child processes that take the
/// next one as they get free; libraries that keep global state (PCL's Poisson) and crashes of one
/// task harm no other. A child that ends in a task is replaced. Tasks leave their results in files.
/// An exception out of a task is a crash. What tasks print is appended to `output`, so that the
/// terminal stays readable; its last lines tell more of a crash. `progress` is called in this
/// process about five times a second and at the end.
/// @pre No other thread runs in this process.
/// @throws std::system_error when no child can be made, std::invalid_argument for processes < 1.
std::vector<CrashedTask> run_in_processes(
    int count, int processes, const std::filesystem::path& output,
    const std::function<void(int)>& task,
    const std::function<void(const PoolProgress&)>& progress = {});

}  // namespace prehend::eval
