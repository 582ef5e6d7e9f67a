#include "tools/robot_model/model_figure.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/shape_mesh.h"
#include "prehend/surface/simplify.h"
#include "tools/robot_model/model_words.h"

namespace prehend::tools {
namespace {

using namespace robot::formats;
using geometry::RigidTransform;
using geometry::TriangleMesh;
using report::RobotFigure;

constexpr std::size_t kMostLinks = 2000;
constexpr std::size_t kMostTriangles = 300'000;  // in all: about 6 MB of a page
constexpr std::size_t kFewTriangles = 200;       // that any mesh may keep
constexpr double kThinnest = 1e-4;               // m, side of an inertia's box that is seen

constexpr geometry::Rgb kSeen{190, 190, 196}, kTouched{80, 130, 200}, kInertia{150, 80, 170},
    kWrong{210, 40, 40}, kSensor{30, 150, 80}, kLoop{230, 170, 20};

/// A box as heavy, and as inert about all axes, as a link: half of its sides by its principal
/// inertias. Of inertias that no body has its thinnest side is taken for 0, and it is red.
struct InertiaBox {
  RigidTransform X_LS = RigidTransform::Identity();
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  bool possible = true;
};

InertiaBox inertia_box(const Inertial& inertial) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(
      0.5 * (inertial.inertia + inertial.inertia.transpose()));
  Eigen::Matrix3d axes = solver.eigenvectors();
  if (axes.determinant() < 0) axes.col(0) = -axes.col(0);
  const Eigen::Vector3d principal = solver.eigenvalues();
  InertiaBox box;
  box.X_LS = inertial.X_LI;
  box.X_LS.linear() = inertial.X_LI.linear() * axes;
  box.possible = principal[0] > 0 && principal[2] <= (1 + 1e-6) * (principal[0] + principal[1]);
  for (int k = 0; k < 3; ++k) {
    const double squared = 6 / inertial.mass * (principal.sum() - 2 * principal[k]);
    box.size[k] = std::max(kThinnest, std::sqrt(std::max(0.0, squared)));
  }
  return box;
}

class Drawing {
 public:
  Drawing(const RobotDescription& robot, const std::filesystem::path& folder)
      : robot_(robot), meshes_(folder) {}

  ModelFigure made() {
    const std::vector<std::string> order = tree_order(robot_);
    if (order.size() > kMostLinks) {
      throw geometry::InputError(fmt::format("{} links are more than a page draws", order.size()),
                                 fmt::format("Show a robot of at most {} links", kMostLinks));
    }
    for (const LinkDescription& link : robot_.links) {
      link_at_[link.name] = figure_.links.size();
      figure_.links.push_back({link.name, link_words(link)});
    }
    add_joints();
    for (const LinkDescription& link : robot_.links) add_link(link);
    add_places();
    add_postures();
    thin_out();
    return {std::move(figure_), std::move(remarks_)};
  }

 private:
  static std::string link_words(const LinkDescription& link) {
    return fmt::format("{}; {} shapes seen, {} touched", inertial_words(link), link.visuals.size(),
                       link.collisions.size());
  }

  void add_joints() {
    std::map<std::string, std::size_t> joint_at;
    for (const JointDescription& joint : robot_.joints) {
      joint_at.emplace(joint.name, joint_at.size());
    }
    int still = 0;
    for (const JointDescription& joint : robot_.joints) {
      RobotFigure::Joint one;
      one.name = joint.name;
      one.kind = kind_of(joint.kind);
      still += one.kind == RobotFigure::Joint::Kind::kOther ? 1 : 0;
      one.parent = link_at_.at(joint.parent);
      one.child = link_at_.at(joint.child);
      one.X_PJ = joint.X_PJ;
      one.X_JC = joint.X_JC;
      one.axis_J = joint.axis_J;
      one.lower = joint.lower;
      one.upper = joint.upper;
      one.start = std::max(joint.lower.value_or(0), std::min(0.0, joint.upper.value_or(0)));
      if (joint.follows) follow(one, *joint.follows, joint_at);
      one.words = fmt::format("{} {} {} {} {}", kind_word(joint.kind), limit_words(joint),
                              effort_words(joint), speed_words(joint), drag_words(joint));
      figure_.joints.push_back(std::move(one));
    }
    if (still > 0) {
      remarks_.push_back(
          fmt::format("{} ball, floating or planar joints stand at 0: they have no slider", still));
    }
    if (!robot_.loops.empty()) {
      remarks_.push_back(
          "Sliders move the tree of joints: closed loops do not hold their ends together here");
    }
  }

  static RobotFigure::Joint::Kind kind_of(JointDescription::Kind kind) {
    switch (kind) {
      case JointDescription::Kind::kFixed:
        return RobotFigure::Joint::Kind::kFixed;
      case JointDescription::Kind::kRevolute:
        return RobotFigure::Joint::Kind::kRevolute;
      case JointDescription::Kind::kPrismatic:
        return RobotFigure::Joint::Kind::kPrismatic;
      default:
        return RobotFigure::Joint::Kind::kOther;
    }
  }

  static void follow(RobotFigure::Joint& joint, const Follows& follows,
                     const std::map<std::string, std::size_t>& joint_at) {
    const auto leader = joint_at.find(follows.joint);
    if (leader == joint_at.end()) return;  // check_model() says so
    joint.leader = leader->second;
    joint.coefficients = follows.coefficients;
  }

  void add_link(const LinkDescription& link) {
    const std::size_t at = link_at_.at(link.name);
    for (const Shape& shape : link.visuals) add_shape(at, shape, "seen", kSeen, 1);
    for (const Shape& shape : link.collisions) add_shape(at, shape, "touched", kTouched, 0.5);
    if (link.inertial && link.inertial->mass > 0 && link.inertial->inertia.allFinite()) {
      const InertiaBox box = inertia_box(*link.inertial);
      add({at, add_mesh(geometry::make_box(box.size)), "inertia", box.possible ? kInertia : kWrong,
           0.5, box.X_LS});
    }
  }

  void add_shape(std::size_t link, const Shape& shape, const char* layer, geometry::Rgb color,
                 double opacity) {
    if (shape.color && std::string_view(layer) == "seen") {
      const auto part = [&](int k) {
        return static_cast<std::uint8_t>(
            std::lround(255 * std::clamp((*shape.color)[k], 0.0, 1.0)));
      };
      color = {part(0), part(1), part(2)};
      opacity = std::clamp((*shape.color)[3], 0.05, 1.0);
    }
    try {
      TriangleMesh mesh = meshes_.of(shape);
      if (mesh.triangles.empty()) return;
      add({link, add_mesh(std::move(mesh)), layer, color, opacity, shape.X_LS});
    } catch (const geometry::InputError&) {
      ++not_read_;
    }
  }

  // Sensors, tools and ends of loops, each as a sign of its size.
  void add_places() {
    constexpr double kSign = 0.006;  // m
    for (const Sensor& sensor : robot_.sensors) {
      const auto link = link_at_.find(sensor.link);
      if (link == link_at_.end()) continue;
      const bool has_size = sensor.size.minCoeff() > 0;
      const Eigen::Vector3d size = has_size ? sensor.size : Eigen::Vector3d::Constant(kSign);
      add({link->second, add_mesh(geometry::make_box(size)), "sensors", kSensor, 1, sensor.X_LS});
    }
    for (const Manipulator& one : robot_.manipulators) {
      if (const auto link = link_at_.find(one.tip); link != link_at_.end()) {
        add_triad(link->second, one.X_TipTool);
      }
    }
    for (const Loop& loop : robot_.loops) {
      if (const auto link = link_at_.find(loop.first); link != link_at_.end()) {
        add({link->second, add_mesh(geometry::make_sphere(kSign / 2, 12)), "loops", kLoop, 1,
             loop.X_FirstLoop});
      }
    }
    if (not_read_ > 0) {
      remarks_.push_back(
          fmt::format("{} shapes are not drawn: their meshes are not read", not_read_));
    }
  }

  void add_triad(std::size_t link, const RigidTransform& X_LT) {
    constexpr double kLength = 0.05, kThick = 0.002;  // m
    for (int axis = 0; axis < 3; ++axis) {
      Eigen::Vector3d size = Eigen::Vector3d::Constant(kThick);
      size[axis] = kLength;
      RigidTransform X = X_LT;
      X.translate(Eigen::Vector3d(kLength / 2 * Eigen::Vector3d::Unit(axis)));
      geometry::Rgb color{40, 40, 40};
      color[static_cast<std::size_t>(axis)] = 220;
      add({link, add_mesh(geometry::make_box(size)), "tools", color, 1, X});
    }
  }

  void add_postures() {
    for (const Posture& posture : robot_.postures) {
      RobotFigure::Posture one{posture.name, {}};
      for (std::size_t i = 0; i < robot_.joints.size(); ++i) {
        const auto position = posture.positions.find(robot_.joints[i].name);
        if (position != posture.positions.end()) one.positions.emplace_back(i, position->second);
      }
      if (!one.positions.empty()) figure_.postures.push_back(std::move(one));
    }
  }

  std::size_t add_mesh(TriangleMesh mesh) {
    figure_.meshes.push_back(std::move(mesh));
    return figure_.meshes.size() - 1;
  }
  void add(RobotFigure::Shape shape) { figure_.shapes.push_back(std::move(shape)); }

  // Each mesh keeps its share of the triangles that a page bears.
  void thin_out() {
    std::size_t all = 0;
    for (const TriangleMesh& mesh : figure_.meshes) all += mesh.triangles.size();
    if (all <= kMostTriangles) return;
    std::size_t left = 0;
    for (TriangleMesh& mesh : figure_.meshes) {
      const std::size_t share =
          std::max(kFewTriangles, mesh.triangles.size() * kMostTriangles / all);
      if (mesh.triangles.size() > share) mesh = surface::simplified(mesh, share).mesh;
      left += mesh.triangles.size();
    }
    remarks_.push_back(fmt::format("Meshes are drawn with {} triangles of {}", left, all));
  }

  const RobotDescription& robot_;
  ShapeMeshes meshes_;
  RobotFigure figure_;
  std::vector<std::string> remarks_;
  std::map<std::string, std::size_t> link_at_;
  int not_read_ = 0;
};

}  // namespace

ModelFigure model_figure(const RobotDescription& robot, const std::filesystem::path& folder) {
  return Drawing(robot, folder).made();
}

}  // namespace prehend::tools
