#include "prehend/motion/blended_trajectory.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace prehend::motion {
namespace {

using robot::Positions;
using Piece = BlendedPath::Piece;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kLeastSteps = 8;     // of an arc
constexpr int kNewtonSteps = 100;  // each leaves one pair of rows behind: few are needed

/// low <= a u + b c <= high.
struct Row {
  double a = 0, b = 0, low = 0, high = 0;
};

/// The u that a set of rows allows at c, and the slopes of its ends by c.
struct Range {
  double low = -kInfinity, high = kInfinity;
  double low_slope = 0, high_slope = 0;
};

Range range(const std::vector<Row>& rows, double c) {
  Range result;
  for (const Row& row : rows) {
    if (row.a == 0) continue;
    const double slope = -row.b / row.a;
    const double one = row.low / row.a + slope * c, other = row.high / row.a + slope * c;
    const double low = std::min(one, other), high = std::max(one, other);
    if (low > result.low) {
      result.low = low;
      result.low_slope = slope;
    }
    if (high < result.high) {
      result.high = high;
      result.high_slope = slope;
    }
  }
  return result;
}

/// The largest c in [0, most] at which the rows allow a u, given that they do at 0. The gap between
/// the ends of u is concave in c, so that Newton's method from the right ends at the last zero.
double largest(const std::vector<Row>& rows, double most) {
  for (const Row& row : rows) {
    if (row.a == 0 && row.b != 0)
      most = std::min(most, std::max(row.low / row.b, row.high / row.b));
  }
  double c = most;
  for (int k = 0; k < kNewtonSteps && c > 0; ++k) {
    const Range u = range(rows, c);
    const double excess = u.low - u.high, slope = u.low_slope - u.high_slope;
    if (!(excess > 0) || !(slope > 0)) break;
    const double next = c - excess / slope;
    if (!(next < c)) break;
    c = next;
  }
  return std::max(0.0, c);
}

}  // namespace

/// Squares of speed at the borders of pieces and of steps in arcs. On an arc of radius r,
/// c = x / r [1/s^2], the acceleration to the centre, stands for x: c' = c + 2 u d over an angle d.
struct BlendedTrajectory::Timing {
  const BlendedPath& path;
  Eigen::VectorXd speed, acceleration;  // limits
  double angle_step;

  struct Arc {
    int steps = 0;
    double angle = 0;                        // of a step [rad]
    std::vector<Positions> tangent, inward;  // at the borders of steps: steps + 1
    std::vector<double> cap, reach;          // of c, by the speeds and by what comes after
  };
  std::vector<Arc> arcs{};      // one for each piece, empty for lines
  std::vector<double> reach{};  // largest x at the start of each piece, and of the end: 0
  std::vector<Row> rows{};
  double excess = 1;  // of an acceleration or a squared speed over its limit

  double line_speed(const Piece& line) const {
    double most = kInfinity;
    for (int j = 0; j < speed.size(); ++j)
      most = std::min(most, ratio(speed[j], line.direction[j]));
    return most;
  }
  double line_acceleration(const Piece& line) const {
    double most = kInfinity;
    for (int j = 0; j < speed.size(); ++j) {
      most = std::min(most, ratio(acceleration[j], line.direction[j]));
    }
    return most;
  }
  static double ratio(double limit, double share) {
    return share == 0 ? kInfinity : limit / std::abs(share);
  }

  Arc cut(const Piece& piece) const {
    Arc arc;
    const double angle = piece.length / piece.radius;
    arc.steps = std::max(kLeastSteps, static_cast<int>(std::ceil(angle / angle_step)));
    arc.angle = angle / arc.steps;
    for (int i = 0; i <= arc.steps; ++i) {
      const double along = piece.length * i / arc.steps;
      arc.tangent.push_back(piece.tangent(along));
      arc.inward.push_back(piece.radius * piece.curvature(along));
      double most = kInfinity;
      for (int j = 0; j < speed.size(); ++j) {
        const double v = ratio(speed[j], arc.tangent.back()[j]);
        most = std::min({most, v * v / piece.radius, ratio(acceleration[j], arc.inward.back()[j])});
      }
      arc.cap.push_back(most);
    }
    arc.reach.assign(static_cast<std::size_t>(arc.steps) + 1, 0);
    return arc;
  }

  /// The limits of acceleration at both ends of a step, by u and the c at its start.
  void set_rows(const Arc& arc, std::size_t step) {
    rows.clear();
    for (std::size_t end = 0; end < 2; ++end) {
      for (int j = 0; j < speed.size(); ++j) {
        const double b = arc.inward[step + end][j];
        const double later = end == 0 ? 0 : 2 * arc.angle;  // of u in c
        rows.push_back(
            {arc.tangent[step + end][j] + b * later, b, -acceleration[j], acceleration[j]});
      }
    }
  }

  void backward() {
    reach.assign(path.pieces().size() + 1, 0);
    arcs.resize(path.pieces().size());
    for (std::size_t i = path.pieces().size(); i-- > 0;) {
      const Piece& piece = path.pieces()[i];
      const double after = piece.stops ? 0 : reach[i + 1];
      if (!piece.is_arc()) {
        const double v = line_speed(piece);
        reach[i] = std::min(v * v, after + 2 * line_acceleration(piece) * piece.length);
        continue;
      }
      Arc arc = cut(piece);
      arc.reach.back() = std::min(after / piece.radius, arc.cap.back());
      for (auto k = static_cast<std::size_t>(arc.steps); k-- > 0;) {
        set_rows(arc, k);
        rows.push_back({2 * arc.angle, 1, 0, arc.reach[k + 1]});
        arc.reach[k] = largest(rows, arc.cap[k]);
      }
      reach[i] = arc.reach.front() * piece.radius;
      arcs[i] = std::move(arc);
    }
  }

  /// Phases from the start on; `time` of each is filled in when the whole is known.
  std::vector<Phase> forward() {
    std::vector<Phase> phases;
    double x = 0;
    for (std::size_t i = 0; i < path.pieces().size(); ++i) {
      const Piece& piece = path.pieces()[i];
      const double after = piece.stops ? 0 : reach[i + 1];
      x = piece.is_arc() ? follow_arc(i, x, phases) : follow_line(i, x, after, phases);
    }
    return phases;
  }

  double follow_line(std::size_t i, double x, double after, std::vector<Phase>& phases) const {
    const Piece& line = path.pieces()[i];
    const double v = line_speed(line), a = line_acceleration(line);
    const double end = std::min({after, v * v, x + 2 * a * line.length});
    // Where speeding up meets slowing down, or the cruise between them.
    const double top = std::max({x, end, std::min(v * v, 0.5 * (x + end) + a * line.length)});
    const double up = (top - x) / (2 * a), down = (top - end) / (2 * a);
    const double first = std::sqrt(x), cruise = std::sqrt(top), last = std::sqrt(end);
    if (up > 0) phases.push_back({i, 0, 0, first, cruise, a});
    if (line.length - up - down > 0) phases.push_back({i, 0, up, cruise, cruise, 0});
    if (down > 0) phases.push_back({i, 0, line.length - down, cruise, last, -a});
    return end;
  }

  double follow_arc(std::size_t i, double x, std::vector<Phase>& phases) {
    const Piece& piece = path.pieces()[i];
    const Arc& arc = arcs[i];
    double c = std::min(x / piece.radius, arc.reach.front());
    for (std::size_t k = 0; k < static_cast<std::size_t>(arc.steps); ++k) {
      set_rows(arc, k);
      double u = std::min(range(rows, c).high, (arc.reach[k + 1] - c) / (2 * arc.angle));
      const double next = std::max(0.0, c + 2 * u * arc.angle);
      u = (next - c) / (2 * arc.angle);
      phases.push_back({i, 0, piece.radius * arc.angle * static_cast<double>(k),
                        std::sqrt(c * piece.radius), std::sqrt(next * piece.radius), u});
      bound(piece, arc, k, c, next, u);
      c = next;
    }
    return c * piece.radius;
  }

  /// A function whose second derivative is at most M is at most M d^2 / 8 above the larger of its
  /// values at the ends of a step d. With amplitude A of f'_j on the arc, M of the acceleration is
  /// A (5 |u| + c), and that of the squared speed r A^2 (2 c + 4 |u|), by the angle.
  void bound(const Piece& piece, const Arc& arc, std::size_t k, double c, double next, double u) {
    const double eighth = arc.angle * arc.angle / 8, most = std::max(c, next);
    for (int j = 0; j < speed.size(); ++j) {
      const double amplitude = std::hypot(piece.direction[j], piece.inward[j]);
      const auto pull = [&](std::size_t at, double at_c) {
        return std::abs(arc.tangent[at][j] * u + arc.inward[at][j] * at_c);
      };
      const double a =
          std::max(pull(k, c), pull(k + 1, next)) + eighth * amplitude * (5 * std::abs(u) + most);
      const double first = arc.tangent[k][j], last = arc.tangent[k + 1][j];
      const double v2 =
          piece.radius * (std::max(first * first * c, last * last * next) +
                          eighth * amplitude * amplitude * (2 * most + 4 * std::abs(u)));
      excess = std::max({excess, a / acceleration[j], v2 / (speed[j] * speed[j])});
    }
  }
};

BlendedTrajectory::BlendedTrajectory(const robot::KinematicChain& chain, BlendedPath path,
                                     const Eigen::Ref<const Eigen::VectorXd>& max_acceleration,
                                     double speed_factor, double angle_step)
    : path_(std::move(path)) {
  const auto require = [](bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(std::string("BlendedTrajectory: ") + what);
  };
  require(path_.front().size() == chain.size(), "the path has another number of joints");
  require(speed_factor > 0 && speed_factor <= 1, "speed_factor must be in (0, 1]");
  require(max_acceleration.size() == chain.size() && max_acceleration.allFinite() &&
              max_acceleration.minCoeff() > 0,
          "one positive acceleration for each joint is needed");
  require(angle_step > 0 && angle_step <= 0.5, "angle_step must be in (0, 0.5]");
  Timing timing{path_, Eigen::VectorXd(chain.size()), max_acceleration, angle_step};
  for (int j = 0; j < chain.size(); ++j) {
    timing.speed[j] = speed_factor * chain.joints()[static_cast<std::size_t>(j)].max_velocity;
    const bool moves = std::any_of(
        path_.pieces().begin(), path_.pieces().end(),
        [j](const Piece& piece) { return piece.direction[j] != 0 || piece.inward[j] != 0; });
    require(!moves || (std::isfinite(timing.speed[j]) && timing.speed[j] > 0),
            "a joint that moves has no velocity limit");
  }
  timing.backward();
  phases_ = timing.forward();
  // Slower by the same everywhere: accelerations and squared speeds shrink by `excess`.
  const double slower = std::sqrt(timing.excess);
  for (std::size_t i = 0; i < phases_.size(); ++i) {
    Phase& phase = phases_[i];
    const bool last_of_piece = i + 1 == phases_.size() || phases_[i + 1].piece != phase.piece;
    const double end = last_of_piece ? path_.pieces()[phase.piece].length : phases_[i + 1].along;
    phase.speed /= slower;
    phase.last_speed /= slower;
    phase.acceleration /= timing.excess;
    phase.start = duration_;
    duration_ += 2 * (end - phase.along) / (phase.speed + phase.last_speed);
  }
}

TrajectoryPoint BlendedTrajectory::at(double time) const {
  const Positions zero = Positions::Zero(path_.front().size());
  if (!(time > 0) || phases_.empty()) return {path_.front(), zero, zero};
  if (time >= duration_) return {path_.back(), zero, zero};
  const auto next = std::upper_bound(phases_.begin(), phases_.end(), time,
                                     [](double t, const Phase& phase) { return t < phase.start; });
  const Phase& phase = *(next - 1);
  const Piece& piece = path_.pieces()[phase.piece];
  const double t = time - phase.start;
  const double along =
      std::clamp(phase.along + t * (phase.speed + 0.5 * phase.acceleration * t), 0.0, piece.length);
  const double speed = std::max(0.0, phase.speed + phase.acceleration * t);
  const Positions tangent = piece.tangent(along);
  return {piece.position(along), speed * tangent,
          phase.acceleration * tangent + speed * speed * piece.curvature(along)};
}

BlendedTrajectory blend_trajectory(const RobotInWorld& robot,
                                   const std::vector<Positions>& waypoints,
                                   const Eigen::Ref<const Eigen::VectorXd>& max_acceleration,
                                   const TimingOptions& options) {
  BlendedTrajectory blended(robot.chain(),
                            BlendedPath(robot, waypoints, options.deviation, options.resolution),
                            max_acceleration, options.speed_factor);
  BlendedTrajectory stopping(robot.chain(), BlendedPath(waypoints, 0), max_acceleration,
                             options.speed_factor);
  return blended.duration() < stopping.duration() ? std::move(blended) : std::move(stopping);
}

}  // namespace prehend::motion
