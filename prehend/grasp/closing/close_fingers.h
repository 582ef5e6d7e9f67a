#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/grasp/closing/hand_balls.h"
#include "prehend/grasp/closing/touch_scene.h"
#include "prehend/grasp/grasp.h"
#include "prehend/robot/hand_model.h"

namespace prehend::grasp {

class ClosingMethod;

/// A hand made ready for closing: its model, how it closes, the balls of its surface. Refers to the
/// model.
struct HandToClose {
  /// @throws geometry::InputError when the hand cannot close as its file says: closing_method().
  explicit HandToClose(const robot::HandModel& model);
  const robot::HandModel* hand;
  std::shared_ptr<const ClosingMethod> method;
  HandBalls balls;
};

struct HandClosingOptions {
  double tolerance = 1e-4;    // m, > 0: clearance at which a link counts as touching
  double patch_depth = 5e-4;  // m, > 0: what is nearer to the surface than this is in contact: the
                              // give of rubber under light force
  int largest_steps = 400;    // > 0, of each finger
  double farthest_push = 0.02;  // m, >= 0: by which jaws of one motor push a thing to their middle

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

struct ClosedFingers {
  Eigen::VectorXd all;                 // positions of all joints of the model [rad or m]
  std::vector<GraspContact> contacts;  // of the object, in the order of the links
  std::vector<bool> finger_touches;    // the object, of the hand's fingers
  Touched other = Touched::kNothing;   // kTable, kObstacle: a finger was stopped by that
  std::vector<double> broken_away;     // rad, by which joints of hand.breakaways went on
  /// By which the hand has to stand elsewhere for this [m, in the world]: fingers of one motor push
  /// the object to their middle, which is here as if the hand went there.
  Eigen::Vector3d push_W = Eigen::Vector3d::Zero();
};

/// Closes the fingers of a hand whose root stands at X_WH from positions `open` of its motors until
/// they touch, without physics: the object does not move.
///
/// Each joint moves at its rate of `preshape.closing` until a link that it moves touches something
/// (the joints below it go on) or it is at its limit; a joint `with` another stops with it; a
/// coupled joint stops with its motor, but a joint that breaks away (BarrettHand) goes on when the
/// link above it is stopped. Motion is by conservative advancement: no step is longer than the
/// clearance of the link's balls divided by a bound of their speed (B. Mirtich, "Impulse-based
/// dynamic simulation of rigid body systems", 1996, section 2.3), so that nothing is stepped over;
/// the last step is corrected by exact distances. A link that touches while moving away or along is
/// let go on. Where one motor moves several fingers and the first of them touches the object, it
/// pushes it until another one touches, too, at most by `farthest_push`: `push_W`. Fingers that no
/// joint couples are closed one after the other; they are not tested
/// against each other.
/// @throws std::invalid_argument when `open` has another size than the hand, or for bad options.
ClosedFingers close_fingers(const HandToClose& hand, const geometry::RigidTransform& X_WH,
                            const robot::Preshape& preshape, const Eigen::VectorXd& open,
                            const TouchScene& scene, const HandClosingOptions& options = {});

/// How far the hand, its joints at `all`, moves from X_WH along `direction_W` (unit) before any
/// link is nearer than `margin` [m] to anything; at most `distance`. 0 when it starts that near.
struct Advance {
  double distance = 0;  // m
  Touched what = Touched::kNothing;
  int link = -1;  // that is stopped
};
Advance advance_hand(const HandToClose& hand, const geometry::RigidTransform& X_WH,
                     const Eigen::VectorXd& all, const Eigen::Vector3d& direction_W,
                     double distance, double margin, const TouchScene& scene);

/// Least clearance of all links [m], as nearest_ball() has it; `link` gets the link.
NearBall hand_clearance(const HandToClose& hand, const geometry::RigidTransform& X_WH,
                        const Eigen::VectorXd& all, const TouchScene& scene, int* link = nullptr);

}  // namespace prehend::grasp
