#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/image.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::report {

/// A robot to be looked at from all sides in a page, with a slider for each joint
/// (Page::add_robot()).
struct RobotFigure {
  struct Link {
    std::string name;
    std::string words;  // what is told of it when it is chosen
  };
  struct Joint {
    enum class Kind { kFixed, kRevolute, kPrismatic, kOther };  // other: it stands at 0
    std::string name;
    Kind kind = Kind::kFixed;
    std::size_t parent = 0, child = 0;                                     // of `links`
    geometry::RigidTransform X_PJ = geometry::RigidTransform::Identity();  // J at 0, in the parent
    geometry::RigidTransform X_JC = geometry::RigidTransform::Identity();  // the child in J
    Eigen::Vector3d axis_J = Eigen::Vector3d::UnitX();                     // unit
    std::optional<double> lower, upper;                                    // rad or m
    double start = 0;                                                      // rad or m
    std::optional<std::size_t> leader;  // of `joints`: the one that it follows
    /// Of the polynomial of that one's position that it follows by, from the constant on.
    std::vector<double> coefficients;
    std::string words;
  };
  struct Shape {
    std::size_t link = 0, mesh = 0;  // of `links`, `meshes`
    std::string layer;               // shapes of one layer are shown and hidden together
    geometry::Rgb color{200, 200, 200};
    double opacity = 1;  // in (0, 1]
    geometry::RigidTransform X_LS = geometry::RigidTransform::Identity();
  };
  struct Posture {
    std::string name;
    std::vector<std::pair<std::size_t, double>> positions;  // joint, rad or m
  };
  std::vector<Link> links;
  std::vector<Joint> joints;  // a tree, or several
  std::vector<geometry::TriangleMesh> meshes;
  std::vector<Shape> shapes;
  std::vector<Posture> postures;
};

/// The robot as web/src/report reads it, without any '<'. @throws std::invalid_argument without
/// links, for a link, joint or mesh that is not there, joints that make no trees, an opacity out of
/// range, or what is not finite.
std::string robot_figure_json(const RobotFigure& figure);

}  // namespace prehend::report
