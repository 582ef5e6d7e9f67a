#include "prehend/motion/trajectory.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace prehend::motion {

using robot::Positions;

Trajectory::Trajectory(const robot::KinematicChain& chain, std::vector<Positions> waypoints,
                       const Eigen::Ref<const Eigen::VectorXd>& max_acceleration,
                       double speed_factor)
    : waypoints_(std::move(waypoints)) {
  const auto require = [](bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(std::string("Trajectory: ") + what);
  };
  require(!waypoints_.empty(), "there are no waypoints");
  require(speed_factor > 0 && speed_factor <= 1, "speed_factor must be in (0, 1]");
  require(max_acceleration.size() == chain.size() && max_acceleration.allFinite() &&
              max_acceleration.minCoeff() > 0,
          "one positive acceleration for each joint is needed");
  for (const Positions& waypoint : waypoints_) {
    require(waypoint.size() == chain.size() && waypoint.allFinite(),
            "a waypoint has another size or is not finite");
  }
  starts_.push_back(0);
  for (std::size_t i = 1; i < waypoints_.size(); ++i) {
    const Positions way = (waypoints_[i] - waypoints_[i - 1]).cwiseAbs();
    Profile profile;
    profile.speed = profile.acceleration = std::numeric_limits<double>::infinity();
    for (int j = 0; j < chain.size(); ++j) {
      if (way[j] == 0) continue;
      const double limit = chain.joints()[static_cast<std::size_t>(j)].max_velocity;
      require(std::isfinite(limit), "a joint has no velocity limit");
      profile.speed = std::min(profile.speed, speed_factor * limit / way[j]);
      profile.acceleration = std::min(profile.acceleration, max_acceleration[j] / way[j]);
    }
    if (std::isfinite(profile.speed)) {
      // A line too short to reach the speed is half speeding up, half slowing down.
      profile.speed = std::min(profile.speed, std::sqrt(profile.acceleration));
      profile.ramp = profile.speed / profile.acceleration;
      profile.duration = 1 / profile.speed + profile.ramp;
    } else {
      profile = Profile{};
    }
    profiles_.push_back(profile);
    starts_.push_back(starts_.back() + profile.duration);
  }
}

TrajectoryPoint Trajectory::at(double time) const {
  const Positions zero = Positions::Zero(waypoints_.front().size());
  if (!(time > 0) || profiles_.empty()) return {waypoints_.front(), zero, zero};
  if (time >= duration()) return {waypoints_.back(), zero, zero};
  const auto next = std::upper_bound(starts_.begin(), starts_.end(), time);
  const std::size_t line = static_cast<std::size_t>(next - starts_.begin()) - 1;
  const Profile& profile = profiles_[line];
  const double t = time - starts_[line], left = profile.duration - t;
  double share = 0, speed = 0, acceleration = 0;
  if (t < profile.ramp) {
    share = 0.5 * profile.acceleration * t * t;
    speed = profile.acceleration * t;
    acceleration = profile.acceleration;
  } else if (left < profile.ramp) {
    share = 1 - 0.5 * profile.acceleration * left * left;
    speed = profile.acceleration * left;
    acceleration = -profile.acceleration;
  } else {
    share = profile.speed * (t - 0.5 * profile.ramp);
    speed = profile.speed;
  }
  const Positions way = waypoints_[line + 1] - waypoints_[line];
  return {waypoints_[line] + share * way, speed * way, acceleration * way};
}

}  // namespace prehend::motion
