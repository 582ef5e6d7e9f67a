#include "prehend/simulation/robot_touch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "prehend/simulation/contact_detection.h"
#include "prehend/simulation/engines/convex_contact.h"
#include "prehend/simulation/engines/pad_on_body.h"
#include "prehend/simulation/mesh_surface.h"

namespace prehend::simulation {
namespace {

using engines::EngineShape;
using engines::TouchPoint;
using engines::Vector6;
using geometry::RigidTransform;

constexpr double kLookAhead = 1e-4;           // m, looked ahead beyond what speeds say
constexpr std::size_t kMostPartContacts = 4;  // of two links of which one is a mesh
constexpr double kBeforeFoam = 0.002;         // m, over a pad's face
constexpr double kOnFace = 2e-4;              // m: nearer to a face's mesh, it is on it
constexpr double kOverFace = 0.95;  // cosine: nearer to its normal, it is over or below it

/// Leaves the deepest and those farthest from what is left already: as many as primitives have, so
/// that links do not become stiffer with the number of points on them.
void keep_apart(std::vector<engines::ConvexContact>& contacts, std::size_t most) {
  if (contacts.size() <= most) return;
  const auto deepest =
      std::max_element(contacts.begin(), contacts.end(),
                       [](const auto& a, const auto& b) { return a.depth < b.depth; });
  std::iter_swap(contacts.begin(), deepest);
  std::vector<double> apart(contacts.size(), std::numeric_limits<double>::infinity());
  for (std::size_t kept = 1; kept < most; ++kept) {
    for (std::size_t i = kept; i < contacts.size(); ++i) {
      apart[i] = std::min(apart[i], (contacts[i].p_W - contacts[kept - 1].p_W).norm());
    }
    const auto farthest =
        std::max_element(apart.begin() + static_cast<std::ptrdiff_t>(kept), apart.end()) -
        apart.begin();
    std::swap(contacts[kept], contacts[static_cast<std::size_t>(farthest)]);
    std::swap(apart[kept], apart[static_cast<std::size_t>(farthest)]);
  }
  contacts.resize(most);
}

geometry::TriangleMesh mesh_of(const EngineShape& shape) {
  switch (shape.kind) {
    case EngineShape::Kind::kBox:
      return geometry::make_box(shape.size);
    case EngineShape::Kind::kSphere:
      return geometry::make_sphere(shape.radius, 24);
    case EngineShape::Kind::kCylinder:
    case EngineShape::Kind::kCapsule:
      return geometry::make_revolution(
          {{shape.radius, -0.5 * shape.length}, {shape.radius, 0.5 * shape.length}}, 24);
    case EngineShape::Kind::kConvexPieces:
      break;  // links have primitives and meshes
  }
  return {};
}

}  // namespace

RobotTouch::RobotTouch(const RobotBodies& robot, const std::vector<robot::HandPad>& pads,
                       std::vector<Object> objects)
    : objects_(std::move(objects)) {
  std::vector<std::shared_ptr<const geometry::MeshQuery>> faces;
  for (const robot::HandPad& pad : pads) {
    faces.push_back(pad.layout->is_flat()
                        ? nullptr
                        : std::make_shared<geometry::MeshQuery>(*pad.layout->face()));
  }
  const int root = robot.body_of_link[0];
  for (const RobotBodies::Part& own : robot.parts) {
    const std::size_t body = static_cast<std::size_t>(own.body);
    const bool carried = robot.bodies[body].is_fixed;
    const bool palm = own.body == robot.body_of_link[robot.hand_root];
    // The arm's base is bolted to the table.
    if (own.body == root && !palm) continue;
    const geometry::TriangleMesh mesh = own.solid ? *own.solid : mesh_of(own.shape);
    Part part{own.body,
              robot.finger_of_body[body],
              robot.rank_of_body[body],
              carried,
              own.shape,
              own.X_BS,
              {},
              0,
              sample_surface(mesh, carried && !palm ? kArmSpacing : kPointSpacing),
              {},
              {},
              {},
              {},
              geometry::bounds(mesh),
              nullptr};
    part.normals_S = normals_at(part.points_S, mesh);
    if (own.solid) {
      part.mesh = std::make_shared<geometry::MeshQuery>(mesh);
      for (const Eigen::Vector3d& p : mesh.vertices) part.radius = std::max(part.radius, p.norm());
    } else {
      part.felt = engines::felt_shape(own.shape);
      part.box_S = part.felt.bounds();
      part.radius = engines::bounding_radius(own.shape);
    }
    for (const RobotBodies::Pad& pad : robot.pads) {
      if (pad.body != own.body) continue;
      const robot::HandPad& of = pads[static_cast<std::size_t>(pad.pad)];
      const RigidTransform X_PS = pad.X_BP.inverse(Eigen::Isometry) * own.X_BS;
      if (of.layout->is_flat()) {
        part.foams.push_back(
            {X_PS, {0.5 * of.model.width(), 0.5 * of.model.length()}, of.model.thickness});
      } else {
        part.surface_foams.push_back(
            {X_PS, faces.at(static_cast<std::size_t>(pad.pad)), of.model.thickness});
      }
    }
    part.hard_S = part.points_S;
    for (Eigen::Vector3d& p : part.hard_S) {
      for (const FoamOnSurface& foam : part.surface_foams) {
        const auto place = foam.find(p, foam.thickness + kBeforeFoam);
        if (place) p -= std::max(0.0, foam.thickness - place->below) * place->out_S;
      }
    }
    parts_.push_back(std::move(part));
  }
  for (const Object& object : objects_) surfaces_.emplace_back(object.model);
}

bool RobotTouch::Foam::holds(const Eigen::Vector3d& p_S) const {
  const Eigen::Vector3d p_P = X_PS * p_S;
  return p_P.z() > -thickness && p_P.z() < kBeforeFoam && std::abs(p_P.x()) <= half.x() &&
         std::abs(p_P.y()) <= half.y();
}

std::optional<RobotTouch::FoamOnSurface::Place> RobotTouch::FoamOnSurface::find(
    const Eigen::Vector3d& p_S, double reach) const {
  const Eigen::Vector3d p_P = X_PS * p_S;
  if (face_P->box().squaredExteriorDistance(p_P) > reach * reach) return std::nullopt;
  const auto nearest = face_P->nearest(p_P, reach);
  if (!nearest) return std::nullopt;
  const geometry::TriangleMesh& mesh = face_P->mesh();
  const Eigen::Vector3i& t = mesh.triangles[static_cast<std::size_t>(nearest->triangle)];
  const Eigen::Vector3d normal = (mesh.vertices[t[1]] - mesh.vertices[t[0]])
                                     .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]])
                                     .normalized();
  const double below = -normal.dot(p_P - nearest->point);
  // Beside the face's rim the way to it is not along its normal.
  if (nearest->distance > kOnFace && std::abs(below) < kOverFace * nearest->distance) {
    return std::nullopt;
  }
  return Place{below, X_PS.linear().transpose() * normal};
}

double RobotTouch::Part::hard_depth(const Eigen::Vector3d& p_S, double depth) const {
  double hard = depth;
  for (const FoamOnSurface& foam : surface_foams) {
    const auto place = foam.find(p_S, depth + foam.thickness + kBeforeFoam);
    if (place) hard = std::min(hard, place->below - foam.thickness);
  }
  return hard;
}

bool RobotTouch::Part::holds(const Eigen::Vector3d& p_S, Eigen::Vector3d& normal_S,
                             double& depth) const {
  if (!box_S.contains(p_S)) return false;
  if (!mesh) {
    depth = felt.depth_inside(p_S, normal_S);
  } else if (!mesh_depth(*mesh, p_S, ObjectSurface::kDeepest, normal_S, depth)) {
    return false;
  }
  return depth > 0 && depth < ObjectSurface::kDeepest;
}

void RobotTouch::add(int a, int b, const Eigen::Vector3d& p_W, const Eigen::Vector3d& n_W,
                     double depth, std::vector<TouchPoint>& touches) const {
  TouchPoint& touch = touches.emplace_back();
  touch.a = a;
  touch.b = b;
  touch.at = {p_W, n_W, depth};
  touch.p_A = base_->X_WB[static_cast<std::size_t>(a)].inverse(Eigen::Isometry) * p_W;
}

void RobotTouch::find_table(int body, const std::vector<Eigen::Vector3d>& points,
                            const RigidTransform& X_WP, double reach,
                            std::vector<TouchPoint>& touches) {
  const Eigen::RowVector3d up = X_WP.linear().row(2);
  const double base = X_WP.translation().z();
  for (const Eigen::Vector3d& p : points) {
    const double z = base + up * p;
    if (z > reach) continue;
    add(body, -1, X_WP * p, Eigen::Vector3d::UnitZ(), -z, touches);
  }
}

// a: the object. Normals point from the part into it.
void RobotTouch::find_part_object(const Part& part, std::size_t index, double margin,
                                  std::vector<TouchPoint>& touches) {
  const Object& object = objects_[index];
  const RigidTransform X_WB = base_->X_WB[static_cast<std::size_t>(object.body)] * object.X_CB;
  const RigidTransform X_WS = base_->X_WB[static_cast<std::size_t>(part.body)] * part.X_BS;
  const RigidTransform X_BS = X_WB.inverse(Eigen::Isometry) * X_WS;
  Eigen::AlignedBox3d box = object.model.box;
  box.min().array() -= margin;
  box.max().array() += margin;
  if (box.squaredExteriorDistance(X_BS.translation()) > part.radius * part.radius) return;
  Eigen::Vector3d normal;
  double depth = 0;
  const bool precise = box.exteriorDistance(X_BS.translation()) < part.radius;
  if (!precise) return;
  const auto in_foam = [&part](const Eigen::Vector3d& p_S) {
    return std::any_of(part.foams.begin(), part.foams.end(),
                       [&p_S](const Foam& foam) { return foam.holds(p_S); });
  };
  for (std::size_t i = 0; i < part.hard_S.size(); ++i) {
    const Eigen::Vector3d p_B = X_BS * part.hard_S[i];
    if (!box.contains(p_B) || in_foam(part.hard_S[i])) continue;
    const auto met = surfaces_[index].met_by(p_B, X_BS.linear() * part.normals_S[i], margin);
    if (!met) continue;
    add(object.body, part.body, X_WB * p_B, -(X_WB.linear() * met->normal), met->depth, touches);
  }
  const RigidTransform X_SB = X_BS.inverse(Eigen::Isometry);
  const Eigen::AlignedBox3d part_B = transformed_box(X_BS, part.box_S);
  for (const Eigen::Vector3d& p_B : object.model.surface_points) {
    if (!part_B.contains(p_B)) continue;
    const Eigen::Vector3d p_S = X_SB * p_B;
    if (!part.holds(p_S, normal, depth) || in_foam(p_S)) continue;
    depth = part.hard_depth(p_S, depth);
    if (!(depth > 0)) continue;
    add(object.body, part.body, X_WB * p_B, X_WS.linear() * normal, depth, touches);
  }
}

void RobotTouch::find_part_part(const Part& a, const Part& b) {
  const RigidTransform X_WA = base_->X_WB[static_cast<std::size_t>(a.body)] * a.X_BS;
  const RigidTransform X_WB = base_->X_WB[static_cast<std::size_t>(b.body)] * b.X_BS;
  if ((X_WA.translation() - X_WB.translation()).norm() > a.radius + b.radius) return;
  Eigen::Vector3d normal;
  double depth = 0;
  // Normals point into a.
  const auto points_in = [&](const Part& of, const RigidTransform& X_WOf, const Part& in,
                             const RigidTransform& X_WIn, double sign) {
    const RigidTransform X_InOf = X_WIn.inverse(Eigen::Isometry) * X_WOf;
    for (const Eigen::Vector3d& p : of.points_S) {
      if (!in.holds(X_InOf * p, normal, depth)) continue;
      found_.push_back({X_WOf * p, sign * (X_WIn.linear() * normal), depth});
    }
  };
  points_in(a, X_WA, b, X_WB, 1);
  points_in(b, X_WB, a, X_WA, -1);
  keep_apart(found_, kMostPartContacts);
}

void RobotTouch::find_objects(std::size_t a, std::size_t b, std::vector<TouchPoint>& touches) {
  const RigidTransform X_WA =
      base_->X_WB[static_cast<std::size_t>(objects_[a].body)] * objects_[a].X_CB;
  const RigidTransform X_WB =
      base_->X_WB[static_cast<std::size_t>(objects_[b].body)] * objects_[b].X_CB;
  if (!transformed_box(X_WA, objects_[a].model.box)
           .intersects(transformed_box(X_WB, objects_[b].model.box))) {
    return;
  }
  const auto points_in = [&](std::size_t of, const RigidTransform& X_WOf, std::size_t in,
                             const RigidTransform& X_WIn, double sign) {
    const RigidTransform X_InOf = X_WIn.inverse(Eigen::Isometry) * X_WOf;
    for (const Eigen::Vector3d& p : objects_[of].model.surface_points) {
      const Eigen::Vector3d p_In = X_InOf * p;
      if (!objects_[in].model.box.contains(p_In)) continue;
      const auto met = surfaces_[in].at(p_In, 0);
      if (!met) continue;
      add(objects_[a].body, objects_[b].body, X_WIn * p_In, sign * (X_WIn.linear() * met->normal),
          met->depth, touches);
    }
  };
  points_in(a, X_WA, b, X_WB, 1);
  points_in(b, X_WB, a, X_WA, -1);
}

void RobotTouch::find(const engines::Multibody& system, const engines::MultibodyState& base,
                      double h, const Eigen::VectorXd& u, std::vector<TouchPoint>& touches) {
  base_ = &base;
  speed_.assign(base.X_WB.size(), 0.0);
  const auto set_speed = [&](int body, double radius) {
    const Vector6 twist = system.twist(body, u);
    double& speed = speed_[static_cast<std::size_t>(body)];
    speed = std::max(speed, twist.head<3>().norm() + radius * twist.tail<3>().norm());
  };
  for (const Part& part : parts_) {
    set_speed(part.body, part.radius + part.X_BS.translation().norm());
  }
  for (const Object& object : objects_) set_speed(object.body, object.model.radius);
  const auto margin = [&](int a, int b) {
    const double speed =
        speed_[static_cast<std::size_t>(a)] + (b < 0 ? 0.0 : speed_[static_cast<std::size_t>(b)]);
    return std::min(0.002, kLookAhead + 2 * h * speed);
  };
  for (std::size_t o = 0; o < objects_.size(); ++o) {
    const Object& object = objects_[o];
    const bool fixed = system.scene().bodies[static_cast<std::size_t>(object.body)].is_fixed;
    if (!fixed && !system.asleep(object.body)) {
      find_table(object.body, object.model.hull_points,
                 base.X_WB[static_cast<std::size_t>(object.body)] * object.X_CB,
                 margin(object.body, -1), touches);
    }
    for (const Part& part : parts_) {
      find_part_object(part, o, margin(object.body, part.body), touches);
    }
    for (std::size_t other = o + 1; other < objects_.size(); ++other) {
      find_objects(o, other, touches);
    }
  }
  for (const Part& part : parts_) {
    const RigidTransform X_WS = base.X_WB[static_cast<std::size_t>(part.body)] * part.X_BS;
    if (X_WS.translation().z() > part.radius + 0.002) continue;
    find_table(part.body, part.points_S, X_WS, margin(part.body, -1), touches);
  }
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    for (std::size_t j = i + 1; j < parts_.size(); ++j) {
      const Part &a = parts_[i], &b = parts_[j];
      // The links at the palm are built into one another.
      if (a.finger < 0 || b.finger < 0 || a.finger == b.finger || (a.rank == 0 && b.rank == 0)) {
        continue;
      }
      found_.clear();
      if (a.mesh || b.mesh) {
        find_part_part(a, b);
      } else {
        engines::find_contacts(a.shape, base.X_WB[static_cast<std::size_t>(a.body)] * a.X_BS,
                               b.shape, base.X_WB[static_cast<std::size_t>(b.body)] * b.X_BS,
                               margin(a.body, b.body), found_);
      }
      for (const engines::ConvexContact& at : found_) {
        add(a.body, b.body, at.p_W, at.n_W, at.depth, touches);
      }
    }
  }
}

}  // namespace prehend::simulation
