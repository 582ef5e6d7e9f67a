// Where everything is: the links of the robot, the camera, and the objects, which move with the
// hand while it carries them.

#include <map>
#include <mutex>
#include <optional>

#include "msgs/convert/foxglove_geometry.h"
#include "msgs/convert/foxglove_objects.h"
#include "msgs/convert/foxglove_robot.h"
#include "msgs/convert/geometry.h"
#include "msgs/grasp.pb.h"
#include "msgs/joints.pb.h"
#include "msgs/objects.pb.h"
#include "msgs/sensors.pb.h"
#include "msgs/views/view_makers.h"

namespace prehend::views {
namespace {

using geometry::RigidTransform;

constexpr std::int64_t kFramePeriod = 30'000'000;  // ns

class Frames {
 public:
  Frames(std::shared_ptr<const robot::Platform> platform, View::Publish publish)
      : platform_(std::move(platform)), publish_(std::move(publish)) {}

  void take_joints(const ViewedMessage& raw) {
    const auto state = decoded<msgs::JointState>(raw);
    const std::lock_guard lock(mutex_);
    const int count = std::min(state.name_size(), state.position_size());
    for (int i = 0; i < count; ++i) positions_[state.name(i)] = state.position(i);
    changed(raw, false);
  }

  // The joint of a gripper's jaws is half of what it is open.
  void take_gripper(const ViewedMessage& raw) {
    const auto state = decoded<msgs::GripperState>(raw);
    const std::lock_guard lock(mutex_);
    for (const std::string& joint : platform_->hand.actuated_names()) {
      positions_["hand_" + joint] = state.opening() / 2;
    }
  }

  void take_camera(const ViewedMessage& raw) {
    const auto info = decoded<msgs::CameraInfo>(raw);
    if (!info.has_x_wc() || info.header().frame_id().empty()) return;
    const RigidTransform X_WC = convert::from_message(info.x_wc());
    const std::lock_guard lock(mutex_);
    cameras_[info.header().frame_id()] = X_WC;
    changed(raw, true);
  }

  void take_model(const ViewedMessage& raw) {
    const auto model = decoded<msgs::ObjectModel>(raw);
    const std::lock_guard lock(mutex_);
    const std::int64_t before = look_.stamp();
    std::vector<std::uint32_t> gone;
    if (!look_.take(raw.publish_time, model.header().stamp(), model.object_count(), gone)) {
      return;
    }
    if (look_.stamp() != before) {  // what is seen anew lies where it is seen
      for (auto& [id, X_WO] : objects_) X_WO = RigidTransform::Identity();
      held_.reset();
    }
    objects_.try_emplace(model.id(), RigidTransform::Identity());
    changed(raw, true);
  }

  void take_cycle(const ViewedMessage& raw) {
    const auto state = decoded<msgs::CycleState>(raw);
    const std::lock_guard lock(mutex_);
    const bool carries =
        state.phase() == msgs::CycleState::LIFT || state.phase() == msgs::CycleState::MOVE;
    if (!carries || objects_.count(state.object_id()) == 0) {
      held_.reset();
    } else if (!held_ && platform_ && !positions_.empty()) {
      held_ = Held{state.object_id(), flange().inverse() * objects_.at(state.object_id())};
    }
  }

 private:
  struct Held {
    std::uint32_t object = 0;
    RigidTransform X_FO;  // in the flange's frame
  };

  RigidTransform flange() const {
    const auto index = static_cast<std::size_t>(platform_->model.link_index(platform_->flange));
    return convert::link_poses(*platform_, positions_)[index];
  }

  void changed(const ViewedMessage& raw, bool at_once) {
    if (!at_once && !pace_.lets_through(raw.pace_time)) return;
    const std::int64_t stamp = raw.publish_time;
    ::foxglove::FrameTransforms transforms;
    if (platform_ && !positions_.empty()) {
      const auto& model = platform_->model;
      const auto poses = convert::link_poses(*platform_, positions_);
      for (std::size_t i = 0; i < poses.size(); ++i) {
        convert::add_transform(transforms, stamp, convert::kWorldFrame, model.links[i].name,
                               poses[i]);
      }
      const auto& X_WF = poses[static_cast<std::size_t>(model.link_index(platform_->flange))];
      convert::add_transform(transforms, stamp, convert::kWorldFrame, "hand",
                             X_WF * platform_->X_FH);
      if (held_) objects_[held_->object] = X_WF * held_->X_FO;
    }
    for (const auto& [name, X_WC] : cameras_) {
      convert::add_transform(transforms, stamp, convert::kWorldFrame, name, X_WC);
    }
    for (const auto& [id, X_WO] : objects_) {
      convert::add_transform(transforms, stamp, convert::kWorldFrame, convert::object_frame(id),
                             X_WO);
    }
    publish_(stamp, transforms.SerializeAsString(), "");
  }

  const std::shared_ptr<const robot::Platform> platform_;  // may be null
  const View::Publish publish_;
  std::mutex mutex_;  // of what follows
  std::map<std::string, double> positions_;
  std::map<std::string, RigidTransform> cameras_;    // X_WC
  std::map<std::uint32_t, RigidTransform> objects_;  // of the object's frame in the world
  Look look_;
  std::optional<Held> held_;
  Pace pace_{kFramePeriod};
};

}  // namespace

View frames_view(std::shared_ptr<const robot::Platform> platform) {
  View view{view_channel<::foxglove::FrameTransforms>("/viewer/frames", 1, true), {}, {}};
  view.begin = [platform = std::move(platform)](View::Publish publish) {
    auto frames = std::make_shared<Frames>(platform, std::move(publish));
    const auto source = [&](const char* topic, void (Frames::*take)(const ViewedMessage&)) {
      return View::Source{topic,
                          [frames, take](const ViewedMessage& raw) { ((*frames).*take)(raw); }};
    };
    std::vector<View::Source> sources{source("/camera/info", &Frames::take_camera),
                                      source("/models", &Frames::take_model),
                                      source("/cycle/state", &Frames::take_cycle)};
    if (!platform) return sources;
    sources.push_back(source("/joint_states", &Frames::take_joints));
    if (platform->hand_port == robot::HandPort::kGripper) {
      sources.push_back(source("/gripper/state", &Frames::take_gripper));
    }
    return sources;
  };
  return view;
}

}  // namespace prehend::views
