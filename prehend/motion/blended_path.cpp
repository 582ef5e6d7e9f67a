#include "prehend/motion/blended_path.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace prehend::motion {
namespace {

using robot::Positions;

constexpr double kCoincident = 1e-12;  // rad or m
constexpr double kStraight = 1e-9;     // tangent of half the turn: no corner
constexpr double kReversal = 1e6;      // tangent of half the turn: no arc
constexpr int kHalvings = 5;

/// An arc that rounds the corner between two lines of directions `in` and `out`.
struct Corner {
  bool sharp = true;
  double cut = 0;  // of each line
  BlendedPath::Piece arc;
};

/// @param room how much of each line an arc may take.
Corner round(const Positions& waypoint, const Positions& in, const Positions& out, double room,
             double deviation) {
  Corner corner;
  const Positions change = out - in;
  const double sine = 0.5 * change.norm(), cosine = 0.5 * (out + in).norm();  // of half the turn
  const double tangent = sine / cosine;
  if (tangent < kStraight) {
    corner.sharp = false;
    return corner;
  }
  if (!(tangent < kReversal) || deviation == 0) return corner;
  // 1 - cosine without cancellation.
  corner.cut = std::min(room, deviation * (1 + cosine) / sine);
  corner.arc.radius = corner.cut / tangent;
  corner.arc.start = waypoint - corner.cut * in;
  corner.arc.direction = in;
  // Across `in`, in the plane of the corner.
  corner.arc.inward = (change - in * in.dot(change)).normalized();
  corner.arc.length = corner.arc.radius * 2 * std::atan2(sine, cosine);
  corner.sharp = false;
  return corner;
}

bool is_free(const RobotInWorld& robot, const BlendedPath::Piece& arc, double resolution) {
  const int steps = std::max(1, static_cast<int>(std::ceil(arc.length / resolution)));
  for (int i = 0; i <= steps; ++i) {
    if (!robot.is_free(arc.position(arc.length * i / steps))) return false;
  }
  return true;
}

}  // namespace

Positions BlendedPath::Piece::position(double along) const {
  if (!is_arc()) return start + along * direction;
  const double angle = along / radius, half = std::sin(0.5 * angle);
  return start + radius * std::sin(angle) * direction + 2 * radius * half * half * inward;
}

Positions BlendedPath::Piece::tangent(double along) const {
  if (!is_arc()) return direction;
  return std::cos(along / radius) * direction + std::sin(along / radius) * inward;
}

Positions BlendedPath::Piece::curvature(double along) const {
  if (!is_arc()) return Positions::Zero(direction.size());
  return (std::cos(along / radius) * inward - std::sin(along / radius) * direction) / radius;
}

BlendedPath::BlendedPath(const std::vector<Positions>& waypoints, double deviation) {
  build(waypoints, deviation, nullptr, 0);
}

BlendedPath::BlendedPath(const RobotInWorld& robot, const std::vector<Positions>& waypoints,
                         double deviation, double resolution) {
  if (!(resolution > 0) || !std::isfinite(resolution)) {
    throw std::invalid_argument("BlendedPath: the resolution must be positive");
  }
  for (const Positions& waypoint : waypoints) {
    if (waypoint.size() == robot.chain().size()) continue;
    throw std::invalid_argument("BlendedPath: a waypoint needs " +
                                std::to_string(robot.chain().size()) + " positions");
  }
  build(waypoints, deviation, &robot, resolution);
}

void BlendedPath::build(const std::vector<Positions>& waypoints, double deviation,
                        const RobotInWorld* robot, double resolution) {
  const auto require = [](bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(std::string("BlendedPath: ") + what);
  };
  require(!waypoints.empty(), "there are no waypoints");
  require(deviation >= 0 && std::isfinite(deviation), "the deviation must be >= 0");
  std::vector<Positions> way;
  for (const Positions& waypoint : waypoints) {
    require(waypoint.size() == waypoints.front().size() && waypoint.size() > 0,
            "waypoints have different sizes");
    require(waypoint.allFinite(), "a waypoint is not finite");
    if (way.empty() || (waypoint - way.back()).norm() > kCoincident) way.push_back(waypoint);
  }
  front_ = waypoints.front();
  back_ = waypoints.back();
  double used = 0;  // of the line, by the arc at its start
  for (std::size_t i = 0; i + 1 < way.size(); ++i) {
    const Positions line = way[i + 1] - way[i];
    const double length = line.norm();
    const Positions direction = line / length;
    Corner corner;
    if (i + 2 < way.size()) {
      const Positions next = way[i + 2] - way[i + 1];
      const double room = 0.5 * std::min(length, next.norm());
      double nearer = deviation;
      for (int k = 0; k <= kHalvings; ++k, nearer /= 2) {
        corner = round(way[i + 1], direction, next.normalized(), room, nearer);
        if (!robot || !corner.arc.is_arc() || is_free(*robot, corner.arc, resolution)) break;
        corner = Corner{};
      }
    }
    const double left = length - used - corner.cut;
    // Between two arcs that take half each nothing is left but rounding.
    if (left > kCoincident) {
      Piece piece;
      piece.start = way[i] + used * direction;
      piece.direction = direction;
      piece.inward = Positions::Zero(direction.size());
      piece.length = left;
      pieces_.push_back(piece);
    }
    if (corner.sharp && !pieces_.empty()) pieces_.back().stops = true;
    if (corner.arc.is_arc()) pieces_.push_back(corner.arc);
    used = corner.cut;
  }
}

double BlendedPath::length() const {
  double sum = 0;
  for (const Piece& piece : pieces_) sum += piece.length;
  return sum;
}

int BlendedPath::stops() const {
  int count = 0;
  for (std::size_t i = 0; i + 1 < pieces_.size(); ++i) count += pieces_[i].stops;
  return count;
}

}  // namespace prehend::motion
