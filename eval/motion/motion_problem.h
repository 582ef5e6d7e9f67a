#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/rigid_transform.h"

namespace prehend::eval {

/// A thing that stands in the robot's way, in its base frame B.
struct MotionObstacle {
  enum class Kind { kBox, kSphere, kCylinder };
  std::string name;
  Kind kind = Kind::kBox;
  geometry::RigidTransform X_BO = geometry::RigidTransform::Identity();
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  // m, full sides of a box
  double radius = 0, length = 0;                   // m; a cylinder lies along z
};

/// One problem: from a start to a goal among obstacles.
struct MotionProblem {
  std::string set, name;                      // "box_panda", "0001"
  std::string group;                          // of the SRDF, that moves
  std::map<std::string, double> start, goal;  // rad or m, by joint
  std::vector<MotionObstacle> obstacles;
};

/// The problems of a folder as MotionBenchMaker writes them (C. Chamzas et al., "MotionBenchMaker:
/// A tool to generate and benchmark motion planning datasets", RA-L 7(2), 2022): SET/sceneN.yaml,
/// MoveIt's PlanningScene, with SET/requestN.yaml, its MotionPlanRequest with a goal for each
/// joint. In the order of their names. Meshes as obstacles are refused.
/// @throws geometry::InputError naming file and line: what is no YAML, lacks a key, has a shape
/// that is not known, numbers that are none; a folder without problems.
std::vector<MotionProblem> read_motion_problems(const std::filesystem::path& folder);

}  // namespace prehend::eval
