#include "drivers/kuka_rsi/emulator/served_controller.h"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <array>
#include <utility>

namespace prehend::drivers::kuka_rsi {

void corrupt_datagram(std::string& datagram, std::mt19937_64& random) {
  if (datagram.empty()) return;
  char& one = datagram[random() % datagram.size()];
  one = static_cast<char>(static_cast<unsigned char>(one) ^ (1u << random() % 8));
}

ServedController::ServedController(ArmPlant& plant, const ControllerOptions& controller,
                                   const ServedOptions& options, Note note)
    : controller_options_(controller),
      options_(options),
      note_(std::move(note)),
      pc_(peer_at(options.host, options.port)),
      controller_(plant, controller),
      out_(&corrupt_datagram, 1),
      in_(&corrupt_datagram, 2),
      thread_([this] { run(); }) {}

ServedController::~ServedController() {
  ends_ = true;
  thread_.join();
}

void ServedController::set_faults(const LineFaults& faults) {
  const std::lock_guard lock(mutex_);
  out_.set_faults(faults);
  in_.set_faults(faults);
}

void ServedController::run() {
  if (options_.priority > 0) {
    sched_param parameters{};
    parameters.sched_priority = options_.priority;
    if (::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &parameters) != 0) {
      note_(
          "real-time scheduling is not granted: its clock is as exact as this machine's load "
          "lets it be");
    }
  }
  const Time cycle = to_time(controller_options_.cycle);
  Time next = steady_now();
  ended_ = next - to_time(options_.restart_pause);
  while (!ends_) {
    listen(next);
    const Time now = steady_now();
    if (now - next > cycle) {
      missed_ += static_cast<std::uint64_t>((now - next) / cycle);
      next = now;
    }
    next += cycle;
    note_changes();  // the pause begins with the end
    {
      const std::lock_guard lock(mutex_);
      const bool is_off = controller_.state() != Controller::State::kRunning;
      const bool is_ready = !options_.is_ready || options_.is_ready();
      const bool is_due = noted_ == Controller::State::kOff || options_.restart_pause > 0;
      if (is_off && is_ready && is_due && now - ended_ >= to_time(options_.restart_pause)) {
        const std::string any = options_.host == "127.0.0.1" ? "127.0.0.1" : "0.0.0.0";
        socket_ = std::make_unique<UdpSocket>(any, 0);
        out_.clear();
        in_.clear();
        controller_.begin();
      }
      const std::string_view telegram = controller_.tick(now);
      if (!telegram.empty()) out_.push(std::string(telegram), now);
    }
    deliver(now);
    note_changes();
  }
}

// Answers count from when they came to this machine, whatever keeps this thread from its work.
void ServedController::listen(Time end) {
  std::array<char, 4096> buffer{};
  while (!ends_) {
    if (!socket_) {
      if (end > steady_now()) std::this_thread::sleep_for(end - steady_now());
      return;
    }
    constexpr auto kTurn = std::chrono::milliseconds(1);  // late datagrams leave in between
    const auto datagram = socket_->receive(buffer, std::min(end, steady_now() + kTurn));
    const std::string bytes(datagram.bytes);
    if (datagram.came) {
      const std::lock_guard lock(mutex_);
      in_.push(bytes, datagram.arrived);
    }
    deliver(steady_now());
    if (!datagram.came && steady_now() >= end) return;
  }
}

void ServedController::deliver(Time now) {
  const std::lock_guard lock(mutex_);
  while (const auto answer = in_.next_due(now)) controller_.receive(answer->second, answer->first);
  while (auto telegram = out_.pop(now)) {
    if (socket_) socket_->send(*telegram, pc_);
  }
}

void ServedController::note_changes() {
  const std::lock_guard lock(mutex_);
  const Controller::State state = controller_.state();
  if (state == noted_) return;
  noted_ = state;
  if (state == Controller::State::kRunning) {
    note_("RSI begins; telegrams go to " + pc_.name() + " from " + socket_->here().name());
  } else {
    ended_ = steady_now();
    note_("RSI ended: " + controller_.why());
  }
}

}  // namespace prehend::drivers::kuka_rsi
