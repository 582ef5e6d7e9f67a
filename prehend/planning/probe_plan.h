#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/grasp/closing/close_fingers.h"
#include "prehend/planning/platform_pick.h"
#include "prehend/surface/object_model.h"

// From where a fingertip would learn most to a motion of the arm that touches there.
namespace prehend::planning {

/// A straight motion of a fingertip, a ball, by which something is to be learnt of an object's
/// surface; as belief::Probe [m, m^2].
struct ProbeWay {
  Eigen::Vector3d start_W = Eigen::Vector3d::Zero();  // of the ball's centre
  Eigen::Vector3d at_W = Eigen::Vector3d::Zero();     // on the surface, where it is expected
  double radius = 0;                                  // m, of the ball
  double gain = 0;                                    // the more, the better
};

struct ProbePlanOptions {
  double speed = 0.01;        // m/s, > 0, of the hand on the straight way
  double beyond = 0.015;      // m, > 0, that it goes on where nothing is met as expected
  double clearance = 0.004;   // m, >= 0, of the hand from all, where the straight way begins
  double largest_off = 0.01;  // m, > 0, along the way, between where the ball and the hand meet it
  int rolls = 8;              // > 0, of the hand about each direction
  int candidates = 24;        // > 0, poses of the hand that the arm is asked for

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// How a hand touches an object with one fingertip, or the tip of a jaw.
struct PlannedProbe {
  int way = -1;     // of the list; -1: none can be made
  int finger = -1;  // of the hand, that touches
  /// No grasp: where the open hand is at the way's end, and how it comes there; its one contact is
  /// where the fingertip is then.
  grasp::Grasp hand;
  Eigen::Vector3d tip_H = Eigen::Vector3d::Zero();  // m, its foremost point, in the hand's root
  std::vector<motion::PickSegment> segments;        // timed: reach, approach
  std::vector<double> stops;  // m, of the approach until it meets each shape; beyond its end: none
  std::string problem;        // why there is none, in words
};

/// Plans the motion of the first of the `ways`, best first, that the arm can make: the open hand,
/// in its first preshape, comes to where the foremost point of one of its fingers, along the way,
/// is on the way's line, and goes straight along it. The hand is turned towards the way, tilted so
/// that the finger leads, or comes from above (or as the arm holds it, where no joint can tilt it),
/// each turned about in `rolls` steps. By the believed mesh the finger must meet the object before
/// any other part of the hand meets anything, within `largest_off` of where it is expected. The
/// rest is plan_platform_pick()'s, which keeps arm and hand from table and neighbours.
/// @param object which the pieces of `scene` are of, with its other shapes.
/// @throws as plan_platform_pick(), and std::invalid_argument for options out of range.
PlannedProbe plan_probe(const robot::Platform& platform, const grasp::HandToClose& hand,
                        const robot::Positions& start, const std::vector<ProbeWay>& ways,
                        const surface::ObjectModel& object, const PlatformScene& scene,
                        const PlatformPickOptions& arm, const ProbePlanOptions& options = {});

}  // namespace prehend::planning
