#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "msgs/grasp.pb.h"
#include "msgs/objects.pb.h"
#include "prehend/control/surprise.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/grasp/plan_outcome.h"

namespace prehend::nodes {

/// Plans and models of the objects seen in one view, by id.
struct View {
  std::map<std::uint32_t, std::shared_ptr<const msgs::GraspPlan>> plans;
  std::map<std::uint32_t, std::shared_ptr<const msgs::ObjectModel>> models;
  std::chrono::steady_clock::time_point newest_plan{};

  /// As many plans as the view has objects, and the model of each.
  bool complete() const;
};

/// Sorts plans and models, which come in any order, into the views they belong to by their stamp.
class ViewCollector {
 public:
  explicit ViewCollector(std::chrono::duration<double> patience) : patience_(patience) {}

  void add(std::shared_ptr<const msgs::GraspPlan> plan, std::chrono::steady_clock::time_point now);
  void add(std::shared_ptr<const msgs::ObjectModel> model);
  void add(const msgs::ObjectHypotheses& objects, std::chrono::steady_clock::time_point now);

  /// The newest view, seen at the stamp `since` [ns] or later, that is complete, or whose last plan
  /// came `patience` ago; else nullptr.
  const View* newest_ready(std::chrono::steady_clock::time_point now,
                           std::int64_t since = std::numeric_limits<std::int64_t>::min()) const;

  /// Why nothing is seen, in words, when no view of the stamp `since` [ns] or later has an object,
  /// and the first of them came two seconds ago: a camera that goes on may see the next time what
  /// it missed once. Else empty.
  std::string why_nothing(std::chrono::steady_clock::time_point now, std::int64_t since) const;

 private:
  View& view_of(std::int64_t stamp);

  std::chrono::duration<double> patience_;
  std::map<std::int64_t, View> views_;  // by stamp [ns]; the newest few
  // When views without objects came, by stamp [ns], since one had some; and what the newest said.
  std::map<std::int64_t, std::chrono::steady_clock::time_point> empty_views_;
  std::string why_nothing_;
};

/// What is to be grasped. Without grasps: why there are none, or why the choice is impossible
/// (kFailed).
struct Target : grasp::PlanAnswer {
  std::uint32_t id = 0;
  std::vector<const msgs::Grasp*> grasps;  // of its plan, best first
  bool none_left = false;                  // all that is in the view is left out
};

/// What a grasp lacks to be executed, in words; empty: nothing.
using Lacks = std::function<std::string(const msgs::Grasp&)>;

/// Whether an object is to be left alone, or to be taken after all others.
using OfObject = std::function<bool(const msgs::GraspPlan&)>;

/// The object whose best grasp promises most, score / (1 + vote), or the one with id `object` when
/// that is >= 0; of its grasps those before the first that lacks something. Objects cut by the
/// image's border and those that `comes_last` says are taken last. When it has no grasp, the
/// problem tells why; of several objects, each one's. Objects that `leaves_out` says are not taken
/// unless asked for. The target refers to the view's plans.
Target choose_target(const View& view, int object, const Lacks& lacks,
                     const OfObject& leaves_out = nullptr, const OfObject& comes_last = nullptr);

/// The plan whose push is worth most, of those that have one and that `leaves_out` does not say;
/// null: nothing is to be pushed.
const msgs::GraspPlan* choose_push(const View& view, const OfObject& leaves_out);

/// Whether the hand has met something on an approach where nothing was predicted, by the surprises
/// of an attempt: an object that is of another shape would be predicted like that again.
bool met_too_early(std::span<const control::Surprise> of_attempt);

/// The id of the planned object whose centroid is nearest to `p_W` [m]: ids are of one view. -1
/// without plans.
int nearest_object(const View& view, const Eigen::Vector3d& p_W);

/// Meshes of the valid models by id, in the world frame.
/// @throws geometry::InputError for a mesh that does not make sense.
std::map<std::uint32_t, geometry::TriangleMesh> meshes_of(const View& view);

}  // namespace prehend::nodes
