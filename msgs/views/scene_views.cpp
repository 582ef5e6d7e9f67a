// The entities of a scene: what is kept of each object belongs to the newest look.

#include <algorithm>
#include <map>
#include <mutex>
#include <utility>

#include <fmt/format.h>

#include "msgs/convert/foxglove_geometry.h"
#include "msgs/convert/foxglove_objects.h"
#include "msgs/convert/foxglove_robot.h"
#include "msgs/grasp.pb.h"
#include "msgs/objects.pb.h"
#include "msgs/sensors.pb.h"
#include "msgs/views/view_makers.h"

namespace prehend::views {
namespace {

using ::foxglove::SceneUpdate;

constexpr int kMostGrasps = 8;                      // of each object
constexpr std::int64_t kTruthPeriod = 100'000'000;  // ns

std::string key_of(std::uint32_t object) { return std::to_string(object); }

// What was looked at in the hand is known better than by the look that it was grasped by, whichever
// of the two is heard first.
class ObjectsShown {
 public:
  explicit ObjectsShown(View::Publish publish) : publish_(std::move(publish)) {}

  void take_model(const ViewedMessage& raw) {
    const auto model = decoded<msgs::ObjectModel>(raw);
    const std::int64_t stamp = model.header().stamp();
    std::vector<std::uint32_t> gone;
    const std::lock_guard lock(mutex_);
    if (!look_.take(raw.publish_time, stamp, model.object_count(), gone)) return;
    if (look_.began_anew()) held_.clear();
    for (const std::uint32_t id : gone) {
      SceneUpdate deletion;
      convert::add_deletion(deletion, convert::object_frame(id), stamp);
      publish_(raw.publish_time, deletion.SerializeAsString(), key_of(id));
    }
    const auto held = held_.find(model.id());
    if (held == held_.end() || held->second != stamp) show(raw, model);
  }
  void take_held(const ViewedMessage& raw) {
    const auto model = decoded<msgs::ObjectModel>(raw);
    const std::int64_t stamp = model.header().stamp();
    const std::lock_guard lock(mutex_);
    if (stamp < look_.stamp()) return;
    held_[model.id()] = stamp;
    show(raw, model);
  }

 private:
  void show(const ViewedMessage& raw, const msgs::ObjectModel& model) {
    SceneUpdate update;
    *update.add_entities() = convert::object_entity(model);
    publish_(raw.publish_time, update.SerializeAsString(), key_of(model.id()));
  }

  const View::Publish publish_;
  std::mutex mutex_;  // of what follows
  Look look_;
  std::map<std::uint32_t, std::int64_t> held_;  // the stamp [ns] of its look, by the object
};

struct GraspsState {
  std::mutex mutex;
  Look look;
  std::map<std::uint32_t, int> shown;  // grasps of each object
};

struct TruthState {
  std::mutex mutex;
  Pace pace{kTruthPeriod};
};

}  // namespace

View robot_view(std::shared_ptr<const robot::Platform> platform) {
  View view{view_channel<SceneUpdate>("/viewer/robot", 1, false), {}, {}};
  view.begin = [platform](const View::Publish& publish) {
    publish(0, convert::robot_update(*platform, 0).SerializeAsString(), "");
    return std::vector<View::Source>();
  };
  return view;
}

View objects_view() {
  View view{view_channel<SceneUpdate>("/viewer/objects", 1, false), {"/models"}, {}};
  view.begin = [](View::Publish publish) {
    auto shown = std::make_shared<ObjectsShown>(std::move(publish));
    return std::vector<View::Source>{
        {"/models", [shown](const ViewedMessage& raw) { shown->take_model(raw); }},
        {"/held/model", [shown](const ViewedMessage& raw) { shown->take_held(raw); }}};
  };
  return view;
}

View grasps_view() {
  View view{view_channel<SceneUpdate>("/viewer/grasps", 1, false), {"/plans"}, {}};
  view.begin = [](View::Publish publish) {
    auto state = std::make_shared<GraspsState>();
    return std::vector<View::Source>{
        {"/plans", [state, publish](const ViewedMessage& raw) {
           const auto plan = decoded<msgs::GraspPlan>(raw);
           std::vector<std::uint32_t> gone;
           const std::lock_guard lock(state->mutex);
           if (!state->look.take(raw.publish_time, plan.header().stamp(), plan.object_count(),
                                 gone))
             return;
           for (const std::uint32_t id : gone) {
             msgs::GraspPlan nothing;
             *nothing.mutable_header() = plan.header();
             nothing.set_id(id);
             auto update = convert::grasps_update(nothing, kMostGrasps, state->shown[id]);
             update.clear_entities();
             convert::add_deletion(update, fmt::format("grasp/{}/none", id), plan.header().stamp());
             publish(raw.publish_time, update.SerializeAsString(), key_of(id));
             state->shown.erase(id);
           }
           int& shown = state->shown[plan.id()];
           const auto update = convert::grasps_update(plan, kMostGrasps, shown);
           shown = std::max(shown, std::min(kMostGrasps, plan.grasps_size()));
           publish(raw.publish_time, update.SerializeAsString(), key_of(plan.id()));
         }}};
  };
  return view;
}

View table_view() {
  View view{view_channel<SceneUpdate>("/viewer/table", 1, false), {"/objects"}, {}};
  view.begin = [](View::Publish publish) {
    return std::vector<View::Source>{
        {"/objects", [publish](const ViewedMessage& raw) {
           const auto update = convert::table_update(decoded<msgs::ObjectHypotheses>(raw));
           publish(raw.publish_time, update.SerializeAsString(), "table");
         }}};
  };
  return view;
}

// A channel of its own, as a slow viewer may miss some of it.
View truth_view() {
  View view{view_channel<SceneUpdate>("/viewer/truth", 1, true), {"/ground_truth"}, {}};
  view.begin = [](View::Publish publish) {
    auto state = std::make_shared<TruthState>();
    return std::vector<View::Source>{
        {"/ground_truth", [publish, state](const ViewedMessage& raw) {
           {
             const std::lock_guard lock(state->mutex);
             if (!state->pace.lets_through(raw.pace_time)) return;
           }
           const auto update = convert::truth_update(decoded<msgs::GroundTruth>(raw));
           publish(raw.publish_time, update.SerializeAsString(), "truth");
         }}};
  };
  return view;
}

}  // namespace prehend::views
