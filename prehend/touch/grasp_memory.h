#pragma once

#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/touch/felt_pad.h"
#include "prehend/touch/imprint_memory.h"

namespace prehend::touch {

/// One pad's frame.
struct FeltFrame {
  const FeltPad* pad = nullptr;
  std::vector<double> counts;
};

/// What one grasp tells of the thing: the hand's posture (the opening of a gripper [m], the
/// positions of a hand's motors [rad]), and of the pads that touch the mean and the range of:
/// contact area, its extent along the finger and across it, how far from the fingertip it is, how
/// uneven the pressure is, the surface's two curvatures and its tilt along and across the finger.
/// It does not tell which pad felt what. Empty when no pad touches.
Eigen::VectorXd grasp_features(const Eigen::VectorXd& posture,
                               const std::vector<FeltFrame>& frames);

/// Recognises things that it was taught by grasps of them, taken anywhere.
///
/// A grasp is its features, each in units of how much it differs between a thing's grasp and the
/// most similar other grasp of the same thing: what changes from grasp to grasp counts little, what
/// repeats counts much. A question of one or more grasps is answered by the thing with the least
/// sum of squared distances to the nearest taught grasp, none more than a bound, so that a grasp
/// unlike all others decides nothing. It is refused when the sum exceeds what the things' own
/// grasps have.
class GraspMemory {
 public:
  /// Replaces what was taught of it before. @throws std::invalid_argument without grasps, or for
  /// features of another number than there are.
  void teach(const std::string& name, const std::vector<Eigen::VectorXd>& grasps);
  /// False when it was not known.
  bool forget(const std::string& name);

  /// @throws std::invalid_argument without grasps, or as teach().
  Recognised ask(const std::vector<Eigen::VectorXd>& grasps) const;

  const std::map<std::string, std::vector<Eigen::VectorXd>>& things() const { return things_; }

 private:
  void weigh();
  double squared_distance(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const;
  /// To the nearest of `grasps`, not `except` itself.
  double nearest(const Eigen::VectorXd& grasp, const std::vector<Eigen::VectorXd>& grasps,
                 const Eigen::VectorXd* except = nullptr) const;

  std::map<std::string, std::vector<Eigen::VectorXd>> things_;
  Eigen::VectorXd unit_;  // of each feature
  double usual_ = 1;      // squared distance, 1.5 times what 95 % of own grasps do not exceed
};

}  // namespace prehend::touch
