#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "drivers/dsa/driver/driver.h"
#include "drivers/wire/stream/byte_stream.h"
#include "drivers/wire/stream/reopening.h"

namespace prehend::drivers::dsa {

/// A Driver that lives: a thread reads, keeps time, opens the line and opens it again whenever it
/// is gone (hot unplug and plug).
class Device {
 public:
  using Open = std::function<std::unique_ptr<ByteStream>()>;
  /// A frame with the matrices it is of. Called by the thread; must not call the device.
  using OnFrame = std::function<void(const Frame&, const std::vector<MatrixInfo>&)>;

  /// `open` throws std::runtime_error while there is no line; it is tried every `retry` seconds.
  Device(const DriverOptions& options, Open open, OnFrame on_frame, Driver::Note note,
         double retry = 0.5);
  /// Ends the stream.
  ~Device();

  DriverState state();
  Statistics statistics();
  /// What is wrong with the line or the controller, "" when nothing is (or it is too early to say).
  std::string trouble();

 private:
  void run();
  void open_line();

  Open open_;
  Reopening reopening_;
  std::mutex mutex_;  // guards driver_ and line_problem_
  std::string line_problem_;
  std::unique_ptr<ByteStream> line_;
  Driver driver_;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

}  // namespace prehend::drivers::dsa
