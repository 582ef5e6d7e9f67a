#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "prehend/control/jog.h"

namespace prehend::control {

/// What keys ask for.
enum class JogKey {
  kStop,  // and whatever is no key
  kPlus,
  kMinus,
  kPrevious,
  kNext,
  kMode,
  kAxisX,
  kAxisY,
  kAxisZ,
  kRoll,
  kPitch,
  kYaw,
  kSlower,
  kFaster,
  kOpen,
  kClose,
  kEmergency,
  kQuit,
};
/// Of a character; kStop for all that mean nothing: who hits any key wants it to stop.
JogKey jog_key(int character);

/// A joint that can be chosen.
struct JogRow {
  std::string name;  // as /joint_states has it, or "opening"
  bool is_hand = false;
  bool is_revolute = true;  // else its numbers are m and m/s
  double lower = 0, upper = 0;
  double greatest_speed = 0;
};

/// What is known when a period begins.
struct JogPercepts {
  double time = 0;            // s, rising
  robot::Positions arm;       // rad or m; empty: not told yet
  double arm_age = 0;         // s
  std::vector<double> hand;   // of the hand's rows; empty: not told yet
  double hand_age = 0;        // s
  std::string forbidden;      // why nothing may move, in words; empty: it may
  std::string arm_forbidden;  // why the arm may not
  /// The arm takes trajectories alone (JogCommands::run), and whether one goes on.
  bool arm_takes_runs = false, arm_runs = false;
};

/// What is to be done in this period.
struct JogCommands {
  std::optional<robot::Positions> arm;  // a set point
  bool stop_arm = false;
  /// Positions a period of ArmJog apart, from where it stands to rest: to be followed until
  /// end_run, where the arm takes trajectories alone.
  std::vector<robot::Positions> run;
  bool end_run = false;
  std::optional<std::pair<int, double>> hand;  // row of the hand, and its speed [rad/s or m/s]
  bool stop_hand = false;                      // that moves by its speed
  bool end_hand_motion = false;                // that was begun by the two that follow
  bool open_hand = false, close_hand = false;  // as a whole
  bool emergency = false, quit = false;
};

/// Keys -> commands: which joint or axis is chosen, the mode, the speed, the dead man. Letters
/// choose, plus and minus alone move: whoever hits a wrong letter moves nothing. A key that means
/// nothing stops. An arm that takes no set points is moved by trajectories of a second, each
/// checked ahead and cut off when no key comes.
class JogSession {
 public:
  /// @param hand of the hand's joints (or its opening), with `accelerations` [per s] of the same.
  JogSession(ArmJog arm, std::vector<JogRow> hand, const std::vector<double>& accelerations,
             const JogOptions& options = {});

  void key(JogKey key, double time);
  JogCommands step(const JogPercepts& percepts);

  using Kind = JogMotion::Kind;
  const std::vector<JogRow>& rows() const { return rows_; }
  Kind mode() const { return mode_; }
  int row() const { return row_; }    // chosen, where the mode is kJoint
  int axis() const { return axis_; }  // chosen, else
  double speed() const { return arm_.speed(); }
  ArmJog& arm() { return arm_; }
  const ArmJog& arm() const { return arm_; }
  bool is_moving() const;
  /// Why it is slower than asked, or stands, as of the last step; empty: it is not.
  const std::string& words() const { return words_; }
  JogHindrance hindrance() const { return hindrance_; }

 private:
  void move(double sign, double time);
  void step_by_runs(const JogPercepts& percepts, JogCommands* commands);
  void release();

  ArmJog arm_;
  std::vector<AxisJog> hand_;
  std::vector<JogRow> rows_;
  Kind mode_ = Kind::kJoint;
  int row_ = 0, axis_ = 0;
  JogCommands pending_;           // by keys since the last step
  std::optional<JogMotion> run_;  // that goes on
  bool refused_ = false;          // a key of motion came while nothing may move
  std::string words_;
  JogHindrance hindrance_ = JogHindrance::kNone;
};

}  // namespace prehend::control
