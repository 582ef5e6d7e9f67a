#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "msgs/actions.pb.h"
#include "msgs/sensors.pb.h"
#include "nodes/grasp_cycle/view.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/graph/node.h"

namespace prehend::nodes {

/// The model when its body has moved by `X_moved` in the world: mesh, pieces, alternatives, mass
/// properties and a known object's pose. @throws geometry::InputError for a bad mesh.
msgs::ObjectModel moved_model(const msgs::ObjectModel& model,
                              const geometry::RigidTransform& X_moved);

/// What was predicted of a recorded scene, put into a simulation to be grasped there, and looked at
/// again: nobody sees these bodies, but the simulation says where they are.
class PredictedObjects {
 public:
  /// Declares the parameters `spawn_predicted` and `density`.
  explicit PredictedObjects(graph::Node& node);
  /// Subscribes, once all parameters are declared. Does nothing unless it is wanted.
  void listen();

  bool wanted() const { return wanted_; }

  /// Puts the meshes of the view into the simulation, one after another; unless `all_move`, all but
  /// `target`'s stay where they are, as neighbours that were predicted a little too large would
  /// push each other about. Then calls `done` with the reason why that failed for the target, or
  /// with nothing.
  /// @throws geometry::InputError when the target's model has not come, or when the view's table is
  /// not the plane z = 0.
  void put(const View& view, std::uint32_t target, bool all_move,
           std::function<void(const std::string&)> done);
  /// Where objects were at the start is known as soon as the simulation has said it.
  void watch();
  /// Publishes the models as they lie at `since` [s] or later, once for each such time, for new
  /// plans. @return why that cannot be, in words; empty: it was, or will be at a later call.
  std::string look(double since);

 private:
  void put_next();

  graph::Node& node_;
  bool wanted_;
  double density_;  // kg/m^3
  std::optional<graph::ServiceClient<msgs::SpawnRequest, msgs::SpawnResponse>> spawn_;
  graph::Publisher<msgs::ObjectModel> models_;
  graph::Subscription subscription_;
  std::shared_ptr<const msgs::GroundTruth> truth_;

  struct Waiting {
    std::uint32_t id = 0;
    msgs::SpawnRequest request;
  };
  std::deque<Waiting> waiting_;
  std::function<void(const std::string&)> done_;
  View view_;
  std::uint32_t target_ = 0;
  std::vector<std::uint32_t> movable_;
  std::map<std::uint32_t, geometry::RigidTransform> X_WB_start_;  // of movable bodies, when put
  std::optional<double> looked_;                                  // s
};

}  // namespace prehend::nodes
