#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "drivers/sdh/codec/firmware.h"
#include "drivers/sdh/codec/stream.h"
#include "drivers/wire/hand/hand_motion.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::sdh {

/// Of each axis, as codes.h numbers them; currents in A.
using Limits = HandLimits<kAxes>;
using HandGoal = drivers::HandGoal<kAxes>;
/// Ranges and speeds that the vendor's library has, and 1 A.
Limits sdh2_limits();

enum class Profile { kSineSquare, kRamp };

struct DriverOptions {
  Limits limits = sdh2_limits();
  /// Of a ramp the target may change on the way; firmware before 0.0.2.7 has sine-square alone.
  Profile profile = Profile::kRamp;
  double acceleration = 1.745;  // rad/s^2 of the ramp: 100 degree/s^2, the hand's own default
  /// Axes' values in the checked binary form, where the firmware has it; false: as text, which the
  /// hand repeats and the driver compares.
  bool binary = true;
  bool has_checksum = true;       // of binary messages: RS-232, not TCP
  double state_period = 0.03;     // s, of asking for states, positions and speeds
  double watchdog = 0.2;          // s without command while moving by /hand/command -> stop
  double loss_time = 0.6;         // s without any state -> stop, and report
  double reply_time = 0.25;       // s to wait for an answer
  int tries = 3;                  // of a command without answer
  double stop_repeat = 0.1;       // s between stops that are not answered
  double stop_time = 0.7;         // s of motion after a stop was answered -> power off
  double start_time = 0.5;        // s that states may take to show a motion (ipa320's schunk_sdh)
  double blocked_time = 0.15;     // s of standing before its target that count as blocked
  double tolerance = 0.01;        // rad, within which a target counts as reached
  double grip_give = 0.1;         // rad that what is held may give way before the grip is lost
  double stretch = 0.5;           // s that a speed goes on ahead of its commands
  double temperature_period = 5;  // s
  double hot = 65;  // degree Celsius that are told; the hand's own bound is not published
  bool power_off_at_end = true;  // unless it holds something; powered axes overheat in 20 min
};

/// What the driver makes of the hand. The life cycle:
///
/// | state         | power                          | motion                                      |
/// |---------------|--------------------------------|---------------------------------------------|
/// | kDisconnected | unknown                        | a motion goes on to its target, or where it |
/// |               |                                | is blocked; nothing can be sent; reported   |
/// | kConnecting   | as the hand left it            | `stop` is the first command that is sent;   |
/// |               |                                | commands are refused                        |
/// | kLost         | unknown: replies are missing   | `stop` is sent again and again until one is |
/// |               |                                | answered; commands are refused              |
/// | kFault        | an axis is not initialised     | none; commands are refused                  |
/// | kOff          | axes off: the gears hold them  | none; a motion switches them on             |
/// | kStanding     | axes hold their positions      | none                                        |
/// | kMoving       | on, currents limited           | towards the targets                         |
/// | kHolding      | on, press with at most the     | none: blocked, as a rule by what it grips   |
/// |               | current limits                 |                                             |
///
/// Motions are commanded by the pose controller alone, which ends them by itself at their targets;
/// a speed is a stretch of `stretch` seconds that is drawn out while commands go on. Before each
/// motion current limits, speeds and targets are sent and compared with what the hand says is in
/// force. After each stop the target is where the hand stands, so that a command which comes late
/// moves nothing. Every way from kDisconnected, kConnecting or kLost leads through an answered
/// `stop`. One that is not answered although axes moved, or that is answered while they move on for
/// `stop_time`, is followed by power off.
enum class DriverState {
  kDisconnected,
  kConnecting,
  kLost,
  kFault,
  kOff,
  kStanding,
  kMoving,
  kHolding,
};
/// "standing", "moving", ...
const char* to_string(DriverState state);

struct Reading {
  DriverState state = DriverState::kDisconnected;
  AxisValues position{};  // rad
  AxisValues velocity{};  // rad/s
  std::array<AxisState, kAxes> axes{};
  std::array<bool, kAxes> blocked{};  // stands before its target, and presses
  bool moving = false;
  std::vector<double> temperatures;  // degree Celsius: motors by axis, FPGA, board; empty: unknown
  std::uint8_t error_code = 0;       // ReturnCode that refused the last motion; 0: it was taken
  std::uint64_t states = 0;          // whole rounds of readings so far
  std::string firmware;              // empty until it is known

  bool is_blocked() const;
  bool is_connected() const { return state != DriverState::kDisconnected; }
  /// It tells its states.
  bool is_answering() const { return state >= DriverState::kFault; }
};

struct DriverCounters {
  std::uint64_t replies = 0;      // good ones
  std::uint64_t strange = 0;      // that nobody asked for, or show what cannot be
  std::uint64_t unanswered = 0;   // commands that had to be repeated or were given up
  std::uint64_t connections = 0;  // beginnings of a connection
};

/// The hand as a state machine over bytes and time. It does no input or output itself: what it
/// sends goes to `send`, which returns "" or why it could not. Call update() every few
/// milliseconds. Not thread-safe. Same calls, same behaviour.
class Driver {
 public:
  using Send = std::function<std::string(Bytes)>;
  using Note = std::function<void(bool is_problem, const std::string& words)>;
  /// What is said when its process ends while it holds something.
  static constexpr const char* kStaysOn =
      "the hand holds something, so its axes stay on; powered for longer than 20 min it overheats";
  /// @throws std::invalid_argument for options out of range.
  Driver(const DriverOptions& options, Send send, Note note);

  void connected(Time now);
  void disconnected(const std::string& why);
  /// Somebody else has used the line: as after connected(), `stop` comes first.
  void begin_anew(const std::string& why, Time now);
  void receive(Bytes bytes, Time now);
  void update(Time now);

  /// To positions, each finger along a straight line of its joints' positions; a finger of which a
  /// joint is blocked stays there and presses, the others go on. Returns why it was refused, or "";
  /// report() knows the ticket until the next command.
  std::string move_to(const HandGoal& goal, Time now, std::uint64_t& ticket);
  /// A continuous command to the axes of `moves`: `values` in rad or rad/s. Axes that still move
  /// `watchdog` later are stopped. Returns why it was refused, or "".
  std::string command(CommandMode mode, const std::array<bool, kAxes>& moves,
                      const AxisValues& values, Time now);
  MotionReport report(std::uint64_t ticket) const;
  /// Halts all axes; controllers stay on. `why` becomes the reason of the motion that it ends.
  void stop(Time now, const std::string& why = "stopped");
  /// Switches all axes off: they stop at once, and what is held may fall.
  void power_off(Time now, const std::string& why = "switched off");

  const Reading& reading() const { return reading_; }
  const DriverCounters& counters() const { return counters_; }
  std::uint64_t damaged() const { return decoder_.damaged(); }
  /// A stop or a power off is not yet seen to be done.
  bool is_stopping() const { return stopping_.has_value() || powers_off_; }
  /// Nothing moves or is on its way to, and no stop is under way.
  bool is_settled() const {
    return !is_stopping() && !parks_ && !reading_.moving && setup_ == Setup::kNone;
  }

 private:
  enum class Connect {
    kStop,
    kVersion,
    kSpeedLimit,
    kAccelerationLimit,
    kController,
    kSetController,
    kProfile,
    kAcceleration,
    kState,
    kPosition,
    kPark,
    kDone
  };
  enum class Setup { kNone, kCurrent, kSpeed, kTarget, kGo };
  enum class Cycle { kState, kPosition, kVelocity, kTemperature };
  struct Exchange {
    Command command{};
    std::vector<double> values;
    bool is_binary = false;
    Time sent{};
    int tries = 1;
  };
  struct Stopping {
    Time began{}, last_sent{};
    int tries = 1;
    bool moved = false;
    std::optional<Time> answered;
  };
  struct Motion {
    bool ended = true, continuous = false, accepted = false, seen_moving = false;
    bool is_blocked = false;
    AxisValues start{}, goal{}, target{}, speed{}, current{};
    std::array<bool, kAxes> frozen{}, blocked{};
    std::array<bool, kAxes> arrived{};       // although the hand says that they are on their way
    std::array<CommandMode, kAxes> modes{};  // of a continuous one
    AxisValues asked{};                      // rad or rad/s, of a continuous one
    double duration = 0;                     // s, about
    Time accepted_at{};
    AxisValues standing_at{};
    std::array<std::optional<Time>, kAxes> standing_since{};
    int again = 0;
    std::string failure;
  };

  // driver.cpp: the connection and its exchanges
  void begin_connecting(Time now);
  void drain(Time now);
  void ask(Command command, std::vector<double> values, Time now);
  void ask_again(Time now);
  void transmit(const Exchange& exchange);
  void next_exchange(Time now);
  void next_of_connection(Time now);
  void next_of_cycle(Time now);
  void watch_exchange(Time now);
  void update_state();

  // driver_replies.cpp
  void take(const LineReply& reply, Time now);
  void take(const BinaryReply& reply, Time now);
  void refused(std::uint8_t code, Time now);
  void answered(const std::vector<double>& values, const std::string& text, Time now);
  bool take_values(const Exchange& exchange, const std::vector<double>& values,
                   const std::string& text, Time now);
  bool take_states(const std::vector<double>& values, Time now);
  bool take_positions(const std::vector<double>& values);
  bool take_limits(const std::vector<double>& values);
  void connect_goes_on();
  void strange(const char* what);

  // driver_motion.cpp
  std::string refusal_of_motion() const;
  std::string begin_motion(const HandGoal& goal, bool continuous, Time now);
  void begin_setup(Time now);
  void end_motion(const std::string& failure);
  void update_motion(Time now);
  bool has_room() const;
  void draw_out(Time now);
  void look_at_axes();
  void freeze_fingers(Time now);
  void conclude_end(Time now);
  void watch_grip();
  void watch_unasked_motion(Time now);
  bool stands(std::size_t axis, double seconds) const;
  bool is_there(std::size_t axis) const;
  bool is_busy(std::size_t axis) const;

  // driver_stop.cpp
  void send_stop(Time now);
  void watch_stop(Time now);
  void stop_is_done(Time now);

  DriverOptions options_;
  Send send_;
  Note note_;
  ReplyDecoder decoder_;
  Reading reading_;
  DriverCounters counters_;
  Firmware firmware_;
  AxisValues max_speed_{};         // rad/s
  AxisValues max_acceleration_{};  // rad/s^2; 0: unknown
  AxisValues held_{};              // rad, where axes were sent
  bool has_line_ = false, lost_ = false, has_temperatures_ = true;
  Connect connect_ = Connect::kStop;
  Setup setup_ = Setup::kNone;
  Cycle cycle_ = Cycle::kState;
  bool parks_ = false, powers_off_ = false;
  std::optional<Exchange> exchange_;
  std::optional<Time> drains_until_;
  Time next_cycle_{}, last_state_{}, last_temperature_{}, last_command_{}, power_off_sent_{};
  Time connecting_since_{};
  std::optional<Stopping> stopping_;
  std::optional<Time> unasked_since_;
  Motion motion_;
  AxisValues gripped_at_{};
  std::uint64_t ticket_ = 0;
};

}  // namespace prehend::drivers::sdh
