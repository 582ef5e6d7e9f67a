#include "prehend/simulation/arm_drive.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/contact/require.h"
#include "prehend/text/nearest_match.h"
#include "prehend/text/told_apart.h"

namespace prehend::simulation {
namespace {

using robot::ChainJoint;
using robot::Positions;

constexpr double kLimitSlack = 1e-6;    // rad or m
constexpr double kSpeedSlack = 1.0001;  // of the velocity limit
constexpr double kSettled = 1e-4;       // rad or m, from the goal
constexpr double kTracked = 1e-6;  // rad or m, from a set point, and in a hundredth of a second

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument(what); }

// Where each of the chain's joints is in the request.
std::vector<std::size_t> order_of(const robot::KinematicChain& chain,
                                  const std::vector<std::string>& names) {
  std::vector<std::string> known;
  for (const ChainJoint& joint : chain.joints()) known.push_back(joint.name);
  std::vector<std::size_t> order(known.size(), names.size());
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto found = std::find(known.begin(), known.end(), names[k]);
    if (found == known.end()) {
      refuse(fmt::format("the arm has no joint '{}'{}", names[k],
                         text::nearest_match_hint(names[k], known)));
    }
    std::size_t& place = order[static_cast<std::size_t>(found - known.begin())];
    if (place != names.size()) refuse(fmt::format("joint '{}' is named twice", names[k]));
    place = k;
  }
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (order[i] == names.size()) refuse(fmt::format("joint '{}' is missing", known[i]));
  }
  return order;
}

Positions ordered(const std::vector<double>& values, const std::vector<std::size_t>& order,
                  const char* what, std::size_t point) {
  if (values.size() != order.size()) {
    refuse(fmt::format("point {} has {} {} values for {} joints", point, values.size(), what,
                       order.size()));
  }
  Positions result(static_cast<Eigen::Index>(order.size()));
  for (std::size_t i = 0; i < order.size(); ++i) {
    result[static_cast<Eigen::Index>(i)] = values[order[i]];
  }
  if (!result.allFinite()) {
    refuse(fmt::format("point {} has a {} that is no finite number", point, what));
  }
  return result;
}

void check_position(const ChainJoint& joint, double p, const std::string& where) {
  if (p >= joint.lower - kLimitSlack && p <= joint.upper + kLimitSlack) return;
  refuse(fmt::format("{}: joint '{}' at {:.4f} is outside {:.4f} to {:.4f}", where, joint.name, p,
                     joint.lower, joint.upper));
}

// Quintic Hermite polynomial of one joint over T, at s in [0, 1]; with accelerations chosen by the
// caller it is the cubic too.
struct Hermite {
  double p0, v0, a0, p1, v1, a1;
};

void quintic(const Hermite& e, double T, double s, double& p, double& v, double& a) {
  const double d = e.p1 - e.p0;
  const double v0 = e.v0 * T, v1 = e.v1 * T, a0 = e.a0 * T * T, a1 = e.a1 * T * T;
  const double c3 = 10 * d - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1;
  const double c4 = -15 * d + 8 * v0 + 7 * v1 + 1.5 * a0 - a1;
  const double c5 = 6 * d - 3 * v0 - 3 * v1 - 0.5 * a0 + 0.5 * a1;
  p = e.p0 + s * (v0 + s * (0.5 * a0 + s * (c3 + s * (c4 + s * c5))));
  v = (v0 + s * (a0 + s * (3 * c3 + s * (4 * c4 + s * 5 * c5)))) / T;
  a = (a0 + s * (6 * c3 + s * (12 * c4 + s * 20 * c5))) / (T * T);
}

void cubic(const Hermite& e, double T, double s, double& p, double& v, double& a) {
  const double d = e.p1 - e.p0, v0 = e.v0 * T, v1 = e.v1 * T;
  const double c2 = 3 * d - 2 * v0 - v1, c3 = -2 * d + v0 + v1;
  p = e.p0 + s * (v0 + s * (c2 + s * c3));
  v = (v0 + s * (2 * c2 + s * 3 * c3)) / T;
  a = (2 * c2 + s * 6 * c3) / (T * T);
}

}  // namespace

ArmTrajectory::Point ArmTrajectory::at(double time) const {
  const auto rest = [](const Point& end) {
    Point point = end;
    point.velocity.setZero(end.position.size());
    point.acceleration.setZero(end.position.size());
    return point;
  };
  if (time <= points.front().time) return rest(points.front());
  if (time >= points.back().time) return rest(points.back());
  const auto next = std::upper_bound(points.begin(), points.end(), time,
                                     [](double t, const Point& point) { return t < point.time; });
  const Point &from = *(next - 1), &to = *next;
  const double T = to.time - from.time, s = (time - from.time) / T;
  Point point;
  point.time = time;
  const Eigen::Index size = from.position.size();
  point.position.resize(size);
  point.velocity.resize(size);
  point.acceleration.resize(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    double &p = point.position[i], &v = point.velocity[i], &a = point.acceleration[i];
    Hermite ends{from.position[i], 0, 0, to.position[i], 0, 0};
    if (has_velocity) ends.v0 = from.velocity[i], ends.v1 = to.velocity[i];
    if (has_acceleration) ends.a0 = from.acceleration[i], ends.a1 = to.acceleration[i];
    if (has_velocity && has_acceleration) {
      quintic(ends, T, s, p, v, a);
    } else if (has_velocity) {
      cubic(ends, T, s, p, v, a);
    } else {
      p = ends.p0 + s * (ends.p1 - ends.p0);
      v = (ends.p1 - ends.p0) / T;
      a = 0;
    }
  }
  return point;
}

ArmTrajectory check_trajectory(const robot::KinematicChain& chain, const TrajectoryRequest& request,
                               const Eigen::Ref<const Eigen::VectorXd>& q,
                               const ArmDriveOptions& options) {
  const std::vector<std::size_t> order = order_of(chain, request.joints);
  if (request.points.empty()) refuse("the trajectory has no points");
  ArmTrajectory trajectory;
  trajectory.has_velocity = !request.points.front().velocity.empty();
  trajectory.has_acceleration =
      trajectory.has_velocity && !request.points.front().acceleration.empty();
  for (std::size_t k = 0; k < request.points.size(); ++k) {
    const TrajectoryRequest::Point& asked = request.points[k];
    ArmTrajectory::Point point;
    point.time = asked.time;
    if (!std::isfinite(asked.time)) refuse(fmt::format("the time of point {} is not finite", k));
    if (asked.time < 0) refuse(fmt::format("the time of point {} is negative", k));
    if (k > 0 && !(asked.time > trajectory.points.back().time)) {
      refuse(fmt::format("times do not increase: {} s at point {} after {} s", asked.time, k,
                         trajectory.points.back().time));
    }
    point.position = ordered(asked.position, order, "position", k);
    if (trajectory.has_velocity) point.velocity = ordered(asked.velocity, order, "velocity", k);
    if (trajectory.has_acceleration) {
      point.acceleration = ordered(asked.acceleration, order, "acceleration", k);
    }
    for (int i = 0; i < chain.size(); ++i) {
      const ChainJoint& joint = chain.joints()[static_cast<std::size_t>(i)];
      const double p = point.position[i];
      check_position(joint, p, fmt::format("point {}", k));
      double speed = trajectory.has_velocity ? std::abs(point.velocity[i]) : 0.0;
      if (!trajectory.has_velocity && k > 0) {
        const ArmTrajectory::Point& before = trajectory.points.back();
        speed = std::abs(p - before.position[i]) / (point.time - before.time);
      }
      if (speed > kSpeedSlack * joint.max_velocity) {
        const auto [given, most] = text::told_apart(speed, joint.max_velocity, 3);
        refuse(fmt::format("point {}: joint '{}' at {} /s is faster than {} /s", k, joint.name,
                           given, most));
      }
    }
    trajectory.points.push_back(std::move(point));
  }
  for (int i = 0; i < chain.size(); ++i) {
    const double off = std::abs(trajectory.points.front().position[i] - q[i]);
    if (off > options.start_tolerance) {
      refuse(
          fmt::format("the trajectory starts {:.3f} from where joint '{}' stands ({:.4f}); plan "
                      "from the arm's present positions",
                      off, chain.joints()[static_cast<std::size_t>(i)].name, q[i]));
    }
  }
  return trajectory;
}

robot::Positions check_set_point(const robot::KinematicChain& chain,
                                 const std::vector<std::string>& names,
                                 const std::vector<double>& values) {
  const std::vector<std::size_t> order = order_of(chain, names);
  const Positions goal = ordered(values, order, "position", 0);
  for (int i = 0; i < chain.size(); ++i) {
    check_position(chain.joints()[static_cast<std::size_t>(i)], goal[i], "the set point");
  }
  return goal;
}

ArmDrive::ArmDrive(robot::KinematicChain chain, const Eigen::Ref<const Eigen::VectorXd>& start,
                   const ArmDriveOptions& options)
    : chain_(std::move(chain)), options_(options), q_(start) {
  contact::require_positive(options.acceleration, "ArmDriveOptions::acceleration");
  if (options_.accelerations.empty()) {
    options_.accelerations.assign(static_cast<std::size_t>(chain_.size()), options.acceleration);
  }
  contact::require(options_.accelerations.size() == static_cast<std::size_t>(chain_.size()),
                   "ArmDriveOptions::accelerations", "empty or one number a joint");
  for (const double most : options_.accelerations) {
    contact::require_positive(most, "ArmDriveOptions::accelerations");
  }
  contact::require_positive(options.bandwidth, "ArmDriveOptions::bandwidth");
  contact::require_positive(options.tracking_bandwidth, "ArmDriveOptions::tracking_bandwidth");
  contact::require(start.size() == chain_.size() && start.allFinite(), "the arm's start",
                   "one finite position a joint");
  v_.setZero(q_.size());
  desired_ = q_;
}

void ArmDrive::follow(const ArmTrajectory& trajectory, const std::vector<double>& tolerance) {
  contact::require(tolerance.empty() || tolerance.size() == static_cast<std::size_t>(q_.size()),
                   "path_tolerance", "empty or one number a joint");
  for (const double t : tolerance) contact::require_positive(t, "path_tolerance");
  trajectory_ = trajectory;
  tolerance_ = tolerance;
  if (tolerance_.empty()) {
    tolerance_.assign(static_cast<std::size_t>(q_.size()), options_.path_tolerance);
  }
  status_ = Status::kMoving;
  time_ = 0;
  largest_error_ = 0;
  reason_.clear();
}

void ArmDrive::track(const robot::Positions& goal) {
  if (status_ != Status::kTracking) forget();
  status_ = Status::kTracking;
  desired_ = goal;
}

void ArmDrive::stop() {
  if (status_ == Status::kMoving || status_ == Status::kTracking) status_ = Status::kStopped;
}

void ArmDrive::forget() {
  status_ = Status::kIdle;
  largest_error_ = 0;
  time_ = 0;
  reason_.clear();
}

void ArmDrive::step(double h) {
  if (is_idle()) return;
  const bool tracks = status_ == Status::kTracking;
  const bool follows = status_ == Status::kMoving || tracks;
  ArmTrajectory::Point goal;
  if (tracks) {
    goal.position = desired_;
    goal.velocity.setZero(q_.size());
    goal.acceleration.setZero(q_.size());
  } else if (follows) {
    time_ += h;
    goal = trajectory_.at(time_);
    desired_ = goal.position;
  }
  const double w = tracks ? options_.tracking_bandwidth : options_.bandwidth;
  for (Eigen::Index i = 0; i < q_.size(); ++i) {
    const ChainJoint& joint = chain_.joints()[static_cast<std::size_t>(i)];
    const double most = options_.accelerations[static_cast<std::size_t>(i)];
    double velocity = 0;
    if (follows) {
      // The loop, as far as it is not stiffer than the step can follow.
      const double k = std::min(w, 0.5 / h);
      const double error = goal.position[i] - q_[i];
      velocity =
          v_[i] + h * (goal.acceleration[i] + 2 * k * (goal.velocity[i] - v_[i]) + k * k * error);
    }
    velocity = std::clamp(velocity, v_[i] - h * most, v_[i] + h * most);
    if (std::isfinite(joint.max_velocity)) {
      velocity = std::clamp(velocity, -joint.max_velocity, joint.max_velocity);
    }
    const double next = std::clamp(q_[i] + h * velocity, joint.lower, joint.upper);
    v_[i] = (next - q_[i]) / h;
    if (std::abs(v_[i]) < 1e-12) v_[i] = 0;
    q_[i] = next;
    if (!follows || tracks) continue;
    const double off = std::abs(q_[i] - goal.position[i]);
    largest_error_ = std::max(largest_error_, off);
    if (off > tolerance_[static_cast<std::size_t>(i)] && status_ == Status::kMoving) {
      status_ = Status::kOffPath;
      reason_ =
          fmt::format("joint '{}' is {:.4f} off the path after {:.2f} s", joint.name, off, time_);
    }
  }
  if (tracks) {
    const bool there = (q_ - desired_).cwiseAbs().maxCoeff() < kTracked &&
                       v_.cwiseAbs().maxCoeff() < 100 * kTracked;
    if (!there) return;
    q_ = desired_;
    v_.setZero();
    return;
  }
  if (status_ != Status::kMoving || time_ < trajectory_.duration()) return;
  const double away = (q_ - goal.position).cwiseAbs().maxCoeff();
  bool slow = true;
  for (Eigen::Index i = 0; i < v_.size(); ++i) {
    slow = slow && std::abs(v_[i]) < h * options_.accelerations[static_cast<std::size_t>(i)];
  }
  if (away < kSettled && slow) {
    status_ = Status::kReached;
    v_.setZero();
    q_ = goal.position;
  }
}

}  // namespace prehend::simulation
