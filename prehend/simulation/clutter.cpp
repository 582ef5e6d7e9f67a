#include "prehend/simulation/clutter.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/simulation/random_draw.h"
#include "prehend/simulation/surface_gap.h"
#include "prehend/simulation/world.h"

namespace prehend::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using geometry::RigidTransform;

constexpr int kTries = 40;
constexpr double kRelease = 0.001;    // m, over what bears it
constexpr double kPushed = 0.0008;    // m, from what it is pushed against
constexpr double kFar = 0.5;          // m, beyond which gaps do not matter
constexpr double kPeriod = 0.02;      // s, between two looks whether all is at rest
constexpr double kStillTime = 0.24;   // s
constexpr double kStillSpeed = 2e-3;  // m/s
constexpr double kStillTurn = 2e-2;   // rad/s
constexpr double kTimeLimit = 6;      // s
constexpr double kRolledOff = 0.1;    // m, beyond the part of the table
constexpr double kTakenAlong = 0.02;  // m

struct Lying {
  ClutterBody body;
  RigidTransform X_OB = RigidTransform::Identity();  // of the mesh in the world's own frame of it
};

Scene empty_table(const ClutterOptions& options) {
  Scene scene;
  scene.table.friction = options.table_friction;
  // The gripper is not in the way.
  scene.carrier.maximum.z() = 10;
  scene.carrier.start = {0, 0, 10};
  return scene;
}

class Dropper {
 public:
  Dropper(const std::vector<ClutterSolid>& solids, const ClutterOptions& options)
      : solids_(solids), options_(options), draw_(options.seed), world_(empty_table(options)) {
    for (const ClutterSolid& solid : solids) {
      if (!solid.mesh_B) throw std::invalid_argument("a solid has no mesh: " + solid.name);
      const Vector3d sides = geometry::bounds(*solid.mesh_B).sizes();
      if (sides.head<2>().maxCoeff() > options.size.minCoeff()) {
        throw geometry::InputError(
            fmt::format("'{}' is {:.0f} mm long, and the part of the table {:.0f} mm", solid.name,
                        1e3 * sides.head<2>().maxCoeff(), 1e3 * options.size.minCoeff()),
            "Leave it out, tell its unit, or give more room");
      }
      surfaces_.emplace_back(*solid.mesh_B);
      radii_.push_back(radius_of(*solid.mesh_B));
    }
  }

  std::vector<ClutterBody> run(const std::function<void(int)>& progress) {
    for (int i = 0; i < options_.count; ++i) {
      bool lies = false;
      for (int t = 0; t < kTries && !lies; ++t) lies = try_one(i);
      if (!lies) break;
      if (progress) progress(i + 1);
    }
    std::vector<ClutterBody> bodies;
    for (Lying& one : lying_) bodies.push_back(std::move(one.body));
    return bodies;
  }

 private:
  // m, of the circle round its foot about the frame's z
  static double radius_of(const geometry::TriangleMesh& mesh) {
    double squared = 0;
    for (const Vector3d& p : mesh.vertices) squared = std::max(squared, p.head<2>().squaredNorm());
    return std::sqrt(squared);
  }

  ClutterPlacing draw_placing() {
    double share = draw_.unit();
    for (const auto& [placing, of_all] : {std::pair{ClutterPlacing::kTouching, options_.touching},
                                          std::pair{ClutterPlacing::kStacked, options_.stacked},
                                          std::pair{ClutterPlacing::kLeaning, options_.leaning},
                                          std::pair{ClutterPlacing::kHidden, options_.hidden}}) {
      if (share < of_all) return placing;
      share -= of_all;
    }
    return ClutterPlacing::kApart;
  }

  bool is_on_part(const Vector3d& p, double beyond) const {
    const Vector2d off = (p.head<2>() - options_.center).cwiseAbs();
    return (off.array() <= 0.5 * options_.size.array() + beyond).all() && p.z() > -0.01;
  }

  const SampledSurface& surface(const Lying& one) const { return surfaces_[one.body.solid]; }

  double gap_to_others(std::size_t solid, const RigidTransform& X_WB) const {
    double gap = kFar;
    for (const Lying& other : lying_) {
      gap = surface_gap(surfaces_[solid], X_WB, surface(other), other.body.X_WB, gap).distance;
    }
    return gap;
  }

  // As far along the unit vector as nothing is nearer than `near`; each step is as long as the gap,
  // so that it never passes through. False: it is too near or within one from the start, or meets
  // nothing.
  bool slide(std::size_t solid, const Vector3d& way_W, double near, double most,
             RigidTransform& X_WB) const {
    for (const Lying& other : lying_) {
      if (surfaces_overlap(surfaces_[solid], X_WB, surface(other), other.body.X_WB)) return false;
    }
    double done = 0;
    for (int step = 0; step < 200 && done < most; ++step) {
      double gap = gap_to_others(solid, X_WB);
      if (way_W.z() < 0) gap = std::min(gap, surfaces_[solid].lowest(X_WB));
      if (gap < 0.5 * near) return false;
      if (gap <= 1.1 * near) return true;
      X_WB.translation() += (gap - near) * way_W;
      done += gap - near;
    }
    return false;
  }

  bool lower(std::size_t solid, RigidTransform& X_WB) const {
    double top = 0;
    for (const Lying& other : lying_) {
      top = std::max(top, surface(other).highest(other.body.X_WB));
    }
    X_WB.translation().z() += top + 2 * kRelease - surfaces_[solid].lowest(X_WB);
    return slide(solid, -Vector3d::UnitZ(), kRelease, 10, X_WB);
  }

  Vector2d somewhere(double radius) {
    const Vector2d room = (0.5 * options_.size.array() - radius).max(0).matrix();
    return options_.center +
           Vector2d(draw_.between(-room.x(), room.x()), draw_.between(-room.y(), room.y()));
  }

  // Unset: there is no room for it so.
  std::optional<RigidTransform> place(std::size_t solid, ClutterPlacing placing) {
    RigidTransform X_WB = RigidTransform::Identity();
    const double radius = radii_[solid];
    X_WB.linear() =
        draw_.unit() < options_.tumbled && placing != ClutterPlacing::kLeaning
            ? draw_.rotation().toRotationMatrix()
            : Eigen::AngleAxisd(draw_.between(0, 2 * std::numbers::pi), Vector3d::UnitZ())
                  .toRotationMatrix();
    if (lying_.empty()) placing = ClutterPlacing::kApart;
    if (placing == ClutterPlacing::kApart) {
      const Vector2d p = somewhere(radius);
      for (const Lying& other : lying_) {
        const double between = (p - other.body.X_WB.translation().head<2>()).norm();
        if (between < radius + radii_[other.body.solid] + options_.gap) return std::nullopt;
      }
      X_WB.translation() << p, 0;
      return lower(solid, X_WB) ? std::optional(X_WB) : std::nullopt;
    }
    const Lying& neighbour = lying_[draw_.one_of(lying_.size())];
    const Vector3d p_N = neighbour.body.X_WB.translation();
    const double reach = radius + radii_[neighbour.body.solid];
    if (placing == ClutterPlacing::kStacked) {
      const double aside = 0.3 * radii_[neighbour.body.solid];
      X_WB.translation() =
          p_N + Vector3d(draw_.between(-aside, aside), draw_.between(-aside, aside), 0);
      return lower(solid, X_WB) ? std::optional(X_WB) : std::nullopt;
    }
    if (placing == ClutterPlacing::kHidden) {
      const Vector2d away = (p_N - options_.eye).head<2>().normalized();
      X_WB.translation() << p_N.head<2>() + (reach + draw_.between(0.005, options_.gap)) * away, 0;
      return lower(solid, X_WB) ? std::optional(X_WB) : std::nullopt;
    }
    const double angle = draw_.between(0, 2 * std::numbers::pi);
    const Vector3d away(std::cos(angle), std::sin(angle), 0);
    if (placing == ClutterPlacing::kLeaning) {
      const Vector3d axis = Vector3d::UnitZ().cross(-away);
      X_WB.linear() = Eigen::AngleAxisd(draw_.between(0.3, 0.7), axis) * X_WB.linear();
    }
    // Leaning things reach as far as they are high.
    const double height = geometry::bounds(*solids_[solid].mesh_B).sizes().z();
    const double far = reach + (placing == ClutterPlacing::kLeaning ? height : 0) + 0.01;
    X_WB.translation() << (p_N + far * away).head<2>(), 0;
    X_WB.translation().z() += kRelease - surfaces_[solid].lowest(X_WB);
    if (!slide(solid, -away, kPushed, far, X_WB)) return std::nullopt;
    return X_WB;
  }

  bool comes_to_rest() {
    double still = 0;
    for (double end = world_.time() + kTimeLimit; world_.time() < end && still < kStillTime;) {
      world_.advance(kPeriod);
      still += kPeriod;
      for (std::size_t i = 0; i < world_.body_count(); ++i) {
        const BodyReading body = world_.body(i);
        if (!body.asleep && (!(body.velocity.norm() < kStillSpeed) ||
                             !(body.angular_velocity.norm() < kStillTurn))) {
          still = 0;
        }
      }
    }
    return still >= kStillTime;
  }

  bool try_one(int index) {
    Lying next;
    next.body.solid = draw_.one_of(solids_.size());
    next.body.placing = draw_placing();
    const auto X_WB = place(next.body.solid, next.body.placing);
    if (!X_WB || !is_on_part(X_WB->translation(), 0)) return false;
    const ClutterSolid& solid = solids_[next.body.solid];
    next.body.name = fmt::format("{}_{}", solid.name, index);
    if (lying_.empty()) next.body.placing = ClutterPlacing::kApart;
    world_.add_object(next.body.name, geometry::transformed(*solid.mesh_B, *X_WB), solid.mass,
                      false, solid.friction);
    next.X_OB = world_.body(next.body.name).X_WB.inverse(Eigen::Isometry) * *X_WB;
    next.body.X_WB = *X_WB;
    lying_.push_back(next);
    std::vector<RigidTransform> rest;
    bool good = comes_to_rest();
    for (const Lying& one : lying_) {
      rest.push_back(world_.body(one.body.name).X_WB * one.X_OB);
      good = good && is_on_part(rest.back().translation(), kRolledOff);
      const double moved = (rest.back().translation() - one.body.X_WB.translation()).norm();
      good = good && (&one == &lying_.back() || moved < kTakenAlong);
    }
    if (good) {
      for (std::size_t i = 0; i < lying_.size(); ++i) lying_[i].body.X_WB = rest[i];
      return true;
    }
    world_.remove_object(next.body.name);
    lying_.pop_back();
    for (const Lying& one : lying_) {
      world_.place_object(one.body.name, one.body.X_WB * one.X_OB.inverse(Eigen::Isometry));
    }
    return false;
  }

  const std::vector<ClutterSolid>& solids_;
  const ClutterOptions& options_;
  RandomDraw draw_;
  World world_;
  std::vector<SampledSurface> surfaces_;
  std::vector<double> radii_;  // m
  std::vector<Lying> lying_;
};

}  // namespace

std::string to_string(ClutterPlacing placing) {
  static constexpr const char* kNames[] = {"apart", "touching", "stacked", "leaning", "hidden"};
  return kNames[static_cast<std::size_t>(placing)];
}

void ClutterOptions::validate() const {
  const auto require = [](bool good, const std::string& field, const std::string& what) {
    if (!good) throw std::invalid_argument(field + " must be " + what);
  };
  require(count >= 1 && count <= 12, "count", "1 to 12");
  require(center.allFinite(), "center", "finite");
  require(((center.cwiseAbs() + size / 2).array() <= TableModel().size.array() / 2).all(), "center",
          "such that all of the size about it is on the table");
  require(size.allFinite() && size.minCoeff() > 0 && size.maxCoeff() <= 2, "size",
          "positive and at most 2 m");
  for (const auto& [name, share] : {std::pair{"touching", touching}, std::pair{"stacked", stacked},
                                    std::pair{"leaning", leaning}, std::pair{"hidden", hidden},
                                    std::pair{"tumbled", tumbled}}) {
    require(share >= 0 && share <= 1, name, "a share from 0 to 1");
  }
  require(touching + stacked + leaning + hidden <= 1 + 1e-9,
          "touching + stacked + leaning + hidden", "at most 1");
  require(gap >= 0 && gap <= 1, "gap", "0 to 1 m");
  require(eye.allFinite(), "eye", "finite");
  require(table_friction >= 0 && std::isfinite(table_friction), "table_friction",
          "finite and not negative");
}

std::vector<ClutterBody> drop_clutter(const std::vector<ClutterSolid>& solids,
                                      const ClutterOptions& options,
                                      const std::function<void(int)>& progress) {
  options.validate();
  if (solids.empty()) throw std::invalid_argument("drop_clutter: no solids");
  return Dropper(solids, options).run(progress);
}

}  // namespace prehend::simulation
