#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace prehend::nodes {

/// Threads of their own for what may wait, so that neither the graph's callbacks nor the server's
/// thread do. With one thread, tasks run in their order.
class Tasks {
 public:
  using Task = std::function<void()>;
  using Failed = std::function<void(const std::string& what)>;

  /// `failed` is told what leaves a task as an exception.
  Tasks(int threads, Failed failed);
  /// Ends after the tasks that run; those that wait are forgotten.
  ~Tasks();
  Tasks(const Tasks&) = delete;
  Tasks& operator=(const Tasks&) = delete;

  void post(Task task);
  /// The same, unless `most` tasks wait already: then false.
  bool post_unless_full(Task task, std::size_t most);
  /// Ends as the destructor does.
  void stop();

 private:
  void run();

  const Failed failed_;
  std::mutex mutex_;
  std::condition_variable news_;
  std::deque<Task> waiting_;
  bool ends_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace prehend::nodes
