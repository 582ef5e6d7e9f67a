#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/grasp/closing/close_fingers.h"
#include "prehend/planning/platform_pick.h"
#include "prehend/surface/object_model.h"

// How a hand pushes things apart that cannot be grasped as they stand.
namespace prehend::planning {

/// A straight way along the table.
struct PushLine {
  Eigen::Vector3d end_W = Eigen::Vector3d::Zero();         // m, of the hand
  Eigen::Vector3d direction_W = Eigen::Vector3d::UnitX();  // unit
};

struct PushPlanOptions {
  /// Pushes that were made, and did not part what stands there: others come first.
  std::vector<PushLine> made;
  double speed = 0.08;      // m/s, > 0, of the hand on the straight way
  double beyond = 0.06;     // m, > 0, that it goes on where it meets something
  double height = 0.02;     // m, > 0, of its lowest point over the table
  double clearance = 0.01;  // m, >= 0, of the hand from all, where the straight way begins
  int directions = 16;      // > 0, along the table

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// A straight way of the hand along the table, through something.
struct PlannedPush {
  /// No grasp: where the hand is at the way's end, and how it comes there.
  grasp::Grasp hand;
  std::vector<motion::PickSegment> segments;  // timed: reach, approach; empty: none can be made
  double length = 0;                          // m, that it goes on from where it meets something
  double room = 0;      // m, before what is pushed there meets something else; no more than length
  double worth = 0;     // 0..1: share of the length with room, less where it was pushed before
  std::string problem;  // why there is none, in words
};

/// Plans a way of the hand along the table that moves an object: through its middle, or beside it
/// by a third of its width, from where the hand is clear of everything to `beyond` from the first
/// thing that it meets. A parallel gripper is nearly closed, other hands are open, and come from
/// above (or as the arm holds them, where no joint can tilt it), turned about in quarters. Ways on
/// which the object has most room before it come first, and those like what was `made` (within 45
/// degrees and 0.1 m) last; what is pushed stays on the part of the
/// table that the arm's motions are planned on. The rest is plan_platform_pick()'s: the arm keeps
/// from everything but what the hand pushes.
/// @param object which the pieces of `scene` are of.
/// @throws as plan_platform_pick(), and std::invalid_argument for options out of range.
PlannedPush plan_push(const robot::Platform& platform, const grasp::HandToClose& hand,
                      const robot::Positions& start, const surface::ObjectModel& object,
                      const PlatformScene& scene, const PlatformPickOptions& arm,
                      const PushPlanOptions& options = {});

}  // namespace prehend::planning
