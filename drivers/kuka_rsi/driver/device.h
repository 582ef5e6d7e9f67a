#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "drivers/kuka_rsi/driver/driver.h"
#include "drivers/kuka_rsi/transport/udp_socket.h"

namespace prehend::drivers::kuka_rsi {

struct DeviceOptions {
  DriverOptions driver;
  std::string host = "0.0.0.0";  // of this machine, where the controller sends to
  int port = 49152;
  std::string controller;  // IPv4 address that alone is answered; "": whoever sends first
  int priority = 40;       // of real-time scheduling, 1 to 99; 0: not asked for
};

/// How long answers took, from a telegram's arrival at this machine (its kernel's stamp) until the
/// answer was handed to the kernel.
struct AnswerTimes {
  static constexpr std::array<double, 6> kBounds{0.0005, 0.001, 0.002, 0.004, 0.008, 0.012};  // s
  std::array<std::uint64_t, kBounds.size() + 1> counts{};  // up to each bound, and beyond
  double longest = 0;                                      // s

  void add(double seconds);
};

/// The driver on its socket. One thread answers telegrams and does nothing else: what others ask of
/// it is handed over by atomics, what it says is left where it never waits for a reader.
class Device {
 public:
  using Note = std::function<void(bool is_problem, const std::string& words)>;
  /// `note` is called by the thread before it begins, and by the caller here.
  /// @throws geometry::InputError when the port cannot be had, std::invalid_argument as Driver.
  Device(const DeviceOptions& options, const Limits& limits, const Note& note);
  /// Brakes first; then answers cease, and the controller ends RSI by itself.
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  Snapshot snapshot() const;
  AnswerTimes answer_times() const;
  /// "10.0.0.2:6008" of who is answered; "" before anybody was.
  std::string peer() const;
  /// Telegrams from others than the one that is answered.
  std::uint64_t strangers() const { return strangers_; }
  /// What real-time scheduling lacks, in words; "": nothing, or it was not asked for.
  std::string missing_real_time() const;

  /// Hands a motion over; false when it did not start, as the arm does not hold (see snapshot()).
  /// Waits for the thread, some cycles at most. One caller at a time.
  bool start(std::unique_ptr<Motion> motion);
  void stop() { asked_ |= kStop; }
  void latch() {
    is_latched_ = true;
    asked_ |= kLatch;
  }
  /// Whether there was a latch() to release.
  bool release() {
    asked_ |= kRelease;
    return is_latched_.exchange(false);
  }
  void feel(double force) {
    force_ = force;
    force_time_ = steady_now().count();
  }

 private:
  enum Asked : unsigned { kStop = 1, kLatch = 2, kRelease = 4 };

  void run();
  void turn(std::span<char> buffer);
  void take_what_was_asked();
  bool is_answered(const UdpPeer& peer);
  void tell();

  DeviceOptions options_;
  UdpSocket socket_;
  Driver driver_;  // of the thread
  UdpPeer active_;
  bool has_active_ = false;
  AnswerTimes times_;

  std::atomic<unsigned> asked_ = 0;
  std::atomic<double> force_ = 0;
  std::atomic<std::int64_t> force_time_ = 0;  // 0: none yet
  std::atomic<Motion*> incoming_ = nullptr, outgoing_ = nullptr;
  std::atomic<std::uint64_t> taken_ = 0;  // motions that the thread has looked at
  std::atomic<bool> started_ = false;     // the last of them
  std::atomic<bool> is_latched_ = false;  // as asked for; told_ has it a cycle later
  std::atomic<std::uint64_t> strangers_ = 0;

  mutable std::mutex mutex_;  // guards what follows; the thread only tries it
  Snapshot told_;
  AnswerTimes told_times_;
  UdpPeer told_peer_;
  bool has_told_peer_ = false;
  std::string missing_real_time_;

  std::mutex start_mutex_;
  std::atomic<bool> is_ready_ = false, ends_ = false;
  std::thread thread_;
};

}  // namespace prehend::drivers::kuka_rsi
