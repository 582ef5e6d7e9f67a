#include "prehend/robot/formats/model_check.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/overlap.h"
#include "prehend/robot/formats/shape_mesh.h"
#include "prehend/robot/formats/uniform_inertial.h"
#include "prehend/robot/mesh_shape.h"

namespace prehend::robot::formats {
namespace {

using geometry::RigidTransform;
using Kind = JointDescription::Kind;
using Level = ModelFinding::Level;

bool moves(const JointDescription& joint) {
  return joint.kind == Kind::kRevolute || joint.kind == Kind::kPrismatic;
}

class Checker {
 public:
  Checker(const RobotDescription& robot, const std::filesystem::path& folder)
      : robot_(robot), folder_(folder), meshes_(folder) {}

  std::vector<ModelFinding> run() {
    try {
      tree_order(robot_);
    } catch (const geometry::InputError& error) {
      add(Level::kError, "robot", error.what(), "");
    }
    for (const JointDescription& joint : robot_.joints) {
      if (joint.kind != Kind::kFixed) moved_.insert(joint.child);
      joints_.emplace(joint.name, &joint);
    }
    for (const LinkDescription& link : robot_.links) {
      check_shapes(link);
      check_inertial(link);
    }
    for (const JointDescription& joint : robot_.joints) check_joint(joint);
    check_overlaps();
    return std::move(findings_);
  }

 private:
  void add(Level level, const std::string& place, const std::string& what,
           const std::string& mend) {
    findings_.push_back({level, place, what, mend});
  }

  void check_inertial(const LinkDescription& link) {
    const std::string place = "link '" + link.name + "'";
    if (!link.inertial) {
      if (moved_.count(link.name) != 0) {
        add(Level::kWarning, place, "moves and has no inertia",
            "Give it mass, centre and inertia, as of its shape and density");
      }
      return;
    }
    const Inertial& inertial = *link.inertial;
    if (!(inertial.mass > 0)) {
      return add(moved_.count(link.name) != 0 ? Level::kError : Level::kWarning, place,
                 fmt::format("has a mass of {} kg", inertial.mass),
                 "Give it a mass, or take its inertia away where it never moves");
    }
    constexpr double kHeavy = 200, kLight = 1e-5;  // kg, of a link
    if (inertial.mass > kHeavy || inertial.mass < kLight) {
      add(Level::kWarning, place, fmt::format("weighs {:g} kg", inertial.mass),
          "Look at the unit: is it in grams, or a density of another length?");
    }
    const Eigen::Matrix3d& I = inertial.inertia;
    if (!I.allFinite() || !I.isApprox(I.transpose(), 1e-9)) {
      return add(Level::kError, place, "has an inertia that is not symmetric",
                 "Write the six numbers once more, about the centre of mass");
    }
    const Eigen::Vector3d principal =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(I, Eigen::EigenvaluesOnly).eigenvalues();
    if (!(principal.minCoeff() > 0)) {
      return add(
          Level::kError, place,
          fmt::format("has principal inertias of {:.3g}, {:.3g}, {:.3g} kg m^2, which no body "
                      "has: each is positive",
                      principal[0], principal[1], principal[2]),
          "Compute it from its shape and mass");
    }
    if (principal[2] > (1 + 1e-6) * (principal[0] + principal[1])) {
      add(Level::kError, place,
          fmt::format("has principal inertias of {:.3g}, {:.3g}, {:.3g} kg m^2, which no body has: "
                      "the greatest is more than the sum of the others",
                      principal[0], principal[1], principal[2]),
          "Compute it from its shape and mass");
    }
    // No point of a body is farther from its centre than its shapes reach.
    const auto reach = reach_of(link, inertial.X_LI.translation());
    if (!reach || !(*reach > 0)) return;
    const double gyration = std::sqrt(principal[2] / inertial.mass);
    if (gyration > 1.05 * *reach) {
      add(Level::kWarning, place,
          fmt::format("has an inertia as of mass {:.3g} m from its centre, and no shape that far: "
                      "{:.3g} m",
                      gyration, *reach),
          "Look at the unit (g mm^2 is 1e-9 kg m^2), or about which point it is");
    } else if (gyration < 1e-3 * *reach) {
      add(Level::kWarning, place, "has an inertia a million times less than its shape would have",
          "Look at the unit");
    }
  }

  /// How far the shapes reach from a point of the link; none: unknown.
  std::optional<double> reach_of(const LinkDescription& link, const Eigen::Vector3d& from) const {
    std::optional<double> reach;
    for (const auto* shapes : {&link.collisions, &link.visuals}) {
      for (const Shape& shape : *shapes) {
        const Eigen::Vector3d p = shape.X_LS.inverse() * from;
        double farthest = 0;
        switch (shape.kind) {
          case Shape::Kind::kBox:
            farthest = (p.cwiseAbs() + shape.size / 2).norm();
            break;
          case Shape::Kind::kSphere:
            farthest = p.norm() + shape.radius;
            break;
          case Shape::Kind::kCylinder:
          case Shape::Kind::kCapsule:
            farthest = p.norm() + shape.radius + shape.length / 2 +
                       (shape.kind == Shape::Kind::kCapsule ? shape.radius : 0);
            break;
          case Shape::Kind::kMesh: {
            const auto found = extents_.find(shape.mesh);
            if (found == extents_.end()) continue;
            const Eigen::AlignedBox3d& box = found->second;
            for (int corner = 0; corner < 8; ++corner) {
              const auto type = static_cast<Eigen::AlignedBox3d::CornerType>(corner);
              farthest =
                  std::max(farthest, (box.corner(type).cwiseProduct(shape.scale) - p).norm());
            }
            break;
          }
          default:
            continue;
        }
        reach = std::max(reach.value_or(0), farthest);
      }
    }
    return reach;
  }

  void check_shapes(const LinkDescription& link) {
    const std::string place = "link '" + link.name + "'";
    if (!link.visuals.empty() && link.collisions.empty() && moved_.count(link.name) != 0) {
      add(Level::kWarning, place, "is seen and cannot be touched: it has no collision shape",
          "Give it one; its visual mesh's convex pieces do");
    }
    for (const auto* shapes : {&link.collisions, &link.visuals}) {
      for (const Shape& shape : *shapes) check_shape(shape, place);
    }
  }

  void check_shape(const Shape& shape, const std::string& place) {
    if (has_no_size(shape)) add(Level::kError, place, "has a shape without size", "Give it one");
    if (shape.kind != Shape::Kind::kMesh) return;
    if (shape.scale.prod() < 0) {
      add(Level::kWarning, place, "mirrors the mesh '" + shape.mesh + "': its inside is outside",
          "Make a mesh of the other hand of its own");
    }
    if (shape.scale.prod() == 0) {
      return add(Level::kError, place, "has a mesh of scale 0: '" + shape.mesh + "'", "Mend it");
    }
    if (shape.surface || !looked_.insert(shape.mesh).second) return;
    std::filesystem::path file;
    try {
      file = find_mesh_file(shape.mesh, folder_);
    } catch (const geometry::InputError& problem) {
      return add(Level::kError, place, "has a mesh that is not read: " + problem.problem(),
                 "Name a file in its package, or one by its path");
    }
    std::error_code error;
    if (!std::filesystem::is_regular_file(file, error)) {
      return add(Level::kError, place, "names a mesh that is not there: '" + shape.mesh + "'",
                 "Looked for " + file.string() + "; set ROS_PACKAGE_PATH, or mend the name");
    }
    try {
      const Eigen::AlignedBox3d box = geometry::bounds(meshes_.read(shape.mesh));
      extents_[shape.mesh] = box;
      const double extent = box.diagonal().cwiseProduct(shape.scale).norm();
      constexpr double kLong = 5, kShort = 5e-4;  // m, of a link's mesh
      if (extent > kLong || extent < kShort) {
        add(Level::kError, place, fmt::format("has a mesh {:.3g} m long: '{}'", extent, shape.mesh),
            extent > kLong ? "It looks like millimetres: scale=\"0.001 0.001 0.001\""
                           : "It was scaled twice, or is in kilometres");
      }
    } catch (const std::exception& problem) {
      add(Level::kWarning, place, std::string("has a mesh that is not read: ") + problem.what(),
          "Convert it to STL, OBJ, PLY or COLLADA");
    }
  }

  void check_overlaps() {
    try {
      std::vector<std::string> remarks;
      constexpr double kLeast = 1e-3;  // m
      for (const LinkOverlap& one : overlaps_at_rest(robot_, meshes_, kLeast, &remarks)) {
        add(Level::kWarning, fmt::format("link '{}' and link '{}'", one.first, one.second),
            fmt::format("overlap by {:.1f} mm at rest", 1e3 * one.depth),
            "Allow them to touch (SRDF disable_collisions), or make the shapes smaller");
      }
      for (const std::string& remark : remarks) {
        add(Level::kWarning, "robot", "is looked over for overlaps in part: " + remark,
            "Give it collision shapes of fewer triangles");
      }
    } catch (const geometry::InputError&) {
      // The tree or its couplings are wrong, which is said already.
    }
  }

  const JointDescription* named(const std::string& joint) const {
    const auto found = joints_.find(joint);
    return found == joints_.end() ? nullptr : found->second;
  }

  void check_joint(const JointDescription& joint) {
    const std::string place = "joint '" + joint.name + "'";
    if (joint.follows) {
      const JointDescription* leader = named(joint.follows->joint);
      for (int i = 0; i < kMostLeaders && leader && leader->follows; ++i) {
        leader = named(leader->follows->joint);
      }
      if (!leader) {
        add(Level::kError, place, "follows '" + joint.follows->joint + "', which is not there",
            "Name a joint of this robot");
      } else if (leader->follows) {
        add(Level::kError, place, "follows itself in the end, or over too many joints",
            "Let one of them move by itself");
      }
    }
    if (!moves(joint)) return;
    if (std::abs(joint.axis_J.norm() - 1) > 1e-6) {
      add(Level::kError, place, fmt::format("has an axis of length {:.4g}", joint.axis_J.norm()),
          "Make it a unit vector");
    }
    if (joint.lower && joint.upper) {
      if (*joint.lower > *joint.upper) {
        add(Level::kError, place,
            fmt::format("has limits that are exchanged: {} to {}", *joint.lower, *joint.upper),
            "Exchange them");
      } else if (*joint.lower == *joint.upper) {
        add(Level::kWarning, place, "cannot move: both limits are the same",
            "Make it fixed, or mend a limit");
      }
      const double range = *joint.upper - *joint.lower;
      if (joint.kind == Kind::kRevolute && range > 8 * std::numbers::pi) {
        add(Level::kWarning, place, fmt::format("turns by {:.4g} rad", range),
            "It looks like degrees");
      }
      if (joint.kind == Kind::kPrismatic && range > 10) {
        add(Level::kWarning, place, fmt::format("slides by {:.4g} m", range),
            "It looks like millimetres");
      }
    }
    if (joint.follows) return;
    if (!joint.effort || !(*joint.effort > 0)) {
      add(Level::kWarning, place, "has no effort: nothing moves it in a simulation",
          "Give the greatest torque or force of its motor");
    }
    if (!joint.velocity || !(*joint.velocity > 0)) {
      add(Level::kWarning, place, "has no greatest speed: no trajectory can be timed",
          "Give that of its motor");
    }
  }

  const RobotDescription& robot_;
  const std::filesystem::path folder_;
  ShapeMeshes meshes_;
  std::vector<ModelFinding> findings_;
  std::set<std::string> moved_, looked_;
  std::map<std::string, Eigen::AlignedBox3d> extents_;  // by mesh
  std::map<std::string, const JointDescription*> joints_;
};

}  // namespace

std::vector<ModelFinding> check_model(const RobotDescription& robot,
                                      const std::filesystem::path& folder) {
  return Checker(robot, folder).run();
}

std::vector<std::string> mend_model(RobotDescription& robot, const std::filesystem::path& folder) {
  std::vector<std::string> mended;
  ShapeMeshes meshes(folder);
  for (JointDescription& joint : robot.joints) {
    if (joint.lower && joint.upper && *joint.lower > *joint.upper) {
      std::swap(*joint.lower, *joint.upper);
      mended.push_back("joint '" + joint.name + "': limits exchanged");
    }
    const double length = joint.axis_J.norm();
    if (moves(joint) && std::abs(length - 1) > 1e-12 && length > 1e-9) {
      joint.axis_J /= length;
      mended.push_back("joint '" + joint.name + "': axis made a unit vector");
    }
  }
  for (LinkDescription& link : robot.links) {
    if (!link.inertial) continue;
    Eigen::Matrix3d& I = link.inertial->inertia;
    if (!I.isApprox(I.transpose(), 1e-12)) {
      I = (0.5 * (I + I.transpose())).eval();
      mended.push_back("link '" + link.name + "': inertia made symmetric");
    }
    if (link.inertial->mass == 0) {
      link.inertial.reset();
      mended.push_back("link '" + link.name + "': inertia without mass taken away");
      continue;
    }
    const Eigen::Vector3d principal =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(I, Eigen::EigenvaluesOnly).eigenvalues();
    const bool is_body =
        principal[0] > 0 && principal[2] <= (1 + 1e-6) * (principal[0] + principal[1]);
    if (is_body || !(link.inertial->mass > 0)) continue;
    const auto uniform = uniform_inertial(link, meshes);
    if (!uniform) continue;
    I = uniform->inertia * (link.inertial->mass / uniform->mass);
    link.inertial->X_LI.linear() = uniform->X_LI.linear();
    mended.push_back("link '" + link.name + "': inertia computed from its shape and mass");
  }
  return mended;
}

namespace {

/// Within its limits where they are a range that a joint has, else within those of any.
double random_position(const JointDescription& joint, std::mt19937& random) {
  const double unlimited = joint.kind == Kind::kRevolute ? std::numbers::pi : 1.0;
  double lower = joint.lower.value_or(-unlimited), upper = joint.upper.value_or(unlimited);
  constexpr double kLong = 1e4;  // rad or m
  if (std::abs(lower) > kLong) lower = -unlimited;
  if (std::abs(upper) > kLong) upper = unlimited;
  if (lower > upper) std::swap(lower, upper);
  return std::uniform_real_distribution<double>(lower, upper)(random);
}

}  // namespace

ModelDifference difference(const RobotDescription& first, const RobotDescription& second,
                           int samples) {
  ModelDifference result;
  const auto indices = [](const auto& items) {
    std::map<std::string, std::size_t> by_name;
    for (std::size_t i = 0; i < items.size(); ++i) by_name.emplace(items[i].name, i);
    return by_name;
  };
  const auto first_links = indices(first.links), second_links = indices(second.links);
  const auto first_joints = indices(first.joints), second_joints = indices(second.joints);
  const auto compare_names = [](const auto& items, const auto& others, const char* kind,
                                std::vector<std::string>& only) {
    for (const auto& item : items) {
      if (others.count(item.name) == 0) only.push_back(fmt::format("{} '{}'", kind, item.name));
    }
  };
  compare_names(first.links, second_links, "link", result.only_first);
  compare_names(second.links, first_links, "link", result.only_second);
  compare_names(first.joints, second_joints, "joint", result.only_first);
  compare_names(second.joints, first_joints, "joint", result.only_second);

  std::mt19937 random(1);
  const LinkPoses first_poses(first), second_poses(second);
  for (int sample = 0; sample < samples; ++sample) {
    std::vector<double> at(first.joints.size()), its(second.joints.size());
    for (std::size_t i = 0; i < first.joints.size(); ++i) {
      const JointDescription& joint = first.joints[i];
      if (!moves(joint) || joint.follows) continue;
      at[i] = random_position(joint, random);
      const auto found = second_joints.find(joint.name);
      if (found != second_joints.end()) its[found->second] = at[i];
    }
    const auto one = first_poses.at(at), other = second_poses.at(its);
    for (std::size_t i = 0; i < one.size(); ++i) {
      const auto found = second_links.find(first.links[i].name);
      if (found == second_links.end()) continue;
      const RigidTransform &X = one[i], &Y = other[found->second];
      const double place = (X.translation() - Y.translation()).norm();
      const double turn = Eigen::AngleAxisd(X.linear().transpose() * Y.linear()).angle();
      if (place > result.place || turn > result.turn) result.where = first.links[i].name;
      result.place = std::max(result.place, place);
      result.turn = std::max(result.turn, turn);
    }
  }
  const auto differs = [](double a, double b) {
    return std::abs(a - b) > 1e-9 * std::max({1.0, std::abs(a), std::abs(b)});
  };
  for (const LinkDescription& link : first.links) {
    const auto found = second_links.find(link.name);
    if (found == second_links.end()) continue;
    const LinkDescription* other = &second.links[found->second];
    const double mass = link.inertial ? link.inertial->mass : 0;
    const double its = other->inertial ? other->inertial->mass : 0;
    if (differs(mass, its)) {
      result.others.push_back(fmt::format("link '{}': {:g} kg, {:g} kg", link.name, mass, its));
    }
  }
  for (const JointDescription& joint : first.joints) {
    const auto found = second_joints.find(joint.name);
    if (found == second_joints.end()) continue;
    const JointDescription* other = &second.joints[found->second];
    const auto compare = [&](const char* what, const std::optional<double>& a,
                             const std::optional<double>& b) {
      if (a.has_value() != b.has_value() || (a && differs(*a, *b))) {
        result.others.push_back(fmt::format("joint '{}', {}: {}, {}", joint.name, what,
                                            a ? fmt::format("{:g}", *a) : "none",
                                            b ? fmt::format("{:g}", *b) : "none"));
      }
    };
    compare("lower limit", joint.lower, other->lower);
    compare("upper limit", joint.upper, other->upper);
    // 0 is what URDF has for not known.
    const auto known = [](const std::optional<double>& value) {
      return value && *value != 0 ? value : std::nullopt;
    };
    compare("effort", known(joint.effort), known(other->effort));
    compare("speed", known(joint.velocity), known(other->velocity));
  }
  return result;
}

}  // namespace prehend::robot::formats
