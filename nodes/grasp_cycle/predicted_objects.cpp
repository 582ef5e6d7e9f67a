#include "nodes/grasp_cycle/predicted_objects.h"

#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "msgs/convert/geometry.h"
#include "msgs/convert/objects.h"
#include "prehend/geometry/errors.h"
#include "prehend/surface/model.h"

namespace prehend::nodes {
namespace {

constexpr auto kServiceTimeout = std::chrono::seconds(10);
constexpr double kLevel = 0.02;       // rad, of the table
constexpr double kTableNoise = 0.01;  // m, of its height at the target
constexpr double kMoved = 0.001;      // m

std::string body_name(std::uint32_t id) { return "object_" + std::to_string(id); }

// The body's pose at `since` [ns] or later, where the simulation has told it.
std::optional<geometry::RigidTransform> pose_of(const msgs::GroundTruth* truth,
                                                const std::string& name, std::int64_t since) {
  if (!truth || truth->header().stamp() < since) return std::nullopt;
  for (const auto& body : truth->bodies()) {
    if (body.name() == name) return convert::from_message(body.x_wb());
  }
  return std::nullopt;
}

// A robot stands on the plane z = 0 of its simulation.
void check_table(const msgs::ObjectModel& model) {
  const geometry::Plane table = convert::from_message(model.table());
  const Eigen::Vector3d foot = table.project(convert::from_message(model.centroid()));
  if (table.normal.z() > std::cos(kLevel) && std::abs(foot.z()) < kTableNoise) return;
  throw geometry::InputError(
      fmt::format("The table of object {} is not the plane z = 0 of the world, on which the "
                  "simulated robot stands: it is {:.3f} m high and tilted by {:.1f} degrees",
                  model.id(), foot.z(),
                  std::acos(std::min(1.0, table.normal.z())) * 180 / std::acos(-1.0)),
      "Let the source make the world from the table (world:=table)");
}

}  // namespace

msgs::ObjectModel moved_model(const msgs::ObjectModel& model,
                              const geometry::RigidTransform& X_moved) {
  const msgs::ObjectModel solid =
      convert::to_message(surface::moved(convert::from_message(model), X_moved));
  msgs::ObjectModel moved = model;
  moved.clear_convex_pieces();
  moved.clear_unit_density_inertia();
  moved.clear_alternatives();
  moved.clear_shape_weight();
  moved.MergeFrom(solid);
  if (model.has_known()) {
    *moved.mutable_known()->mutable_x_wo() =
        convert::to_message(X_moved * convert::from_message(model.known().x_wo()));
  }
  return moved;
}

PredictedObjects::PredictedObjects(graph::Node& node)
    : node_(node),
      wanted_(node.declare_parameter<bool>(
          {.name = "spawn_predicted",
           .default_value = false,
           .description = "put the predicted objects into the simulation before grasping",
           .read_only = true})),
      density_(node.declare_parameter<double>({.name = "density",
                                               .default_value = 800,
                                               .unit = "kg/m^3",
                                               .minimum = 1,
                                               .description = "of spawned objects",
                                               .read_only = true})) {}

void PredictedObjects::listen() {
  if (!wanted_) return;
  using graph::QoS;
  spawn_.emplace(node_.client<msgs::SpawnRequest, msgs::SpawnResponse>("/simulation/spawn"));
  models_ = node_.advertise<msgs::ObjectModel>("/models", QoS::latched(32));
  subscription_ = node_.subscribe<msgs::GroundTruth>(
      "/ground_truth", QoS::latest(), [this](const auto& truth) { truth_ = truth.shared(); });
}

void PredictedObjects::put(const View& view, std::uint32_t target, bool all_move,
                           std::function<void(const std::string&)> done) {
  if (view.models.count(target) == 0) {
    throw geometry::InputError("the model of object " + std::to_string(target) + " did not come",
                               "See what the node that makes models says");
  }
  check_table(*view.models.at(target));
  view_ = view;
  target_ = target;
  done_ = std::move(done);
  X_WB_start_.clear();
  movable_.clear();
  looked_.reset();
  waiting_.clear();
  for (const auto& [id, model] : view.models) {
    if (!model->valid()) continue;
    Waiting& waiting = waiting_.emplace_back();
    waiting.id = id;
    waiting.request.set_name(body_name(id));
    *waiting.request.mutable_mesh() = model->mesh();
    *waiting.request.mutable_convex_pieces() = model->convex_pieces();
    waiting.request.set_density(density_);
    const bool moves = all_move || id == target;
    waiting.request.set_is_static(!moves);
    if (moves) movable_.push_back(id);
  }
  put_next();
}

void PredictedObjects::put_next() {
  if (waiting_.empty()) return done_("");
  const Waiting next = std::move(waiting_.front());
  waiting_.pop_front();
  spawn_->call_async(
      next.request, kServiceTimeout,
      [this, id = next.id](const graph::Outcome<msgs::SpawnResponse>& outcome) {
        const std::string reason =
            !outcome.ok() ? outcome.error() : (outcome->success() ? "" : outcome->reason());
        if (!reason.empty() && id == target_) {
          waiting_.clear();
          return done_("the predicted object cannot be simulated: " + reason);
        }
        if (!reason.empty()) {
          node_.report(graph::Health::kWarning,
                       fmt::format("object {} is not in the simulation: {}", id, reason));
        }
        put_next();
      });
}

void PredictedObjects::watch() {
  if (!wanted_) return;
  for (const std::uint32_t id : movable_) {
    if (X_WB_start_.count(id) > 0) continue;
    if (const auto X_WB = pose_of(truth_.get(), body_name(id), 0)) X_WB_start_.emplace(id, *X_WB);
  }
}

std::string PredictedObjects::look(double since) {
  if (looked_ == since) return {};
  const auto body = [&](std::uint32_t id) {
    return pose_of(truth_.get(), body_name(id), graph::nanoseconds(since));
  };
  if (!body(target_)) return {};  // the cycle gives up when it does not come
  looked_ = since;
  if (X_WB_start_.count(target_) == 0) return "the simulation did not say where the object was";
  for (const auto& [id, model] : view_.models) {
    msgs::ObjectModel now = *model;
    const auto start = X_WB_start_.find(id);
    if (const auto X_WB = body(id); X_WB && start != X_WB_start_.end() && model->valid()) {
      const double way = (X_WB->translation() - start->second.translation()).norm();
      if (way > kMoved) {
        node_.log_info("object {} lies {:.0f} mm from where it was", id, 1e3 * way);
      }
      now = moved_model(*model, *X_WB * start->second.inverse());
    }
    now.mutable_header()->set_stamp(truth_->header().stamp());
    models_.publish(std::move(now));
  }
  return {};
}

}  // namespace prehend::nodes
