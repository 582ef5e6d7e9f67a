#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "prehend/control/balance.h"
#include "prehend/control/cycle.h"
#include "prehend/control/joint_trajectory.h"
#include "prehend/motion/segment.h"
#include "prehend/robot/closing_way.h"

namespace prehend::control {

/// A planned grasp with the arm's motion round it.
struct ArmGrasp {
  GraspPose pose;
  /// In the order in which they are run; some may lack.
  std::vector<std::pair<motion::SegmentKind, JointTrajectory>> segments;
  /// Share of the time of the segment kPlace, in (0, 1], at which the object is predicted to stand.
  /// The rest is gone until it is felt to, where the wrist can be felt.
  double place_share = 1;
  double approach_length = 0;  // m, of the straight way of the segment kApproach; 0: not known
  double place_length = 0;     // m, the same of kPlace; 0: what presses there is not gone up from
  std::vector<std::string> hand_joints;
  robot::ClosingWay hand;   // of hand_joints
  double lifted_mass = 0;   // kg, predicted; 0: not predicted. Compared, but decides nothing
  double score = 0;         // expected success, 0 to 1
  double robustness = -1;   // share of disturbed trials in which it holds; -1: not assessed
  double force = 0;         // N, per pad, that it is to be held with; 0: as the motors press
  bool knows_slip = false;  // that force is by how the object slipped before
  double effort = 1;        // share of what the hand can that this is thought to take, in (0, 1]
  std::vector<double> largest_effort;  // N m or N, of hand_joints; empty: not known
  /// What the pads that touch are predicted to feel then, their mean [m^2, N]; 0: not predicted.
  double contact_area = 0, tactile_sum = 0;
  double closure = 0;  // rad, predicted, that the hand has closed when it meets it, by ClosingWay
  /// How it can adapt to a thing that is beside its prediction, and how it feels that: of
  /// hand_joints, see displacement_felt(). Empty: it does not, as where no simulated hand has said
  /// where its motors are stopped.
  std::vector<HandShift> shifts;
  robot::FingertipWays fingertips;  // in the world
  Eigen::VectorXd stops;            // rad or m, where it is predicted to be stopped by the thing
  /// To turn it before a camera, each from the lift's end and back the same way; without points: it
  /// is looked at where it is. Empty: it is not, and why, in words.
  std::vector<JointTrajectory> views;
  std::string views_problem;
  /// It is no grasp but a probe: the fingertip's foremost point on its way, in the hand's root
  /// frame [m]. Unset: a grasp.
  std::optional<Eigen::Vector3d> probe_H;
  /// It is no grasp but a push: its approach goes on through what the hand meets.
  bool pushes = false;

  bool is_grasp() const { return !probe_H && !pushes; }
};

/// "grasp 2 (score 0.71, held in 80 % of the disturbed trials)".
std::string described(const ArmGrasp& grasp, int index);

}  // namespace prehend::control
