#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "drivers/camera/driver/delivery_rate.h"
#include "drivers/camera/transport/depth_source.h"

namespace prehend::drivers::camera {

struct DepthDeviceOptions {
  double most_rate = 0;   // 1/s of views handed on, at most; 0: each
  double stale_time = 1;  // s without a view that are told
  double retry = 0.5;     // s between tries to open it
  double grace = 2;       // s at first in which one that cannot be opened is not told
};

struct DepthStatistics {
  std::uint64_t views = 0;        // handed on, or left out for most_rate
  std::uint64_t unpaired = 0;     // depth and colour images without a partner
  std::uint64_t lost = 0;         // how often it went away
  std::uint64_t connections = 0;  // how often it was opened
};

/// A depth camera: a thread opens it, takes views, and opens it again when it is gone (hot unplug
/// and replug). It moves nothing, so there is nothing to stop. Trouble is a state, as of
/// CameraDevice.
class DepthDevice {
 public:
  /// @throws std::runtime_error (geometry::InputError among them) when it cannot.
  using Open = std::function<std::unique_ptr<DepthSource>()>;
  using OnView = std::function<void(DepthView view)>;
  using Note = std::function<void(bool is_problem, const std::string& words)>;

  /// All functions are called by the thread.
  /// @throws std::invalid_argument for options that cannot be.
  DepthDevice(const DepthDeviceOptions& options, Open open, OnView on_view, Note note);
  ~DepthDevice();

  DepthStatistics statistics() const;
  /// What is wrong; "" while views come.
  std::string trouble() const;
  /// What is not as asked for, though views come.
  std::string remark() const;
  /// It is a recording that is over.
  bool is_at_end() const { return is_at_end_; }

 private:
  void run();
  void take(DepthView view);

  DepthDeviceOptions options_;
  Open open_;
  OnView on_view_;
  Note note_;
  DeliveryRate delivery_;
  mutable std::mutex mutex_;  // guards what follows
  DepthStatistics statistics_;
  std::uint64_t unpaired_before_ = 0;  // of sources that are gone
  std::string trouble_, remark_;
  bool is_open_ = false;
  Time last_view_{};  // when it came, or the source was opened
  std::atomic<bool> is_at_end_ = false;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

}  // namespace prehend::drivers::camera
