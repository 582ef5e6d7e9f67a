#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string_view>

#include "drivers/kuka_rsi/codec/telegram.h"
#include "drivers/kuka_rsi/driver/limits.h"
#include "drivers/kuka_rsi/driver/motion.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::kuka_rsi {

struct DriverOptions {
  TelegramNames names;
  double cycle = 0.012;  // s: 0.012 or 0.004, the controller's
  int late_limit = 3;  // telegrams without an accepted answer that stop a motion: so many in a row,
                       // or so many more than there were hundreds of accepted ones between them
  int loss_cycles = 10;            // without a telegram, then RSI is held to have ended
  double start_tolerance = 0.002;  // rad, between actual and programmed axes at the start
  double lag = 0.3;                // s, by which the arm may be behind its set points
  double settled = 0.002;          // rad, from the goal
  double settle_time = 1;          // s after the last set point in which the arm has to be there
  double force_age = 0.1;          // s without a force while contact is minded, then it is stopped
};

/// What the driver does, and what that means for the arm. Brakes and power are the controller's
/// alone; the driver moves the arm by corrections, and only while it answers telegrams.
///
/// | state      | the arm                                                                       |
/// |------------|-------------------------------------------------------------------------------|
/// | kSilent    | is the controller's: no telegram for loss_cycles, nothing is sent             |
/// | kRefused   | telegrams come, but what is corrected already is not known: they are not      |
/// |            | answered, so that the controller ends RSI by itself; its program has to be    |
/// |            | started again                                                                 |
/// | kBeginning | stands; a few telegrams are compared before anything may move                 |
/// | kHolding   | stands at the set point, answered in each cycle                               |
/// | kMoving    | follows a Motion, a set point further with each answer that was accepted      |
/// | kStopping  | brakes, each axis by its greatest acceleration                                |
enum class State { kSilent, kRefused, kBeginning, kHolding, kMoving, kStopping };
const char* to_string(State state);

/// How the last motion ended, or why telegrams are refused.
enum class Reason {
  kNone,
  kAsked,    ///< stop()
  kLatched,  ///< latch()
  kContact,
  kNoForce,  ///< contact was to be minded, and /wrench is silent
  kLate,     ///< answers were late or lost
  kLost,     ///< the controller sends no more
  kOffPath,
  kNotThere,   ///< the goal was not reached within settle_time
  kLimit,      ///< a set point broke a limit: what was checked before has changed
  kNoSignals,  ///< telegrams lack axes or delay
  kCorrected,  ///< at the start actual and programmed axes differ
  kMidway,     ///< RSI had begun before, and what was sent then is not known
  kCycle,      ///< telegrams come faster than options.cycle says
};
const char* to_string(Reason reason);

/// The state of everything, of one moment.
struct Snapshot {
  State state = State::kSilent;
  Reason refusal = Reason::kNone;  // of kRefused
  bool latched = false;
  Axes set_point{}, actual{}, velocity{};  // rad, rad/s; actual ones as told
  bool has_pose = false;
  Axes pose{};       // mm, deg, as told
  Axes reference{};  // rad, where the controller's program stands
  // Of the last motion.
  enum class End { kNone, kRunning, kReached, kStopped, kContact, kOffPath };
  std::uint64_t ticket = 0;
  End end = End::kNone;
  Reason reason = Reason::kNone;
  Broken broken;             // of kLimit; axis also of kOffPath and kNotThere
  double off = 0;            // rad, of kOffPath and kNotThere
  double time = 0;           // s, on it
  double largest_error = 0;  // rad, beyond what the lag explains
  // Since the start.
  std::uint64_t telegrams = 0, answers = 0;
  std::uint64_t damaged = 0;   // telegrams that could not be believed
  std::uint64_t missing = 0;   // telegrams that did not come, by their time stamps
  std::uint64_t late = 0;      // answers that the controller did not accept
  std::uint64_t repeated = 0;  // telegrams that came twice or behind a later one
  std::uint64_t sessions = 0;  // how often RSI began
  std::uint64_t delay = 0;     // as the controller counts, of this session
};

/// The PC's side of RSI as a state machine: telegrams in, answers out, nothing else; no clock, no
/// thread, no allocation after its making.
///
/// Corrections are absolute: the answer is the set point minus where the controller's program
/// stands, for which RSI has to be switched on with absolute corrections and HOLDON=1 (with
/// HOLDON=0 one lost answer would send the arm back to the start). A set point is left for the next
/// one only when the controller's Delay shows that it was taken; else the same is sent again. So
/// whatever gets lost, the arm's set point never moves by more than one cycle's way in a cycle.
///
/// RSI that begins anew is told from RSI that goes on by Delay, which begins at 0. A driver that
/// meets one under way, or finds the arm away from its program, does not know what correction acts,
/// and any answer might be a jump: it does not answer then. After a gap it goes on where Delay,
/// program and axes show that this is the same RSI still.
class Driver {
 public:
  static constexpr std::size_t kMostLag = 512;     // cycles
  static constexpr std::uint64_t kFreshDelay = 3;  // telegrams: RSI has just begun
  static constexpr int kBeginTelegrams = 10;       // compared before motions are taken
  static constexpr int kFastTelegrams = 100;       // too fast on average: not a burst, the cycle

  /// @throws std::invalid_argument for options out of range.
  Driver(const DriverOptions& options, Limits limits);

  /// The answer to a telegram that came to this machine at `arrived` (before the last one's: at
  /// that time), to be sent at once; valid until the next call. Empty: none.
  std::string_view on_packet(std::string_view telegram, Time arrived);
  /// Call it at least every cycle: notices that telegrams cease.
  void on_time(Time now);

  /// Starts `motion` from where the set point stands, if it stands; returns the one before, or
  /// `motion` itself where it does not start (see snapshot().ticket).
  std::unique_ptr<Motion> start(std::unique_ptr<Motion> motion);
  /// Brakes; a motion ends by it.
  void stop() { end_motion(Reason::kAsked); }
  /// Brakes, and starts nothing until release(): for who stops all motion.
  void latch();
  void release() { now_.latched = false; }
  /// What the wrist feels [N]. Acts with the next answer.
  void feel(double force, Time when) { force_ = force, force_time_ = when; }

  const Snapshot& snapshot() const { return now_; }
  const DriverOptions& options() const { return options_; }
  const Limits& limits() const { return limits_; }

 private:
  std::string_view answer(const RobotTelegram& telegram);
  std::string_view go_on(const RobotTelegram& telegram, Time now);
  std::string_view begin(const RobotTelegram& telegram, Time now);
  std::string_view refuse(Reason reason);
  bool is_same_session(const RobotTelegram& telegram, const Axes& actual) const;
  void take_state(const RobotTelegram& telegram);
  /// What a telegram's time stamp and Delay say of those before it.
  struct Flow {
    bool believed = false;   // both may be
    bool repeated = false;   // it is no later one than the last
    bool accepted = false;   // the last answer was
    std::uint64_t gap = 0;   // telegrams that did not come since the last
    std::uint64_t late = 0;  // answers that were not accepted since
  };
  Flow flow_of(const RobotTelegram& telegram, Time now) const;
  void count(const Flow& flow);
  /// Counts a telegram of kBeginning, and holds after enough; false: they come too fast.
  bool begin_further(Time now);
  void mind_force(Time now);
  void advance();
  void follow();
  void settle();
  void brake();
  void watch_path();
  void stand();
  void end_motion(Reason reason);
  void forget_trail();

  DriverOptions options_;
  Limits limits_;
  Snapshot now_;
  std::array<char, 1024> out_{};

  Axes pending_{};   // rad: last sent; now_.set_point is what was last accepted
  Axes velocity_{};  // rad/s, of accepted set points
  std::unique_ptr<Motion> motion_;
  std::size_t next_ = 0;  // set point of the motion that comes next
  int settling_ = 0;      // cycles
  int off_path_ = 0;      // cycles in a row
  Reason stopping_ = Reason::kNone;

  bool has_session_ = false;  // reference and pending_ are of one
  Ipoc last_ipoc_;
  std::uint64_t step_ = 0;  // of IPOC in a cycle; 0: not known
  std::uint64_t delay_before_ = 0;
  bool answered_ = false;         // the last believed telegram
  std::uint64_t unaccepted_ = 0;  // telegrams in a row
  int trouble_ = 0, calm_ = 0;    // unaccepted ones of late; accepted ones since
  int begun_ = 0;                 // telegrams since begin
  Time begun_time_{};
  Time last_telegram_{};     // believed
  RobotTelegram candidate_;  // that may begin a session, with the next one
  bool has_candidate_ = false;

  double force_ = 0;
  Time force_time_ = Time::min();
  std::array<Axes, kMostLag> trail_{};  // set points of the last `lag`
  std::size_t trail_size_ = 1, trail_next_ = 0;
};

}  // namespace prehend::drivers::kuka_rsi
