#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "msgs/actions.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/image.h"
#include "prehend/graph/node.h"
#include "prehend/motion/trajectory.h"

namespace prehend::tools {

/// An arm and a camera of a running graph, simulated or real: /joint_states, /arm/follow,
/// /camera/info and the left images of /camera/stereo. SIGINT and SIGTERM stop the arm. Every
/// function waits for at most `patience` of wall time for a message and throws std::runtime_error
/// with one line that names what did not come.
class ArmAndCamera {
 public:
  /// @throws std::runtime_error when no registry answers at `registry`.
  ArmAndCamera(const std::string& registry, const robot::KinematicChain& chain,
               double patience = 10);

  /// The rectified left camera.
  geometry::PinholeCamera camera();

  struct Joints {
    std::int64_t stamp = 0;  // ns
    std::vector<std::string> names;
    std::vector<double> positions;  // rad or m
    robot::Positions q;             // of the chain's joints
  };
  /// The next message that has all of the chain's joints.
  Joints joints();

  /// Along the trajectory, to its end. @throws std::runtime_error in the server's words when it
  /// was not reached, or "interrupted".
  void follow(const motion::Trajectory& trajectory);

  /// An image that was taken while the arm stood: its joints were the same to 1e-4 rad or m for
  /// 0.3 s before it and still are after it.
  struct Still {
    geometry::ColorImage image;
    robot::Positions q;
  };
  Still still_image();

 private:
  using Follow = graph::ActionClient<msgs::FollowTrajectoryGoal, msgs::FollowTrajectoryFeedback,
                                     msgs::FollowTrajectoryResult>;

  void take(const msgs::JointState& state);
  /// Under the lock, until `ready`. @throws std::runtime_error "interrupted", or `what` that did
  /// not come.
  template <class Ready>
  void wait_for(std::unique_lock<std::mutex>& lock, const std::string& what, Ready ready);

  const robot::KinematicChain chain_;
  const double patience_;  // s
  std::mutex mutex_;
  std::condition_variable came_;
  std::deque<Joints> states_;  // the last seconds, oldest first
  std::string lacking_;        // a joint that /joint_states does not have
  std::optional<msgs::CameraInfo> info_;
  std::optional<msgs::StereoPair> pair_;  // the newest
  graph::Node node_;
  graph::Subscription joints_, infos_, pairs_;
  Follow follow_;
};

}  // namespace prehend::tools
