#include "prehend/control/joint_path.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

namespace prehend::control {

JointPath reversed(const JointPath& path) {
  JointPath back = path;
  std::reverse(back.points.begin(), back.points.end());
  const double duration = path.duration();
  for (JointPath::Point& point : back.points) {
    point.time = duration - point.time;
    for (double& v : point.velocity) v = -v;
  }
  return back;
}

JointPath joined(JointPath path, const std::vector<std::string>& names,
                 const std::vector<double>& positions, double most) {
  if (path.points.empty()) throw std::invalid_argument("the arm's segment has no points");
  const double duration = path.duration();
  for (std::size_t k = 0; k < path.joints.size(); ++k) {
    const auto found = std::find(names.begin(), names.end(), path.joints[k]);
    if (found == names.end()) {
      throw std::invalid_argument("no joint '" + path.joints[k] + "' tells where it stands");
    }
    if (path.points.front().position.size() != path.joints.size()) {
      throw std::invalid_argument("the arm's segment has not one position a joint");
    }
    const double off = positions.at(static_cast<std::size_t>(found - names.begin())) -
                       path.points.front().position[k];
    if (!(std::abs(off) <= most)) {
      throw std::invalid_argument(fmt::format(
          "joint '{}' stands {:.2f} rad from where the plan begins", path.joints[k], off));
    }
    if (off == 0 || duration <= 0) continue;
    for (JointPath::Point& point : path.points) {
      if (point.position.size() != path.joints.size()) {
        throw std::invalid_argument("the arm's segment has not one position a joint");
      }
      const double s = point.time / duration;
      point.position[k] += off * (1 - s * s * s * (10 + s * (6 * s - 15)));
      if (k < point.velocity.size()) {
        point.velocity[k] -= off * 30 * s * s * (1 - s) * (1 - s) / duration;
      }
      if (k < point.acceleration.size()) {
        point.acceleration[k] -= off * 60 * s * (1 - s) * (1 - 2 * s) / (duration * duration);
      }
    }
  }
  return path;
}

}  // namespace prehend::control
