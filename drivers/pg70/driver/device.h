#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "drivers/pg70/driver/driver.h"
#include "drivers/pg70/transport/link.h"
#include "drivers/wire/stream/reopening.h"

namespace prehend::drivers::pg70 {

/// A Driver that lives: a thread receives, keeps time, opens the link and opens it again whenever
/// it is gone. Commands may come from any thread.
class Device {
 public:
  using Open = std::function<std::unique_ptr<Link>()>;
  using OnState = std::function<void(const Reading&)>;
  using OnRound = std::function<void(const Reading&)>;

  /// `open` throws std::runtime_error while there is no link; it is tried every `retry` seconds and
  /// its words are noted when they change. `on_state` is called by the thread after each answer to
  /// GET STATE and whenever the driver's state changes; `note` by any thread. Neither may call the
  /// device. `on_round` is called by the thread each time it has served the link, at least every
  /// 25 ms while there is one: what stops being called is a driver that hangs.
  Device(const DriverOptions& options, Open open, OnState on_state, Driver::Note note,
         double retry = 0.5, OnRound on_round = {});
  /// Stops the gripper, as far as it can be reached, and ends.
  ~Device();

  /// Runs `work` on the driver with the present time, between two messages.
  template <class Work>
  auto with_driver(Work&& work) {
    const std::lock_guard lock(mutex_);
    return work(driver_, steady_now());
  }
  Reading reading();
  std::uint64_t damaged_messages() const { return damaged_; }
  /// What is wrong with the line, "" while there is one (or it is too early to say).
  std::string line_problem();
  /// Leaves the link and opens it again, so that CMD STOP comes first: somebody else has used it.
  /// Any thread; `words` are noted.
  void begin_anew(const std::string& words);

 private:
  void run();
  void open_link();
  bool leave_link();
  void round();
  void stop_at_end();
  std::string send(const Content& content);
  void serve(std::optional<LinkInput> input);

  Open open_;
  OnState on_state_;
  OnRound on_round_;
  Driver::Note note_;
  Reopening reopening_;
  std::mutex mutex_;  // guards driver_, the pointer link_ and what follows
  std::string line_problem_, anew_;
  std::shared_ptr<Link> link_;
  Driver driver_;
  std::atomic<std::uint64_t> damaged_ = 0;
  std::uint64_t link_damaged_ = 0;  // of the present link
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

}  // namespace prehend::drivers::pg70
