#include "nodes/grasp_cycle/gripper_robot.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "msgs/convert/geometry.h"
#include "msgs/convert/grasp.h"
#include "nodes/task_source/task_source.h"
#include "prehend/geometry/errors.h"

namespace prehend::nodes {
namespace {

constexpr double kHandRadius = 0.06;  // m, beside what is put down

double declare_length(graph::Node& node, const std::string& name, double value, double minimum,
                      const std::string& description) {
  return node.declare_parameter<double>({.name = name,
                                         .default_value = value,
                                         .unit = "m",
                                         .minimum = minimum,
                                         .description = description,
                                         .read_only = true});
}

}  // namespace

GripperRobotOptions declare_gripper_options(graph::Node& node) {
  GripperRobotOptions options;
  control::CycleOptions& cycle = options.cycle;
  cycle.lift_height = declare_length(node, "lift_height", cycle.lift_height, 0.12, "of the object");
  cycle.transit_height = declare_length(node, "transit_height", cycle.transit_height, 0,
                                        "above which the hand crosses the scene");
  planning::PlaceOptions& place = options.place;
  place.straight_height = cycle.lift_height;
  place.distance = declare_length(node, "move_distance", place.distance, 0.01,
                                  "sideways with the object, if there is room, else farther");
  place.farthest = std::max(place.farthest, place.distance);
  place.given_W = planning::read_place(node.declare_parameter<std::string>(
      {.name = "place",
       .description = "x,y of the world [m] where the object is put; empty: a free place is "
                      "chosen",
       .read_only = true}));
  options.workspace = declare_length(node, "workspace", options.workspace, 0.01,
                                     "half the side of the square the carrier reaches");
  return options;
}

GripperRobot::GripperRobot(graph::Node& node, const GripperSource& gripper,
                           const GripperRobotOptions& options)
    : node_(node), gripper_(gripper), options_(options), gripper_port_(node), carrier_port_(node) {
  using graph::QoS;
  const auto keep = [this]<class Message>(const std::string& topic,
                                          std::shared_ptr<const Message>& place) {
    subscriptions_.push_back(node_.subscribe<Message>(
        topic, QoS::latest(), [&place](const auto& message) { place = message.shared(); }));
  };
  keep("/tactile/left", left_);
  keep("/tactile/right", right_);
  keep("/gripper/state", gripper_state_);
  // What cannot be read here leaves the older one in place, which soon is too old to move by.
  subscriptions_.push_back(node_.subscribe<msgs::CarrierState>(
      "/carrier/state", QoS::latest(), [this](const auto& message) {
        carrier_ = {convert::from_message(message->x_wg()), message->header().stamp()};
      }));
  subscriptions_.push_back(node_.subscribe<
                           msgs::Wrench>("/wrench", QoS::latest(), [this](const auto& message) {
    wrist_ = {convert::from_message(message->wrench().force()).norm(), message->header().stamp()};
  }));
}

std::string GripperRobot::waits_for() const {
  return gripper_.model() || !gripper_.problem().empty() ? "" : gripper_.missing();
}

std::string GripperRobot::prepare(const View& view, const Target& target) {
  if (const std::string other = gripper_.differs_from(*view.plans.at(target.id)); !other.empty()) {
    throw std::runtime_error(other);
  }
  std::vector<grasp::Grasp> grasps;
  for (const msgs::Grasp* grasp : target.grasps) grasps.push_back(convert::from_message(*grasp));
  move_W_ = choose_move(view, target, grasps.front().X_WG.translation());
  prepared_ = std::move(grasps);
  return move_W_.isZero() ? "put back where it stands: there is no free place for it"
                          : fmt::format("put {:.2f} m away", move_W_.norm());
}

void GripperRobot::start() {
  const std::optional<robot::GripperModel> gripper = gripper_.model();
  if (!gripper) throw std::runtime_error(gripper_.missing());
  control::CycleOptions options = options_.cycle;
  options.force.force_per_current = gripper->force_per_current;
  options.force.largest_current = gripper->nominal_current;
  options.move_W = move_W_;
  cycle_.emplace(*gripper, options, gripper_port_, carrier_port_);
  cycle_->start(prepared_);
}

Eigen::Vector3d GripperRobot::choose_move(const View& view, const Target& target,
                                          const Eigen::Vector3d& hand_W) const {
  geometry::Plane table_W;
  if (const auto model = view.models.find(target.id); model != view.models.end()) {
    table_W = convert::from_message(model->second->table());
  }
  std::vector<Eigen::Vector3d> object{hand_W};
  std::vector<std::vector<Eigen::Vector3d>> others;
  for (auto& [id, mesh_W] : meshes_of(view)) {
    if (id == target.id) {
      object = mesh_W.vertices;
    } else {
      others.push_back(mesh_W.vertices);
    }
  }
  planning::PlaceOptions options = places_of(options_.cycle.task, object, options_.place);
  for (const double x : {-kHandRadius, kHandRadius}) {
    for (const double y : {-kHandRadius, kHandRadius}) {
      options.hand_W.push_back(hand_W + Eigen::Vector3d(x, y, 0));
    }
  }
  options.unreachable = [&](const Eigen::Vector3d& move) -> std::string {
    if ((hand_W + move).head<2>().cwiseAbs().maxCoeff() <= options_.workspace) return {};
    return fmt::format("the carrier reaches {:.2f} m from the middle", options_.workspace);
  };
  const planning::FreePlaces places = planning::free_places(table_W, object, others, options);
  if (!places.problem.empty()) throw geometry::InputError(places.problem, planning::kPlaceMend);
  return places.moves_W.front();
}

control::Percepts GripperRobot::percepts() const {
  control::Percepts percepts;
  percepts.time = graph::seconds(node_.clock().now());
  const auto age = [&percepts](std::int64_t stamp) {
    return percepts.time - graph::seconds(stamp);
  };
  const auto pad = [&](const msgs::TactileFrame& frame) {
    return control::PadPercept{frame.sum(),
                               robot::touched_area(frame.intensity(), options_.touch_counts,
                                                   frame.texel_width() * frame.texel_height()),
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

}  // namespace prehend::nodes
