#pragma once

#include <vector>

#include "prehend/motion/robot_in_world.h"

namespace prehend::motion {

/// Lines in joint space whose corners are rounded by circular arcs (T. Kunz and M. Stilman,
/// "Time-optimal trajectory generation for path following with bounded acceleration and velocity",
/// RSS 2012, section IV). The direction is continuous but at the corners that are left sharp, where
/// a motion has to stop.
class BlendedPath {
 public:
  /// A line, or an arc of a circle. Lengths in joint space (rad, and m of prismatic joints, alike).
  struct Piece {
    robot::Positions start;
    robot::Positions direction;  // unit, at the start
    robot::Positions inward;     // unit, to the arc's centre at the start; zero: a line
    double radius = 0;           // of the arc; 0: a line
    double length = 0;           // > 0
    bool stops = false;          // the corner at its end is sharp

    bool is_arc() const { return radius > 0; }
    robot::Positions position(double along) const;
    /// Derivatives of position() by the length along the piece.
    robot::Positions tangent(double along) const;
    robot::Positions curvature(double along) const;
  };

  /// @param deviation how far an arc may pass from its waypoint [rad or m, in joint space], >= 0;
  /// 0 leaves corners sharp. An arc takes at most half of each line beside it. Waypoints that
  /// coincide are taken as one; a reversal stays sharp.
  /// @throws std::invalid_argument without waypoints, for sizes that differ, or what is not finite.
  BlendedPath(const std::vector<robot::Positions>& waypoints, double deviation);

  /// As above for lines that are free. An arc that is not, at steps of `resolution` [rad or m] of
  /// any joint, is made with half the deviation, and so on; after five halvings the corner stays
  /// sharp. @throws std::invalid_argument also for a resolution that is not positive.
  BlendedPath(const RobotInWorld& robot, const std::vector<robot::Positions>& waypoints,
              double deviation, double resolution = 0.02);

  const std::vector<Piece>& pieces() const { return pieces_; }
  const robot::Positions& front() const { return front_; }
  const robot::Positions& back() const { return back_; }
  double length() const;
  /// Corners that are left sharp.
  int stops() const;

 private:
  void build(const std::vector<robot::Positions>& waypoints, double deviation,
             const RobotInWorld* robot, double resolution);

  std::vector<Piece> pieces_;
  robot::Positions front_, back_;
};

}  // namespace prehend::motion
