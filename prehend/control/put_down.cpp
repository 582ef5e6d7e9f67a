#include "prehend/control/put_down.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "prehend/text/require.h"

namespace prehend::control {
namespace {

using Rectangle = Eigen::AlignedBox2d;

Rectangle footprint(const Eigen::AlignedBox3d& box) {
  return {box.min().head<2>(), box.max().head<2>()};
}

// Least horizontal distance of the object with the hand to what it could hit [m], negative inside.
double room(const Rectangle& object, double bottom, const Eigen::Vector3d& move,
            const std::vector<Eigen::AlignedBox3d>& obstacles, double lift_height) {
  double least = std::numeric_limits<double>::infinity();
  const Rectangle end(object.min() + move.head<2>(), object.max() + move.head<2>());
  for (const auto& obstacle : obstacles) {
    // Diagonal ways are judged by their bounding rectangle: on the safe side.
    const bool in_the_way = obstacle.max().z() > bottom + lift_height;
    const Rectangle taken = in_the_way ? object.merged(end) : end;
    const Eigen::Vector2d gap =
        (footprint(obstacle).min() - taken.max()).cwiseMax(taken.min() - footprint(obstacle).max());
    least = std::min(least, gap.minCoeff() > 0 ? gap.norm() : gap.maxCoeff());
  }
  return least;
}

}  // namespace

void PutDownOptions::validate() const {
  const text::Require require{"PutDownOptions."};
  require(distance > 0, "distance must be positive");
  require(lift_height >= 0, "lift_height must not be negative");
  require(hand_radius >= 0, "hand_radius must not be negative");
  require(enough >= 0, "enough must not be negative");
  require(directions > 0, "directions must be positive");
}

Eigen::Vector3d choose_move(const Eigen::AlignedBox3d& object_W, const Eigen::Vector3d& hand_W,
                            const std::vector<Eigen::AlignedBox3d>& obstacles_W,
                            const PutDownOptions& options) {
  options.validate();
  const Eigen::Vector2d hand = Eigen::Vector2d::Constant(options.hand_radius);
  Rectangle taken = footprint(object_W);
  taken.extend(hand_W.head<2>() + hand);
  taken.extend(hand_W.head<2>() - hand);

  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double most = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < options.directions; ++i) {
    const double angle = std::numbers::pi * (0.5 + 2.0 * i / options.directions);
    const Eigen::Vector3d move =
        options.distance * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
    if (!options.workspace_W.isEmpty() && !options.workspace_W.contains(hand_W + move)) continue;
    const double found = room(taken, object_W.min().z(), move, obstacles_W, options.lift_height);
    if (found > most + 1e-9) {
      most = found;
      best = move;
    }
    if (found >= options.enough) break;
  }
  return best;
}

}  // namespace prehend::control
