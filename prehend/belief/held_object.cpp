#include "prehend/belief/held_object.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "prehend/belief/point_cells.h"
#include "prehend/belief/points_beside.h"
#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/surface/normals.h"
#include "prehend/surface/shape_cloud.h"
#include "prehend/surface/vertex_origin.h"
#include "prehend/text/require.h"

namespace prehend::belief {
namespace {

using geometry::RigidTransform;

constexpr std::size_t kLeastPoints = 60;  // of a look, of the object
constexpr double kSeenThrough = 0.008;    // m, before what a look saw behind it
constexpr float kSeenConfidence = 0.95F;
constexpr double kReach = 1.5;     // spacings, of a seen point to a vertex
constexpr int kWindowMargin = 24;  // pixels

/// What was seen, averaged and smoothed, with normals towards the camera.
geometry::PointCloud oriented(const geometry::PointCloud& seen, const Eigen::Vector3d& viewpoint,
                              const surface::OrientedCloudOptions& options) {
  shape::CompletedShape only;
  only.cloud_W.points = seen.points;
  only.origin.assign(seen.size(), shape::PointOrigin::kSeen);
  only.support.assign(seen.size(), shape::PointSupport::kSeen);
  only.point_confidence.assign(seen.size(), 1);
  only.viewpoint_W = viewpoint;
  return surface::oriented_cloud(only, options);
}

geometry::PointCloud seen_of(const shape::CompletedShape& shape, const geometry::Plane& table_W,
                             const surface::ModelOptions& options) {
  const surface::ShapeCloud points = surface::shape_cloud(shape, table_W, options.points());
  std::vector<int> seen;
  for (std::size_t i = 0; i < points.basis.size(); ++i) {
    if (points.basis[i] == surface::SurfaceOrigin::kSeen) seen.push_back(static_cast<int>(i));
  }
  return geometry::select(points.cloud_W, seen);
}

}  // namespace

void HeldObjectOptions::validate() const {
  belief.validate();
  const text::Require require{"HeldObjectOptions."};
  for (const HeldPrior* prior : {&closing, &holding}) {
    require(prior->along > 0 && prior->along < 0.1, "along must be above 0, below 0.1 m");
    require(prior->turn > 0 && prior->turn < 1, "turn must be above 0, below 1 rad");
  }
  require(seen_deviation > 0 && seen_deviation < 0.1,
          "seen_deviation must be above 0, below 0.1 m");
  require(most_contacts >= 0, "most_contacts must not be negative");
  require(largest_residual > 0 && largest_residual < 0.1,
          "largest_residual must be above 0, below 0.1 m");
  require(most_violated > 0 && most_violated <= 1, "most_violated must be above 0, at most 1");
}

HeldObject::HeldObject(const shape::CompletedShape& shape, const geometry::Plane& table_W,
                       const HeldObjectOptions& options)
    : options_((options.validate(), options)),
      shape_(shape),
      belief_(shape, table_W, options.belief),
      known_(seen_of(shape, table_W, options.model)),
      middle_(geometry::centroid(known_)) {}

// Of what is known, how much would be where the look saw that nothing is.
double HeldObject::violated(const shape::SeenSpace& space_O) const {
  if (space_O.empty_until.empty()) return 0;
  const RigidTransform X_CO = space_O.X_WC.inverse(Eigen::Isometry);
  std::size_t through = 0;
  for (const Eigen::Vector3f& p : known_.points) {
    if (shape::depth_in_empty_space(space_O, X_CO * p.cast<double>()) > kSeenThrough) ++through;
  }
  return known_.empty() ? 0 : static_cast<double>(through) / static_cast<double>(known_.size());
}

TakenLook HeldObject::add(const HeldLook& look) {
  for (const Eigen::Vector3f& p : look.seen_W.points) {
    if (!geometry::is_finite(p)) {
      throw std::invalid_argument("HeldObject: a point of a look is not finite");
    }
  }
  TakenLook taken;
  taken.points = look.seen_W.size();
  taken.X_WO = look.X_WO * X_held_;
  if (look.seen_W.size() < kLeastPoints) {
    taken.problem = fmt::format(
        "only {} points of it were seen: it is hidden, beside the picture, or not held any more",
        look.seen_W.size());
    return taken;
  }
  // Where it was in the hand at the look before.
  const RigidTransform X_SW = taken.X_WO.inverse(Eigen::Isometry);
  geometry::PointCloud seen_S;
  try {
    seen_S = oriented(geometry::transformed(look.seen_W, X_SW),
                      X_SW * look.space.X_WC.translation(), options_.model.cloud);
  } catch (const geometry::InputError& error) {
    taken.problem = error.what();
    return taken;
  }
  const HeldPose pose =
      held_pose(known_, seen_S, looks_ == 0 ? options_.closing : options_.holding);
  taken.matched = pose.matched;
  const RigidTransform X_held = X_held_ * pose.X_KS.inverse(Eigen::Isometry);
  taken.X_WO = look.X_WO * X_held;
  taken.moved = (X_held * middle_ - middle_).norm();
  shape::SeenSpace space_O = look.space;
  space_O.X_WC = taken.X_WO.inverse(Eigen::Isometry) * look.space.X_WC;
  const double through = violated(space_O);
  if (pose.matched >= kLeastPoints && pose.residual > options_.largest_residual) {
    taken.problem = fmt::format(
        "what was seen is {:.1f} mm off what is known of it: it is something else, or lies "
        "otherwise in the hand",
        1e3 * pose.residual);
    return taken;
  }
  if (through > options_.most_violated) {
    taken.problem = fmt::format(
        "{:.0f} % of what is known of it would be where the look saw nothing: it is not held, or "
        "lies otherwise in the hand",
        100 * through);
    return taken;
  }
  const geometry::PointCloud seen_O = geometry::transformed(seen_S, pose.X_KS);
  belief_.begin_act({options_.holding.along, 0});
  for (const std::size_t i :
       points_beside(seen_O, known_, static_cast<std::size_t>(options_.most_contacts))) {
    belief_.add({seen_O.points[i].cast<double>(), seen_O.normals[i].cast<double>().normalized(),
                 options_.seen_deviation});
  }
  belief_.add_seen(seen_O);
  if (!space_O.empty_until.empty()) belief_.add_seen_space(std::move(space_O));
  belief_.update();
  known_.points.insert(known_.points.end(), seen_O.points.begin(), seen_O.points.end());
  known_.normals.insert(known_.normals.end(), seen_O.normals.begin(), seen_O.normals.end());
  X_held_ = X_held;
  ++looks_;
  return taken;
}

surface::ObjectModel HeldObject::model() const {
  surface::ObjectModel model =
      surface::model_of_shape(belief_.mesh(), shape_, options_.model.convex_pieces);
  const double reach = kReach * surface::spacing_of(shape_.cloud_W);
  const PointCells cells(known_.points, std::max(reach, 2 * options_.seen_deviation));
  for (std::size_t v = 0; v < model.mesh_W.vertices.size(); ++v) {
    if (!surface::is_guessed(model.vertex_origin[v])) continue;
    bool is_seen = false;
    cells.each_near(model.mesh_W.vertices[v].cast<float>(),
                    [&](std::size_t, float) { is_seen = true; });
    if (!is_seen) continue;
    model.vertex_origin[v] = surface::SurfaceOrigin::kSeen;
    model.vertex_confidence[v] = std::max(model.vertex_confidence[v], kSeenConfidence);
  }
  model.guessed_area = surface::guessed_area(model.mesh_W, model.vertex_origin);
  return model;
}

HeldLook held_look(const geometry::DepthImage& depth, const geometry::PinholeCamera& camera,
                   const geometry::RigidTransform& X_WC, const geometry::Plane& table_W,
                   const std::vector<geometry::TriangleMesh>& robot_W,
                   const geometry::PointCloud& thought_W, double reach, double clearance) {
  HeldLook look;
  const Eigen::Vector3d middle = geometry::centroid(thought_W);
  Eigen::AlignedBox3d near;
  near.extend(middle - Eigen::Vector3d::Constant(reach));
  near.extend(middle + Eigen::Vector3d::Constant(reach));
  std::vector<geometry::MeshQuery> links;
  for (const geometry::TriangleMesh& link : robot_W) {
    if (link.triangles.empty()) continue;
    if (geometry::bounds(link).squaredExteriorDistance(near) > clearance * clearance) continue;
    links.emplace_back(link);
  }
  for (int v = 0; v < depth.height; ++v) {
    for (int u = 0; u < depth.width; ++u) {
      const double z = static_cast<double>(depth.at(u, v));
      if (!(z > 0) || !std::isfinite(z)) continue;
      const Eigen::Vector3d p_W = X_WC * camera.unproject(u, v, z);
      if ((p_W - middle).squaredNorm() > reach * reach) continue;
      if (table_W.signed_distance(p_W) < clearance) continue;
      const bool is_robot = std::any_of(links.begin(), links.end(), [&](const auto& link) {
        return link.nearest(p_W, clearance).has_value() || link.contains(p_W);
      });
      if (!is_robot) look.seen_W.points.push_back(p_W.cast<float>());
    }
  }
  look.space =
      shape::make_seen_space(depth, camera, X_WC, table_W, thought_W.points, kWindowMargin);
  look.space.X_WC = X_WC;
  return look;
}

}  // namespace prehend::belief
