#include "drivers/barrett/emulator/gcl/hand.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace prehend::drivers::barrett::gcl {
namespace {

constexpr char kCarriageReturn = '\r';

// What a byte looks like at another rate: nothing that means anything here.
std::uint8_t garbage(std::uint8_t byte) { return static_cast<std::uint8_t>((byte * 167u) | 0x80u); }

}  // namespace

Hand::Hand(const HandOptions& options, Send send) : options_(options), send_(std::move(send)) {
  if (options.plant == nullptr) throw std::invalid_argument("an emulated hand needs a plant");
  temperature_ = options.room;
  power_on();
}

void Hand::put(std::string_view text, Time now, double delay) {
  put(std::vector<std::uint8_t>(text.begin(), text.end()), now, delay);
}

void Hand::put(std::vector<std::uint8_t> bytes, Time now, double delay) {
  constexpr double kBits = 10;  // of a byte on the line
  const auto takes = to_time(static_cast<double>(bytes.size()) * kBits / baud_);
  line_free_ = std::max(line_free_, now + to_time(delay)) + takes;
  outputs_.push_back({line_free_, std::move(bytes)});
}

void Hand::reboot(Time now) {
  power_on();
  outputs_.clear();
  boots_until_ = now + to_time(options_.boot_time);
  command_plant();
}

void Hand::receive(Bytes bytes, Time now) {
  if (options_.host_baud) host_baud_ = options_.host_baud();
  const bool is_garbled = host_baud_ != 0 && host_baud_ != baud_;
  for (const std::uint8_t byte : bytes) {
    take(static_cast<char>(is_garbled ? garbage(byte) : byte), now);
  }
}

void Hand::take(char c, Time now) {
  switch (state_) {
    case State::kBooting:
      return;
    case State::kRunning:  // a command that moves ends by itself, or by Ctrl-C
      if (c == kAbort) abort(now);
      return;
    case State::kInLoop:
      block_.push_back(static_cast<std::uint8_t>(c));
      return take_block(now);
    case State::kIdle:
      break;
  }
  if (c == kAbort) return abort(now);
  if (c != kCarriageReturn) {
    if (line_.size() < kLongestLine) line_ += c;
    if (lost_echoes_ > 0) {
      --lost_echoes_;
    } else {
      put(std::string_view(&c, 1), now);
    }
    return;
  }
  const auto request = decode_request(std::exchange(line_, {}));
  if (request) return carry_out(*request, now);
  put(kEndOfLine, now);
  answer(kUnknownCommand, {}, now);
}

void Hand::answer(int error, const Words& lines, Time now) {
  std::string text;
  for (const std::string& line : lines) text += line + std::string(kEndOfLine);
  if (error != 0) text += "ERR " + std::to_string(error) + std::string(kEndOfLine);
  if (has_prompts_) text += kPrompt;
  put(text, now, delay_);
}

void Hand::abort(Time now) {
  ++aborts_;
  const bool says = state_ == State::kRunning || options_.prints_abort;
  line_.clear();
  block_.clear();
  state_ = State::kIdle;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (!runs_on_) switch_off(i);
    if (says) motors_[i].active["S"] |= kAborted;
  }
  put(kEndOfLine, now);
  answer(says ? kAborted : 0, {}, now);
}

// "\n\rERR n\n\r=> " instead of a block: from then on it is in Supervisory mode.
void Hand::end_loop(int error, Time now) {
  state_ = State::kIdle;
  block_.clear();
  for (std::size_t i = 0; i < kAxes; ++i) switch_off(i);
  put(kEndOfLine, now);
  answer(error, {}, now);
}

void Hand::take_block(Time now) {
  const auto header = static_cast<Header>(block_.front());
  if (block_.size() == 1 && block_.front() == static_cast<std::uint8_t>(kAbort)) return abort(now);
  const bool has_data = header == Header::kControl || header == Header::kControlOnly;
  const bool is_known =
      has_data || header == Header::kFeedback || header == Header::kAcknowledgement;
  if (!is_known) return end_loop(kInvalidHeader, now);
  if (has_data && block_.size() < 1 + layout_.control_size()) return;
  if (refusal_ != 0) return end_loop(refusal_, now);
  if (temperature_ >= options_.hot) return end_loop(kOverTemperature, now);
  if (has_data) {
    if (const auto controls = decode_control(Bytes(block_).subspan(1), layout_)) control(*controls);
  }
  block_.clear();
  ++blocks_;
  if (header == Header::kControlOnly || header == Header::kAcknowledgement) {
    return put(std::string_view(&kLooping, 1), now);
  }
  std::vector<std::uint8_t> bytes = encode(feedback(), layout_);
  if (garbled_blocks_ > 0) {
    --garbled_blocks_;
    bytes[std::min(garbled_place_, bytes.size() - 1)] ^= 0x40;
  }
  if (short_blocks_ > 0) {
    --short_blocks_;
    bytes.pop_back();
  }
  put(std::move(bytes), now);
}

Feedback Hand::feedback() {
  Feedback all;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const MotorLayout& of = layout_.motors[i];
    MotorFeedback& told = all.motors[i];
    const int here = static_cast<int>(std::lround(position(i)));
    const double unit = options_.gearing.counts_per_radian(i) * 0.01;  // counts per 10 ms
    told.speed = static_cast<int>(std::lround(motion_.velocity[i] * unit / of.speed_coefficient));
    told.strain = strain(i);
    told.position = here;
    told.delta = delta_of(here - motors_[i].told, of.delta_coefficient);
    if (of.loops && of.delta) {
      // The rest comes with the next block, or never.
      motors_[i].told =
          globals_["LFDPD"] != 0 ? here : motors_[i].told + told.delta * of.delta_coefficient;
    }
    told.breakaway = motors_[i].active["BP"];
  }
  all.temperature =
      static_cast<int>(std::lround(temperature_ * (options_.firmware == Firmware::k4_3 ? 10 : 1)));
  return all;
}

int Hand::property(std::size_t motor, const std::string& name) const {
  const auto& active = motors_.at(motor).active;
  const auto found = active.find(name);
  return found == active.end() ? 0 : found->second;
}

void Hand::update(Time now) {
  constexpr double kStep = 2e-3;  // s
  if (is_updated_ && now > last_update_) {
    const double before = motion_.time;
    motion_ = options_.plant->advance(to_seconds(now - last_update_));
    const double passed = motion_.time - before;
    for (std::size_t i = 0; i < kAxes; ++i) {
      for (double left = passed; left > 0; left -= kStep) advance_motor(i, std::min(left, kStep));
      look_at_motor(i);
    }
    watch_run(now);
    command_plant();
  } else if (!is_updated_) {
    motion_ = options_.plant->advance(0);
    for (std::size_t i = 0; i < kAxes; ++i) motors_[i].zero = motion_.position[i];
    boots_until_ = now + to_time(options_.boot_time);
  }
  last_update_ = now;
  is_updated_ = true;
  if (options_.host_baud) host_baud_ = options_.host_baud();
  if (state_ == State::kBooting && now >= boots_until_) {
    state_ = State::kIdle;
    // Its whole text is not published; these words are in it (BHAPI).
    put("\n\rBarrett Technology, Inc. BarrettHand Firmware\n\r", now);
    answer(0, {}, now);
  }
  while (!outputs_.empty() && outputs_.front().due <= now) {
    std::vector<std::uint8_t> bytes = std::move(outputs_.front().bytes);
    outputs_.pop_front();
    if (host_baud_ != 0 && host_baud_ != baud_)
      std::ranges::transform(bytes, bytes.begin(), garbage);
    if (!is_mute_) send_(bytes);
  }
  if (outputs_.empty() && next_baud_) {
    baud_ = *std::exchange(next_baud_, std::nullopt);
    answer(0, {}, now);
  }
}

}  // namespace prehend::drivers::barrett::gcl
