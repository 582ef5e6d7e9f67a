#include "prehend/grasp/closing/close_pads.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <Eigen/Cholesky>

#include "prehend/geometry/symmetric_solve.h"
#include "prehend/text/require.h"

namespace prehend::grasp {
namespace {

using geometry::RigidTransform;
using geometry::SurfaceQuery;

// Centre of the texel in row `row` (from the fingertip) and column `column` in G: x and z [m].
Eigen::Vector2d texel_center(const robot::TactilePadModel& pad, int row, int column) {
  return {(column - (pad.columns - 1) / 2.0) * pad.texel_pitch,
          ((pad.rows - 1) / 2.0 - row) * pad.texel_pitch};
}

// With opening s a texel is pressed by height - s/2.
using Spring = SurfaceOverTexel;

// d height / d q for q = (shift along y [m], turn about x [rad], turn about z [rad]): a small turn
// w moves the surface point r by w x r, so its y by w_z x - w_x z.
Eigen::Vector3d jacobian_of(const Spring& spring) {
  return spring.side * Eigen::Vector3d(1, -spring.z, spring.x);
}

// Centres of one pad's texels in the plane y = `y` of G.
std::vector<Eigen::Vector3d> texel_centers(const robot::TactilePadModel& pad, double y) {
  std::vector<Eigen::Vector3d> centers;
  centers.reserve(static_cast<std::size_t>(pad.rows * pad.columns));
  for (int row = 0; row < pad.rows; ++row) {
    for (int column = 0; column < pad.columns; ++column) {
      const Eigen::Vector2d c = texel_center(pad, row, column);
      centers.emplace_back(c.x(), y, c.y());
    }
  }
  return centers;
}

std::vector<Eigen::Vector3d> placed(const RigidTransform& X_WG,
                                    const std::vector<Eigen::Vector3d>& points_G) {
  std::vector<Eigen::Vector3d> points_W;
  points_W.reserve(points_G.size());
  for (const auto& p_G : points_G) points_W.push_back(X_WG * p_G);
  return points_W;
}

// The spring beds of both pads and the free rigid object between them.
class PadBeds {
 public:
  PadBeds(std::vector<Spring> springs, double stiffness)
      : springs_(std::move(springs)), stiffness_(stiffness) {
    for (const auto& spring : springs_) {
      rows_.emplace_back();
      rows_.back() << jacobian_of(spring), -0.5;
      highest_[spring.side > 0] = std::max(highest_[spring.side > 0], spring.height);
    }
  }

  const std::vector<Spring>& springs() const { return springs_; }
  double stiffness() const { return stiffness_; }
  Eigen::Vector3d rest() const { return x_.head<3>(); }
  double depth(std::size_t i) const { return springs_[i].height + rows_[i].dot(x_); }

  // The opening at which the mean of the pads' forces is `force` [N], and the object's rest there:
  // the least of E / k + F s / k over x = (q, s).
  double opening_for(double force) {
    const double load = force / stiffness_;
    // Touching with the highest texel of each pad.
    x_ << (highest_[0] - highest_[1]) / 2, 0, 0, highest_[0] + highest_[1] - 1e-4;
    double value = energy(x_, load);
    for (int iteration = 0; iteration < 100; ++iteration) {
      Eigen::Vector4d gradient = 1e-6 * kWeights.cwiseProduct(x_);
      Eigen::Matrix4d hessian = (1e-6 * kWeights).asDiagonal();
      gradient[3] += load;
      for (std::size_t i = 0; i < springs_.size(); ++i) {
        const double d = depth(i);
        if (d <= 0) continue;
        gradient.noalias() += d * rows_[i];
        hessian.noalias() += rows_[i] * rows_[i].transpose();
      }
      const Eigen::Vector4d step = -geometry::symmetric_solve<4>(hessian, gradient);
      double scale = 1;
      double next = energy(x_ + step, load);
      while (next > value && scale > 1e-6) {
        scale /= 2;
        next = energy(x_ + scale * step, load);
      }
      x_ += scale * step;
      value = next;
      if ((scale * step).cwiseProduct(kLengths).norm() < 1e-9) break;
    }
    return x_[3];
  }

 private:
  double energy(const Eigen::Vector4d& x, double load) const {
    double sum = 0.5e-6 * x.dot(kWeights.cwiseProduct(x)) + load * x[3];
    for (std::size_t i = 0; i < springs_.size(); ++i) {
      const double d = springs_[i].height + rows_[i].dot(x);
      if (d > 0) sum += d * d / 2;
    }
    return sum;
  }

  // Tiny springs that hold what no texel holds; turns count with a lever of 20 mm. The opening has
  // next to none: it would take from the force.
  inline static const Eigen::Vector4d kLengths{1, 0.02, 0.02, 1};
  inline static const Eigen::Vector4d kWeights{1, 4e-4, 4e-4, 1e-6};

  std::vector<Spring> springs_;
  std::vector<Eigen::Vector4d> rows_;  // d depth / d x
  double stiffness_;
  double highest_[2] = {-1e9, -1e9};             // m, right and left
  Eigen::Vector4d x_ = Eigen::Vector4d::Zero();  // q and the opening
};

// Corners, middles of the long edges, and two in the middle: what eight rays at once can ask.
std::vector<Eigen::Vector3d> spread_texels(const std::vector<Eigen::Vector3d>& centers,
                                           const robot::TactilePadModel& pad) {
  const int bottom = pad.rows - 1, right = pad.columns - 1;
  std::vector<Eigen::Vector3d> spread;
  for (const auto& [row, column] :
       {std::pair(0, 0), std::pair(0, right), std::pair(bottom, 0), std::pair(bottom, right),
        std::pair(bottom / 2, 0), std::pair(bottom / 2, right), std::pair(bottom / 3, right / 2),
        std::pair(bottom - bottom / 3, right / 2)}) {
    spread.push_back(centers[static_cast<std::size_t>(row * pad.columns + column)]);
  }
  return spread;
}

bool leaves(const geometry::RayHit& hit, const Eigen::Vector3d& direction_W) {
  return hit.normal.dot(direction_W) > 0;
}

// Of a ray that leaves the object. Through a hole of an open mesh it may do so without having
// started inside: then the way back meets nothing from inside.
bool starts_inside(const SurfaceQuery& object, const Eigen::Vector3d& origin,
                   const Eigen::Vector3d& direction_W) {
  const auto back = object.cast_ray(origin, -direction_W);
  return back && back->normal.dot(direction_W) < 0;
}

// Heights over all texels of both open pads; nothing when a pad starts inside the object.
std::optional<std::vector<Spring>> measure_heights(const SurfaceQuery& object,
                                                   const RigidTransform& X_WG, double opening,
                                                   const robot::TactilePadModel& pad) {
  std::vector<Spring> springs;
  std::vector<std::optional<geometry::RayHit>> hits;
  for (int side : {1, -1}) {
    const Eigen::Vector3d direction_W = X_WG.linear() * Eigen::Vector3d(0, -side, 0);
    const std::vector<Eigen::Vector3d> centers = texel_centers(pad, side * opening / 2);
    // What is too wide is mostly so over many texels: a few rays instead of all.
    const std::vector<Eigen::Vector3d> few = placed(X_WG, spread_texels(centers, pad));
    object.cast_rays(few, direction_W, 1e9, &hits);
    for (std::size_t i = 0; i < hits.size(); ++i) {
      if (hits[i] && leaves(*hits[i], direction_W) && starts_inside(object, few[i], direction_W)) {
        return std::nullopt;
      }
    }
    const std::vector<Eigen::Vector3d> origins = placed(X_WG, centers);
    object.cast_rays(origins, direction_W, 1e9, &hits);
    for (std::size_t i = 0; i < hits.size(); ++i) {
      const auto& hit = hits[i];
      if (!hit) continue;
      if (leaves(*hit, direction_W)) {
        if (starts_inside(object, origins[i], direction_W)) return std::nullopt;
        continue;
      }
      if (hit->distance > opening) continue;
      springs.push_back({centers[i].x(), centers[i].z(), side, opening / 2 - hit->distance,
                         X_WG.linear().transpose() * hit->normal});
    }
  }
  return springs;
}

// True when the object, at rest between the pads, reaches into a finger beyond its pad: the
// finger's face lies the pad's thickness behind the pad's, from the housing to the fingertip.
bool reaches_finger(const SurfaceQuery& object, const RigidTransform& X_WG, double open,
                    const PadBeds& beds, double opening, const robot::GripperModel& gripper) {
  constexpr double kSpacing = 0.004;  // m, of the rays along the finger
  const auto& pad = gripper.pad;
  const double half_width = gripper.finger_size.x() / 2;
  for (int side : {1, -1}) {
    const Eigen::Vector3d direction_W = X_WG.linear() * Eigen::Vector3d(0, -side, 0);
    for (double z = gripper.housing_front_z(); z <= gripper.tip_z(); z += kSpacing) {
      if (std::abs(z) < pad.length() / 2) continue;  // the pad itself
      for (const double x : {-half_width, 0.0, half_width}) {
        const double start = open / 2 + pad.thickness;
        const auto hit =
            object.cast_ray(X_WG * Eigen::Vector3d(x, side * start, z), direction_W, open);
        if (!hit || hit->normal.dot(direction_W) > 0) continue;
        const Spring finger{x, z, side, start - hit->distance, Eigen::Vector3d::UnitY()};
        const double moved = finger.height + jacobian_of(finger).dot(beds.rest());
        if (moved > opening / 2 + pad.thickness) return true;
      }
    }
  }
  return false;
}

ContactPatch make_patch(const PadBeds& beds, int side, double opening,
                        const robot::TactilePadModel& pad, const ClosingOptions& options) {
  ContactPatch patch;
  patch.normal_G.setZero();
  const Eigen::Vector3d turn(beds.rest()[1], 0, beds.rest()[2]);
  for (std::size_t i = 0; i < beds.springs().size(); ++i) {
    const Spring& spring = beds.springs()[i];
    const double depth = beds.depth(i);
    if (spring.side != side || depth <= 0) continue;
    const double force = beds.stiffness() * depth;
    patch.points_G.emplace_back(spring.x, side * (opening / 2 + depth), spring.z);
    patch.normals_G.push_back((spring.normal_G + turn.cross(spring.normal_G)).normalized());
    patch.forces.push_back(force);
    patch.force += force;
    patch.depth = std::max(patch.depth, depth);
    patch.center_G += force * patch.points_G.back();
    patch.normal_G += force * patch.normals_G.back();
    if (force > options.touch_counts * pad.newton_per_count) {
      patch.area += pad.texel_pitch * pad.texel_pitch;
    }
  }
  if (patch.force <= 0) return patch;
  patch.center_G /= patch.force;
  patch.center_G.y() = side * opening / 2;
  patch.normal_G.normalize();
  // A texel is a square: even a single one resists torsion with its own mean radius.
  const double texel_radius = 0.3826 * pad.texel_pitch;
  for (std::size_t i = 0; i < patch.forces.size(); ++i) {
    const Eigen::Vector3d r = patch.points_G[i] - patch.center_G;
    patch.torsion_radius += patch.forces[i] / patch.force *
                            std::sqrt(r.x() * r.x() + r.z() * r.z() + texel_radius * texel_radius);
  }
  return patch;
}

// m, from G's xz plane to beyond every vertex along G's y axis.
double reach_along_closing(const SurfaceQuery& object, const RigidTransform& X_WG) {
  const Eigen::Vector3d y_W = X_WG.linear().col(1);
  const Eigen::AlignedBox3d& box = object.box();
  return std::abs(y_W.dot(box.center() - X_WG.translation())) +
         y_W.cwiseAbs().dot(box.sizes()) / 2 + 0.01;
}

}  // namespace

void ClosingOptions::validate() const {
  const text::Require require{"ClosingOptions."};
  require(touch_force > 0, "touch_force must be positive");
  require(largest_turn >= 0, "largest_turn must not be negative");
  require(touch_counts >= 0, "touch_counts must not be negative");
}

SectionExtent measure_section(const SurfaceQuery& object_W, const RigidTransform& X_WG,
                              const robot::GripperModel& gripper) {
  const Eigen::Vector3d y_W = X_WG.linear().col(1);
  const double reach = reach_along_closing(object_W, X_WG);
  SectionExtent section;
  section.upper = -reach;
  section.lower = reach;
  std::vector<std::optional<geometry::RayHit>> hits;
  for (int side : {1, -1}) {
    const std::vector<Eigen::Vector3d> centers = texel_centers(gripper.pad, side * reach);
    object_W.cast_rays(placed(X_WG, centers), -side * y_W, 2 * reach, &hits);
    for (std::size_t i = 0; i < hits.size(); ++i) {
      if (!hits[i]) continue;
      const double height = reach - hits[i]->distance;
      section.met = true;
      section.upper = std::max(section.upper, side * height);
      section.lower = std::min(section.lower, side * height);
      section.surface.push_back({centers[i].x(), centers[i].z(), side, height,
                                 X_WG.linear().transpose() * hits[i]->normal});
    }
  }
  return section;
}

double least_section_width(const SurfaceQuery& object_W, const RigidTransform& X_WG,
                           const robot::GripperModel& gripper) {
  const Eigen::Vector3d y_W = X_WG.linear().col(1);
  const double reach = reach_along_closing(object_W, X_WG);
  double highest[2] = {-reach, -reach};
  std::vector<std::optional<geometry::RayHit>> hits;
  for (int side : {1, -1}) {
    const auto centers = spread_texels(texel_centers(gripper.pad, side * reach), gripper.pad);
    object_W.cast_rays(placed(X_WG, centers), -side * y_W, 2 * reach, &hits);
    for (const auto& hit : hits) {
      if (hit) highest[side > 0] = std::max(highest[side > 0], reach - hit->distance);
    }
  }
  return highest[0] + highest[1];
}

void SectionExtent::shift_hand(double offset) {
  upper -= offset;
  lower -= offset;
  for (SurfaceOverTexel& over : surface) over.height -= over.side * offset;
}

ClosedHand close_hand(const SurfaceQuery& object_W, const RigidTransform& X_WG, double opening,
                      double force, const robot::GripperModel& gripper,
                      const ClosingOptions& options, const SectionExtent* section) {
  options.validate();
  if (!(opening > 0) || !(force > 0)) {
    throw std::invalid_argument("close_hand: opening and force must be positive");
  }
  ClosedHand hand;
  std::optional<std::vector<Spring>> springs;
  if (section != nullptr && section->met && section->upper <= opening / 2 &&
      section->lower >= -opening / 2) {
    springs = section->surface;
  } else {
    springs = measure_heights(object_W, X_WG, opening, gripper.pad);
  }
  if (!springs) {
    hand.outcome = ClosingOutcome::kTooWide;
    return hand;
  }
  double highest[2] = {-opening, -opening};  // right, left
  for (const auto& spring : *springs) {
    double& height = highest[spring.side > 0];
    height = std::max(height, spring.height);
  }
  if (highest[0] == -opening || highest[1] == -opening) return hand;  // missed

  hand.offset = (highest[1] - highest[0]) / 2;
  PadBeds beds(*springs, gripper.pad.law.stiffness);
  hand.opening_at_touch = beds.opening_for(std::min(options.touch_force, force));
  hand.opening = beds.opening_for(force);
  hand.turn = beds.rest().tail<2>().norm();
  hand.left = make_patch(beds, 1, hand.opening, gripper.pad, options);
  hand.right = make_patch(beds, -1, hand.opening, gripper.pad, options);

  const bool balanced = std::min(hand.left.force, hand.right.force) > 0.9 * force;
  if (hand.turn > options.largest_turn || !balanced) {
    hand.outcome = ClosingOutcome::kTurns;
  } else if (hand.opening < 0 ||
             std::max(hand.left.depth, hand.right.depth) > gripper.pad.thickness) {
    hand.outcome = ClosingOutcome::kBottomsOut;
  } else if (reaches_finger(object_W, X_WG, opening, beds, hand.opening, gripper)) {
    hand.outcome = ClosingOutcome::kTouchesFinger;
  } else {
    hand.outcome = ClosingOutcome::kClosed;
  }
  return hand;
}

}  // namespace prehend::grasp
