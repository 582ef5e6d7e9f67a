#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>

#include "drivers/pg70/codec/request.h"
#include "drivers/pg70/codec/response.h"
#include "drivers/pg70/transport/link.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::pg70 {

struct Limits {
  double max_opening = 0.069;       // m
  double max_speed = 0.083;         // m/s of the opening
  double max_acceleration = 0.320;  // m/s^2 of the opening
  double nominal_current = 2.0;     // A
  double max_current = 6.5;         // A
};

struct DriverOptions {
  Limits limits;
  /// Opening per unit of the module's position: 1 when it counts the total opening (as the PG70
  /// does in SmartRoboticSystems/schunk_grippers), 2 when it counts the way of one finger.
  double opening_per_position = 1;
  double state_period = 0.02;  // s, of cyclic GET STATE
  double watchdog = 0.2;       // s without command while moving by /gripper/command -> stop
  double loss_time = 0.2;      // s without any state -> stop, and report
  double reply_time = 0.1;     // s to wait for the answer to a command
  int tries = 3;               // of a command without answer
  double blocked_time = 0.15;  // s of standing, although told to move, that count as blocked
  double stop_time = 0.7;      // s of motion after CMD STOP was answered -> CMD FAST STOP
  /// Part of the commanded current that the module must show while it holds something; less for
  /// `blocked_time` is a lost grip. 0: the current is not looked at.
  double holding_current = 0.2;
  double grip_give = 2e-3;          // m that what is held may give way before the grip is lost
  double opening_tolerance = 3e-4;  // m, within which a target counts as reached
  /// How a velocity is commanded. True: as MOVE POS to the end of the range with that speed, which
  /// can never run over a soft limit. False: as MOVE VEL, as public drivers do; the driver then
  /// stops it before the end of the range.
  bool velocity_as_position = true;
  /// How a current is commanded. False: MOVE CUR, true: MOVE GRIP.
  bool current_as_grip = false;
};

/// What the driver makes of the module. The life cycle:
///
/// | state         | power, brake                     | motion                                    |
/// |---------------|----------------------------------|-------------------------------------------|
/// | kDisconnected | unknown                          | unknown; nothing can be sent; reported    |
/// | kConnecting   | as the module left it            | CMD STOP is the first thing that is sent; |
/// |               |                                  | commands are refused                      |
/// | kLost         | unknown: replies are missing     | CMD STOP is sent again and again until    |
/// |               |                                  | one is answered, CMD FAST STOP too when   |
/// |               |                                  | it moved; commands are refused            |
/// | kFault        | motor off, brake applied where   | none; commands are refused until          |
/// |               | one is fitted                    | acknowledge() succeeds                    |
/// | kUnreferenced | motor holds                      | none but reference()                      |
/// | kReferencing  | motor on                         | the module moves by itself; stop() ends it|
/// | kStanding     | motor holds the position         | none                                      |
/// | kMoving       | motor on, current limited        | towards the target                        |
/// | kHolding      | motor on, presses with at most   | none: blocked, as a rule by what it grips;|
/// |               | the current limit                | for as long as states go on to show it    |
///
/// Every way from kDisconnected, kConnecting or kLost leads through a confirmed CMD STOP, so that a
/// restart of either side never resumes a motion. A CMD STOP that is not answered although the jaws
/// moved, or that is answered while they move on for `stop_time`, is followed by CMD FAST STOP
/// (motor shorted, kFault) until the module shows it.
enum class DriverState {
  kDisconnected,
  kConnecting,
  kLost,
  kFault,
  kUnreferenced,
  kReferencing,
  kStanding,
  kMoving,
  kHolding,
};
/// "standing", "moving", ...
const char* to_string(DriverState state);

enum class MotionMode { kStop, kPosition, kVelocity, kCurrent };

struct Reading {
  DriverState state = DriverState::kDisconnected;
  double opening = 0;   // m
  double velocity = 0;  // m/s of the opening, negative closes
  double current = 0;   // A, negative closes
  bool referenced = false;
  bool moving = false;
  bool blocked = false;           // told to move, stands before its target, and presses
  std::uint8_t error_code = 0;    // ErrorCode
  std::uint8_t warning_code = 0;  // ErrorCode of a cause that persists
  std::uint64_t states = 0;       // GET STATE answers so far
};

/// A motion that was refused, or how far it is.
struct MotionReport {
  enum class Kind { kRunning, kReached, kBlocked, kReplaced, kFailed };
  Kind kind = Kind::kRunning;
  std::string reason;  // of kFailed: a fault, a loss, or who stopped it
};

/// What the driver had to put up with since it was made.
struct DriverCounters {
  std::uint64_t states = 0;       // good answers to GET STATE
  std::uint64_t strange = 0;      // messages that mean nothing, or show what cannot be
  std::uint64_t unanswered = 0;   // commands that had to be repeated or were given up
  std::uint64_t connections = 0;  // beginnings of a connection
};

/// The PG70 as a state machine over messages and time. It does no input or output itself: what it
/// sends goes to `send`, which returns "" or why nothing could be sent. Call update() at least
/// every few milliseconds. Not thread-safe. Same calls, same behaviour.
class Driver {
 public:
  using Send = std::function<std::string(const Content&)>;
  using Note = std::function<void(bool is_problem, const std::string& words)>;
  /// `note` takes rare remarks: faults, losses, recoveries. @throws std::invalid_argument for
  /// options that are not positive and finite.
  Driver(const DriverOptions& options, Send send, Note note);

  /// A link was opened.
  void connected(Time now);
  void link_event(const LinkEvent& event, Time now);
  void receive(const Incoming& incoming, Time now);
  void update(Time now);

  /// Continuous command: must be repeated within the watchdog time while it moves. Values as the
  /// simulated gripper takes them: opening [m], speed [m/s] or current [A], the latter two negative
  /// to close and cut to the limits; `current_limit` [A] 0: nominal. Returns "" or why it was
  /// refused. Takes the gripper over from any motion.
  std::string command(MotionMode mode, double value, double current_limit, Time now);
  /// A motion with an end of its own: to an opening [m] with at most `speed` [m/s] > 0. `ticket`
  /// names it for report().
  std::string move_to(double opening, double speed, double current_limit, Time now,
                      std::uint64_t& ticket);
  /// How the motion is getting on; kReplaced when another command came since.
  MotionReport report(std::uint64_t ticket) const;

  /// CMD STOP, watched until states show that the jaws stand. `why` becomes the reason of the
  /// motion that it ends.
  void stop(Time now, const std::string& why = "stopped");
  /// CMD FAST STOP, until the module shows it: shorts the motor and applies the brake; kFault then.
  void fast_stop(Time now, const std::string& why = "stopped by CMD FAST STOP");
  /// True from stop() or fast_stop() until states show what was asked for, or nobody is there.
  bool is_stopping() const { return stopping_.has_value(); }
  /// "" or why it was refused at once. The module moves its jaws.
  std::string reference(Time now);
  /// Asks the module to clear its fault; whether it did shows in reading().
  std::string acknowledge(Time now);

  const Reading& reading() const { return reading_; }
  /// True when it stands as far as is known, and no command waits for its answer.
  bool is_settled() const { return outstanding_.empty() && !stopping_ && !reading_.moving; }
  const DriverCounters& counters() const { return counters_; }
  /// Why kConnecting cannot end, "" when there is only no answer yet.
  const std::string& obstacle() const { return obstacle_; }
  const std::optional<DetailedError>& detailed_error() const { return detailed_error_; }
  const DriverOptions& options() const { return options_; }

 private:
  struct Outstanding {  // a command whose answer is due
    Content content;
    Time sent{};
    int tries = 1;
    bool is_motion = false;
  };
  struct Motion {
    MotionMode mode = MotionMode::kStop;
    double value = 0;
    double current = 0;
    bool continuous = false;
    bool accepted = false;
    bool ended = true;     // reached, blocked, stopped, failed
    bool blocked = false;  // ended before its target
    bool seen_moving = false;
    bool is_repeat = false;  // of one that is blocked
    double target = 0;       // m, kPosition
    Time started{};
    Time accepted_at{};
    std::optional<Time> standing_since;  // arrival of the first state that says so
    double standing_at = 0;              // m, opening in that state
    std::optional<Time> end_told;        // by an impulse message, which states have to bear out
    std::string failure;
  };
  struct Stopping {
    Time last_sent{};
    int tries = 1;
    bool moved = false;  // when it began
    bool is_fast = false;
    std::optional<Time> answered;
  };

  std::string transmit(const Request& request, Time now, bool is_motion = false);
  void ask_for_states(Time now);
  void begin_connecting(Time now);
  void check_connection(Time now);
  void probe(Time now);
  std::string refusal_of_motion() const;
  std::string begin_motion(MotionMode mode, double value, double speed, double current_limit,
                           bool continuous, Time now);
  Request request_of(MotionMode mode, double value, double speed, double current) const;
  void end_motion(const std::string& failure = {});
  void fault(std::uint8_t code, Time now);

  void take(const Response& response, Time now);
  void take_state(const State& state, Time now);
  void take_refusal(const Refusal& refusal, Time now);
  void take_motion_end(const MotionEnd& end, Time now);
  void take_fault(const Fault& fault, Time now);
  void take_info(const Info& info, Time now);
  void take_config(const ConfigValue& value, Time now);
  void take_unit(double unit, Time now);
  void answered(Command command, Time now);

  void update_motion(Time now);
  void conclude_end();
  void guard_range(Time now);
  void watch_grip();
  void lose_grip(const std::string& words);
  void watch_unasked_motion(Time now);
  void begin_stopping(Time now, bool is_fast);
  void watch_stop(Time now);
  void escalate(const std::string& words, Time now);
  void update_state();

  double to_opening(float position) const {
    return position * unit_ * options_.opening_per_position;
  }
  float to_device(double metres) const {
    return static_cast<float>(metres / (unit_ * options_.opening_per_position));
  }

  DriverOptions options_;
  Send send_;
  Note note_;
  Reading reading_;
  std::optional<DetailedError> detailed_error_;

  double unit_ = 1e-3;  // m per unit of the module
  bool link_up_ = false;
  bool has_link_ = false;  // there is one, although nothing may pass
  Time last_probe_{};      // of a link that is down
  bool stop_confirmed_ = false;
  bool unit_known_ = false;
  std::string obstacle_;  // e.g. a unit system that is no length
  bool lost_ = false;
  bool referencing_ = false;
  bool fault_told_ = false;
  std::uint8_t status_ = 0;
  Time last_state_{};
  Time last_question_{};
  Time last_command_{};
  Time connecting_since_{};
  std::optional<Time> unasked_since_;
  std::deque<Outstanding> outstanding_;
  Motion motion_;
  std::uint64_t ticket_ = 0;
  std::optional<Stopping> stopping_;
  DriverCounters counters_;
  int fast_states_ = 0;    // in a row, of jaws that move whatever the status says
  Time pressed_{};         // last state whose current presses
  double gripped_at_ = 0;  // m, opening where it was blocked
};

}  // namespace prehend::drivers::pg70
