#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "prehend/control/cycle.h"
#include "prehend/control/force_controller.h"
#include "prehend/control/input_watch.h"
#include "prehend/control/pad_gripper.h"
#include "prehend/control/pad_percept.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/grasp/planner.h"
#include "prehend/robot/gripper_model.h"

namespace prehend::control {

/// What the cycle asks of the carrier that holds the gripper. Calls return at once.
class CarrierPort {
 public:
  virtual ~CarrierPort() = default;
  /// Straight line of the gripper frame to X_WG at `speed` [m/s]; stops when the wrist force
  /// exceeds `contact_force` [N] if that is positive. The force includes a held object's weight.
  virtual void move_to(const geometry::RigidTransform& X_WG, double speed,
                       double contact_force) = 0;
  virtual MotionStatus motion() = 0;         // of the last move_to
  virtual double answer_age() { return 0; }  // as GripperPort's
  virtual void stop() = 0;
};

/// All the cycle knows of the world. Unset: nothing has come yet. Ages in s at `time`, 0 for what
/// is read in the same instant.
struct Percepts {
  double time = 0;  // s, now, of the graph's clock
  std::optional<PadPercept> left;
  std::optional<PadPercept> right;
  std::optional<double> opening;  // m
  bool gripper_blocked = false;   // commanded to move but does not
  unsigned gripper_error = 0;     // the device's code, 0 none
  double gripper_age = 0;
  std::optional<double> wrist_force;  // N
  double wrist_age = 0;
  std::optional<geometry::RigidTransform> X_WG;
  double carrier_age = 0;
};

struct CycleOptions : SharedCycleOptions {
  Eigen::Vector3d up_W = Eigen::Vector3d::UnitZ();  // unit, away from the table
  double transit_height = 0.30;  // m along up_W, of G above which it may cross the scene; 0: none
  double travel_speed = 0.25;    // m/s, > 0, in free space
  double approach_speed = 0.08;  // m/s, > 0
  double lift_speed = 0.10;      // m/s, > 0
  double opening_speed = 0.08;   // m/s, > 0
  double closing_speed = 0.02;   // m/s, > 0, until both pads touch
  double fast_closing_speed = 0.05;  // m/s, > 0, before that, where nothing is predicted
  double closing_margin = 0.006;     // m, >= 0, of the opening over the predicted one: then slower
  double pressing_speed = 0.01;      // m/s, > 0, aimed at under force control
  double contact_force = 4;          // N, > 0, at the wrist that counts as unexpected contact
  double touch_force = 0.3;          // N, > 0, of a pad's sum
  double held_ratio = 0.3;          // 0..1, of the grasp force each pad must still feel when lifted
  double largest_collapse = 0.004;  // m, > 0, the opening may shrink after the grasp settled
  double settled_time = 0.2;        // s, >= 0, the force must stay settled
  double check_time = 0.4;    // s, >= 0, to wait after the lift before looking whether it is held
  double lift_height = 0.15;  // m, >= 0.12
  Eigen::Vector3d move_W{0, 0.15, 0};  // m, sideways with the object
  double motion_timeout = 20;          // s, > 0, of each motion of carrier or gripper
  double closing_timeout = 8;   // s, > 0, from the start of closing to the touch of both pads
  double force_timeout = 4;     // s, > 0, to reach the grasp force
  double largest_excess = 1.5;  // >= 1, times the grasp force, that is taken after this time
  /// In (0, 1], of the grasp force, that is taken then too: a finger that meets the object beside
  /// its pad keeps it from more. Whether that holds is seen after the lift.
  double least_share = 0.6;
  ForceControllerOptions force;

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// Executes a task with a parallel gripper on its carrier. The approach opens, crosses at the
/// transit height to the pregrasp and goes straight on; the grasp closes with a constant speed
/// until both pads touch and controls the mean of the pads' sums through the motor's current until
/// it is settled; the lift looks whether the object is still held (the opening has not collapsed
/// and both pads still feel it); then it is carried sideways, lowered to where it stood over the
/// table, let go. What is felt is compared with what was predicted (surprises). Every wait ends by
/// its time-out on the percepts' clock. It begins when pads, gripper, wrist and carrier have
/// spoken. From then on, whenever one of them falls silent (`stale_time`), or who carries out a
/// motion (`answer_time`), gripper and carrier are stopped and the cycle ends with that reason; not
/// while it stands and waits for a new look.
///
/// Before a new look the hand goes back to where the cycle began, out of the camera's view.
///
/// Not thread-safe. Never blocks, never throws after start().
class GraspCycle : public Cycle {
 public:
  /// Keeps references to the ports. @throws std::invalid_argument for options out of range.
  GraspCycle(const robot::GripperModel& gripper, const CycleOptions& options,
             GripperPort& gripper_port, CarrierPort& carrier_port);

  /// Starts from the first grasp. An empty list ends at once as failed, with `problem` as reason.
  void start(std::vector<grasp::Grasp> grasps, const std::string& problem = "");

  /// One step; call it at 50 Hz or more. @pre percepts.time does not decrease.
  void step(const Percepts& percepts);

  /// Goes on with these, best first, carrying by `move_W` [m]; none of a new look when empty, for
  /// the reason `problem`. @pre looks_since() is set
  void take_plan(std::vector<grasp::Grasp> grasps, const Eigen::Vector3d& move_W,
                 const std::string& problem = "");

  /// That of the present or last attempt. @pre the cycle was started with a grasp
  const grasp::Grasp& grasp() const { return current_grasp(); }

 private:
  /// Parts of actions.
  enum class Step {
    kOpen,
    kRise,
    kCross,
    kPregrasp,
    kApproach,
    kClose,
    kPress,
    kLift,
    kCheck,
    kCarry,  // sideways, down or up again
    kLower,
    kRelease,
    kRetreat,
    kRiseClear,
    kClear,
    kWait
  };

  void begin(const Action& action) override;
  void prepare_attempt() override;
  void clear_view() override;
  void stop_motion() override;
  void enter(Step step, const std::string& detail);
  void begin_move(const Action& action);
  void step_transit();
  void step_approach();
  void step_close();
  void step_press();
  void step_lift();
  void step_check();
  void step_carry();
  void step_release();
  void step_clear();
  void step_waiting();
  /// What the cycle relies on.
  std::vector<InputAge> inputs();
  /// Stops and ends when something of it is lost; true then.
  bool stop_when_lost();
  void regulate_force();
  std::string why_not_held() const;
  void move_carrier(const geometry::RigidTransform& X_WG, double speed, double contact_force);
  geometry::RigidTransform raised_to_transit(const geometry::RigidTransform& X_WG) const;
  geometry::RigidTransform pregrasp() const;
  geometry::RigidTransform lifted(double share = 1) const;
  const grasp::Grasp& current_grasp() const { return grasps_[static_cast<size_t>(grasp_index())]; }
  bool timed_out(double limit) const { return spent() > limit; }

  robot::GripperModel gripper_;
  CycleOptions options_;
  GripperPort& gripper_port_;
  CarrierPort& carrier_port_;
  ForceController force_controller_;
  InputWatch watch_;
  Percepts percepts_;

  std::vector<grasp::Grasp> grasps_;
  Step step_ = Step::kWait;
  double wait_time_ = 0;       // s
  bool holds_ = false;         // the force is controlled
  bool stands_ = false;        // what is held was put down
  double last_update_ = 0;     // s, of the force controller
  double settled_since_ = -1;  // s, negative: not settled
  double grasp_opening_ = 0;   // m, when the force settled
  geometry::RigidTransform X_WG_target_ = geometry::RigidTransform::Identity();
  geometry::RigidTransform X_WG_start_ = geometry::RigidTransform::Identity();  // of the cycle
};

}  // namespace prehend::control
