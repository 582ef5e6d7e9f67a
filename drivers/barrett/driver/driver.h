#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "drivers/barrett/codec/gearing.h"
#include "drivers/barrett/codec/message.h"
#include "drivers/barrett/codec/tactile.h"
#include "drivers/barrett/driver/hand_driver.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::barrett {

/// 140 degrees of a finger's inner joint, 180 of the spread; MV 200 and 50 counts/ms, MT 2200
/// (pyHand's defaults).
Limits bh8_limits(const Gearing& gearing = {});

struct DriverOptions {
  Gearing gearing = {};
  Limits limits = bh8_limits();
  Initialisation initialisation = Initialisation::kAsked;
  double state_period = 0.02;     // s, of asking for positions and modes
  double tactile_period = 0.04;   // s, of asking for the pads' images; 0: never
  double watchdog = 0.2;          // s without command while moving by /hand/command -> stop
  double loss_time = 0.3;         // s without a puck's position or mode -> stop, and report
  double reply_time = 0.05;       // s to wait for an answer
  int tries = 3;                  // of a question or order without answer
  double stop_repeat = 0.05;      // s between stops that are not answered
  double stop_time = 0.7;         // s of motion after a stop was answered -> motors off, too
  double begin_time = 0.3;        // s in which MODE has to show a motion
  double stall_time = 0.25;       // s of standing before its target: TSTOP
  double tolerance = 0.02;        // rad of a motor, within which a target counts as reached
  double clutch_tolerance = 0.1;  // rad between motor and joint: the clutch has opened
  double grip_give = 0.1;         // rad that what is held may give way before the grip is lost
  double stretch = 0.5;           // s that a speed goes on ahead of its commands
  double initialise_time = 15;    // s that HI of fingers, or of the spread, may take
  double initial_velocity = 75;   // counts/ms of HI at most: IVEL
  double temperature_period = 5;  // s
  double gauge_range = 1;         // N m of a fingertip at the strain gauge's full scale
};

/// A BH8-280's driver, over frames and time. The life cycle:
///
/// | state          | power                          | motion                                     |
/// |----------------|--------------------------------|--------------------------------------------|
/// | kDisconnected  | unknown                        | a motion goes on to its target, or until   |
/// |                |                                | it stalls; nothing can be sent; reported   |
/// | kConnecting    | as the hand left it            | MODE 0 is the first order; commands are    |
/// |                |                                | refused                                    |
/// | kLost          | unknown: answers are missing   | MODE 0 is sent again and again until each  |
/// |                |                                | puck answers it; commands are refused      |
/// | kFault         | a puck shows STAT 1            | none; commands are refused                 |
/// | kUninitialised | motors off                     | none but initialise(): zero is not known   |
/// | kInitialising  | on, torque limited             | to the open stops                          |
/// | kStanding      | fingers off: their worm gears  | none                                       |
/// |                | hold them; spread held after a |                                            |
/// |                | motion, braked after a stop    |                                            |
/// | kMoving        | on, torque limited             | towards the targets                        |
/// | kHolding       | off: worm gears keep what they | none: stalled, as a rule by what it grips  |
/// |                | pressed with; spread held      |                                            |
///
/// Motions are CMD M to DP alone, which end by themselves at the target, or TSTOP after they stall;
/// a speed is a stretch of `stretch` seconds that is drawn out while commands go on. Before each
/// motion MT, MV and DP are set and read back. After each stop DP is where the hand stands, so that
/// a CMD M which comes late moves nothing. Every way from kDisconnected, kConnecting or kLost leads
/// through an answered MODE 0 of each puck. A stop that is not answered although axes moved, or
/// that is answered while they move on for `stop_time`, is followed by CMD T (motors off) with each
/// repetition. A puck that was switched off and on (STAT 0, or its clock went back) makes the hand
/// uninitialised.
///
/// What it sends goes to `send`, which returns "" or why it could not.
class Driver : public HandDriver {
 public:
  using Send = std::function<std::string(const CanFrame&)>;
  using OnPad = std::function<void(std::size_t axis, const Cells& cells)>;
  /// `on_pad` takes each whole image of a pad, from receive().
  /// @throws std::invalid_argument for options out of range.
  Driver(const DriverOptions& options, Send send, Note note, OnPad on_pad = {});

  void connected(Time now) override;
  void disconnected(const std::string& why) override;
  void begin_anew(const std::string& why, Time now) override;
  void receive(const CanFrame& frame, Time now);
  void update(Time now) override;
  std::string move_to(const HandGoal& goal, Time now, std::uint64_t& ticket) override;
  std::string command(CommandMode mode, const std::array<bool, kAxes>& moves,
                      const AxisValues& values, Time now) override;
  std::string initialise(Time now, std::uint64_t& ticket) override;
  MotionReport report(std::uint64_t ticket) const override;
  /// MODE 0 to all axes.
  void stop(Time now, const std::string& why = "stopped") override;

  const Reading& reading() const override { return reading_; }
  const DriverCounters& counters() const override { return counters_; }
  std::uint64_t damaged() const override { return counters_.strange + broken_images(); }
  std::string axis_words(std::size_t axis) const override;
  bool is_stopping() const override { return stopping_.has_value(); }
  bool is_settled() const override { return !is_stopping() && !reading_.moving && motion_.ended; }
  Mode mode(std::size_t axis) const { return modes_[axis]; }
  std::uint64_t broken_images() const;

 private:
  /// Something to be asked, or set and then asked: done when the answer is the value.
  struct Step {
    Property property{};
    std::optional<std::int32_t> value = {};
    enum class Kind {
      kReading,
      kConnection,
      kOptional,
      kStop,
      kMotion,
      kPark
    } kind = Kind::kReading;
    int tries = 0;
    Time began{}, sent{};  // first and last
  };
  struct Sample {
    Time time{};
    double motor = 0, joint = 0;  // rad
  };
  struct Puck {
    std::deque<Step> steps;
    std::optional<Step> asked;
    bool is_connected = false, was_asleep = false, stop_answered = false;
    bool is_status_bad = false;
    Time next_cycle{}, last_position{}, last_mode{}, mode_asked{}, last_temperature{}, uptime_at{};
    std::optional<int> uptime;  // s
    int turn = 0;
    bool fresh_position = false, fresh_mode = false;
    std::deque<Sample> samples;
    double gauge_rest = 2048, gauge = 2048;  // counts
    TactileAssembler pad;
  };
  enum class Phase { kNone, kSetup, kCommanded, kGoing, kEnded };
  struct AxisMotion {
    Phase phase = Phase::kNone;
    double target = 0, speed = 0, current = 0;  // rad, rad/s, unit of MT
    Time commanded{}, standing_since{};
    double standing_at = 0;
    int again = 0, ended_polls = 0;
    bool blocked = false;
    CommandMode mode = CommandMode::kStop;  // of a continuous one
    double asked = 0;                       // rad or rad/s, of a continuous one
  };
  struct Motion {
    enum class Kind { kMove, kInitialiseFingers, kInitialiseSpread } kind = Kind::kMove;
    bool ended = true, continuous = false, is_blocked = false;
    std::array<AxisMotion, kAxes> axes{};
    Time began{};
    std::string failure;

    bool initialises() const { return kind != Kind::kMove; }
  };
  struct Stopping {
    Time began{};
    std::optional<Time> answered;
    bool moved = false, is_off = false;
  };

  // driver.cpp: the connection and its exchanges
  void begin_connecting(Time now);
  void order(std::size_t axis, Property property, std::int32_t value);
  void ask(std::size_t axis, Step step, Time now);
  void transmit(std::size_t axis);
  void next_of_puck(std::size_t axis, Time now);
  void add_readings(std::size_t axis, Time now);
  void watch_exchange(std::size_t axis, Time now);
  void give_up(std::size_t axis, const Step& step, Time now);
  void watch_loss(Time now);
  void ask_pads(Time now);
  void update_state();
  bool all_connected() const;
  std::int32_t counts(std::size_t axis, double angle) const;

  // driver_replies.cpp
  void take(const Value& value, Time now);
  void take(const Position& position, Time now);
  void take(const TactilePart& part, Time now);
  void take_value(std::size_t axis, Property property, std::int32_t value, const Step& step,
                  Time now);
  void take_uptime(std::size_t axis, int uptime, Time now);
  void was_reset(std::size_t axis, const char* how, Time now);
  void puck_goes_on(std::size_t axis, Time now);
  void count_round();

  // driver_motion.cpp
  std::string refusal_of_motion() const {
    return barrett::refusal_of_motion(reading_, is_stopping());
  }
  std::string begin_motion(const HandGoal& goal, bool continuous, Time now);
  void begin_initialising(Motion::Kind kind, Time now);
  void begin_setup(std::size_t axis);
  void end_motion(const std::string& failure);
  void update_motion(Time now);
  void go(Time now);
  void look_at_axis(std::size_t axis, Time now);
  void conclude(Time now);
  void conclude_initialising(Time now);
  void draw_out(Time now);
  bool has_room(std::size_t axis) const;
  void watch_grip();
  void watch_unasked_motion(Time now);
  bool is_busy(std::size_t axis) const;
  bool stands(std::size_t axis) const;
  bool is_there(std::size_t axis) const;
  void look_whether_it_moves();

  // driver_stop.cpp
  void send_stop(std::size_t axis, Time now);
  void watch_stop(Time now);

  DriverOptions options_;
  Send send_;
  Note note_;
  OnPad on_pad_;
  Reading reading_;
  std::array<Mode, kAxes> modes_{};
  DriverCounters counters_;
  std::array<Puck, kAxes> pucks_;
  Motion motion_;
  std::optional<Stopping> stopping_;
  std::optional<Time> unasked_since_;
  bool has_line_ = false, lost_ = false, is_connected_ = false;
  bool is_initialised_ = false, begins_by_initialising_ = false;
  Time last_command_{}, next_pads_{};
  AxisValues gripped_at_{};
  std::uint64_t ticket_ = 0;
};

}  // namespace prehend::drivers::barrett
