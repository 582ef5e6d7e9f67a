#pragma once

#include <deque>
#include <map>

#include <Eigen/Geometry>

#include "msgs/objects.pb.h"
#include "prehend/planning/platform_plan.h"

namespace prehend::nodes {

/// What an object of a view is to the others. @throws geometry::InputError for a bad mesh.
planning::Neighbours neighbour_of(const msgs::ObjectModel& model);

/// What the robot has put down in a cycle, where it was put: things that a camera may not see there
/// are in the way all the same.
class PlacedObjects {
 public:
  /// Keeps the newest 64. @param picked what it was in the view that it was picked from, which is
  /// no more where it was put down before; null: that view is not known.
  /// @throws geometry::InputError for a bad mesh.
  void add(const msgs::ObjectModel& model, const planning::Neighbours* picked);
  /// The cycle has ended: somebody may take away what was put down.
  void clear() { placed_.clear(); }

  /// Those of which nothing of `seen`, by id, is a view: where one is seen, the look knows better.
  /// It is one when it is no mere fragment, and its convex pieces hold the middle of what was put
  /// down, or its own middle is in the box of that. What reaches into the box beside it is not.
  planning::Neighbours unseen(const std::map<std::uint32_t, planning::Neighbours>& seen) const;

 private:
  struct Placed {
    planning::Neighbours shape;
    Eigen::AlignedBox3d box_W;  // m
    bool is_seen_as(const planning::Neighbours& other) const;
  };
  std::deque<Placed> placed_;
};

}  // namespace prehend::nodes
