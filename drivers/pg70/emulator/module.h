#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "drivers/pg70/codec/request.h"
#include "drivers/pg70/codec/response.h"
#include "drivers/pg70/emulator/gripper_plant.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::pg70 {

struct ModuleOptions {
  double max_opening = 0.069;       // m; also the soft limits, with 0
  double max_speed = 0.083;         // m/s
  double max_acceleration = 0.320;  // m/s^2
  double nominal_current = 2.0;     // A
  double max_current = 6.5;         // A
  UnitSystem unit = UnitSystem::kMillimetre;
  bool referenced = true;      // at power-on
  double boot_time = 1.0;      // s of silence after a restart
  double blocked_time = 0.05;  // s of standing that end a motion as blocked (not published)
  double fault_period = 15;    // s between repetitions of CMD ERROR (manual, page 112)
  double warning_period = 30;  // s, of CMD WARNING
  bool tells_duration = true;  // MOVE POS is answered with a duration, else with OK
  bool impulse_messages = true;
};

/// A PG70's electronics as its manual describes them, over a plant. Like Driver it does no input or
/// output: replies go to `send`. Strict about lengths and values: unknown commands, wrong lengths
/// and parameters out of range are refused with the code that fits. Faults of the device come by
/// request: fail(), reboot(), and those of the plant. Call update() every few milliseconds.
class Module {
 public:
  using Send = std::function<void(Direction, const Content&)>;
  Module(GripperPlant& plant, const ModuleOptions& options, Send send);

  /// A command from the master.
  void receive(const Content& content, Time now);
  void update(Time now);

  /// Raises an error: motor off. While `persists`, an acknowledge turns it into a warning only.
  void fail(ErrorCode code, bool persists, Time now);
  /// The cause of a persisting error is gone.
  void mend(Time now);
  /// Restarts: silent for boot_time, then INFO BOOT. Forgets cyclic states and targets.
  void reboot(Time now);
  /// Answers nothing and sends nothing, as if its wire were cut; it goes on moving.
  void set_mute(bool mute) { mute_ = mute; }

  /// Neither carries this command out nor answers it, as if its frames got lost.
  void set_deaf_to(std::optional<Command> command) { deaf_to_ = command; }

  bool is_moving() const { return moving_; }
  const GripperPlant::Motion& motion() const { return motion_; }
  std::uint64_t stops() const { return stops_; }      // CMD STOP and FAST STOP received
  std::uint64_t motions() const { return motions_; }  // MOVE commands carried out

 private:
  void say(const Response& response);
  void impulse(const Response& response);
  void refuse(Command command, InfoCode reason) { say(Refusal{command, reason}); }
  void take(const PlainRequest& request, Time now);
  void take(const SetTarget& request, Time now);
  void take(const Move& request, Time now);
  void take(const GetState& request, Time now);
  void take(const GetConfig& request, Time now);
  void take(const SetConfig& request, Time now);
  void take(const OtherRequest& request, Time now);
  std::optional<InfoCode> reason_against(const Move& move) const;
  void drive(const Move& move);
  void begin(const GripperPlant::Command& command, Command by);
  void halt(GripperPlant::Drive drive);
  void acknowledge(Time now);
  void tell_state();
  void update_motion();
  void update_faults(Time now);
  State state() const;
  double unit() const;
  float to_device(double metres) const { return static_cast<float>(metres / unit()); }

  GripperPlant& plant_;
  ModuleOptions options_;
  Send send_;
  GripperPlant::Motion motion_;
  double speed_, acceleration_, current_;  // targets in force, m/s, m/s^2, A
  bool impulse_on_;
  bool mute_ = false;
  std::optional<Command> deaf_to_;
  bool referenced_;
  bool moving_ = false;
  bool ended_ = false;    // "move end"
  bool reached_ = false;  // "position reached"
  bool brake_ = false;
  bool referencing_ = false;
  Command moved_by_ = Command::kStop;
  double target_ = 0;          // m
  double standing_since_ = 0;  // s, by the plant's time
  ErrorCode error_ = ErrorCode::kNone;
  bool persists_ = false;
  bool warning_ = false;  // acknowledged, but the cause persists
  Time last_fault_told_{};
  std::uint8_t mode_ = 0;  // of GET STATE; 0 at power-on
  Time period_{};          // of cyclic states, 0: off
  Time next_state_{};
  std::optional<Time> boots_until_;
  Time last_update_{};
  bool is_updated_ = false;
  std::uint64_t stops_ = 0, motions_ = 0;
};

}  // namespace prehend::drivers::pg70
