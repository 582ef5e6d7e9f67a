#include "nodes/belief/act_forecasts.h"

#include <algorithm>
#include <chrono>
#include <vector>

#include <fmt/format.h>

#include "msgs/convert/geometry.h"
#include "msgs/convert/gripper.h"
#include "msgs/convert/images.h"
#include "msgs/convert/objects.h"
#include "msgs/convert/percepts.h"
#include "prehend/geometry/errors.h"
#include "prehend/robot/kinematic_chain.h"
#include "prehend/robot/placed_links.h"
#include "prehend/text/tree_file.h"

namespace prehend::nodes {
namespace {

constexpr std::size_t kMostKept = 32;      // models, forecasts, percepts
constexpr std::size_t kMostMessages = 32;  // that wait for a late reader

planning::GraspToFeel to_feel(const msgs::Grasp& message) {
  const auto vector_of = [](const auto& values) {
    Eigen::VectorXd vector(values.size());
    std::copy(values.begin(), values.end(), vector.begin());
    return vector;
  };
  grasp::Grasp grasp;
  grasp.X_WG = convert::from_message(message.x_wg());
  grasp.preshape = message.preshape();
  grasp.open = vector_of(message.open_position());
  grasp.closed = vector_of(message.closed_position());
  grasp.force = message.grasp_force();
  grasp.effort = message.effort() > 0 ? message.effort() : 1;
  return planning::grasp_to_feel(grasp);
}

template <class Map>
void forget_oldest(Map* map) {
  while (map->size() > kMostKept) map->erase(map->begin());
}

}  // namespace

ActForecasts::ActForecasts(graph::Node& node, const robot::Platform& platform)
    : node_(node),
      platform_(platform),
      foretells_(node.declare_parameter<bool>(
          {.name = "foretell",
           .default_value = true,
           .description = "simulate the grasp that the cycle approaches with, to tell what its "
                          "sensors are to perceive and how surprising is what they do",
           .read_only = true})),
      model_(belief::SurpriseModel::load_for(
          node.declare_parameter<std::string>(
              {.name = "surprise_model",
               .default_value = text::tree_file("config/touch/percept_surprise"),
               .description = "file that says how percepts scatter, as eval_belief --surprise "
                              "--fit writes it, or folder of them, of which the hand's own is "
                              "taken (HAND.yaml)",
               .read_only = true}),
          platform.hand.name)),
      forecasts_(node.advertise<msgs::PerceptForecast>("/percepts/forecast",
                                                       graph::QoS::latched(kMostMessages))),
      surprises_(node.advertise<msgs::PerceptSurprise>("/percepts/surprise",
                                                       graph::QoS::latched(kMostMessages))) {
  if (!foretells_) return;
  if (model_.hand != platform_.hand.name) {
    node_.log_info(
        "no model of surprise was fitted to {}: its bits are told by that of {}, and are no "
        "alarms. Fit one: eval_belief --surprise --fit FILE --hand PLATFORM",
        platform_.hand.name, model_.hand.empty() ? "no hand" : model_.hand);
  }
  thread_ = std::thread([this] { run(); });
  camera_in_ =
      node.subscribe<msgs::CameraInfo>("/camera/info", graph::QoS::latched(),
                                       [this](const graph::Received<msgs::CameraInfo>& camera) {
                                         const std::lock_guard lock(mutex_);
                                         camera_ = camera.shared();
                                       });
  plans_in_ = node.subscribe<msgs::GraspPlan>("/plans", graph::QoS::latched(kMostMessages),
                                              [this](const graph::Received<msgs::GraspPlan>& plan) {
                                                const std::lock_guard lock(mutex_);
                                                plans_[plan->id()] = plan.shared();
                                              });
  states_in_ = node.subscribe<msgs::CycleState>(
      "/cycle/state", graph::QoS::queue(kMostMessages),
      [this](const graph::Received<msgs::CycleState>& state) { approaches(*state); });
  percepts_in_ = node.subscribe<msgs::ActPercepts>(
      "/cycle/percepts", graph::QoS::latched(kMostMessages),
      [this](const graph::Received<msgs::ActPercepts>& act) { perceived(act.shared()); });
}

ActForecasts::~ActForecasts() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void ActForecasts::seen(const msgs::ObjectModel& model) {
  if (!foretells_ || !model.valid()) return;
  const std::lock_guard lock(mutex_);
  models_[{model.header().stamp(), model.id()}] = std::make_shared<const msgs::ObjectModel>(model);
  forget_oldest(&models_);
}

std::shared_ptr<const msgs::ObjectModel> ActForecasts::model(std::int64_t stamp,
                                                             std::uint32_t id) const {
  const std::lock_guard lock(mutex_);
  const auto found = models_.find({stamp, id});
  return found == models_.end() ? nullptr : found->second;
}

void ActForecasts::approaches(const msgs::CycleState& state) {
  if (state.phase() != msgs::CycleState::APPROACH) return;
  const std::lock_guard lock(mutex_);
  const auto plan = plans_.find(state.object_id());
  if (plan == plans_.end() ||
      state.grasp_index() >= static_cast<std::uint32_t>(plan->second->grasps_size())) {
    return;
  }
  const std::int64_t view = plan->second->header().stamp();
  const Key key{view, state.object_id(), state.grasp_index()};
  const auto model = models_.find({view, state.object_id()});
  const bool begun =
      std::any_of(jobs_.begin(), jobs_.end(), [&key](const Job& job) { return job.key == key; });
  if (begun || known_.contains(key) || model == models_.end()) return;
  Job job{key, plan->second->grasps(static_cast<int>(state.grasp_index())), std::nullopt,
          model->second, camera_};
  if (plan->second->has_gripper()) job.gripper = plan->second->gripper();
  jobs_.push_back(std::move(job));
  wake_.notify_all();
}

void ActForecasts::perceived(std::shared_ptr<const msgs::ActPercepts> act) {
  if (act->hand() != platform_.hand.name) {
    return node_.report(
        graph::Health::kWarning,
        fmt::format("percepts of the hand {} are not judged, this node has {}: give it the "
                    "platform that the cycle has",
                    act->hand(), platform_.hand.name));
  }
  const Key key{act->header().stamp(), act->object_id(), act->grasp_index()};
  std::shared_ptr<const belief::PerceptForecast> forecast;
  {
    const std::lock_guard lock(mutex_);
    const auto known = known_.find(key);
    if (known == known_.end()) {
      waiting_[key] = std::move(act);
      return forget_oldest(&waiting_);
    }
    forecast = known->second;
  }
  judge(*act, *forecast);
}

void ActForecasts::run() {
  while (true) {
    Job job;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return ends_ || !jobs_.empty(); });
      if (ends_) return;
      job = jobs_.front();  // stays in the list while it is worked on
    }
    const std::string item = fmt::format("object {}, grasp {}: what it is to perceive",
                                         std::get<1>(job.key), std::get<2>(job.key));
    node_.shield(item, [&] { foretell(job); });
    const std::lock_guard lock(mutex_);
    jobs_.pop_front();
  }
}

// By where the plan's lift ends. None: nobody looks, or the plan has no lift.
std::optional<belief::ViewAfterLift> ActForecasts::view_of(const Job& job) const {
  if (!job.camera) return std::nullopt;
  const std::optional<geometry::RigidTransform> X_WC = convert::camera_pose(*job.camera);
  const auto lift = std::find_if(
      job.grasp.arm().begin(), job.grasp.arm().end(),
      [](const msgs::ArmSegment& one) { return one.kind() == msgs::ArmSegment::LIFT; });
  if (!X_WC || lift == job.grasp.arm().end() || lift->trajectory().points().empty()) {
    return std::nullopt;
  }
  const msgs::JointTrajectory& way = lift->trajectory();
  const msgs::JointTrajectoryPoint& end = way.points(way.points_size() - 1);
  const robot::KinematicChain chain = platform_.arm_chain();
  Eigen::VectorXd arm(chain.size());
  for (int i = 0; i < chain.size(); ++i) {
    const auto found = std::find(way.joint_name().begin(), way.joint_name().end(),
                                 chain.joints()[static_cast<std::size_t>(i)].name);
    const auto at = static_cast<int>(found - way.joint_name().begin());
    if (at >= end.position_size()) {
      throw geometry::InputError("the plan's lift does not say where all joints of the arm end",
                                 "Mend or update the node that plans");
    }
    arm[i] = end.position(at);
  }
  return belief::ViewAfterLift{convert::from_message(*job.camera).left, *X_WC,
                               platform_.X_WB * chain.forward(arm) * platform_.X_FH,
                               robot::placed_arm_links(platform_, arm)};
}

void ActForecasts::foretell(const Job& job) {
  const auto start = std::chrono::steady_clock::now();
  robot::Platform platform = platform_;
  if (job.gripper && platform.hand.gripper) {
    platform.set_gripper(convert::from_message(*job.gripper));
  }
  const double mass = job.grasp.predicted().lifted_mass();
  if (!(mass > 0)) {
    throw geometry::InputError("the plan does not say what it lifts",
                               "Mend or update the node that plans");
  }
  belief::PerceptOptions options;
  options.view = view_of(job);
  auto forecast = std::make_shared<const belief::PerceptForecast>(belief::predict_percepts(
      platform.hand, to_feel(job.grasp),
      belief::possible_shapes(convert::from_message(*job.model),
                              convert::from_message(job.model->table()), mass),
      options));
  const auto [view, object, grasp] = job.key;
  msgs::PerceptForecast message = convert::to_message(*forecast);
  message.mutable_header()->set_stamp(view);
  message.set_object_id(object);
  message.set_grasp_index(grasp);
  msgs::StageTime* time = message.add_times();
  time->set_stage("percepts");
  time->set_seconds(
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  forecasts_.publish(std::move(message));
  if (forecast->possible.empty()) {
    throw geometry::InputError(
        forecast->problems.empty() ? "nothing can be foretold" : forecast->problems.front(),
        "Nothing: the act goes on without it");
  }
  std::shared_ptr<const msgs::ActPercepts> act;
  {
    const std::lock_guard lock(mutex_);
    known_[job.key] = forecast;
    forget_oldest(&known_);
    const auto waits = waiting_.find(job.key);
    if (waits == waiting_.end()) return;
    act = waits->second;
    waiting_.erase(waits);
  }
  judge(*act, *forecast);
}

void ActForecasts::judge(const msgs::ActPercepts& act, const belief::PerceptForecast& forecast) {
  node_.shield(fmt::format("object {}, attempt {}: surprise", act.object_id(), act.attempt()), [&] {
    const belief::Percepts percepts = convert::from_message(act.percepts());
    belief::PerceptSurprise surprise = belief::percept_surprise(forecast, percepts, model_);
    if (model_.hand != platform_.hand.name) surprise.forget_thresholds();
    msgs::PerceptSurprise message = convert::to_message(surprise, forecast, percepts);
    *message.mutable_header() = act.header();
    message.set_object_id(act.object_id());
    message.set_grasp_index(act.grasp_index());
    message.set_attempt(act.attempt());
    surprises_.publish(std::move(message));
    const std::string text = fmt::format("object {}, attempt {}: {}", act.object_id(),
                                         act.attempt(), surprise.to_string());
    if (surprise.alarm) {
      node_.log_warning("{}", text);
    } else {
      node_.log_info("{}", text);
    }
  });
}

}  // namespace prehend::nodes
