#include "prehend/belief/held_object.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "prehend/belief/point_cells.h"
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
constexpr double kReach = 1.5;             // spacings, of a seen point to a vertex
constexpr double kLeastReach = 0.003;      // m, the same
constexpr std::size_t kMostThought = 400;  // points of what is thought to be held
constexpr double kLeastRoom = 0.01;        // m
constexpr int kWindowMargin = 24;          // pixels

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

/// Whether the depth near a pixel jumps: what stands before something is seen larger than it is, by
/// as much as a camera's matching is wide.
bool is_at_edge(const geometry::DepthImage& depth, int u, int v, const HeldLookOptions& options) {
  const auto step = static_cast<float>(options.step);
  const float z = depth.at(u, v);
  for (int y = v - options.edge; y <= v + options.edge; ++y) {
    for (int x = u - options.edge; x <= u + options.edge; ++x) {
      if (depth.contains(x, y) && std::abs(depth.at(x, y) - z) > step) return true;
    }
  }
  return false;
}

/// Some of the points, evenly, about `most`.
std::vector<Eigen::Vector3f> every(const std::vector<Eigen::Vector3f>& points, std::size_t most) {
  std::vector<Eigen::Vector3f> few;
  for (std::size_t i = 0; i < points.size(); i += 1 + points.size() / most) {
    few.push_back(points[i]);
  }
  return few;
}

/// Of the mask, the connected pixels without steps in depth that are not few.
geometry::MaskImage large_pieces(const geometry::DepthImage& depth, geometry::MaskImage mask,
                                 const HeldLookOptions& options) {
  std::vector<std::vector<std::pair<int, int>>> pieces;
  std::size_t all = 0;
  for (int v = 0; v < mask.height; ++v) {
    for (int u = 0; u < mask.width; ++u) {
      if (mask.at(u, v) == 0) continue;
      std::vector<std::pair<int, int>> piece{{u, v}};
      mask.at(u, v) = 0;
      for (std::size_t i = 0; i < piece.size(); ++i) {
        const auto [x, y] = piece[i];
        for (const auto& [dx, dy] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
          if (!mask.contains(x + dx, y + dy) || mask.at(x + dx, y + dy) == 0) continue;
          const double step = std::abs(depth.at(x + dx, y + dy) - depth.at(x, y));
          if (step > options.step) continue;
          mask.at(x + dx, y + dy) = 0;
          piece.emplace_back(x + dx, y + dy);
        }
      }
      all += piece.size();
      pieces.push_back(std::move(piece));
    }
  }
  const double least = options.least_piece * static_cast<double>(all);
  for (const std::vector<std::pair<int, int>>& piece : pieces) {
    if (static_cast<double>(piece.size()) < least) continue;
    for (const auto& [x, y] : piece) mask.at(x, y) = 255;
  }
  return mask;
}

}  // namespace

void HeldObjectOptions::validate() const {
  belief.validate();
  const text::Require require{"HeldObjectOptions."};
  for (const HeldPrior* prior : {&closing, &holding}) {
    require(prior->along > 0 && prior->along < 0.1, "along must be above 0, below 0.1 m");
    require(prior->turn > 0 && prior->turn < 1, "turn must be above 0, below 1 rad");
  }
  require(largest_residual > 0 && largest_residual < 0.1,
          "largest_residual must be above 0, below 0.1 m");
  require(most_violated > 0 && most_violated <= 1, "most_violated must be above 0, at most 1");
}

void HeldLookOptions::validate() const {
  const text::Require require{"HeldLookOptions."};
  require(room >= 0 && room < 10, "room must be from 0 to 10");
  require(clearance >= 0 && clearance < 0.1, "clearance must be from 0 to 0.1 m");
  require(height >= 0 && height < 1, "height must be from 0 to 1 m");
  require(least_piece >= 0 && least_piece < 1, "least_piece must be from 0 to below 1");
  require(edge >= 0 && edge < 100, "edge must be from 0 to 100 pixels");
  require(step > 0 && step < 1, "step must be above 0, below 1 m");
}

HeldObject::HeldObject(const shape::CompletedShape& shape, const geometry::Plane& table_W,
                       const HeldObjectOptions& options)
    : options_((options.validate(), options)),
      shape_(shape),
      table_W_(table_W),
      belief_(shape, table_W, options.belief),
      first_(seen_of(shape, table_W, options.model)),
      known_(first_),
      middle_(geometry::centroid(first_)) {}

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
  const RigidTransform X_SW = look.X_WO.inverse(Eigen::Isometry);
  Look added{{}, look.space};
  added.space_S.X_WC = X_SW * look.space.X_WC;
  try {
    added.seen_S = oriented(geometry::transformed(look.seen_W, X_SW),
                            added.space_S.X_WC.translation(), options_.model.cloud);
  } catch (const geometry::InputError& error) {
    taken.problem = error.what();
    return taken;
  }
  looks_.push_back(std::move(added));
  std::vector<geometry::PointCloud> clouds;
  for (const Look& one : looks_) clouds.push_back(one.seen_S);
  const std::vector<HeldPose> poses =
      held_poses(first_, clouds, options_.closing, options_.holding);
  const HeldPose& pose = poses.back();
  taken.matched = pose.matched;
  shape::SeenSpace space_O = looks_.back().space_S;
  space_O.X_WC = pose.X_KS * space_O.X_WC;
  const double through = violated(space_O);
  if (pose.matched >= kLeastPoints && pose.residual > options_.largest_residual) {
    taken.problem = fmt::format(
        "what was seen is {:.1f} mm off what is known of it: it is something else, or lies "
        "otherwise in the hand",
        1e3 * pose.residual);
  } else if (through > options_.most_violated) {
    taken.problem = fmt::format(
        "{:.0f} % of what is known of it would be where the look saw nothing: it is not held, or "
        "lies otherwise in the hand",
        100 * through);
  }
  if (!taken.problem.empty()) {
    looks_.pop_back();
    return taken;
  }
  X_held_ = pose.X_KS.inverse(Eigen::Isometry);
  taken.X_WO = look.X_WO * X_held_;
  taken.moved = (X_held_ * middle_ - middle_).norm();
  believe(poses);
  return taken;
}

// All looks, where they lie now.
void HeldObject::believe(const std::vector<HeldPose>& poses) {
  belief_ = ObjectBelief(shape_, table_W_, options_.belief);
  known_ = first_;
  for (std::size_t i = 0; i < looks_.size(); ++i) {
    const geometry::PointCloud seen_O = geometry::transformed(looks_[i].seen_S, poses[i].X_KS);
    belief_.add_seen(seen_O);
    shape::SeenSpace space_O = looks_[i].space_S;
    space_O.X_WC = poses[i].X_KS * space_O.X_WC;
    if (!space_O.empty_until.empty()) belief_.add_seen_space(std::move(space_O));
    known_.points.insert(known_.points.end(), seen_O.points.begin(), seen_O.points.end());
    known_.normals.insert(known_.normals.end(), seen_O.normals.begin(), seen_O.normals.end());
  }
  belief_.update();
}

surface::ObjectModel HeldObject::model() const {
  surface::ObjectModel model =
      surface::model_of_shape(belief_.mesh(), shape_, options_.model.convex_pieces);
  const double reach = kReach * surface::spacing_of(shape_.cloud_W);
  const PointCells cells(known_.points, std::max(reach, kLeastReach));
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

geometry::MaskImage held_pixels(const geometry::DepthImage& depth,
                                const geometry::PinholeCamera& camera,
                                const geometry::RigidTransform& X_WC,
                                const geometry::Plane& table_W,
                                const std::vector<geometry::TriangleMesh>& robot_W,
                                const geometry::PointCloud& thought_W,
                                const HeldLookOptions& options) {
  options.validate();
  if (depth.width != camera.width || depth.height != camera.height) {
    throw std::invalid_argument("held_look(): the depth is not of the camera's size");
  }
  const Eigen::Vector3d middle = geometry::centroid(thought_W);
  double radius = 0;
  for (const Eigen::Vector3f& p : thought_W.points) {
    radius = std::max(radius, (p.cast<double>() - middle).norm());
  }
  const double room = std::max(kLeastRoom, options.room * radius), reach = radius + room;
  const Eigen::AlignedBox3d box(Eigen::Vector3d(middle.array() - reach),
                                Eigen::Vector3d(middle.array() + reach));
  std::vector<geometry::MeshQuery> links;
  for (const geometry::TriangleMesh& link : robot_W) {
    if (link.triangles.empty()) continue;
    if (geometry::bounds(link).squaredExteriorDistance(box) > std::pow(options.clearance, 2)) {
      continue;
    }
    links.emplace_back(link);
  }
  const std::vector<Eigen::Vector3f> few = every(thought_W.points, kMostThought);
  const PointCells thought(few, room);
  const auto may_be_held = [&](int u, int v, const Eigen::Vector3d& p_W) {
    if ((p_W - middle).squaredNorm() > reach * reach) return false;
    if (table_W.signed_distance(p_W) < options.height) return false;
    if (is_at_edge(depth, u, v, options)) return false;
    const bool is_robot = std::any_of(links.begin(), links.end(), [&](const auto& link) {
      return link.box().squaredExteriorDistance(p_W) <= std::pow(options.clearance, 2) &&
             (link.nearest(p_W, options.clearance).has_value() || link.contains(p_W));
    });
    if (is_robot) return false;
    bool is_near = false;
    thought.each_near(p_W.cast<float>(), [&](std::size_t, float) { is_near = true; });
    return is_near;
  };
  geometry::MaskImage mask(depth.width, depth.height, 0);
  for (int v = 0; v < depth.height; ++v) {
    for (int u = 0; u < depth.width; ++u) {
      const double z = static_cast<double>(depth.at(u, v));
      if (!(z > 0) || !std::isfinite(z)) continue;
      if (may_be_held(u, v, X_WC * camera.unproject(u, v, z))) mask.at(u, v) = 255;
    }
  }
  return large_pieces(depth, std::move(mask), options);
}

HeldLook held_look(const geometry::DepthImage& depth, const geometry::PinholeCamera& camera,
                   const geometry::RigidTransform& X_WC, const geometry::Plane& table_W,
                   const std::vector<geometry::TriangleMesh>& robot_W,
                   const geometry::PointCloud& thought_W, const HeldLookOptions& options) {
  HeldLook look;
  const geometry::MaskImage mask =
      held_pixels(depth, camera, X_WC, table_W, robot_W, thought_W, options);
  for (int v = 0; v < depth.height; ++v) {
    for (int u = 0; u < depth.width; ++u) {
      if (mask.at(u, v) == 0) continue;
      const auto z = static_cast<double>(depth.at(u, v));
      look.seen_W.points.push_back((X_WC * camera.unproject(u, v, z)).cast<float>());
    }
  }
  look.space =
      shape::make_seen_space(depth, camera, X_WC, table_W, thought_W.points, kWindowMargin);
  return look;
}

}  // namespace prehend::belief
