#include "nodes/held_picture/held_picture.h"

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <stdexcept>
#include <thread>

#include "msgs/convert/geometry.h"
#include "msgs/convert/images.h"
#include "prehend/belief/hand_evidence.h"
#include "prehend/geometry/errors.h"
#include "prehend/robot/placed_links.h"

namespace prehend::nodes {
namespace {

Eigen::VectorXd vector_of(const google::protobuf::RepeatedField<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), values.size());
}

belief::HandSample sample_of(const msgs::HandPose& message, const robot::Platform& platform) {
  belief::HandSample sample{convert::from_message(message.x_wh()), vector_of(message.position())};
  if (sample.joints.size() != static_cast<Eigen::Index>(platform.hand.model.joints.size()) ||
      !sample.joints.allFinite() || !sample.X_WH.matrix().allFinite()) {
    throw geometry::InputError("the hand's joints are not those of " + platform.hand.name,
                               "Give this node the platform that the cycle has");
  }
  return sample;
}

}  // namespace

HeldPictures::HeldPictures(graph::Node& node, const robot::Platform& platform)
    : platform_(platform),
      camera_(
          node.action_client<msgs::LookGoal, msgs::LookFeedback, msgs::LookResult>("/camera/look")),
      render_(node.client<msgs::RenderRequest, msgs::Acknowledge>("/simulation/render")) {}

HeldPicture HeldPictures::take(const msgs::HeldLookGoal& goal, double patience,
                               const std::function<bool()>& cancelled) {
  const belief::HandSample gripped = sample_of(goal.gripped(), platform_),
                           held = sample_of(goal.held(), platform_);
  const msgs::LookResult seen = picture(goal.since(), patience, cancelled);
  const std::optional<geometry::RigidTransform> X_WC = convert::camera_pose(seen.camera());
  if (!X_WC) {
    throw geometry::InputError("the camera does not say where it stands in the world",
                               "Give it a pose, as camera_pose of launch/bringup.yaml");
  }
  HeldPicture taken;
  taken.camera = convert::from_message(seen.camera()).left;
  taken.X_WC = *X_WC;
  taken.depth = convert::unpack_depth(seen.depth(), taken.camera.width, taken.camera.height);
  taken.robot_W = robot::placed_links(platform_, vector_of(goal.arm_position()), held.joints);
  taken.X_WH = held.X_WH;
  taken.X_WO = held.X_WH * gripped.X_WH.inverse(Eigen::Isometry);
  return taken;
}

msgs::LookResult HeldPictures::picture(std::int64_t since, double patience,
                                       const std::function<bool()>& cancelled) {
  const auto time =
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(patience));
  const auto waits = std::make_shared<std::atomic<bool>>(false);
  msgs::LookGoal goal;
  goal.set_since(since);
  const auto handle =
      camera_.send(goal, [waits](const msgs::LookFeedback&) { *waits = true; }, {.timeout = time});
  bool asked = false;
  while (!handle.done()) {
    if (cancelled()) {
      handle.cancel();
      throw std::runtime_error("it was cancelled before a picture came");
    }
    if (*waits && !asked) {
      asked = true;
      // Cameras that send pictures all the time need not be asked, and do not answer.
      msgs::RenderRequest request;
      request.set_shows_robot(true);
      render_.call_async(request, time, [](const graph::Outcome<msgs::Acknowledge>&) {});
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const auto outcome = handle.wait(std::chrono::nanoseconds(0));
  if (!outcome.ok()) throw std::runtime_error("no picture came: " + outcome.error());
  if (!outcome->problem().empty()) throw std::runtime_error(outcome->problem());
  return *outcome;
}

}  // namespace prehend::nodes
