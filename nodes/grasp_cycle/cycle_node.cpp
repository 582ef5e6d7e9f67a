#include "nodes/grasp_cycle/cycle_node.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "msgs/convert/geometry.h"
#include "prehend/control/moved_grasps.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/node_program.h"

namespace prehend::nodes {
namespace {

using std::chrono::steady_clock;

constexpr double kPeriod = 0.01;                             // s, of the control loop
constexpr auto kExitDelay = std::chrono::milliseconds(500);  // for the last messages
constexpr double kAnyHeight = 10;                            // m
constexpr double kHandRadius = 0.06;                         // m, beside what is put down
constexpr auto kServiceTimeout = std::chrono::seconds(10);
constexpr auto kGripperPatience = std::chrono::seconds(20);  // for the robot to say what it has

bool declare_flag(graph::Node& node, const std::string& name, const std::string& description) {
  return node.declare_parameter<bool>(
      {.name = name, .default_value = false, .description = description, .read_only = true});
}

double declare_length(graph::Node& node, const std::string& name, double value, double minimum,
                      const std::string& description) {
  return node.declare_parameter<double>({.name = name,
                                         .default_value = value,
                                         .unit = "m",
                                         .minimum = minimum,
                                         .description = description,
                                         .read_only = true});
}

control::CycleOptions declare_cycle_options(graph::Node& node) {
  control::CycleOptions options;
  options.lift_height =
      declare_length(node, "lift_height", options.lift_height, 0.12, "of the object");
  options.transit_height = declare_length(node, "transit_height", options.transit_height, 0,
                                          "above which the hand crosses the scene");
  options.stale_time = node.declare_parameter<double>(
      {.name = "stale_time",
       .default_value = options.stale_time,
       .unit = "s",
       .minimum = 0.02,
       .maximum = 10,
       .description = "without a word of gripper, pads, wrist or carrier: all is stopped",
       .read_only = true});
  options.answer_time =
      node.declare_parameter<double>({.name = "answer_time",
                                      .default_value = options.answer_time,
                                      .unit = "s",
                                      .minimum = 0.1,
                                      .maximum = 60,
                                      .description = "without feedback of a motion: all is stopped",
                                      .read_only = true});
  options.largest_attempts =
      node.declare_parameter<int>({.name = "largest_attempts",
                                   .default_value = options.largest_attempts,
                                   .minimum = 1,
                                   .description = "grasps tried before giving up",
                                   .read_only = true});
  return options;
}

planning::PlaceOptions declare_place_options(graph::Node& node, double lift_height) {
  planning::PlaceOptions options;
  options.straight_height = lift_height;
  options.distance = declare_length(node, "move_distance", options.distance, 0.01,
                                    "sideways with the object, if there is room, else farther");
  options.farthest = std::max(options.farthest, options.distance);
  options.given_W = planning::read_place(node.declare_parameter<std::string>(
      {.name = "place",
       .description = "x,y of the world [m] where the object is put; empty: a free place is "
                      "chosen",
       .read_only = true}));
  return options;
}

double touched_area(const msgs::TactileFrame& frame, int counts) {
  const auto touched = std::count_if(
      frame.intensity().begin(), frame.intensity().end(),
      [counts](std::uint32_t value) { return value > static_cast<std::uint32_t>(counts); });
  return static_cast<double>(touched) * frame.texel_width() * frame.texel_height();
}

std::string spawned_name(std::uint32_t id) { return "object_" + std::to_string(id); }

// The body's pose at `since` or later, where the simulation has told it.
std::optional<geometry::RigidTransform> pose_of(const msgs::GroundTruth* truth,
                                                const std::string& name, std::int64_t since) {
  if (!truth || truth->header().stamp() < since) return std::nullopt;
  for (const auto& body : truth->bodies()) {
    if (body.name() == name) return convert::from_message(body.x_wb());
  }
  return std::nullopt;
}

geometry::Plane transformed(const geometry::Plane& plane_W, const geometry::RigidTransform& X_SW) {
  const Eigen::Vector3d normal = X_SW.linear() * plane_W.normal;
  return {normal, plane_W.offset + normal.dot(X_SW.translation())};
}

}  // namespace

CycleNode::CycleNode(graph::Node& node)
    : node_(node),
      object_(node.declare_parameter<int>({.name = "object",
                                           .default_value = -1,
                                           .minimum = -1,
                                           .description = "id of the object to grasp, -1: the one "
                                                          "with the best grasp",
                                           .read_only = true})),
      spawns_(declare_flag(node, "spawn_predicted",
                           "put the predicted objects into the simulation before grasping")),
      exits_(declare_flag(node, "exit_when_done", "end the process after the result")),
      ungraspable_is_ok_(
          declare_flag(node, "ungraspable_is_ok", "exit code 0 when nothing can be grasped")),
      density_(node.declare_parameter<double>({.name = "density",
                                               .default_value = 800,
                                               .unit = "kg/m^3",
                                               .minimum = 1,
                                               .description = "of spawned objects",
                                               .read_only = true})),
      touch_counts_(node.declare_parameter<int>({.name = "touch_counts",
                                                 .default_value = 10,
                                                 .minimum = 0,
                                                 .description = "above: a texel is touched",
                                                 .read_only = true})),
      gripper_(node),
      options_(declare_cycle_options(node)),
      place_(declare_place_options(node, options_.lift_height)),
      workspace_(declare_length(node, "workspace", 0.55, 0.01,
                                "half the side of the square the carrier reaches")),
      look_(node),
      views_(std::chrono::duration<double>(
          node.declare_parameter<double>({.name = "patience",
                                          .default_value = 20.0,
                                          .unit = "s",
                                          .minimum = 0.0,
                                          .description = "wall time to wait for the next plan of "
                                                         "a view",
                                          .read_only = true}))),
      gripper_port_(node),
      carrier_port_(node),
      spawn_(node.client<msgs::SpawnRequest, msgs::SpawnResponse>("/simulation/spawn")),
      surprises_(node.advertise<msgs::Surprise>("/surprise", graph::QoS::latched(32))),
      states_(node.advertise<msgs::CycleState>("/cycle/state", graph::QoS::latched(64))),
      results_(node.advertise<msgs::CycleResult>("/cycle/result", graph::QoS::latched(1))) {
  gripper_.listen();
  subscribe();
  timer_ = node.create_timer(kPeriod, [this] { tick(); });
}

void CycleNode::subscribe() {
  using graph::QoS;
  const auto keep = [this]<class Message>(const std::string& topic,
                                          std::shared_ptr<const Message>& place) {
    subscriptions_.push_back(node_.subscribe<Message>(
        topic, QoS::latest(), [&place](const auto& message) { place = message.shared(); }));
  };
  keep("/tactile/left", left_);
  keep("/tactile/right", right_);
  keep("/gripper/state", gripper_state_);
  if (spawns_) keep("/ground_truth", truth_);
  // What cannot be read here leaves the older one in place, which soon is too old to move by.
  subscriptions_.push_back(node_.subscribe<msgs::CarrierState>(
      "/carrier/state", QoS::latest(), [this](const auto& message) {
        carrier_ = {convert::from_message(message->x_wg()), message->header().stamp()};
      }));
  subscriptions_.push_back(node_.subscribe<
                           msgs::Wrench>("/wrench", QoS::latest(), [this](const auto& message) {
    wrist_ = {convert::from_message(message->wrench().force()).norm(), message->header().stamp()};
  }));
  subscriptions_.push_back(node_.subscribe<msgs::GraspPlan>(
      "/plans", QoS::latched(32),
      [this](const auto& plan) { views_.add(plan.shared(), steady_clock::now()); }));
  subscriptions_.push_back(node_.subscribe<msgs::ObjectModel>(
      "/models", QoS::latched(32), [this](const auto& model) { views_.add(model.shared()); }));
  start_service_ =
      node_.serve<msgs::Empty, msgs::Acknowledge>("/cycle/start", [this](const msgs::Empty&) {
        msgs::Acknowledge answer;
        answer.set_success(!running_ && !preparing_);
        if (!answer.success()) {
          answer.set_reason("a cycle is running");
        } else {
          armed_ = true;
          answer.set_reason("starts on the newest plans");
        }
        return answer;
      });
}

control::Percepts CycleNode::percepts() const {
  control::Percepts percepts;
  percepts.time = graph::seconds(node_.clock().now());
  const auto age = [&percepts](std::int64_t stamp) {
    return percepts.time - graph::seconds(stamp);
  };
  const auto pad = [&](const msgs::TactileFrame& frame) {
    return control::PadPercept{frame.sum(), touched_area(frame, touch_counts_),
                               age(frame.header().stamp())};
  };
  if (left_) percepts.left = pad(*left_);
  if (right_) percepts.right = pad(*right_);
  if (gripper_state_) {
    percepts.opening = gripper_state_->opening();
    percepts.gripper_blocked = gripper_state_->blocked();
    percepts.gripper_error = gripper_state_->error_code();
    percepts.gripper_age = age(gripper_state_->header().stamp());
  }
  if (wrist_) {
    percepts.wrist_force = wrist_->value;
    percepts.wrist_age = age(wrist_->stamp);
  }
  if (carrier_) {
    percepts.X_WG = carrier_->value;
    percepts.carrier_age = age(carrier_->stamp);
  }
  return percepts;
}

void CycleNode::tick() {
  if (exit_time_ && steady_clock::now() >= *exit_time_) return node_.shutdown();
  if (running_) {
    // A step that cannot be done is no reason to let things move on.
    const std::string failure = node_.shield("cycle", [this] {
      if (spawns_ && !spawned_.X_SB) {
        spawned_.X_SB = pose_of(truth_.get(), spawned_name(target_.id), 0);
      }
      cycle_->step(percepts());
      if (const auto since = cycle_->looks_since()) look_again(*since);
    });
    if (!failure.empty()) cycle_->abort("a step of the cycle failed: " + failure);
    publish_progress();
    if (cycle_->finished()) finish(cycle_->result(), false);
    return;
  }
  if (!armed_ || preparing_) return;
  const View* view = views_.newest_ready(steady_clock::now());
  if (!view) return;
  if (!gripper_.model() && gripper_.problem().empty() && waits_for_gripper()) return;
  armed_ = false;
  start(*view);
}

bool CycleNode::waits_for_gripper() {
  const auto now = steady_clock::now();
  if (!gripper_patience_) {
    gripper_patience_ = now + kGripperPatience;
    node_.report(graph::Health::kWarning, "waiting: " + gripper_.missing());
  }
  return now < *gripper_patience_;
}

void CycleNode::start(const View& view) {
  control::CycleResult failure;
  failure.reason = node_.shield("plan", [&] {
    gripper_patience_.reset();
    take_target(choose_target(view, object_));
    if (target_.grasps.empty()) {
      control::CycleResult nothing;
      nothing.reason = target_.problem;
      return finish(nothing, target_.ungraspable);
    }
    const msgs::GraspPlan& plan = *view.plans.at(target_.id);
    if (const std::string other = gripper_.differs_from(plan); !other.empty()) {
      throw std::runtime_error(other);
    }
    centroid_W_ = convert::from_message(plan.centroid());
    if (spawns_ && view.models.count(target_.id) == 0) {
      throw geometry::InputError(
          "the model of object " + std::to_string(target_.id) + " did not come",
          "See what the node that makes models says");
    }
    const auto X_SW =
        spawns_ ? simulation_pose(view, target_) : geometry::RigidTransform::Identity();
    for (auto& grasp : target_.grasps) grasp = transformed(grasp, X_SW);
    move_W_ = choose_move(view, target_, X_SW);
    if (spawns_) return spawn_predicted(view, X_SW);
    begin();
  });
  if (!failure.reason.empty()) finish(failure, false);
}

void CycleNode::take_target(Target target) {
  target_ = std::move(target);
  plan_index_.resize(target_.grasps.size());
  std::iota(plan_index_.begin(), plan_index_.end(), 0u);
}

std::uint32_t CycleNode::plan_index(int grasp_index) const {
  return plan_index_.empty() ? 0 : plan_index_.at(static_cast<std::size_t>(grasp_index));
}

void CycleNode::begin() {
  const std::optional<robot::GripperModel> gripper = gripper_.model();
  if (!gripper) throw std::runtime_error(gripper_.missing());
  control::CycleOptions options = options_;
  options.force.force_per_current = gripper->force_per_current;
  options.force.largest_current = gripper->nominal_current;
  options.move_W = move_W_;
  options.look_timeout = look_.timeout();
  // Predicted objects in a simulation are seen by nobody, but it says where they are.
  options.only_seen_again = spawns_;
  node_.log_info("grasping object {}: {} grasps, best score {:.2f}", target_.id,
                 target_.grasps.size(), target_.grasps.front().score);
  cycle_.emplace(*gripper, options, gripper_port_, carrier_port_);
  surprises_sent_ = 0;
  last_detail_.clear();
  cycle_->start(target_.grasps);
  running_ = true;
}

void CycleNode::follow_spawned(double since) {
  const auto X_SB = pose_of(truth_.get(), spawned_name(target_.id), graph::nanoseconds(since));
  if (!X_SB) return;  // the cycle gives up when it does not come
  if (!spawned_.X_SB) {
    return cycle_->take_plan({}, move_W_, "the simulation did not say where the object was");
  }
  const geometry::RigidTransform X_moved = *X_SB * spawned_.X_SB->inverse();
  target_.grasps.erase(target_.grasps.begin() + cycle_->grasp_index());
  std::vector<std::uint32_t> plan_index = plan_index_;
  plan_index.erase(plan_index.begin() + cycle_->grasp_index());
  control::MovedGraspLimits limits;
  limits.workspace_W = {Eigen::Vector3d(-workspace_, -workspace_, -kAnyHeight),
                        Eigen::Vector3d(workspace_, workspace_, kAnyHeight)};
  const control::MovedGrasps moved = control::moved_grasps(target_.grasps, X_moved, limits);
  if (!moved.grasps.empty()) {
    const double distance = (X_SB->translation() - spawned_.X_SB->translation()).norm();
    target_.grasps = moved.grasps;
    plan_index_.clear();
    for (const std::size_t i : moved.indices) plan_index_.push_back(plan_index[i]);
    spawned_.X_SB = X_SB;
    spawned_.X_moved = X_moved * spawned_.X_moved;
    move_W_ = choose_move(spawned_.view, target_, spawned_.X_SW, spawned_.X_moved);
    node_.log_info("object {} lies {:.0f} mm from where it was: {} grasps there", target_.id,
                   1e3 * distance, target_.grasps.size());
  }
  cycle_->take_plan(moved.grasps, move_W_, moved.problem);
}

void CycleNode::look_again(double since) {
  if (spawns_) return follow_spawned(since);
  look_.ask(since);
  if (!look_.problem().empty()) return cycle_->take_plan({}, move_W_, look_.problem());
  const View* view = views_.newest_ready(steady_clock::now(), graph::nanoseconds(since));
  if (!view) return;
  const std::string failure = node_.shield("plan", [&] {
    // Ids are of one view: the object asked for is what lies nearest to where it was.
    Target target =
        choose_target(*view, object_ < 0 ? -1 : nearest_object(view->plans, centroid_W_));
    if (!target.grasps.empty()) {
      if (const auto other = gripper_.differs_from(*view->plans.at(target.id)); !other.empty()) {
        throw std::runtime_error(other);
      }
      take_target(std::move(target));
      centroid_W_ = convert::from_message(view->plans.at(target_.id)->centroid());
      move_W_ = choose_move(*view, target_, geometry::RigidTransform::Identity());
      node_.log_info("seen again: grasping object {}, {} grasps", target_.id,
                     target_.grasps.size());
      return cycle_->take_plan(target_.grasps, move_W_);
    }
    cycle_->take_plan({}, move_W_, target.problem);
  });
  if (!failure.empty()) cycle_->take_plan({}, move_W_, failure);
}

void CycleNode::spawn_predicted(const View& view, const geometry::RigidTransform& X_SW) {
  to_spawn_.clear();
  spawned_ = {.view = view,
              .X_SW = X_SW,
              .X_SB = std::nullopt,
              .X_moved = geometry::RigidTransform::Identity()};
  for (const auto& [id, mesh_W] : meshes_of(view)) {
    Spawn& spawn = to_spawn_.emplace_back();
    spawn.id = id;
    msgs::SpawnRequest& request = spawn.request;
    request.set_name(spawned_name(id));
    *request.mutable_mesh() = convert::to_message(geometry::transformed(mesh_W, X_SW));
    for (const auto& piece : view.models.at(id)->convex_pieces()) {
      *request.add_convex_pieces() =
          convert::to_message(geometry::transformed(convert::from_message(piece), X_SW));
    }
    request.set_density(density_);
    // Neighbours predicted a little too large would push each other about.
    request.set_is_static(id != target_.id);
  }
  preparing_ = true;
  spawn_next();
}

void CycleNode::spawn_next() {
  if (to_spawn_.empty()) {
    preparing_ = false;
    control::CycleResult failure;
    publish_state("spawn", 0,
                  fmt::format("object {} is in the simulation as it was predicted", target_.id));
    failure.reason = node_.shield("plan", [this] { begin(); });
    if (!failure.reason.empty()) finish(failure, false);
    return;
  }
  const Spawn spawn = std::move(to_spawn_.front());
  to_spawn_.pop_front();
  spawn_.call_async(spawn.request, kServiceTimeout,
                    [this, id = spawn.id](const auto& outcome) { take_spawned(id, outcome); });
}

void CycleNode::take_spawned(std::uint32_t id, const graph::Outcome<msgs::SpawnResponse>& outcome) {
  const std::string reason =
      !outcome.ok() ? outcome.error() : (outcome->success() ? "" : outcome->reason());
  if (!reason.empty() && id == target_.id) {
    to_spawn_.clear();
    preparing_ = false;
    control::CycleResult failure;
    failure.reason = "the predicted object cannot be simulated: " + reason;
    return finish(failure, false);
  }
  if (!reason.empty()) {
    node_.report(graph::Health::kWarning,
                 "object " + std::to_string(id) + " is not in the simulation: " + reason);
  }
  spawn_next();
}

// In the frame S of the simulation, which is the world unless recorded objects are spawned.
Eigen::Vector3d CycleNode::choose_move(const View& view, const Target& target,
                                       const geometry::RigidTransform& X_SW,
                                       const geometry::RigidTransform& X_moved) const {
  const Eigen::Vector3d hand = target.grasps.front().X_WG.translation();
  geometry::Plane table_W;
  if (const auto model = view.models.find(target.id); model != view.models.end()) {
    table_W = convert::from_message(model->second->table());
  }
  std::vector<Eigen::Vector3d> object{hand};
  std::vector<std::vector<Eigen::Vector3d>> others;
  for (const auto& [id, mesh_W] : meshes_of(view)) {
    std::vector<Eigen::Vector3d> points =
        geometry::transformed(mesh_W, id == target.id ? X_moved * X_SW : X_SW).vertices;
    if (id == target.id) {
      object = std::move(points);
    } else {
      others.push_back(std::move(points));
    }
  }
  planning::PlaceOptions options = place_;
  for (const double x : {-kHandRadius, kHandRadius}) {
    for (const double y : {-kHandRadius, kHandRadius}) {
      options.hand_W.push_back(hand + Eigen::Vector3d(x, y, 0));
    }
  }
  if (options.given_W) {
    const Eigen::Vector2d& at = *options.given_W;
    const double z =
        (table_W.offset - table_W.normal.head<2>().dot(at)) / std::max(0.1, table_W.normal.z());
    options.given_W = (X_SW * Eigen::Vector3d(at.x(), at.y(), z)).head<2>();
  }
  options.unreachable = [&](const Eigen::Vector3d& move) -> std::string {
    if ((hand + move).head<2>().cwiseAbs().maxCoeff() <= workspace_) return {};
    return fmt::format("the carrier reaches {:.2f} m from the middle", workspace_);
  };
  const planning::FreePlaces places =
      planning::free_places(transformed(table_W, X_SW), object, others, options);
  if (!places.problem.empty()) throw geometry::InputError(places.problem, planning::kPlaceMend);
  const Eigen::Vector3d move = places.moves_W.front();
  if (move.isZero()) {
    node_.log_info("object {} is put back where it stands: there is no free place for it",
                   target.id);
  }
  return move;
}

msgs::Surprise CycleNode::to_message(const control::Surprise& surprise) const {
  msgs::Surprise message;
  message.mutable_header()->set_stamp(node_.clock().now());
  message.set_kind(static_cast<msgs::Surprise::Kind>(surprise.kind));
  message.set_predicted(surprise.predicted);
  message.set_felt(surprise.felt);
  message.set_tolerance(surprise.tolerance);
  message.set_surprising(surprise.surprising);
  message.set_reaction(surprise.reaction);
  return message;
}

void CycleNode::publish_progress() {
  for (; surprises_sent_ < cycle_->surprises().size(); ++surprises_sent_) {
    const auto message = to_message(cycle_->surprises()[surprises_sent_]);
    if (message.surprising()) {
      node_.log_warning("surprise: {} predicted {:.4g}, felt {:.4g}: {}",
                        msgs::Surprise::Kind_Name(message.kind()), message.predicted(),
                        message.felt(), message.reaction());
    }
    surprises_.publish(message);
  }
  if (cycle_->detail() == last_detail_) return;
  last_detail_ = cycle_->detail();
  publish_state(control::to_string(cycle_->phase()), cycle_->grasp_index(), last_detail_);
}

void CycleNode::publish_state(const std::string& phase, int grasp_index,
                              const std::string& detail) {
  msgs::CycleState state;
  state.mutable_header()->set_stamp(node_.clock().now());
  state.set_phase(phase);
  state.set_object_id(target_.id);
  state.set_grasp_index(plan_index(grasp_index));
  state.set_detail(detail);
  states_.publish(state);
  node_.log_info("{}: {}", state.phase(), state.detail());
}

void CycleNode::finish(const control::CycleResult& result, bool ungraspable) {
  msgs::CycleResult message;
  message.mutable_header()->set_stamp(node_.clock().now());
  message.set_success(result.success);
  message.set_reason(result.reason);
  message.set_object_id(target_.id);
  message.set_grasp_index(plan_index(result.grasp_index));
  message.set_attempts(static_cast<std::uint32_t>(result.attempts));
  if (running_) {
    for (const auto& surprise : cycle_->surprises())
      *message.add_surprises() = to_message(surprise);
    for (const auto& [phase, seconds] : cycle_->phase_times()) {
      auto& time = *message.add_times();
      time.set_stage(phase);
      time.set_seconds(seconds);
    }
  }
  results_.publish(message);
  running_ = preparing_ = false;
  if (result.success) {
    node_.log_info("success: {}", result.reason);
  } else if (ungraspable) {
    node_.log_info("{}", result.reason);
  } else {
    node_.report(graph::Health::kError, result.reason);
  }
  exit_code_ =
      result.success ? 0 : (ungraspable ? (ungraspable_is_ok_ ? 0 : graph::kAnswerIsNo) : 2);
  if (exits_) exit_time_ = steady_clock::now() + kExitDelay;
}

}  // namespace prehend::nodes
