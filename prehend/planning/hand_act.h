#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/planning/touch_prediction.h"
#include "prehend/robot/closing_way.h"
#include "prehend/simulation/robot_world.h"

namespace prehend::planning {

/// Why an act cannot be simulated, or ends early.
struct ActEnds {
  TouchOutcome outcome;
  std::string why;
};

/// A hand alone and an object that stands on its table, in simulation::RobotWorld: the hand is put
/// where a grasp closes, closes as the cycle closes it, and is raised. It can begin again and
/// again, each time with the object as it stood. Frame T: the table's, z = 0 on it.
class HandAct {
 public:
  /// The object is set down and comes to rest. @param hand, options outlive it; @param until when
  /// it gives up. @throws ActEnds (not std::exception) when the object does not stand or time is
  /// up, geometry::InputError as RobotWorld::add_object().
  HandAct(const robot::HandModel& hand, const ObjectToFeel& object,
          const TouchPredictionOptions& options, std::chrono::steady_clock::time_point until);

  /// Called after each step of close() and lift().
  std::function<void()> after_step;

  /// The open hand at the grasp, the object as it stood. @pre the grasp is of this hand
  void begin(const GraspToFeel& grasp);
  /// Fingers gather, close until they press, press on until their pads feel the force, and rest.
  void close();
  /// The hand rises along the table's normal by `height` [m] in `duration` [s], and rests.
  void lift(double height, double duration);
  /// @throws ActEnds when the object has fallen over or was thrown away.
  void check_object(TouchOutcome outcome, const std::string& what) const;

  /// What the pads' electronics show.
  std::vector<PredictedPad> read() const;
  robot::MeanTouch mean(const std::vector<PredictedPad>& pads) const;
  const Eigen::VectorXd& stopped() const { return stopped_; }  // rad or m, of the motors
  const robot::ClosingWay& way() const { return way_; }
  const simulation::RobotWorld& world() const { return world_; }
  simulation::RobotBodyReading object() const;
  /// Where the hand holds it: what was at p when it stood is at X_HO p in the hand's root frame.
  geometry::RigidTransform X_HO() const;
  /// Of all joints of the hand's model, in its order [rad or m].
  Eigen::VectorXd all_joints() const;

 private:
  void step();
  void run_for(double seconds);
  void move(double beyond, double share);
  void press(double wanted, double share);
  Eigen::Vector3d center_of(const PredictedPad& pad, const contact::PadLayout& layout) const;

  const robot::HandModel& hand_;
  const TouchPredictionOptions& options_;
  std::chrono::steady_clock::time_point until_;
  geometry::RigidTransform X_TW_;
  simulation::RobotWorld world_;
  std::shared_ptr<const simulation::RobotWorld::State> standing_;
  robot::ClosingWay way_;
  double wanted_ = 0, share_ = 1;  // N, of the pads' mean; of the motors' effort at first
  geometry::RigidTransform X_TB_start_ = geometry::RigidTransform::Identity();
  Eigen::VectorXd stopped_;
  long steps_ = 0;
};

/// Where the hand's root is at the grasp, in W. @pre the grasp is of this hand
geometry::RigidTransform hand_root(const robot::HandModel& hand, const GraspToFeel& grasp);

/// The same as arguments of a public function. @throws std::invalid_argument naming the value,
/// geometry::InputError for an unknown preshape.
void check_act(const robot::HandModel& hand, const GraspToFeel& grasp, const ObjectToFeel& object);

}  // namespace prehend::planning
