#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "prehend/motion/robot_in_world.h"
#include "prehend/robot/kinematic_chain.h"

// Motion by held keys: set points for only as long as keys come, within every limit. Without
// messages, terminals and clocks: whoever uses it says what time it is.
namespace prehend::control {

/// What a key moves: one joint, or the tool along or about one axis of the base's or its own frame.
struct JogMotion {
  enum class Kind { kJoint, kBase, kTool };
  Kind kind = Kind::kJoint;
  int axis = 0;     // kJoint: of the chain; else 0 to 2 along x, y, z, 3 to 5 about them
  double sign = 1;  // 1 or -1

  bool is_along(const JogMotion& other) const { return kind == other.kind && axis == other.axis; }
  bool operator==(const JogMotion&) const = default;
};

struct JogOptions {
  /// s, > 0, that a key counts: longer than the terminal's repetitions are apart (about 0.03 s),
  /// and what the arm still moves by when the terminal is lost.
  double hold_time = 0.15;
  double linear_speed = 0.25;  // m/s, > 0, of the tool: ISO 10218-1 (2011), 5.7.3, reduced speed
  double angular_speed = 0.8;  // rad/s, > 0, of the tool in its frame or the base's
  double linear_acceleration = 1;   // m/s^2, > 0
  double angular_acceleration = 3;  // rad/s^2, > 0
  double stale_time = 0.25;         // s, > 0: older joint positions stop the arm
  double lag = 0.05;         // rad or m, > 0, that a joint may be off its set point at rest ...
  double lag_time = 0.35;    // s, > 0, ... and so much more for its speed
  double settle_time = 0.3;  // s, > 0, for the arm to come to the last set point
  double period = 0.02;      // s, > 0, between steps where they come as planned

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// Why an arm moves more slowly than asked, or not at all.
enum class JogHindrance {
  kNone,
  kLimit,   // a joint's position limit
  kSpeed,   // in a straight motion of the tool a joint would be too fast: near a singularity
  kCannot,  // no motion of the joints moves the tool so: singular, stretched, too few joints
  kNear,    // the robot would touch itself or an obstacle
  kSilent,  // nobody tells where the joints are
  kDoesNotFollow,
};

/// What is to be commanded in this period.
struct JogStep {
  /// The set point of all joints; none: nothing is commanded, so that others may.
  std::optional<robot::Positions> set_point;
  bool ended = false;  // the motion is over: the arm's driver is to be told to stop
  double asked = 0;    // rad/s or m/s along the motion's axis, signed
  double speed = 0;    // the same, of this step
  JogHindrance hindrance = JogHindrance::kNone;
  std::string words;  // of the hindrance: which joint, which pair; empty: none
};

/// Moves an arm by keys. A key that came within the hold time is pressed. Speeds rise and fall with
/// the arm's accelerations. Each set point, and the place where the arm would come to rest if the
/// key were released then, is within the joints' limits and free (of what `space` has, or no nearer
/// than before), and no joint is faster than its share of its greatest speed, nor the tool than
/// JogOptions says: the speed is the greatest for which all this is true, so the arm slows down
/// before what is in its way and stops there.
///
/// Straight motions follow X(s) = X_0 after the way s exactly (1e-9 m and rad): the joints are
/// found by Newton's steps with damped least squares, dq = J^T (J J^T + lambda^2 I)^-1 e (C.
/// Wampler, "Manipulator inverse kinematic solutions based on vector formulations and damped
/// least-squares methods", IEEE SMC 16(1), 1986); where these do not get there, the tool does not
/// go there. What the tool cannot do slowly it is not made to do beside its way: near a singularity
/// it slows down.
class ArmJog {
 public:
  /// @param acceleration rad/s^2 or m/s^2, > 0, of each joint.
  /// @param X_FG the tool in the frame of the chain's tip.
  /// @throws std::invalid_argument for options, sizes, a joint without limits of position or speed.
  ArmJog(robot::KinematicChain chain, const robot::Positions& acceleration,
         const geometry::RigidTransform& X_FG, const JogOptions& options = {});

  const robot::KinematicChain& chain() const { return chain_; }
  const JogOptions& options() const { return options_; }

  /// What it must not touch; null: nothing. @pre of the same chain
  void set_space(std::shared_ptr<const motion::RobotInWorld> space) { space_ = std::move(space); }
  const motion::RobotInWorld* space() const { return space_.get(); }
  /// Share of the greatest speeds, in (0, 1]. @throws std::invalid_argument otherwise.
  void set_speed(double share);
  double speed() const { return share_; }

  /// A key of this motion came. @throws std::invalid_argument for an axis that there is not, or
  /// another sign.
  void press(const JogMotion& motion, double time);
  /// No key is pressed: it slows down.
  void release() { pressed_.reset(); }
  /// The arm is no longer moved by this: from the next key on it begins where it stands.
  void let_go();

  /// Called once a period, also when nothing is pressed. @param measured rad or m, `age` s old;
  /// empty: never told. @param time s, rising.
  JogStep step(const robot::Positions& measured, double age, double time);

  bool is_moving() const { return active_.has_value(); }
  /// What is pressed at that time.
  std::optional<JogMotion> pressed(double time) const {
    return pressed_ && time < pressed_until_ ? pressed_ : std::nullopt;
  }

  /// The steps, a period apart, of an arm that stands at `measured`, while a key is held for
  /// `duration` [s] or until it gets no farther, and then until it has come to rest: for arms that
  /// take trajectories alone. Empty where it does not move; `end` gets what was in the way last.
  std::vector<robot::Positions> ahead(const JogMotion& motion, const robot::Positions& measured,
                                      double duration, JogStep* end) const;

  geometry::RigidTransform X_BG(const robot::Positions& q) const {
    return chain_.forward(q) * X_FG_;
  }

 private:
  double greatest(const JogMotion& motion) const;      // rad/s or m/s along its axis
  double acceleration(const JogMotion& motion) const;  // the same, per s
  void begin(const robot::Positions& measured);
  /// Where the active motion is after `way` [rad or m] more; none where it cannot get there.
  std::optional<robot::Positions> after(double way) const;
  geometry::RigidTransform tool_after(double way) const;
  std::optional<robot::Positions> solve(const geometry::RigidTransform& X_BG) const;
  /// Whether so fast a step of `h` [s] is allowed; else why not, into `step`.
  bool allows(double speed, double h, JogStep* step) const;
  std::string lag_of(const robot::Positions& measured) const;  // empty: it follows
  JogStep end(JogHindrance hindrance, const std::string& words);

  robot::KinematicChain chain_;
  robot::Positions acceleration_;
  geometry::RigidTransform X_FG_;
  JogOptions options_;
  std::shared_ptr<const motion::RobotInWorld> space_;
  double share_ = 0.1;

  std::optional<JogMotion> pressed_;
  double pressed_until_ = 0;  // s
  std::optional<JogMotion> active_;
  robot::Positions q_, v_;  // set point, and its speed in the last step
  geometry::RigidTransform X_BG_start_;
  double way_ = 0;    // rad or m, of the active motion
  double speed_ = 0;  // along it, signed
  double floor_ = 0;  // m, of nearness(): no set point comes nearer
  std::optional<double> last_time_;
  std::optional<double> settles_since_;
};

/// Moves one joint of a hand, or a gripper's opening, by its speed while a key is pressed.
class AxisJog {
 public:
  struct Axis {
    double lower = 0, upper = 0;  // rad or m
    double greatest_speed = 0;    // rad/s or m/s, > 0, finite
    double acceleration = 0;      // per s, > 0
  };
  /// @throws std::invalid_argument for an axis that is none.
  AxisJog(const Axis& axis, const JogOptions& options = {});

  const Axis& axis() const { return axis_; }
  void press(double sign, double time);
  void release() { sign_ = 0; }

  struct Step {
    std::optional<double> speed;  // rad/s or m/s to be commanded; none: nothing is
    bool ended = false;           // a stop is to be commanded
    JogHindrance hindrance = JogHindrance::kNone;
  };
  /// @param position `age` s old. @param share of the greatest speed.
  Step step(double position, double age, double share, double time);
  bool is_moving() const { return moves_; }

 private:
  Axis axis_;
  JogOptions options_;
  double sign_ = 0, pressed_until_ = 0;
  bool moves_ = false;
};

}  // namespace prehend::control
