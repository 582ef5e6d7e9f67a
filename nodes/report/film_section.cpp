#include "nodes/report/film_section.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "msgs/convert/geometry.h"
#include "msgs/convert/objects.h"
#include "nodes/report/drawn_model.h"
#include "nodes/report/drawn_robot.h"
#include "nodes/report/true_bodies.h"
#include "prehend/control/hand_sample.h"
#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/report/film.h"
#include "prehend/robot/link_mesh.h"
#include "prehend/robot/placed_links.h"
#include "prehend/surface/simplify.h"

namespace prehend::nodes {
namespace {

using geometry::RigidTransform;
using report::FilmBody;

constexpr double kStep = 0.1;                 // s, between frames, at least
constexpr std::size_t kMostTriangles = 4000;  // of an object
constexpr double kTableSide = 0.9;            // m
constexpr double kTableThick = 0.01;          // m
constexpr geometry::Rgb kTableColor{232, 226, 214};
constexpr geometry::Rgb kTruthColor{200, 60, 90};
constexpr double kTruthOpacity = 0.35;

/// Where the robot was.
struct RobotFrame {
  std::vector<RigidTransform> X_WL;  // of all links
  RigidTransform X_WH = RigidTransform::Identity();
};

std::vector<double> times_of(const Collected& collected, int frames) {
  if (collected.joints.empty() || collected.phases.empty()) {
    throw geometry::InputError("Nothing moved", "Nothing");
  }
  const History& joint = collected.joints.begin()->second;
  const double begin = std::max(joint.front().first, collected.phases.front().first);
  const double end = joint.back().first;
  const int count = std::clamp(1 + static_cast<int>((end - begin) / kStep), 1, frames);
  std::vector<double> times;
  for (int i = 0; i < count; ++i) {
    times.push_back(begin + (count > 1 ? (end - begin) * i / (count - 1) : 0));
  }
  return times;
}

RobotFrame robot_at(const Collected& collected, const robot::Platform& platform,
                    const robot::KinematicChain& chain, double time) {
  control::ArmPercepts percepts;
  for (const auto& [name, history] : collected.joints) {
    percepts.names.push_back(name);
    percepts.positions.push_back(value_at(history, time));
  }
  if (!collected.opening.empty()) {
    percepts.gripper = control::GripperPercept{value_at(collected.opening, time)};
  }
  const auto hand = control::hand_sample(platform, chain, percepts);
  if (!hand) {
    throw geometry::InputError("The joints' states are not those of " + platform.name,
                               "Give the report the platform that moves");
  }
  Eigen::VectorXd arm(chain.size());
  for (int i = 0; i < chain.size(); ++i) {
    arm[i] = value_at(collected.joints.at(chain.joints()[static_cast<std::size_t>(i)].name), time);
  }
  return {robot::placed_link_poses(platform, arm, hand->joints), hand->X_WH};
}

// With few triangles, each vertex resting on what the nearest of the model's does.
surface::ObjectModel coarse(const surface::ObjectModel& model) {
  surface::ObjectModel few;
  few.mesh_W = surface::simplified(model.mesh_W, kMostTriangles).mesh;
  if (model.vertex_origin.empty()) return few;
  const geometry::MeshQuery query(model.mesh_W);
  for (const Eigen::Vector3d& p : few.mesh_W.vertices) {
    const Eigen::Vector3i& corners =
        model.mesh_W.triangles[static_cast<std::size_t>(query.nearest(p)->triangle)];
    const auto distance = [&](int v) {
      return (model.mesh_W.vertices[static_cast<std::size_t>(v)] - p).squaredNorm();
    };
    const int nearest = *std::min_element(corners.begin(), corners.end(),
                                          [&](int a, int b) { return distance(a) < distance(b); });
    few.vertex_origin.push_back(model.vertex_origin[static_cast<std::size_t>(nearest)]);
  }
  return few;
}

double begin_of(const Collected& collected, control::Phase phase, double otherwise) {
  const auto found = std::find_if(collected.phases.begin(), collected.phases.end(),
                                  [phase](const auto& entry) { return entry.second == phase; });
  return found == collected.phases.end() ? otherwise : found->first;
}

/// What of an object's motion since it was seen is known.
class ObjectMotion {
 public:
  ObjectMotion(const Collected& collected, const std::vector<double>& times,
               const std::vector<RobotFrame>& robot)
      : collected_(collected), times_(times), robot_(robot) {}

  std::vector<RigidTransform> of(const msgs::ObjectModel& message,
                                 const std::optional<TrueBody>& body) const {
    if (body) {
      std::vector<RigidTransform> motion;
      const RigidTransform X_BW = body->X_WB.inverse(Eigen::Isometry);
      for (const double time : times_)
        motion.push_back(value_at(body->history->poses, time) * X_BW);
      return motion;
    }
    const bool is_held = collected_.result && collected_.result->object_id() == message.id();
    if (!is_held) return {RigidTransform::Identity()};
    return with_hand();
  }

 private:
  std::vector<RigidTransform> with_hand() const {
    constexpr double kNever = std::numeric_limits<double>::infinity();
    const double lifted = begin_of(collected_, control::Phase::kLift, kNever),
                 released = begin_of(collected_, control::Phase::kRelease, kNever);
    std::vector<RigidTransform> motion;
    RigidTransform X = RigidTransform::Identity();
    std::optional<RigidTransform> X_HW;
    for (std::size_t i = 0; i < times_.size(); ++i) {
      if (times_[i] >= lifted && times_[i] < released) {
        if (!X_HW) X_HW = robot_[i].X_WH.inverse(Eigen::Isometry);
        X = robot_[i].X_WH * *X_HW;
      }
      motion.push_back(X);
    }
    return motion;
  }

  const Collected& collected_;
  const std::vector<double>& times_;
  const std::vector<RobotFrame>& robot_;
};

FilmBody table_of(const msgs::Plane& message, const Eigen::Vector3d& near_W) {
  const geometry::Plane table_W = convert::from_message(message);
  RigidTransform X = RigidTransform::Identity();
  X.linear() =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), table_W.normal).matrix();
  X.translation() = table_W.project(near_W) - 0.5 * kTableThick * table_W.normal;
  return {"table", kTableColor, 1, geometry::make_box({kTableSide, kTableSide, kTableThick}), {X}};
}

void add_robot(const robot::Platform& platform, const std::vector<RobotFrame>& frames,
               std::vector<FilmBody>* bodies) {
  for (std::size_t l = 0; l < platform.model.links.size(); ++l) {
    const robot::Link& link = platform.model.links[l];
    geometry::TriangleMesh mesh = robot::link_mesh(link);
    if (mesh.triangles.empty()) continue;
    const bool is_hand = robot::is_of_hand(link);
    FilmBody body{
        is_hand ? "hand" : "arm", is_hand ? kHandColor : kArmColor, 1, std::move(mesh), {}};
    for (const RobotFrame& frame : frames) body.X_WB.push_back(frame.X_WL[l]);
    bodies->push_back(std::move(body));
  }
}

}  // namespace

void add_film(report::Page& page, const Collected& collected, const robot::Platform& platform,
              int frames) {
  report::Film film;
  film.times = times_of(collected, frames);
  const robot::KinematicChain chain = platform.arm_chain();
  std::vector<RobotFrame> robot;
  for (const double time : film.times) {
    robot.push_back(robot_at(collected, platform, chain, time));
    film.captions.emplace_back(control::to_string(value_at(collected.phases, time)));
  }
  const ObjectMotion motion(collected, film.times, robot);
  for (const auto& [id, message] : collected.models) {
    if (!message.valid()) continue;
    const surface::ObjectModel model = coarse(convert::from_message(message));
    const Eigen::Vector3d middle_W = geometry::bounds(model.mesh_W).center();
    const std::optional<TrueBody> body = true_body(collected, message, model);
    const std::vector<RigidTransform> moved = motion.of(message, body);
    for (report::ColoredMesh& part : by_origin(model)) {
      if (part.mesh_W.triangles.empty()) continue;
      film.bodies.push_back(
          {fmt::format("object {}", id), part.color, 1, std::move(part.mesh_W), moved});
    }
    if (const auto mesh_B = body ? true_mesh(collected, body->name) : std::nullopt) {
      FilmBody truth{"true shapes",
                     kTruthColor,
                     kTruthOpacity,
                     surface::simplified(*mesh_B, kMostTriangles).mesh,
                     {}};
      for (const double time : film.times)
        truth.X_WB.push_back(value_at(body->history->poses, time));
      film.bodies.push_back(std::move(truth));
    }
    const bool has_table = std::any_of(film.bodies.begin(), film.bodies.end(),
                                       [](const auto& one) { return one.name == "table"; });
    if (!has_table) film.bodies.push_back(table_of(message.table(), middle_W));
  }
  add_robot(platform, robot, &film.bodies);
  page.add_film(
      film,
      "What the robot did with what it predicted: drag to turn it, wheel or two fingers to "
      "come near. Blue was seen, orange is mirrored, grey a guess, green touched; links "
      "are drawn by their collision shapes.");
}

}  // namespace prehend::nodes
