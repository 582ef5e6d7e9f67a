#pragma once

#include <optional>
#include <string>
#include <vector>

#include "prehend/control/arm_cycle.h"
#include "prehend/control/force_controller.h"
#include "prehend/robot/gripper_model.h"

namespace prehend::control {

/// What is asked of a parallel gripper's drive. Calls return at once. Openings in m; speeds in m/s
/// of the opening, negative closes; currents in A, > 0.
class GripperPort {
 public:
  virtual ~GripperPort() = default;
  virtual void move_to(double opening, double speed) = 0;
  virtual MotionStatus motion() = 0;         // of the last move_to; kContact: blocked
  virtual double answer_age() { return 0; }  // as ArmPort's
  /// Moves with `speed` until told otherwise, pushing with no more than `current_limit`.
  virtual void command_velocity(double speed, double current_limit) = 0;
  virtual void stop() = 0;
};

struct PadGripperOptions {
  double closing_speed = 0.02;       // m/s
  double fast_closing_speed = 0.05;  // m/s
  double closing_margin = 0.006;     // m
  double pressing_speed = 0.01;      // m/s
  double early_force = 4;            // N
  double held_ratio = 0.3;
  double largest_collapse = 0.004;  // m
  double settled_time = 0.2;        // s
  double closing_timeout = 8;       // s
  double force_timeout = 4;         // s
  double largest_excess = 1.5;
  double least_share = 0.6;  // a finger that meets the object beside its pad keeps it from more;
                             // whether that holds is seen after the lift
  double touch_force = 0.3;  // N, > 0, as robot::GripOptions'
  double stale_time = 0.25;  // s, > 0, as SharedCycleOptions'
  ForceControllerOptions force;

  /// See text/knob.h.
  template <class Self, class Visit>
  static void knobs(Self& self, Visit&& visit) {
    using text::Knob;
    visit(Knob{"closing_speed", self.closing_speed, "m/s", 0.0001, 1,
               "of the opening, until both pads touch"});
    visit(Knob{"fast_closing_speed", self.fast_closing_speed, "m/s", 0.0001, 1,
               "before that, where nothing is predicted"});
    visit(Knob{"closing_margin", self.closing_margin, "m", 0, 1,
               "of the opening over the predicted one: from there on slower"});
    visit(Knob{"pressing_speed", self.pressing_speed, "m/s", 0.0001, 1,
               "aimed at under force control"});
    visit(Knob{"early_force", self.early_force, "N", 0.01, 1000,
               "of a pad's sum, that is no noise while the arm approaches"});
    visit(
        Knob{"held_ratio", self.held_ratio, "", 0, 1,
             "of the grasp force that one pad must still feel when lifted, the other any: what it "
             "feels less is borne beside its cells"});
    visit(Knob{"largest_collapse", self.largest_collapse, "m", 0.0001, 1,
               "that the opening may shrink after the grasp settled, of what the pads feel too "
               "little of"});
    visit(Knob{"settled_time", self.settled_time, "s", 0, 10, "that the force must stay settled"});
    visit(Knob{"closing_timeout", self.closing_timeout, "s", 0.1, 120,
               "from the start of closing to the touch of both pads"});
    visit(Knob{"force_timeout", self.force_timeout, "s", 0.1, 120, "to reach the grasp force"});
    visit(Knob{"largest_excess", self.largest_excess, "", 1, 10,
               "times the grasp force, that is taken after this time"});
    visit(Knob{"least_share", self.least_share, "", 0.01, 1,
               "of the grasp force, that is taken then too"});
  }

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// A parallel gripper with two tactile pads as a hand of the cycle. It closes with a constant speed
/// until both pads touch, and controls the mean of their sums through the motor's current from then
/// on until it is told something else. What it holds its pads and its opening tell: something is
/// lost when a pad feels too little, or the jaws have closed. Its one joint is half of the
/// opening. Not thread-safe.
class PadGripper : public HandPort {
 public:
  /// Keeps a reference to the port. @throws std::invalid_argument for options out of range.
  PadGripper(const robot::GripperModel& gripper, const PadGripperOptions& options,
             GripperPort& port);

  /// From now on it is this one. @pre nothing is gripped
  void set_gripper(const robot::GripperModel& gripper);

  void move(const std::vector<std::string>& joints, const std::vector<double>& positions,
            double speed, bool until_contact, const std::vector<double>& effort) override;
  MotionStatus motion() override;
  double answer_age() override { return port_.answer_age(); }
  std::string problem() override { return problem_; }
  std::vector<double> positions() override;
  void stop() override;

  bool feels_its_grip() const override { return true; }
  void prepare(const ArmGrasp& grasp) override;
  void press() override;
  bool press_harder(double factor) override;
  bool hold_harder(double factor, double largest) override;
  void step(const ArmPercepts& percepts) override;
  std::vector<InputAge> inputs() const override;
  std::string fault() const override;
  bool is_blocked() const override { return is_blocked_; }
  bool touches() const override;
  double opening() const override { return percept_ ? percept_->opening : 0; }
  std::string lost(bool rests) const override;
  std::string grip() const override;
  std::string still_felt() const override;

 private:
  enum class Mode { kStands, kMoves, kCloses, kPresses, kHolds };
  void close();
  void regulate();
  void settle();
  void hold();
  void fail(const std::string& problem);
  double most() const;  // N, per pad, that the drive gives
  double mean_sum() const { return (left_->sum + right_->sum) / 2; }

  robot::GripperModel gripper_;
  PadGripperOptions options_;
  GripperPort& port_;
  ForceController controller_;
  double force_ = 0, predicted_opening_ = 0;  // N per pad, m; of the grasp
  std::optional<GripperPercept> percept_;
  std::optional<PadPercept> left_, right_;
  double now_ = 0, begun_ = 0, updated_ = 0;  // s
  std::optional<double> settled_since_;       // s
  Mode mode_ = Mode::kStands;
  MotionStatus status_ = MotionStatus::kReached;  // of what is no motion of the port's
  double grip_opening_ = 0;                       // m, when the force settled
  std::optional<double> rises_since_;             // s, held harder: it has not settled since
  std::string problem_;
  bool is_blocked_ = false;
};

}  // namespace prehend::control
