#pragma once

#include <utility>
#include <vector>

namespace prehend::robot {

class KinematicChain;

}  // namespace prehend::robot

namespace prehend::motion {

struct RobotSphere;

/// Positions that much beyond a joint's limits [rad or m] count as within them here: a robot that
/// stands there is still tested as one that may get there.
constexpr double kPastLimits = 0.02;

/// Whether two balls of a chain stay apart at all positions within its limits. Proven by branch and
/// bound over the positions of the joints between them: from the middle of a box of positions a
/// ball moves by at most the sum over the joints of 2 sin(half of the turn / 2) times its largest
/// distance from the axis; the joint that comes first is solved for in closed form. (Lipschitz
/// bounds: S. A. Piyavskii, "An algorithm for finding the absolute extremum of a function", USSR
/// Computational Mathematics and Mathematical Physics 12, 1972.) Given up after 1000 boxes, where
/// more than three joints are between them after 10.
/// @return false: they touch somewhere, or it was not proven, as of balls of one joint
bool are_kept_apart(const robot::KinematicChain& chain, const RobotSphere& a, const RobotSphere& b);

/// Those of `pairs` of `spheres` that are_kept_apart(), as proven of them, of balls round all balls
/// of their links, or round halves, quarters and so on of these. The same order. What was proven of
/// two links is kept for this process: robots are prepared anew for each posture of the hand.
std::vector<std::pair<int, int>> kept_apart(const robot::KinematicChain& chain,
                                            const std::vector<RobotSphere>& spheres,
                                            const std::vector<std::pair<int, int>>& pairs);

}  // namespace prehend::motion
