#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>

#include "drivers/barrett/codec/gearing.h"
#include "drivers/barrett/codec/message.h"
#include "drivers/barrett/codec/tactile.h"
#include "drivers/barrett/emulator/clutch_hand.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::barrett {

struct HandOptions {
  HandPlant* plant = nullptr;  // that it moves; outlives the hand
  Gearing gearing = {};
  bool has_joint_encoders = true;
  int firmware = 174;
  bool is_awake = false;      // at power-on; else it is in monitor mode until STAT is set to 2
  double self_start = 0;      // s after power-on, when it wakes by itself; 0: never
  double wake_time = 0.2;     // s of silence behind STAT 2; up to 1 s is told of real ones
  double most_torque = 3300;  // unit of MT at which its motors give their most
  double tolerance = 0.004;   // rad, within which an axis is where it was sent
  double room = 25;           // degree Celsius
};

/// A BH8-280's four pucks over a plant, as far as Barrett's software shows them. Like Driver it
/// does no input or output: frames go to `send`. Call update() every few milliseconds.
class Hand {
 public:
  using Send = std::function<void(const CanFrame&)>;
  /// @throws std::invalid_argument without a plant.
  Hand(const HandOptions& options, Send send);

  void receive(const CanFrame& frame, Time now);
  void update(Time now);
  /// What the pad of a finger, or of the palm (the spread's puck), feels: counts.
  void set_cells(std::size_t axis, const Cells& cells) { pucks_.at(axis).cells = cells; }

  // Faults.
  /// Power off and on: motors off, properties as after power-on, zero where it stands.
  void reboot(Time now);
  /// Nothing that it says arrives, or nothing of this puck; it goes on moving.
  void set_mute(bool mute, std::optional<std::size_t> axis = {});
  /// Orders to set this property get lost on their way to it.
  void set_deaf_to(std::optional<Property> property) { deaf_to_ = property; }
  void set_pad_failure(bool fails) { pads_fail_ = fails; }
  void set_temperature(double celsius);
  /// All pucks show STAT 1 and move nothing.
  void set_error(bool on);

  // What is seen of it.
  const HandPlant::Motion& motion() const { return motion_; }
  Mode mode(std::size_t axis) const { return pucks_[axis].mode; }
  bool is_moving() const;
  int property(std::size_t axis, Property property) const {
    return pucks_.at(axis).values[static_cast<std::size_t>(property)];
  }
  std::uint64_t moves() const { return moves_; }  // CMD M, HI, C, O, M= that were carried out
  std::uint64_t stops() const { return stops_; }  // MODE 0 and CMD T

 private:
  struct Puck {
    std::array<std::int32_t, kProperties> values{};
    Status status = Status::kMonitor;
    std::optional<Time> wakes;
    Mode mode = Mode::kIdle;
    bool initialises = false, mute = false;
    double zero = 0;                     // rad of the plant, that is P = 0
    double reference = 0, velocity = 0;  // counts, counts/s
    double standing_at = 0;              // counts
    double standing_since = 0;           // s, plant
    double motor_temperature = 25, temperature = 25;
    Cells cells{};
  };
  void power_on(std::size_t axis, Time now);
  void ask(std::size_t axis, std::uint8_t property);
  void set(std::size_t axis, std::uint8_t property, std::int32_t value, Time now);
  void carry_out(std::size_t axis, Command command, Time now);
  void begin_move(std::size_t axis, std::int32_t target);
  void switch_mode(std::size_t axis, Mode mode);
  void end_motion(std::size_t axis);
  void advance_axis(std::size_t axis, double h);
  void look_at_axis(std::size_t axis);
  void warm_up(std::size_t axis, double h);
  double torque_limit(std::size_t axis) const;
  double position(std::size_t axis) const;  // counts
  double joint_position(std::size_t axis) const;
  void command_plant();
  void put(std::size_t axis, const CanFrame& frame);

  HandOptions options_;
  Send send_;
  std::array<Puck, kAxes> pucks_;
  HandPlant::Motion motion_;
  Time last_update_{}, powered_at_{};
  bool is_updated_ = false, is_mute_ = false, pads_fail_ = false;
  std::optional<Property> deaf_to_;
  std::uint64_t moves_ = 0, stops_ = 0;
};

}  // namespace prehend::drivers::barrett
