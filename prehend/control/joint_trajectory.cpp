#include "prehend/control/joint_trajectory.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace prehend::control {
namespace {

constexpr double kSpeed = 0.5;         // rad/s that every joint can
constexpr double kAcceleration = 2.5;  // rad/s^2

// Greatest absolute value of joint k.
double peak(const JointTrajectory& path, std::vector<double> JointTrajectory::Point::*values,
            std::size_t k) {
  double most = 0;
  for (const JointTrajectory::Point& point : path.points) {
    if (k < (point.*values).size()) most = std::max(most, std::abs((point.*values)[k]));
  }
  return most;
}

// How many times as slow as `path` the other must be, which has the same joints, so that it asks no
// more of any joint, or no more than every joint can.
double slowness(const JointTrajectory& path, const JointTrajectory& other) {
  double times = 1;
  for (std::size_t k = 0; k < path.joints.size(); ++k) {
    const auto speed = &JointTrajectory::Point::velocity;
    const auto acceleration = &JointTrajectory::Point::acceleration;
    times = std::max(times, peak(other, speed, k) / std::max(kSpeed, peak(path, speed, k)));
    times = std::max(times, std::sqrt(peak(other, acceleration, k) /
                                      std::max(kAcceleration, peak(path, acceleration, k))));
  }
  return times;
}

JointTrajectory slowed(JointTrajectory path, double times) {
  for (JointTrajectory::Point& point : path.points) {
    point.time *= times;
    for (double& v : point.velocity) v /= times;
    for (double& a : point.acceleration) a /= times * times;
  }
  return path;
}

// Where the path's joints stand.
std::vector<double> positions_of(const JointTrajectory& path, const std::vector<std::string>& names,
                                 const std::vector<double>& positions) {
  std::vector<double> here;
  for (const std::string& joint : path.joints) {
    const auto found = std::find(names.begin(), names.end(), joint);
    if (found == names.end()) {
      throw std::invalid_argument("no joint '" + joint + "' tells where it stands");
    }
    here.push_back(positions.at(static_cast<std::size_t>(found - names.begin())));
  }
  return here;
}

// How far each joint stands from the path's start.
std::vector<double> offsets(const JointTrajectory& path, const std::vector<std::string>& names,
                            const std::vector<double>& positions, double most) {
  if (path.points.empty()) throw std::invalid_argument("the arm's segment has no points");
  for (const JointTrajectory::Point& point : path.points) {
    if (point.position.size() != path.joints.size()) {
      throw std::invalid_argument("the arm's segment has not one position a joint");
    }
  }
  std::vector<double> offsets = positions_of(path, names, positions);
  for (std::size_t k = 0; k < offsets.size(); ++k) {
    offsets[k] -= path.points.front().position[k];
    if (std::abs(offsets[k]) <= most) continue;  // not for NaN
    throw std::invalid_argument(fmt::format(
        "joint '{}' stands {:.2f} rad from where the plan begins", path.joints[k], offsets[k]));
  }
  return offsets;
}

// Rising from 0 to 1 over the points; all 1 of what does not rise.
std::vector<double> shares(std::vector<double> rising) {
  const double most = rising.empty() ? 0 : rising.back();
  for (double& value : rising) value = most > 0 ? value / most : 1;
  return rising;
}

std::vector<double> times_of(const JointTrajectory& path) {
  std::vector<double> times;
  for (const JointTrajectory::Point& point : path.points) times.push_back(point.time);
  return shares(std::move(times));
}

std::vector<double> ways_of(const JointTrajectory& path) {
  std::vector<double> ways;
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    double square = 0;
    for (std::size_t k = 0; i > 0 && k < path.joints.size(); ++k) {
      const double step = path.points[i].position.at(k) - path.points[i - 1].position.at(k);
      square += step * step;
    }
    ways.push_back((i > 0 ? ways.back() : 0) + std::sqrt(square));
  }
  return shares(std::move(ways));
}

// Of what rises with `x`, where that is `at`.
double interpolated(const std::vector<double>& x, const std::vector<double>& y, double at) {
  const auto after = std::lower_bound(x.begin(), x.end(), at);
  if (after == x.end()) return 1;
  const auto i = static_cast<std::size_t>(after - x.begin());
  if (i == 0) return y.front();
  return y[i - 1] + (y[i] - y[i - 1]) * (at - x[i - 1]) / (x[i] - x[i - 1]);
}

}  // namespace

JointTrajectory reversed(const JointTrajectory& path) {
  JointTrajectory back = path;
  std::reverse(back.points.begin(), back.points.end());
  const double duration = path.duration();
  for (JointTrajectory::Point& point : back.points) {
    point.time = duration - point.time;
    for (double& v : point.velocity) v = -v;
  }
  return back;
}

JointTrajectory part_of(const JointTrajectory& path, double share) {
  if (share >= 1 || path.points.size() < 2) return path;
  constexpr int kPoints = 40;
  constexpr double kPeak = 1.875;  // of ds/dt
  const double way = share * path.duration(), duration = kPeak * way;
  JointTrajectory part;
  part.joints = path.joints;
  std::size_t after = 1;
  for (int i = 0; i <= kPoints; ++i) {
    const double t = static_cast<double>(i) / kPoints;
    const double s = t * t * t * (10 + t * (6 * t - 15));
    const double rate = 30 * t * t * (1 - t) * (1 - t) / duration;  // ds/dt, 1/s
    while (after + 1 < path.points.size() && path.points[after].time < s * way) ++after;
    const JointTrajectory::Point &a = path.points[after - 1], &b = path.points[after];
    const double span = b.time - a.time;
    const double u = span > 0 ? std::clamp((s * way - a.time) / span, 0.0, 1.0) : 1.0;
    JointTrajectory::Point point;
    point.time = t * duration;
    for (std::size_t k = 0; k < a.position.size(); ++k) {
      point.position.push_back(a.position[k] + u * (b.position[k] - a.position[k]));
      const double speed = span > 0 ? (b.position[k] - a.position[k]) / span : 0.0;
      point.velocity.push_back(speed * way * rate);
    }
    part.points.push_back(std::move(point));
  }
  return part;
}

PlaceOnPath nearest_on(const JointTrajectory& path, const std::vector<std::string>& names,
                       const std::vector<double>& positions) {
  if (path.points.empty()) throw std::invalid_argument("the arm's segment has no points");
  const std::vector<double> here = positions_of(path, names, positions);
  PlaceOnPath nearest{0, std::numeric_limits<double>::infinity()};
  const auto take = [&](const JointTrajectory::Point& a, const JointTrajectory::Point& b) {
    double along = 0, length = 0;
    for (std::size_t k = 0; k < here.size(); ++k) {
      const double way = b.position.at(k) - a.position.at(k);
      along += way * (here[k] - a.position[k]);
      length += way * way;
    }
    const double u = length > 0 ? std::clamp(along / length, 0.0, 1.0) : 0.0;
    double off = 0;
    for (std::size_t k = 0; k < here.size(); ++k) {
      const double at = a.position[k] + u * (b.position[k] - a.position[k]);
      off = std::max(off, std::abs(at - here[k]));
    }
    if (off >= nearest.off) return;
    const double time = a.time + u * (b.time - a.time);
    nearest = {path.duration() > 0 ? time / path.duration() : 1.0, off};
  };
  take(path.points.front(), path.points.front());
  for (std::size_t i = 1; i < path.points.size(); ++i) take(path.points[i - 1], path.points[i]);
  return nearest;
}

double way_gone(const JointTrajectory& path, double share_of_time) {
  return interpolated(times_of(path), ways_of(path), share_of_time);
}

double time_of_way(const JointTrajectory& path, double share_of_way) {
  return interpolated(ways_of(path), times_of(path), share_of_way);
}

JointTrajectory joined(JointTrajectory path, const std::vector<std::string>& names,
                       const std::vector<double>& positions, double most) {
  const std::vector<double> off = offsets(path, names, positions, most);
  const JointTrajectory planned = path;
  const double duration = path.duration();
  for (std::size_t k = 0; k < off.size(); ++k) {
    if (off[k] == 0 || duration <= 0) continue;
    for (JointTrajectory::Point& point : path.points) {
      const double s = point.time / duration;
      point.position[k] += off[k] * (1 - s * s * s * (10 + s * (6 * s - 15)));
      if (k < point.velocity.size()) {
        point.velocity[k] -= off[k] * 30 * s * s * (1 - s) * (1 - s) / duration;
      }
      if (k < point.acceleration.size()) {
        point.acceleration[k] -= off[k] * 60 * s * (1 - s) * (1 - 2 * s) / (duration * duration);
      }
    }
  }
  return slowed(std::move(path), slowness(planned, path));
}

JointTrajectory beside(JointTrajectory path, const std::vector<double>& offsets) {
  for (JointTrajectory::Point& point : path.points) {
    for (std::size_t k = 0; k < offsets.size(); ++k) point.position.at(k) += offsets[k];
  }
  return path;
}

JointTrajectory displaced(JointTrajectory path, const std::vector<std::string>& names,
                          const std::vector<double>& positions, double most) {
  const std::vector<double> off = offsets(path, names, positions, most);
  return beside(std::move(path), off);
}

}  // namespace prehend::control
