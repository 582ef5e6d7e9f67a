#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "drivers/camera/codec/depth_wire.h"

namespace prehend::drivers::camera {

/// The emulated depth camera's end of its line: answers the questions of one client at a time with
/// the newest picture (depth_wire.h), on this host's loopback interface.
class DepthServer {
 public:
  /// `port` 0: any free one. @throws geometry::InputError when the port is taken.
  explicit DepthServer(std::uint16_t port);
  ~DepthServer();

  /// "127.0.0.1:PORT"; the device's URI is prehend:// before that.
  const std::string& address() const { return address_; }
  /// What the camera sees from now on; numbers it.
  void show(DepthPicture picture);
  /// While true nobody is connected: the cable is out.
  void set_unplugged(bool unplugged) { unplugged_ = unplugged; }
  /// While true questions get no answer.
  void set_silent(bool silent) { silent_ = silent; }

 private:
  std::string address_;
  std::mutex mutex_;  // guards what follows
  std::vector<std::uint8_t> answer_;
  std::uint32_t number_ = 0;
  std::atomic<bool> unplugged_ = false;
  std::atomic<bool> silent_ = false;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

}  // namespace prehend::drivers::camera
