#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <tuple>
#include <utility>

#include "msgs/grasp.pb.h"
#include "msgs/objects.pb.h"
#include "msgs/percepts.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/belief/percept_forecast.h"
#include "prehend/belief/percept_surprise.h"
#include "prehend/graph/node.h"
#include "prehend/robot/hand_model.h"
#include "prehend/robot/platform.h"

namespace prehend::nodes {

/// Foretells what the cycle's next act is to give, and says how surprising is what it gave. A
/// thread of its own simulates the grasp that the cycle approaches with (/cycle/state), on the
/// shapes that its object may have, and publishes that on /percepts/forecast; once the act is done
/// (/cycle/percepts), its bits are on /percepts/surprise. Neither delays plans or models.
class ActForecasts {
 public:
  /// Declares the parameters `foretell` and `surprise_model`.
  /// @throws geometry::InputError as belief::SurpriseModel::load_for().
  ActForecasts(graph::Node& node, const robot::Platform& platform);
  ~ActForecasts();
  ActForecasts(const ActForecasts&) = delete;

  /// A model as it is published for planning.
  void seen(const msgs::ObjectModel& model);
  /// Of the view with this stamp [ns]; null: not known, or nothing is foretold.
  std::shared_ptr<const msgs::ObjectModel> model(std::int64_t stamp, std::uint32_t id) const;

 private:
  using Key = std::tuple<std::int64_t, std::uint32_t, std::uint32_t>;  // view, object, grasp
  struct Job {
    Key key;
    msgs::Grasp grasp;
    std::optional<msgs::GripperDescription> gripper;
    std::shared_ptr<const msgs::ObjectModel> model;
    std::shared_ptr<const msgs::CameraInfo> camera;  // null: none has said where it stands
  };

  void approaches(const msgs::CycleState& state);
  void perceived(std::shared_ptr<const msgs::ActPercepts> act);
  void run();
  void foretell(const Job& job);
  std::optional<belief::ViewAfterLift> view_of(const Job& job) const;
  void judge(const msgs::ActPercepts& act, const belief::PerceptForecast& forecast);

  graph::Node& node_;
  robot::Platform platform_;
  bool foretells_;
  belief::SurpriseModel model_;
  graph::Publisher<msgs::PerceptForecast> forecasts_;
  graph::Publisher<msgs::PerceptSurprise> surprises_;

  mutable std::mutex mutex_;  // guards what follows, up to the thread
  std::condition_variable wake_;
  bool ends_ = false;
  std::map<std::pair<std::int64_t, std::uint32_t>, std::shared_ptr<const msgs::ObjectModel>>
      models_;
  std::map<std::uint32_t, std::shared_ptr<const msgs::GraspPlan>> plans_;  // by object
  std::shared_ptr<const msgs::CameraInfo> camera_;
  std::deque<Job> jobs_;
  std::map<Key, std::shared_ptr<const belief::PerceptForecast>> known_;
  std::map<Key, std::shared_ptr<const msgs::ActPercepts>> waiting_;  // for their forecast
  std::thread thread_;

  graph::Subscription camera_in_, plans_in_, states_in_, percepts_in_;
};

}  // namespace prehend::nodes
