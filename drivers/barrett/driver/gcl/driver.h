#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "drivers/barrett/codec/gcl/line.h"
#include "drivers/barrett/codec/gcl/real_time.h"
#include "drivers/barrett/codec/gearing.h"
#include "drivers/barrett/driver/hand_driver.h"
#include "drivers/wire/encoding/byte_order.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::barrett::gcl {

/// Motor positions have 125 counts a degree of a finger's inner joint, 17.5 of the spread (YARP).
inline constexpr Gearing kGearing{.counts_per_turn = 360};
inline constexpr double kMostCommand = 127;  // of a motor, 8 bits with a sign

/// 140 degrees of a finger's inner joint, 180 of the spread; 127 and 60 counts per 10 ms (a byte of
/// LCV with LCVC 1, and MCV's default); motor commands up to 127.
Limits bh8_262_limits(const Gearing& gearing = kGearing);

struct DriverOptions {
  Gearing gearing = kGearing;
  Limits limits = bh8_262_limits();
  Initialisation initialisation = Initialisation::kAsked;  // not kDone: S tells whether it was
  unsigned baud = kBaud;                                   // that the hand has after power-on
  unsigned fast_baud = 0;                 // to be agreed on with it by PSET BAUD; 0: none
  std::optional<Firmware> firmware = {};  // none: as VERS tells
  /// LCV's unit: 1: counts per 10 ms (BHAPI), 16: a sixteenth of that (MAN43).
  int velocity_factor = 1;
  double temperature_unit = 0;    // degree Celsius, of LFT; 0: 0.1 with firmware 4.3, 1 with 4.4
  double state_period = 0.02;     // s between states, where the line is fast enough
  double watchdog = 0.2;          // s without command while moving by /hand/command -> stop
  double loss_time = 0.8;         // s without a position -> stop, and report
  double reply_time = 0.3;        // s to wait for a prompt, beyond what the line takes
  double block_time = 0.06;       // s to wait for a feedback block, beyond what the line takes
  int tries = 3;                  // of what is not answered
  double stop_repeat = 0.08;      // s between Ctrl-Cs without a prompt
  double stop_time = 0.7;         // s of motion after a prompt -> motors off (T)
  double quiet_time = 0.02;       // s of silence behind a prompt, then no other comes
  double stall_time = 0.3;        // s of standing although told to move, then it is blocked
  double tolerance = 0.02;        // rad of a motor, within which a target counts as reached
  double approach = 8;            // 1/s: speed by the way that is left
  double settle_time = 0.1;       // s at its target, then a motor has arrived
  double grip_give = 0.1;         // rad that what is held may give way before the grip is lost
  double linger = 0.5;            // s in RealTime mode behind a continuous motion
  double initialise_time = 20;    // s that HI may take
  double temperature_period = 5;  // s
  double gauge_range = 1;         // N m of a fingertip at the strain gauge's full scale
  double strain_range = 100;      // counts of SG from its rest at a joint's greatest effort
};

/// A BH8-262's driver, over the bytes of its serial line and time. The life cycle:
///
/// | state          | power                          | motion                                     |
/// |----------------|--------------------------------|--------------------------------------------|
/// | kDisconnected  | unknown                        | a motion goes on until it stalls; nothing  |
/// |                |                                | can be sent; reported                      |
/// | kConnecting    | as the hand left it            | Ctrl-C is the first order; commands are    |
/// |                |                                | refused                                    |
/// | kLost          | unknown: answers are missing   | Ctrl-C is sent again and again until the   |
/// |                |                                | prompt comes; commands are refused         |
/// | kFault         | a motor or its board is        | none; commands are refused                 |
/// |                | missing, or the firmware is    |                                            |
/// |                | none that is known             |                                            |
/// | kUninitialised | motors off                     | none but initialise(): S tells that HI has |
/// |                |                                | not been done                              |
/// | kInitialising  | on                             | HI: to the open stops; Ctrl-C ends it. The |
/// |                |                                | hand tells nothing meanwhile               |
/// | kStanding      | fingers off: their worm gears  | none                                       |
/// |                | hold them; spread off          |                                            |
/// | kMoving        | on, their commands limited     | towards the targets                        |
/// | kHolding       | off: worm gears keep what they | none: stalled or pressing, as a rule by    |
/// |                | pressed with                   | what it grips                              |
///
/// Motions run in RealTime mode alone, by velocities (LCV) that follow from the positions in each
/// feedback block. A Supervisory command (M, C) would tell nothing until all its motors have ended:
/// no positions, no strain, no other target. In RealTime mode strain ends a motion within a block's
/// time, a stop is the next bytes on the line, and streams of /hand/command are followed. LCPG
/// bounds what a motor presses with when it stalls: its command is LCPG/4 times the speed that is
/// missing (BHAPI). Nobody says that a hand stops when its host falls silent in RealTime mode, so a
/// guardian sends Ctrl-C then.
///
/// The next line waits for the prompt of the one before; echoes are compared. ERR in RealTime mode
/// means that the hand has left it. Layouts of blocks follow from properties that are set and read
/// back in each connection. Every way from kDisconnected, kConnecting or kLost leads through an
/// answered Ctrl-C. A stop that is answered while axes move on for `stop_time` is followed by T
/// (motors off). HI runs when initialise() asks for it; a hand that was reset is told of.
class Driver : public HandDriver {
 public:
  using Send = std::function<std::string(Bytes)>;
  /// Sets the line's rate [bit/s].
  using SetBaud = std::function<std::string(unsigned)>;
  /// `send` and `set_baud` return "" or why they could not.
  /// @throws std::invalid_argument for options out of range.
  Driver(const DriverOptions& options, Send send, SetBaud set_baud, Note note);

  void connected(Time now) override;
  void disconnected(const std::string& why) override;
  void begin_anew(const std::string& why, Time now) override;
  void receive(Bytes bytes, Time now);
  void update(Time now) override;
  std::string move_to(const HandGoal& goal, Time now, std::uint64_t& ticket) override;
  std::string command(CommandMode mode, const std::array<bool, kAxes>& moves,
                      const AxisValues& values, Time now) override;
  std::string initialise(Time now, std::uint64_t& ticket) override;
  MotionReport report(std::uint64_t ticket) const override;
  /// Zero velocities, where RealTime mode takes them, and Ctrl-C.
  void stop(Time now, const std::string& why = "stopped") override;

  const Reading& reading() const override { return reading_; }
  const DriverCounters& counters() const override { return counters_; }
  std::uint64_t damaged() const override { return counters_.strange; }
  std::string axis_words(std::size_t axis) const override;
  bool is_stopping() const override { return stopping_.has_value(); }
  bool is_settled() const override { return !is_stopping() && !reading_.moving && motion_.ended; }
  /// The rate at which it talks with the hand [bit/s].
  unsigned baud() const { return baud_; }
  bool is_looping() const { return mode_ == Mode::kInLoop; }

 private:
  /// What the line is in the middle of.
  enum class Mode {
    kSyncing,    // Ctrl-C was sent: until a prompt and silence
    kSwitching,  // PSET BAUD: until the hand has changed its rate
    kIdle,       // a prompt came
    kAsking,     // a line was sent: until its prompt
    kInLoop,     // RealTime
  };
  /// A line for the hand, and what its answer is for.
  struct Step {
    enum class Kind {
      kVersion,
      kStatus,
      kTemperature,
      kSet,    // its prompt is all
      kCheck,  // `expected` must come
      kPosition,
      kStrain,
      kBreakaway,
      kBreakawayAt,
      kRate,
      kInitialise,
      kLoop,
    } kind = Kind::kSet;
    std::string line = {};
    std::vector<int> expected = {};
    int tries = 1;
  };
  struct Sample {
    Time time{};
    AxisValues motor{}, joint{};  // rad
  };
  enum class Phase { kNone, kGoing, kEnded };
  struct AxisMotion {
    Phase phase = Phase::kNone;
    double target = 0, speed = 0, current = 0;  // rad, rad/s, motor command
    int velocity = 0;                           // counts per 10 ms that it was told
    Time standing_since{};
    double standing_at = 0;
    std::optional<Time> arrived;  // at its target, since then
    int pressing = 0, fast = 0;   // blocks in a row
    bool blocked = false;
    CommandMode mode = CommandMode::kStop;  // of a continuous one
    double asked = 0;                       // rad or rad/s, of a continuous one
  };
  struct Motion {
    bool ended = true, continuous = false, is_blocked = false;
    bool initialises = false;
    bool concludes = false;  // all axes have ended; clutches are looked at
    std::array<AxisMotion, kAxes> axes{};
    int again = 0;  // that RealTime mode was begun once more
    std::string failure;
  };
  struct Stopping {
    std::optional<Time> answered;
    bool moved = false, is_off = false;
  };

  // driver.cpp: the connection and its exchanges
  void begin_connecting(Time now);
  void add_connection_steps();
  void add_readings(Time now);
  static bool is_reading(Step::Kind kind);
  void write(std::string_view text);
  void ask(const Step& step, Time now);
  double line_time(std::size_t bytes) const;  // s
  void select_baud(unsigned baud);
  void watch_exchange(Time now);
  void watch_loss(Time now);
  void next_exchange(Time now);
  void trouble(const std::string& why, Time now);
  void update_state();

  // driver_replies.cpp
  void take_answer(Time now);
  bool take(const Step& step, const Reply& reply, Time now);
  void take_status(const std::vector<int>& values, Time now);
  void take_positions(const AxisValues& counts, Time now);
  void take_strain(std::size_t axis, int value);
  void take_breakaways();
  void was_reset(Time now);
  void connection_is_made(Time now);
  void conclude_initialising(Time now);
  void refused(const Step& step, int error, Time now);

  // driver_loop.cpp: RealTime mode
  bool is_loop_wanted(Time now) const;
  void send_block(Time now);
  void take_block(Time now);
  void loop_failed(const std::string& why, bool goes_on, Time now);
  void leave_loop(Time now);
  MotorControl control_of(std::size_t axis);
  bool can_follow(const AxisValues& counts, Time now) const;
  void look_at_axis(std::size_t axis, Time now);

  // driver_motion.cpp
  std::string begin_motion(const HandGoal& goal, bool continuous, Time now);
  void begin_initialising(Time now);
  void end_motion(const std::string& failure);
  void update_motion(Time now);
  void conclude(Time now);
  bool has_room(std::size_t axis) const;
  void watch_grip();
  void watch_unasked_motion(Time now);
  bool stands(std::size_t axis) const;
  bool is_there(std::size_t axis) const;
  void look_whether_it_moves();

  // driver_stop.cpp
  void begin_sync(Time now, bool is_well);
  void watch_sync(Time now);
  void synced(Time now);
  void watch_stop(Time now);

  double counts_per_radian(std::size_t axis) const {
    return options_.gearing.counts_per_radian(axis);
  }

  DriverOptions options_;
  Send send_;
  SetBaud set_baud_;
  Note note_;
  Reading reading_;
  DriverCounters counters_;
  Layout layout_;

  bool has_line_ = false, lost_ = false, is_connected_ = false;
  bool is_initialised_ = false, begins_by_initialising_ = false, has_version_ = false;
  unsigned baud_ = kBaud;
  int baud_tries_ = 0;
  Mode mode_ = Mode::kSyncing;
  std::string received_;
  Time last_byte_{}, sent_{};
  int sync_tries_ = 0;
  Step step_;               // of kAsking
  std::deque<Step> steps_;  // to come
  bool is_block_out_ = false;
  bool is_at_rest_ = false;  // the last block's velocities were zero
  int bad_blocks_ = 0;       // in a row
  Time next_cycle_{}, next_block_{}, last_state_{}, last_temperature_{}, linger_until_{};
  int turn_ = 0;
  std::deque<Sample> samples_;
  AxisValues gauge_rest_{}, gauge_{};
  std::array<int, kAxes> breakaway_{}, breakaway_at_{};  // BD, BP
  Motion motion_;
  std::optional<Stopping> stopping_;
  std::optional<Time> unasked_since_;
  Time last_command_{};
  AxisValues gripped_at_{};
  std::uint64_t ticket_ = 0;
};

}  // namespace prehend::drivers::barrett::gcl
