#include "eval/motion/motion_problem.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "prehend/geometry/errors.h"

namespace prehend::eval {
namespace {

namespace fs = std::filesystem;
using geometry::InputError;

/// A file of the benchmark; its errors name the line.
class ProblemFile {
 public:
  explicit ProblemFile(const fs::path& file) : file_(file) {
    try {
      root_ = YAML::LoadFile(file.string());
    } catch (const YAML::Exception& error) {
      throw InputError(fmt::format("{}:{}: {}", file.string(), error.mark.line + 1, error.msg),
                       "Give a problem as MotionBenchMaker writes it");
    }
  }

  const YAML::Node& root() const { return root_; }

  [[noreturn]] void fail(const YAML::Node& at, const std::string& what) const {
    throw InputError(fmt::format("{}:{}: {}", file_.string(), at.Mark().line + 1, what),
                     "Give a problem as MotionBenchMaker writes it");
  }
  YAML::Node of(const YAML::Node& node, const char* key) const {
    if (!node.IsMap() || !node[key]) fail(node, std::string("has no '") + key + "'");
    return node[key];
  }
  double number(const YAML::Node& node) const {
    double value = NAN;
    if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || !std::isfinite(value)) {
      fail(node, "is no number");
    }
    return value;
  }
  std::vector<double> numbers(const YAML::Node& node, std::size_t count) const {
    if (!node.IsSequence() || node.size() != count) {
      fail(node, fmt::format("must be {} numbers", count));
    }
    std::vector<double> values;
    for (const YAML::Node& one : node) values.push_back(number(one));
    return values;
  }
  std::string word(const YAML::Node& node) const {
    if (!node.IsScalar()) fail(node, "is no text");
    return node.Scalar();
  }

 private:
  fs::path file_;
  YAML::Node root_;
};

geometry::RigidTransform pose_of(const ProblemFile& file, const YAML::Node& node) {
  const auto p = file.numbers(file.of(node, "position"), 3);
  const auto q = file.numbers(file.of(node, "orientation"), 4);  // x, y, z, w
  const Eigen::Quaterniond turn(q[3], q[0], q[1], q[2]);
  if (!(std::abs(turn.norm() - 1) < 1e-3)) file.fail(node, "has no unit quaternion");
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.linear() = turn.normalized().toRotationMatrix();
  X.translation() = Eigen::Vector3d(p[0], p[1], p[2]);
  return X;
}

MotionObstacle obstacle_of(const ProblemFile& file, const YAML::Node& shape,
                           const YAML::Node& pose) {
  MotionObstacle obstacle;
  const std::string type = file.word(file.of(shape, "type"));
  const YAML::Node sizes = file.of(shape, "dimensions");
  if (type == "box") {
    const auto sides = file.numbers(sizes, 3);
    obstacle.size = Eigen::Vector3d(sides[0], sides[1], sides[2]);
  } else if (type == "sphere") {
    obstacle.kind = MotionObstacle::Kind::kSphere;
    obstacle.radius = file.numbers(sizes, 1)[0];
  } else if (type == "cylinder") {
    obstacle.kind = MotionObstacle::Kind::kCylinder;
    const auto both = file.numbers(sizes, 2);
    obstacle.length = both[0];
    obstacle.radius = both[1];
  } else {
    file.fail(shape, "has the shape '" + type + "', which is not known: box, sphere, cylinder are");
  }
  const bool has_size = obstacle.kind == MotionObstacle::Kind::kBox ? obstacle.size.minCoeff() > 0
                        : obstacle.kind == MotionObstacle::Kind::kSphere
                            ? obstacle.radius > 0
                            : obstacle.radius > 0 && obstacle.length > 0;
  if (!has_size) file.fail(sizes, "must be above 0");
  obstacle.X_BO = pose_of(file, pose);
  return obstacle;
}

std::vector<MotionObstacle> obstacles_of(const ProblemFile& file) {
  std::vector<MotionObstacle> obstacles;
  for (const YAML::Node& one : file.of(file.of(file.root(), "world"), "collision_objects")) {
    const std::string name = file.word(file.of(one, "id"));
    if (one["meshes"] && one["meshes"].size() > 0) {
      file.fail(one, "'" + name + "' is a mesh, which is not read");
    }
    const YAML::Node shapes = file.of(one, "primitives"), poses = file.of(one, "primitive_poses");
    if (!shapes.IsSequence() || shapes.size() != poses.size()) {
      file.fail(one, "'" + name + "' needs a pose for each primitive");
    }
    const auto X_BObject =
        one["pose"] ? pose_of(file, one["pose"]) : geometry::RigidTransform::Identity();
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      MotionObstacle obstacle = obstacle_of(file, shapes[i], poses[i]);
      obstacle.name = name;
      obstacle.X_BO = X_BObject * obstacle.X_BO;
      obstacles.push_back(std::move(obstacle));
    }
  }
  return obstacles;
}

void add_request(const ProblemFile& file, MotionProblem& problem) {
  problem.group = file.word(file.of(file.root(), "group_name"));
  const YAML::Node state = file.of(file.of(file.root(), "start_state"), "joint_state");
  const YAML::Node names = file.of(state, "name"), positions = file.of(state, "position");
  if (!names.IsSequence() || names.size() != positions.size()) {
    file.fail(state, "needs a position for each joint");
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    problem.start[file.word(names[i])] = file.number(positions[i]);
  }
  const YAML::Node goals = file.of(file.root(), "goal_constraints");
  if (!goals.IsSequence() || goals.size() != 1) file.fail(goals, "must be one goal");
  for (const YAML::Node& one : file.of(goals[0], "joint_constraints")) {
    problem.goal[file.word(file.of(one, "joint_name"))] = file.number(file.of(one, "position"));
  }
}

}  // namespace

std::vector<MotionProblem> read_motion_problems(const fs::path& folder) {
  constexpr std::string_view kScene = "scene", kRequest = "request", kEnding = ".yaml";
  std::vector<fs::path> scenes;
  std::error_code error;
  for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end;
       at.increment(error)) {
    const std::string name = at->path().filename().string();
    if (name.starts_with(kScene) && name.ends_with(kEnding)) scenes.push_back(at->path());
  }
  if (error || scenes.empty()) {
    throw InputError("'" + folder.string() + "' has no problems",
                     "Name a folder with sceneN.yaml and requestN.yaml in it or below");
  }
  std::sort(scenes.begin(), scenes.end());
  std::vector<MotionProblem> problems;
  for (const fs::path& scene : scenes) {
    const std::string stem = scene.stem().string();
    MotionProblem problem;
    problem.set = scene.parent_path().filename().string();
    problem.name = stem.substr(kScene.size());
    problem.obstacles = obstacles_of(ProblemFile(scene));
    add_request(ProblemFile(scene.parent_path() /
                            (std::string(kRequest) + problem.name + std::string(kEnding))),
                problem);
    problems.push_back(std::move(problem));
  }
  return problems;
}

}  // namespace prehend::eval
