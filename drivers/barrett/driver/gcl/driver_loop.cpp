// RealTime mode: a control block, its feedback, the next.

#include <algorithm>
#include <cmath>

#include "drivers/barrett/driver/gcl/driver.h"

namespace prehend::drivers::barrett::gcl {
namespace {

constexpr double kPerSecond = 100;  // of what is by 10 ms
constexpr int kMostVelocity = 127;  // LCV
constexpr int kMostGain = 255;      // LCPG
constexpr int kRestGain = 10;       // at rest: FPG of fingers in gripper::barrett
constexpr int kPressingBlocks = 2;  // in a row that show too much strain; one may have come to harm
constexpr int kMostBadBlocks = 3;   // in a row
constexpr std::size_t kMostError = 512;  // bytes of what is no block

}  // namespace

bool Driver::is_loop_wanted(Time now) const {
  if (!is_connected_ || stopping_ || motion_.initialises || motion_.concludes) return false;
  return !motion_.ended || (mode_ == Mode::kInLoop && now < linger_until_);
}

void Driver::send_block(Time now) {
  Controls controls{};
  is_at_rest_ = true;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const bool stood = motion_.axes[i].velocity == 0;
    controls[i] = control_of(i);
    if (stood) {  // its time of standing begins with its motion
      motion_.axes[i].standing_at = reading_.position[i];
      motion_.axes[i].standing_since = now;
    }
    is_at_rest_ = is_at_rest_ && controls[i].velocity == 0;
  }
  received_.clear();
  is_block_out_ = true;
  sent_ = now;
  next_block_ = std::max(next_block_ + to_time(options_.state_period), now);
  send_(encode_control(Header::kControl, controls, layout_));
}

// Zero velocities first.
void Driver::leave_loop(Time now) {
  if (!is_at_rest_) return send_block(now);
  begin_sync(now, true);
}

// The speed falls with the way that is left. A motor's command is LCPG/4 times the speed that is
// missing, so that at a stall it is LCPG/4 times LCV: a weak grip has a low gain, and goes slower
// where the lowest would press too much.
MotorControl Driver::control_of(std::size_t axis) {
  AxisMotion& motion = motion_.axes[axis];
  motion.velocity = 0;
  if (motion_.ended || motion.phase != Phase::kGoing || motion.pressing > 0) {
    return {.velocity = 0, .gain = kRestGain};
  }
  const double unit = counts_per_radian(axis) / kPerSecond;  // counts per 10 ms at 1 rad/s
  const double way = motion.target - reading_.position[axis];
  if (std::abs(way) <= 0.5 * options_.tolerance) return {.velocity = 0, .gain = kRestGain};
  const double speed = std::min(motion.speed, options_.approach * std::abs(way));
  const double most = std::min<double>(kMostVelocity, std::floor(4 * motion.current));
  const double wanted = std::clamp(std::round(speed * unit), 1.0, std::max(1.0, most));
  const double gain = std::floor(4 * motion.current / wanted);
  motion.velocity = static_cast<int>(std::copysign(wanted, way));
  return {.velocity = motion.velocity,
          .gain = static_cast<int>(std::clamp<double>(gain, 1, kMostGain))};
}

void Driver::take_block(Time now) {
  if (received_.front() != kLooping) {
    if (received_.size() > kMostError) {
      ++counters_.strange;
      return loop_failed("what comes in RealTime mode is no feedback", true, now);
    }
    if (!ends_in_prompt(received_)) return;
    const int error = errors_in(received_);
    reading_.error_code = error;
    const bool is_bad_block = (error & ~kInvalidHeader) == 0;
    return loop_failed(error != 0 ? "the hand left RealTime mode: " + describe_status(error)
                                  : "the hand left RealTime mode, and said nothing why",
                       is_bad_block, now);
  }
  if (received_.size() < layout_.feedback_size()) return;
  const auto feedback = decode_feedback(
      {reinterpret_cast<const std::uint8_t*>(received_.data()), received_.size()}, layout_);
  if (!feedback || !is_block_out_) {
    ++counters_.strange;
    return loop_failed("the hand sends more than a feedback block", true, now);
  }
  is_block_out_ = false;
  received_.clear();
  AxisValues counts;
  for (std::size_t i = 0; i < kAxes; ++i) counts[i] = feedback->motors[i].position;
  const std::uint64_t before = reading_.states;
  if (can_follow(counts, now)) take_positions(counts, now);
  if (reading_.states == before) {  // a byte of it came to harm: there is no checksum
    ++counters_.strange;
    if (++bad_blocks_ >= kMostBadBlocks) {
      loop_failed("positions in RealTime mode are none that can be", true, now);
    }
    return;
  }
  bad_blocks_ = 0;
  ++counters_.replies;
  const double unit = options_.temperature_unit > 0        ? options_.temperature_unit
                      : layout_.firmware == Firmware::k4_3 ? 0.1
                                                           : 1.0;
  reading_.temperature = unit * feedback->temperature;
  for (std::size_t i = 0; i < kAxes; ++i) {
    take_strain(i, feedback->motors[i].strain);
    look_at_axis(i, now);
  }
}

// No motor has gone so far since the last reading.
bool Driver::can_follow(const AxisValues& counts, Time now) const {
  constexpr double kSlack = 0.2, kTimes = 4;  // rad, of the greatest speed
  if (samples_.empty()) return true;
  const Sample& last = samples_.back();
  for (std::size_t i = 0; i < kAxes; ++i) {
    const double most =
        kSlack + kTimes * options_.limits.max_speed[i] * to_seconds(now - last.time);
    if (std::abs(counts[i] / counts_per_radian(i) - last.motor[i]) > most) return false;
  }
  return true;
}

// Whatever the reason, Ctrl-C makes sure that the motors stand; a motion goes on from there when a
// message came to harm.
void Driver::loop_failed(const std::string& why, bool goes_on, Time now) {
  bad_blocks_ = 0;
  if (stopping_ || !is_connected_) return begin_sync(now, false);
  if (!goes_on || (!motion_.ended && motion_.again++ >= options_.tries)) {
    note_(true, why);
    return stop(now, why);
  }
  note_(true, why + "; Ctrl-C, then " + (motion_.ended ? "nothing more" : "the motion goes on"));
  steps_.push_front({Step::Kind::kStatus, "FGET S"});
  begin_sync(now, false);
}

// After each feedback: who presses, stands although told to move, or is there.
void Driver::look_at_axis(std::size_t axis, Time now) {
  AxisMotion& motion = motion_.axes[axis];
  if (motion_.ended || motion.phase != Phase::kGoing) return;
  const double position = reading_.position[axis];
  const double way = motion.target - position;
  const double allowed = options_.strain_range * motion.current / options_.limits.max_current[axis];
  const bool has_gauge = axis != kSpread && !reading_.gauge_fails[axis];
  const bool presses = has_gauge && way > 0 && gauge_[axis] - gauge_rest_[axis] >= allowed;
  motion.pressing = presses ? motion.pressing + 1 : 0;
  if (motion.pressing >= kPressingBlocks) {
    motion.blocked = true;
    motion.phase = Phase::kEnded;
    return;
  }
  // What swings through its target has not arrived.
  if (std::abs(way) > 0.5 * options_.tolerance) {
    motion.arrived.reset();
  } else if (!motion.arrived) {
    motion.arrived = now;
  } else if (now - *motion.arrived >= to_time(options_.settle_time) && stands(axis)) {
    motion.phase = Phase::kEnded;
    return;
  }
  // A wrong unit of LCV makes it sixteen times as fast as it was told.
  constexpr double kTimes = 4, kSlack = 0.5;  // rad/s
  constexpr int kFastBlocks = 6;
  const bool is_fast = std::abs(reading_.velocity[axis]) > kTimes * motion.speed + kSlack;
  motion.fast = is_fast ? motion.fast + 1 : 0;
  if (motion.fast >= kFastBlocks) {
    const std::string words =
        std::string(axis_name(axis)) + " is much faster than it was told: see velocity_factor";
    note_(true, words);
    return stop(now, words);
  }
  const double told = std::abs(motion.velocity) * kPerSecond / counts_per_radian(axis);  // rad/s
  const double place = std::clamp(0.25 * told * options_.stall_time, 3e-4, 5e-3);
  if (motion.velocity == 0 || std::abs(position - motion.standing_at) > place) {
    motion.standing_at = position;
    motion.standing_since = now;
  } else if (now - motion.standing_since > to_time(options_.stall_time)) {
    motion.blocked = !is_there(axis);
    motion.phase = Phase::kEnded;
  }
}

}  // namespace prehend::drivers::barrett::gcl
