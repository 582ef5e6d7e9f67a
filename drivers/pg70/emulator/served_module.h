#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "drivers/pg70/emulator/module.h"
#include "drivers/pg70/transport/link.h"

namespace prehend::drivers::pg70 {

/// A Module that lives behind a link: a thread answers and keeps time.
class ServedModule {
 public:
  /// `link` is the module's end of the wire. The plant must outlive the object.
  ServedModule(GripperPlant& plant, const ModuleOptions& options, std::unique_ptr<Link> link);
  ~ServedModule();

  /// Runs `work` on the module with the present time, between two messages.
  template <class Work>
  auto with_module(Work&& work) {
    const std::lock_guard lock(mutex_);
    return work(module_, steady_now());
  }

 private:
  void run();

  std::mutex mutex_;
  std::unique_ptr<Link> link_;
  Module module_;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

}  // namespace prehend::drivers::pg70
