#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "drivers/sdh/codec/firmware.h"
#include "drivers/sdh/codec/stream.h"
#include "drivers/sdh/emulator/hand_plant.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::sdh {

struct HandOptions {
  HandPlant* plant = nullptr;  // that it moves; outlives the hand
  Firmware firmware{{0, 0, 3, 3}};
  bool has_checksum = true;  // of binary messages: RS-232
  double baud = 115200;      // of the line, 10 bits a byte; 0: as fast as it is read
  // degree, degree/s, degree/s^2, A (SDHLibrary-Python, sdhserial.py)
  AxisValues lower{0, -90, -90, -90, -90, -90, -90};
  AxisValues upper{90, 90, 90, 90, 90, 90, 90};
  AxisValues speed_limit{83, 140, 200, 140, 200, 140, 200};
  AxisValues acceleration_limit{5000, 400, 1500, 400, 1500, 400, 1500};
  double most_current = 1;
  AxisValues current_limit{1, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5};  // after power-on; not confirmed
  double boot_time = 2;       // s of silence after power-on; not published
  double blocked_time = 0.1;  // s of standing, by the plant's clock, that show as blocked
  double tolerance = 0.2;     // degree, within which an axis is where it was sent
  bool debug_lines = false;  // @ lines before replies of m, selgrip and grip, whatever the firmware
  double hot = 80;           // degree Celsius, from where on it refuses to move; not published
};

/// An SDH-2's electronics, as far as the vendor's library shows them, over a plant. Like Driver it
/// does no input or output: bytes go to `send` when a line of its speed would have carried them.
/// Speaks lines and binary messages mixed, split at any byte. Call update() every few milliseconds.
class Hand {
 public:
  using Send = std::function<void(Bytes)>;
  /// @throws std::invalid_argument without a plant.
  Hand(const HandOptions& options, Send send);

  void receive(Bytes bytes, Time now);
  void update(Time now);

  // Faults.
  /// Power off and on: axes off, targets and limits as after power-on, silent for boot_time.
  void reboot(Time now);
  /// Says nothing, as an overheated hand; it goes on moving.
  void set_mute(bool mute) { is_mute_ = mute; }
  /// Neither carries this command out nor answers it, as if it got lost.
  void set_deaf_to(std::optional<Command> command) { deaf_to_ = command; }
  /// Answers every command that sets or moves with this code; 0: none.
  void set_refusal(std::uint8_t code) { refusal_ = code; }
  void set_debug_lines(bool on) { options_.debug_lines = on; }
  void set_temperature(double celsius) { temperatures_.fill(celsius); }

  // What is seen of it.
  const HandPlant::Motion& motion() const { return motion_; }
  AxisState state(std::size_t axis) const;
  bool is_moving() const;
  bool is_powered(std::size_t axis) const { return powered_[axis]; }
  const AxisValues& current_limits() const { return current_; }  // A
  std::uint64_t moves() const { return moves_; }                 // m and grip that were carried out
  std::uint64_t stops() const { return stops_; }

 private:
  struct Outcome {
    std::uint8_t error = 0;
    AxisValues values{};                // of those that have a value an axis
    std::optional<std::string> text{};  // of the others
    bool is_bare = false;               // no value
  };
  struct Output {
    Time due{};
    std::vector<std::uint8_t> bytes;
  };
  struct Grip {
    int id = 0;
    double until = 0;  // s, plant
    bool runs = false;
  };
  void put(Bytes bytes, Time now);
  void put(const std::string& line, Time now);
  void take(const LineRequest& request, Time now);
  void take(const BinaryRequest& request, Time now);
  Outcome carry_out(Command command, const std::optional<int>& axis,
                    const std::vector<double>& values, Time now);
  Outcome carry_out_of_axes(Command command, const std::optional<int>& axis,
                            const std::vector<double>& values);
  Outcome carry_out_of_hand(Command command, const std::vector<double>& values, Time now);
  AxisValues* setting(Command command);
  AxisValues reading(Command command) const;
  std::uint8_t reason_against(Command command, std::size_t axis, double value) const;
  Outcome move(Time now);
  Outcome grip(const std::vector<double>& values, Time now);
  void select_controller(int controller);
  double prepare_profile(const AxisValues& target, const AxisValues& speed);
  double begin_profile(const AxisValues& target, const AxisValues& speed);
  void stop();
  void debug(const std::string& words, Time now);
  void advance_references(double h);
  void advance_axis(std::size_t i, double h);
  void look_at_axis(std::size_t i);
  void command_plant();
  void power_on_defaults();
  void warm_up(double h);
  bool is_hot() const;

  HandOptions options_;
  Send send_;
  RequestDecoder decoder_;
  std::deque<Output> outputs_;
  Time line_free_{};
  Time last_update_{};
  bool is_updated_ = false;
  std::optional<Time> boots_until_;
  HandPlant::Motion motion_;

  // Registers, degree and A.
  AxisValues target_{}, speed_{}, acceleration_{}, current_{}, grip_current_{}, hold_current_{};
  std::array<bool, kAxes> powered_{};
  int profile_ = 0, controller_ = 0;
  Grip grip_;

  // Where the controllers are, degree and degree/s.
  AxisValues reference_{}, velocity_{}, sent_{}, start_{}, pace_{}, ramp_{};
  double profile_begin_ = 0, profile_time_ = 0;  // s, plant
  std::array<bool, kAxes> moving_{}, blocked_{}, at_limit_{};
  std::array<double, kAxes> standing_since_{};  // s, plant
  std::array<double, 9> temperatures_{};        // degree Celsius

  bool is_mute_ = false;
  std::optional<Command> deaf_to_;
  std::uint8_t refusal_ = 0;
  std::uint64_t moves_ = 0, stops_ = 0;
};

}  // namespace prehend::drivers::sdh
