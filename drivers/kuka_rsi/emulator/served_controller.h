#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "drivers/kuka_rsi/emulator/controller.h"
#include "drivers/kuka_rsi/transport/udp_socket.h"
#include "drivers/wire/faults/faulty_line.h"

namespace prehend::drivers::kuka_rsi {

struct ServedOptions {
  std::string host = "127.0.0.1";  // of the PC
  int port = 49152;
  double restart_pause = 2;  // s after which its program runs again (KR C2: 2 s); 0: it does not
  std::function<bool()> is_ready;  // whether its program can run; none: at once
  int priority = 0;                // of real-time scheduling; a real controller's clock is exact
};

/// An emulated controller with a socket and a clock of its own: a thread keeps its grid. Each time
/// RSI begins it sends from another port.
class ServedController {
 public:
  using Note = std::function<void(const std::string& words)>;
  /// `note` is called by the thread when RSI begins or ends.
  ServedController(ArmPlant& plant, const ControllerOptions& controller,
                   const ServedOptions& options, Note note);
  ~ServedController();

  /// Runs `work` on the controller between two cycles.
  template <class Work>
  auto with_controller(Work&& work) {
    const std::lock_guard lock(mutex_);
    return work(controller_);
  }
  /// Of what it sends and of what it receives.
  void set_faults(const LineFaults& faults);
  /// Cycles of the grid that the thread was too late for: it is none of a controller's then.
  std::uint64_t missed_cycles() const { return missed_; }

 private:
  void run();
  void listen(Time end);
  void deliver(Time now);
  void note_changes();

  ControllerOptions controller_options_;
  ServedOptions options_;
  Note note_;
  UdpPeer pc_;
  std::mutex mutex_;  // guards controller_ and the lines
  Controller controller_;
  FaultyLine<std::string> out_, in_;
  std::unique_ptr<UdpSocket> socket_;
  Controller::State noted_ = Controller::State::kOff;
  Time ended_{};
  std::atomic<std::uint64_t> missed_ = 0;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

/// Turns a bit of a datagram over.
void corrupt_datagram(std::string& datagram, std::mt19937_64& random);

}  // namespace prehend::drivers::kuka_rsi
