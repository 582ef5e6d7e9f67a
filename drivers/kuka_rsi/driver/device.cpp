#include "drivers/kuka_rsi/driver/device.h"

#include <algorithm>
#include <utility>

#include "drivers/kuka_rsi/codec/xml_reader.h"
#include "drivers/kuka_rsi/driver/real_time.h"

namespace prehend::drivers::kuka_rsi {
namespace {

constexpr double kBrakeTime = 2;  // s, at the end

bool is_moving(State state) { return state == State::kMoving || state == State::kStopping; }

}  // namespace

void AnswerTimes::add(double seconds) {
  const auto place = std::lower_bound(kBounds.begin(), kBounds.end(), seconds);
  ++counts[static_cast<std::size_t>(place - kBounds.begin())];
  longest = std::max(longest, seconds);
}

Device::Device(const DeviceOptions& options, const Limits& limits, const Note& note)
    : options_(options), socket_(options.host, options.port), driver_(options.driver, limits) {
  if (!options.controller.empty()) peer_at(options.controller, 0);
  note(false, "waits for the controller on UDP " + socket_.here().name());
  thread_ = std::thread([this] { run(); });
  // Locking memory takes milliseconds, in which the first telegrams would be late.
  is_ready_.wait(false);
}

Device::~Device() {
  stop();
  const Time end = steady_now() + to_time(kBrakeTime);
  while (is_moving(snapshot().state) && steady_now() < end) {
    std::this_thread::sleep_for(to_time(options_.driver.cycle));
  }
  ends_ = true;
  thread_.join();
  delete incoming_.exchange(nullptr);
  delete outgoing_.exchange(nullptr);
}

Snapshot Device::snapshot() const {
  const std::lock_guard lock(mutex_);
  return told_;
}

AnswerTimes Device::answer_times() const {
  const std::lock_guard lock(mutex_);
  return told_times_;
}

std::string Device::peer() const {
  const std::lock_guard lock(mutex_);
  return has_told_peer_ ? told_peer_.name() : std::string();
}

std::string Device::missing_real_time() const {
  const std::lock_guard lock(mutex_);
  return missing_real_time_;
}

bool Device::start(std::unique_ptr<Motion> motion) {
  const std::lock_guard lock(start_mutex_);
  delete outgoing_.exchange(nullptr);
  const std::uint64_t before = taken_;
  delete incoming_.exchange(motion.release());
  constexpr auto kPatience = std::chrono::seconds(2);  // of a machine that is held up
  const Time end = steady_now() + kPatience;
  while (taken_ == before && steady_now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  if (taken_ == before) {
    // Either it is still here, or the thread has it after all.
    Motion* left = incoming_.exchange(nullptr);
    if (left) {
      delete left;
      return false;
    }
    while (taken_ == before) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return started_;
}

void Device::run() {
  if (options_.priority > 0) {
    const std::string missing = ask_for_real_time(options_.priority);
    const std::lock_guard lock(mutex_);
    missing_real_time_ = missing;
  }
  std::array<char, 2 * XmlReader::kLongestText> buffer{};
  is_ready_ = true;
  is_ready_.notify_all();
  while (!ends_) turn(buffer);
}

void Device::turn(std::span<char> buffer) {
  const auto datagram = socket_.receive(buffer, steady_now() + to_time(options_.driver.cycle));
  take_what_was_asked();
  driver_.on_time(steady_now());
  if (datagram.came) {
    if (is_answered(datagram.peer)) {
      const std::string_view answer = driver_.on_packet(datagram.bytes, datagram.arrived);
      if (!answer.empty()) {
        socket_.send(answer, datagram.peer);
        times_.add(to_seconds(steady_now() - datagram.arrived));
      }
    } else {
      ++strangers_;
    }
  }
  tell();
}

void Device::take_what_was_asked() {
  const unsigned asked = asked_.exchange(0);
  if (asked & kRelease) driver_.release();
  if (asked & kStop) driver_.stop();
  if (asked & kLatch) driver_.latch();
  if (const std::int64_t when = force_time_; when != 0) driver_.feel(force_, Time(when));
  if (Motion* motion = incoming_.exchange(nullptr)) {
    auto back = driver_.start(std::unique_ptr<Motion>(motion));
    started_ = back.get() != motion;
    outgoing_ = back.release();  // empty until now: start() takes it away; freed there
    ++taken_;
  }
}

// One controller at a time. Restarted it sends from another port, but not before it was silent.
bool Device::is_answered(const UdpPeer& peer) {
  if (!options_.controller.empty() &&
      peer.address.sin_addr.s_addr != peer_at(options_.controller, 0).address.sin_addr.s_addr) {
    return false;
  }
  const bool is_free = !has_active_ || driver_.snapshot().state == State::kSilent;
  if (is_free) active_ = peer;
  has_active_ = true;
  return active_ == peer;
}

void Device::tell() {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock) return;  // a reader has it; the next telegram is soon
  told_ = driver_.snapshot();
  told_times_ = times_;
  told_peer_ = active_;
  has_told_peer_ = has_active_;
}

}  // namespace prehend::drivers::kuka_rsi
