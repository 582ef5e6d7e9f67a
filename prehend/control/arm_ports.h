#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/control/arm_grasp.h"
#include "prehend/control/cycle.h"
#include "prehend/control/input_watch.h"
#include "prehend/control/joint_trajectory.h"
#include "prehend/control/pad_percept.h"
#include "prehend/touch/hand_touch.h"

namespace prehend::control {

/// What the cycle asks of an arm. Calls return at once.
class ArmPort {
 public:
  virtual ~ArmPort() = default;
  /// Stops when the wrist force exceeds `contact_force` [N] if that is positive.
  virtual void follow(const JointTrajectory& path, double contact_force) = 0;
  virtual MotionStatus motion() = 0;  // of the last follow; kContact: stopped by it
  /// Seconds since who carries out the last follow gave a word of it; 0 when it has ended or
  /// answers at once, infinity when he is gone.
  virtual double answer_age() { return 0; }
  virtual std::string problem() = 0;  // why that failed, in words
  virtual void stop() = 0;
};

struct ArmPercepts;

/// What the cycle asks of a hand. Calls return at once.
class HandPort {
 public:
  virtual ~HandPort() = default;
  /// Speeds are shares of the joints' greatest. @param until_contact fingers stop where they press,
  /// with `effort` of each joint [N m or N]; empty: the hand's own.
  virtual void move(const std::vector<std::string>& joints, const std::vector<double>& positions,
                    double speed, bool until_contact, const std::vector<double>& effort) = 0;
  virtual MotionStatus motion() = 0;         // of the last move; kContact: fingers press
  virtual double answer_age() { return 0; }  // as ArmPort's
  virtual std::string problem() = 0;
  /// Of its joints where the last motion ended [rad or m]; empty: not known.
  virtual std::vector<double> positions() = 0;
  virtual void stop() = 0;

  /// It controls its force by its pads from press() on, and tells by them and by its opening
  /// whether it holds something. What follows is of such hands.
  virtual bool feels_its_grip() const { return false; }
  virtual void prepare(const ArmGrasp& /*grasp*/) {}           // an attempt with it begins
  virtual void step(const ArmPercepts& /*percepts*/) {}        // in each step of the cycle
  virtual std::vector<InputAge> inputs() const { return {}; }  // that it relies on
  virtual std::string fault() const { return {}; }  // that ends all, in words; empty: none
  /// The last move failed as something was in the way, not for want of who carries it out.
  virtual bool is_blocked() const { return false; }
  virtual bool touches() const { return false; }  // something, while the arm approaches
  /// After a closing that ended in contact: to the force of the grasp; motion() is of it then.
  virtual void press() {}
  /// After press(): to so many times the force, and no more than it can; motion() is of it then.
  /// False: it does not.
  virtual bool press_harder(double /*factor*/) { return false; }
  /// While it holds: from now on with so many times the force, and no more than `largest` [N per
  /// pad; 0: no limit but its own]. Returns at once. False: it already holds as hard as it can.
  virtual bool hold_harder(double /*factor*/, double /*largest*/) { return false; }
  virtual double opening() const { return 0; }  // m, now
  /// Why what was gripped is not held any more, in words; empty: it is. @param rests on something
  virtual std::string lost(bool /*rests*/) const { return {}; }
  virtual std::string grip() const { return {}; }        // how it holds, in words
  virtual std::string still_felt() const { return {}; }  // after it has let go; empty: nothing
};

/// What the cycle asks of who looks at what the hand holds. Calls return at once.
class InspectionPort {
 public:
  virtual ~InspectionPort() = default;
  /// What was gripped when `gripped` was perceived stands still before the camera `now`: look at
  /// it.
  virtual void look(const ArmPercepts& gripped, const ArmPercepts& now) = 0;
  /// Of the last look. kMoving: it goes on, while hand and arm stand; not for ever, which is this
  /// port's to see to: a look is computed, and takes as long however fast the percepts' time runs.
  virtual MotionStatus status() = 0;
  virtual std::string found() = 0;  // by that, in words: what is known now, or why it failed
  virtual void stop() = 0;
};

/// What a parallel gripper's drive says.
struct GripperPercept {
  double opening = 0;    // m
  bool blocked = false;  // commanded to move but does not
  unsigned error = 0;    // the device's code, 0 none
  double age = 0;        // s, at the percepts' time
};

/// All the cycle knows of the world.
struct ArmPercepts {
  double time = 0;  // s, now, of the graph's clock
  std::vector<std::string> names;
  std::vector<double> positions;  // rad, of arm and hand
  /// N, of contact on the hand, with what it holds, in a frame that moves with the hand.
  std::optional<Eigen::Vector3d> wrist_force;
  std::vector<PadPercept> pads = {};         // that have spoken; ages at `time`
  std::vector<touch::PadFrame> frames = {};  // of the same pads
  double joints_age = 0;                     // s, at `time`; 0: read in the same instant
  double wrist_age = 0;                      // s
  std::optional<GripperPercept> gripper = std::nullopt;  // of a hand that is one
  /// N m, with wrist_force, about the origin of the hand's root frame; none: not known.
  std::optional<Eigen::Vector3d> wrist_torque = std::nullopt;
};

}  // namespace prehend::control
