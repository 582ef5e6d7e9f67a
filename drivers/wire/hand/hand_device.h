#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>

#include "drivers/wire/hand/port_event.h"
#include "drivers/wire/stream/reopening.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers {

/// A hand's driver that lives, as its node sees it. Commands may come from any thread.
template <class Driver>
class HandDevice {
 public:
  using Reading = std::remove_cvref_t<decltype(std::declval<const Driver&>().reading())>;
  using OnState = std::function<void(const Reading&)>;
  /// Returns why the connection has to begin anew; "" when it need not.
  using OnRound = std::function<std::string(const Reading&)>;
  using Note = std::function<void(bool is_problem, const std::string& words)>;

  virtual ~HandDevice() = default;
  HandDevice(const HandDevice&) = delete;
  HandDevice& operator=(const HandDevice&) = delete;

  /// Runs `work` on the driver with the present time, between two messages.
  template <class Work>
  auto with_driver(Work&& work) {
    const std::lock_guard lock(mutex_);
    return work(*driver_, steady_now());
  }
  Reading reading() {
    const std::lock_guard lock(mutex_);
    return driver_->reading();
  }
  /// What is wrong with the line; "" while it is there, or when it is too early to say.
  std::string line_problem() {
    const std::lock_guard lock(mutex_);
    return line_problem_;
  }

 protected:
  HandDevice() = default;

  std::mutex mutex_;  // guards what follows
  std::string line_problem_;
  std::unique_ptr<Driver> driver_;
};

/// A HandDevice with its thread, which receives, keeps time, opens the line and opens it again
/// whenever it is gone. `Port` is StreamPort or BusPort; `Interface` what the node sees of the
/// driver.
template <class Driver, class Port, class Interface = Driver>
class WiredHand : public HandDevice<Interface> {
  using Base = HandDevice<Interface>;

 public:
  using typename Base::Note;
  using typename Base::OnRound;
  using typename Base::OnState;
  using typename Base::Reading;
  using Open = std::function<std::unique_ptr<typename Port::Line>()>;
  /// The port as it is now; null: there is none. For the driver, whose calls hold the lock.
  using Now = std::function<Port*()>;

  struct Callbacks {
    Open open;  // throws std::runtime_error while there is no line; tried every `retry` seconds
    OnState on_state;  // by the thread, after each whole round of readings and changed state
    Note note;         // by any thread
    double retry = 0.5;
    /// By the thread each time it has served the line, at least every 25 ms: what stops being
    /// called is a driver that hangs.
    OnRound on_round = {};
    bool power_off_at_end = false;  // of a driver that has power_off(), unless its hand holds
  };

  /// `make` makes the driver, given Now. None of the callbacks may call the device.
  template <class Make>
  WiredHand(Callbacks callbacks, const Make& make)
      : callbacks_(std::move(callbacks)), reopening_(callbacks_.retry, callbacks_.note) {
    auto driver = make([this] { return port_.get(); });
    wired_ = driver.get();
    this->driver_ = std::move(driver);
    thread_ = std::thread([this] { run(); });
  }
  /// Stops the hand and waits until that is seen, at most a second.
  ~WiredHand() override {
    ends_ = true;
    thread_.join();
  }

 private:
  // The next question waits no longer while something is under way, else as long as rounds may
  // take: waking up is most of what a hand at rest costs.
  static constexpr auto kTick = std::chrono::milliseconds(2), kIdle = std::chrono::milliseconds(10);
  static constexpr auto kRound = std::chrono::milliseconds(10);
  static constexpr auto kPause = std::chrono::milliseconds(20);

  void run() {
    while (!ends_) {
      if (port_) {  // set by this thread only
        serve();
      } else {
        open();
      }
      round();
    }
    stop_at_end();
  }
  void open() {
    auto line = reopening_.attempt(callbacks_.open, kPause);
    const std::lock_guard lock(this->mutex_);
    this->line_problem_ = reopening_.problem();
    if (!line) return;
    port_ = std::make_shared<Port>(std::move(line));
    wired_->connected(steady_now());
  }
  void serve() {
    const std::shared_ptr<Port> port = port_;
    port->wait(is_settled_ ? kIdle : kTick);
    std::optional<Reading> news;
    {
      const std::lock_guard lock(this->mutex_);
      const auto states = wired_->reading().states;
      const auto state = wired_->reading().state;
      port->pass_on(*wired_, [this](PortEvent event, const std::string& words) {
        return take(event, words);
      });
      wired_->update(steady_now());
      is_settled_ = wired_->is_settled();
      const Reading& reading = wired_->reading();
      if (reading.states != states || reading.state != state) news = reading;
    }
    if (news) callbacks_.on_state(*news);
  }
  bool take(PortEvent event, const std::string& words) {
    std::string& problem = this->line_problem_;
    switch (event) {
      case PortEvent::kRemark:
        callbacks_.note(true, words);
        return true;
      case PortEvent::kDown:
        problem = port_->name() + ": " + words;
        wired_->disconnected(problem);
        return true;
      case PortEvent::kUp:
        problem.clear();
        callbacks_.note(false, words);
        if (!wired_->reading().is_connected()) wired_->connected(steady_now());
        return true;
      case PortEvent::kClosed:
        break;
    }
    problem = port_->name() + " is gone: " + words;
    wired_->disconnected(problem);
    port_.reset();
    return false;
  }
  void round() {
    const Time now = steady_now();
    if (!callbacks_.on_round || now - last_round_ < kRound) return;
    last_round_ = now;
    const std::string why = callbacks_.on_round(this->reading());
    if (why.empty()) return;
    this->with_driver([&](auto& driver, Time then) { driver.begin_anew(why, then); });
    callbacks_.on_round(this->reading());
  }
  bool serve_until_settled() {
    constexpr auto kPatience = std::chrono::seconds(1);
    const Time end = steady_now() + kPatience;
    while (port_ && steady_now() < end) {
      serve();
      if (callbacks_.on_round) callbacks_.on_round(this->reading());
      if (this->with_driver([](auto& driver, Time) { return driver.is_settled(); })) return true;
    }
    return false;
  }
  void stop_at_end() {
    constexpr bool kHasOff = requires(Driver & driver, Time now) {
      driver.power_off(now, "the driver ends");
    };
    if (!port_) return;
    if constexpr (kHasOff) {
      if (this->reading().state == decltype(this->reading().state)::kHolding) {
        return callbacks_.note(true, Driver::kStaysOn);
      }
    }
    this->with_driver([](auto& driver, Time now) { driver.stop(now, "the driver ends"); });
    if (!serve_until_settled()) {
      if (port_) callbacks_.note(true, "the hand was told to stop, but was not seen to stand");
      return;
    }
    if constexpr (kHasOff) {
      if (!callbacks_.power_off_at_end || !port_) return;
      this->with_driver([](auto& driver, Time now) { driver.power_off(now, "the driver ends"); });
      if (!serve_until_settled() && port_) {
        callbacks_.note(true, "the hand's axes were told to switch off, but were not seen to");
      }
    }
  }

  Callbacks callbacks_;
  Reopening reopening_;
  std::shared_ptr<Port> port_;  // changed by the thread, with the lock held
  Driver* wired_ = nullptr;
  bool is_settled_ = false;  // of the thread
  Time last_round_{};        // of the thread
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

}  // namespace prehend::drivers
