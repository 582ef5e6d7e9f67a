#include "drivers/sdh/driver/device.h"

#include <array>
#include <utility>

namespace prehend::drivers::sdh {
namespace {

constexpr auto kTick = std::chrono::milliseconds(5);  // the next question waits no longer
constexpr auto kPause = std::chrono::milliseconds(20);
constexpr auto kWriteTime = std::chrono::milliseconds(50);

}  // namespace

Device::Device(const DriverOptions& options, Open open, OnState on_state, Driver::Note note,
               double retry, OnRound on_round)
    : power_off_at_end_(options.power_off_at_end),
      open_(std::move(open)),
      on_state_(std::move(on_state)),
      on_round_(std::move(on_round)),
      note_(std::move(note)),
      reopening_(retry, note_),
      // Called with the lock held, by the driver. What cannot be written is lost; its answer is
      // missed.
      driver_(
          options,
          [this](Bytes bytes) -> std::string {
            if (!line_) return "there is no line to the hand";
            const IoResult result = line_->write(bytes, kWriteTime);
            return result.status == IoStatus::kOk ? std::string() : result.problem;
          },
          note_),
      thread_([this] { run(); }) {}

Device::~Device() {
  ends_ = true;
  thread_.join();
}

Reading Device::reading() {
  const std::lock_guard lock(mutex_);
  return driver_.reading();
}

std::string Device::line_problem() {
  const std::lock_guard lock(mutex_);
  return line_problem_;
}

void Device::open_line() {
  std::shared_ptr<ByteStream> line = reopening_.attempt(open_, kPause);
  const std::lock_guard lock(mutex_);
  line_problem_ = reopening_.problem();
  if (!line) return;
  line_ = std::move(line);
  driver_.connected(steady_now());
}

void Device::serve() {
  std::array<std::uint8_t, 4096> buffer;
  const IoResult result = line_->read(buffer, kTick);
  Reading reading;
  bool is_news = false;
  {
    const std::lock_guard lock(mutex_);
    const Time now = steady_now();
    const std::uint64_t states = driver_.reading().states;
    const DriverState state = driver_.reading().state;
    if (result.status == IoStatus::kClosed) {
      line_problem_ = line_->name() + " is gone: " + result.problem;
      driver_.disconnected(line_problem_);
      line_.reset();
    } else {
      if (result.count > 0) driver_.receive(Bytes(buffer).first(result.count), now);
      driver_.update(now);
    }
    reading = driver_.reading();
    is_news = reading.states != states || reading.state != state;
  }
  if (is_news) on_state_(reading);
}

void Device::round() {
  if (!on_round_) return;
  const std::string why = on_round_(reading());
  if (why.empty()) return;
  with_driver([&](Driver& driver, Time now) { driver.begin_anew(why, now); });
  on_round_(reading());
}

void Device::run() {
  while (!ends_) {
    if (line_) {  // set by this thread only
      serve();
    } else {
      open_line();
    }
    round();
  }
  stop_at_end();
}

void Device::stop_at_end() {
  if (!line_) return;
  constexpr auto kPatience = std::chrono::seconds(1);
  const DriverState state = reading().state;
  const auto serve_until_settled = [&] {
    const Time end = steady_now() + kPatience;
    while (line_ && steady_now() < end) {
      serve();
      if (on_round_) on_round_(reading());
      if (with_driver([](Driver& driver, Time) { return driver.is_settled(); })) return true;
    }
    return false;
  };
  if (state == DriverState::kHolding) {
    return note_(true,
                 "the hand holds something, so its axes stay on; powered for longer than 20 "
                 "min it overheats");
  }
  with_driver([](Driver& driver, Time now) { driver.stop(now, "the driver ends"); });
  if (!serve_until_settled()) {
    if (line_) note_(true, "the hand was told to stop, but was not seen to stand");
    return;
  }
  if (!power_off_at_end_ || !line_) return;
  with_driver([](Driver& driver, Time now) { driver.power_off(now, "the driver ends"); });
  if (!serve_until_settled() && line_) {
    note_(true, "the hand's axes were told to switch off, but were not seen to");
  }
}

}  // namespace prehend::drivers::sdh
