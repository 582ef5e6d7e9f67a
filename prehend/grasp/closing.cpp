#include "prehend/grasp/closing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>

#include <Eigen/Cholesky>

namespace prehend::grasp {
namespace {

using geometry::MeshQuery;
using geometry::RigidTransform;

void require(bool condition, const std::string& message) {
  if (!condition) throw std::invalid_argument("ClosingOptions." + message);
}

// Centre of the texel in row `row` (from the fingertip) and column `column` in G: x and z [m].
Eigen::Vector2d texel_center(const robot::TactilePadModel& pad, int row, int column) {
  return {(column - (pad.columns - 1) / 2.0) * pad.texel_pitch,
          ((pad.rows - 1) / 2.0 - row) * pad.texel_pitch};
}

// The surface over one texel. `height` is measured along the outward direction of the pad's side:
// +y for the left, -y for the right; with opening s the texel is pressed by height - s/2.
struct Spring {
  double x = 0, z = 0;  // m, in G
  double height = 0;    // m
  int side = 1;         // +1 left, -1 right
  Eigen::Vector3d normal_G = Eigen::Vector3d::UnitY();

  // d height / d q for q = (shift along y [m], turn about x [rad], turn about z [rad]): a small
  // turn w moves the surface point r by w x r, so its y by w_z x - w_x z.
  Eigen::Vector3d jacobian() const { return side * Eigen::Vector3d(1, -z, x); }
};

// The spring beds of both pads and the free rigid object between them.
class PadBeds {
 public:
  PadBeds(std::vector<Spring> springs, double stiffness)
      : springs_(std::move(springs)), stiffness_(stiffness) {
    for (const auto& spring : springs_) jacobians_.push_back(spring.jacobian());
  }

  const std::vector<Spring>& springs() const { return springs_; }
  double stiffness() const { return stiffness_; }
  const Eigen::Vector3d& rest() const { return q_; }

  double depth(std::size_t i, double opening) const {
    return springs_[i].height + jacobians_[i].dot(q_) - opening / 2;
  }

  // Lets the object come to rest at this opening, starting from where it is; returns the mean of
  // the pads' forces [N].
  double settle(double opening) {
    for (int iteration = 0; iteration < 40; ++iteration) {
      Eigen::Vector3d gradient = 1e-6 * weights_.cwiseProduct(q_);
      Eigen::Matrix3d hessian = (1e-6 * weights_).asDiagonal();
      for (std::size_t i = 0; i < springs_.size(); ++i) {
        const double d = depth(i, opening);
        if (d <= 0) continue;
        gradient += d * jacobians_[i];
        hessian.noalias() += jacobians_[i] * jacobians_[i].transpose();
      }
      const Eigen::Vector3d step = -hessian.ldlt().solve(gradient);
      const double before = energy(opening, Eigen::Vector3d::Zero());
      double scale = 1;
      while (scale > 1e-4 && energy(opening, scale * step) > before) scale /= 2;
      q_ += scale * step;
      if ((scale * step).cwiseProduct(length_).norm() < 1e-9) break;
    }
    return force(opening);
  }

  double force(double opening) const {
    double sum = 0;
    for (std::size_t i = 0; i < springs_.size(); ++i) sum += std::max(0.0, depth(i, opening));
    return stiffness_ * sum / 2;
  }

  // The opening at which the mean force is `target`: the force falls as the opening grows.
  double opening_for(double target) {
    double upper = 0;
    for (const auto& spring : springs_) upper = std::max(upper, 2 * spring.height);
    double step = 1e-3;
    double lower = upper - step;
    while (settle(lower) < target && step < 0.2) {
      upper = lower;
      step *= 2;
      lower = upper - step;
    }
    for (int i = 0; i < 60 && upper - lower > 1e-8; ++i) {
      const double middle = (lower + upper) / 2;
      (settle(middle) < target ? upper : lower) = middle;
    }
    settle(lower);
    return lower;
  }

 private:
  double energy(double opening, const Eigen::Vector3d& step) const {
    const Eigen::Vector3d q = q_ + step;
    double sum = 0.5e-6 * q.dot(weights_.cwiseProduct(q));
    for (std::size_t i = 0; i < springs_.size(); ++i) {
      const double d = springs_[i].height + jacobians_[i].dot(q) - opening / 2;
      if (d > 0) sum += d * d / 2;
    }
    return sum;
  }

  std::vector<Spring> springs_;
  std::vector<Eigen::Vector3d> jacobians_;
  double stiffness_;
  Eigen::Vector3d q_ = Eigen::Vector3d::Zero();
  // Tiny springs that hold what no texel holds; turns count with a lever of 20 mm.
  Eigen::Vector3d length_{1, 0.02, 0.02};
  Eigen::Vector3d weights_{1, 4e-4, 4e-4};
};

// Heights over all texels of both open pads; nothing when a pad starts inside the object.
std::optional<std::vector<Spring>> measure_heights(const MeshQuery& object,
                                                   const RigidTransform& X_WG, double opening,
                                                   const robot::TactilePadModel& pad) {
  std::vector<Spring> springs;
  for (int side : {1, -1}) {
    const Eigen::Vector3d direction_W = X_WG.linear() * Eigen::Vector3d(0, -side, 0);
    for (int row = 0; row < pad.rows; ++row) {
      for (int column = 0; column < pad.columns; ++column) {
        const Eigen::Vector2d c = texel_center(pad, row, column);
        const Eigen::Vector3d origin_G(c.x(), side * opening / 2, c.y());
        const auto hit = object.cast_ray(X_WG * origin_G, direction_W);
        if (!hit) continue;
        if (hit->normal.dot(direction_W) > 0) {
          // The ray leaves the object. Through a hole of an open mesh it may do so without having
          // started inside: then the way back meets nothing from inside.
          const auto back = object.cast_ray(X_WG * origin_G, -direction_W);
          if (back && back->normal.dot(direction_W) < 0) return std::nullopt;
          continue;
        }
        if (hit->distance > opening) continue;
        springs.push_back({c.x(), c.y(), opening / 2 - hit->distance, side,
                           X_WG.linear().transpose() * hit->normal});
      }
    }
  }
  return springs;
}

// True when the object, at rest between the pads, reaches into a finger beyond its pad: the
// finger's face lies the pad's thickness behind the pad's, from the housing to the fingertip.
bool reaches_finger(const MeshQuery& object, const RigidTransform& X_WG, double open,
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
        const Spring finger{x, z, start - hit->distance, side, Eigen::Vector3d::UnitY()};
        const double moved = finger.height + finger.jacobian().dot(beds.rest());
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
    const double depth = beds.depth(i, opening);
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

}  // namespace

void ClosingOptions::validate() const {
  require(touch_force > 0, "touch_force must be positive");
  require(largest_turn >= 0, "largest_turn must not be negative");
  require(touch_counts >= 0, "touch_counts must not be negative");
}

SectionExtent measure_section(const MeshQuery& object_W, const RigidTransform& X_WG,
                              const robot::GripperModel& gripper) {
  // Start beyond every vertex.
  const Eigen::Vector3d y_W = X_WG.linear().col(1);
  double upper = -std::numeric_limits<double>::infinity(), lower = -upper;
  for (const auto& v : object_W.mesh().vertices) {
    const double y = y_W.dot(v - X_WG.translation());
    upper = std::max(upper, y);
    lower = std::min(lower, y);
  }
  const double reach = std::max(std::abs(upper), std::abs(lower)) + 0.01;
  SectionExtent section;
  section.upper = -reach;
  section.lower = reach;
  const auto& pad = gripper.pad;
  for (int side : {1, -1}) {
    for (int row = 0; row < pad.rows; ++row) {
      for (int column = 0; column < pad.columns; ++column) {
        const Eigen::Vector2d c = texel_center(pad, row, column);
        const auto hit = object_W.cast_ray(X_WG * Eigen::Vector3d(c.x(), side * reach, c.y()),
                                           -side * y_W, 2 * reach);
        if (!hit) continue;
        const double y = side * (reach - hit->distance);
        section.met = true;
        section.upper = std::max(section.upper, y);
        section.lower = std::min(section.lower, y);
      }
    }
  }
  return section;
}

ClosedHand close_hand(const MeshQuery& object_W, const RigidTransform& X_WG, double opening,
                      double force, const robot::GripperModel& gripper,
                      const ClosingOptions& options) {
  options.validate();
  if (!(opening > 0) || !(force > 0)) {
    throw std::invalid_argument("close_hand: opening and force must be positive");
  }
  ClosedHand hand;
  const auto springs = measure_heights(object_W, X_WG, opening, gripper.pad);
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
