#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "drivers/kuka_rsi/codec/telegram.h"
#include "drivers/kuka_rsi/emulator/arm_plant.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::kuka_rsi {

struct ControllerOptions {
  TelegramNames names;
  RobotLayout layout;
  double cycle = 0.012;            // s
  double answer_time = 0.010;      // s from a telegram, in which its answer has to come
  int late_limit = 10;             // telegrams without a good answer that end RSI
  bool counts_total = false;       // ... in all, and not in a row: which of them is not settled
  bool holds = true;               // HOLDON: the last correction goes on acting; else 0
  double largest_correction = 90;  // deg, monitor of the whole correction: beyond it RSI ends
  double clamp = 0;                // deg, of the correction object: silently cut there; 0: not
  bool sends_program = true;       // ASPos
  bool short_first = false;        // RSI up to 2.3: the first telegram is nearly empty
  std::uint64_t first_ipoc = 4208163634;  // above 2^31
  std::uint64_t ipoc_step = 12;           // in a cycle; 1 as simulators count
  // Of the axes, rad and rad/s.
  std::array<double, kAxes> lower{}, upper{}, speed{};
};

/// A KR C as RSI shows it: absolute corrections of the axes about where its program stands. Sends
/// on its grid whatever is answered; an answer counts when its XML, type and IPOC are right and it
/// comes in time. Ends RSI, and brakes the arm, when too many are late, a correction is beyond its
/// monitor, an axis would be faster than it may or beyond its software limit, or EStr begins with
/// "Error:". Does no input or output.
class Controller {
 public:
  enum class State { kOff, kRunning, kStopped };

  Controller(ArmPlant& plant, const ControllerOptions& options);

  /// The program switches RSI on, where the arm stands.
  void begin();
  /// As an emergency stop, or the program's end.
  void end(const std::string& why);
  /// The next cycle, at `now`: returns the telegram to be sent, valid until the next one; empty
  /// while RSI is off.
  std::string_view tick(Time now);
  void receive(std::string_view answer, Time arrived);

  State state() const { return state_; }
  const std::string& why() const { return why_; }  // it stopped
  std::uint64_t delay() const { return delay_; }   // of this session
  std::uint64_t late_in_all() const { return late_in_all_; }
  std::uint64_t telegrams() const { return telegrams_; }
  const Axes& actual() const { return actual_; }  // rad
  /// Of any axis' set point in a cycle, as part of what its speed allows.
  double largest_step() const { return largest_step_; }
  const Axes& set_point() const { return set_point_; }  // rad, program and correction

 private:
  void take_answer();
  void move();

  ArmPlant& plant_;
  ControllerOptions options_;
  State state_ = State::kOff;
  std::string why_;
  std::array<char, 2048> out_{};
  Axes actual_{}, program_{}, set_point_{};  // rad
  Axes correction_{}, answer_{};             // deg
  bool is_answered_ = false, is_first_ = true, awaits_ = false;
  Ipoc ipoc_;
  Time sent_{};
  std::uint64_t delay_ = 0, late_in_all_ = 0, telegrams_ = 0;
  int late_in_row_ = 0;
  double largest_step_ = 0;
};

}  // namespace prehend::drivers::kuka_rsi
