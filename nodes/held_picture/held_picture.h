#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "msgs/actions.pb.h"
#include "msgs/belief.pb.h"
#include "msgs/camera.pb.h"
#include "prehend/belief/attempt.h"
#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/image.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/graph/node.h"
#include "prehend/robot/platform.h"

namespace prehend::nodes {

/// A picture of what a hand holds, and where everything was then.
struct HeldPicture {
  geometry::PinholeCamera camera;
  geometry::RigidTransform X_WC = geometry::RigidTransform::Identity();  // optical frame
  geometry::DepthImage depth;
  std::vector<geometry::TriangleMesh> robot_W;                           // its links
  geometry::RigidTransform X_WH = geometry::RigidTransform::Identity();  // the hand's root
  /// Where the hand has brought what it holds: what was at p when it closed is at X_WO p.
  geometry::RigidTransform X_WO = geometry::RigidTransform::Identity();
};

/// Takes pictures of what a hand holds by the graph's camera (/camera/look), which is asked for
/// them where it is simulated (/simulation/render).
class HeldPictures {
 public:
  /// `platform` lives longer.
  HeldPictures(graph::Node& node, const robot::Platform& platform);

  /// Waits for the picture; not in a node's callback.
  /// @param patience wall time [s]. @param cancelled asked all the time.
  /// @throws std::runtime_error in words when none comes, or it has no depth;
  /// geometry::InputError for joints that are not the platform's, or a camera without a pose.
  HeldPicture take(const msgs::HeldLookGoal& goal, double patience,
                   const std::function<bool()>& cancelled);

 private:
  msgs::LookResult picture(std::int64_t since, double patience,
                           const std::function<bool()>& cancelled);

  const robot::Platform& platform_;
  graph::ActionClient<msgs::LookGoal, msgs::LookFeedback, msgs::LookResult> camera_;
  graph::ServiceClient<msgs::RenderRequest, msgs::Acknowledge> render_;
};

}  // namespace prehend::nodes
