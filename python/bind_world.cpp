// prehend.World: a robot and objects, simulated step by step.

#include <atomic>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "prehend/robot/hand_model.h"
#include "prehend/simulation/robot_world.h"
#include "python/arrays.h"
#include "python/bound_types.h"

namespace prehend::python {
namespace {

using simulation::RobotWorld;

constexpr int kBlock = 50;  // steps between looks for Ctrl-C

/// A world that one thread at a time may use, as its steps run without the interpreter's lock.
class World {
 public:
  World(RobotWorld world, robot::HandModel hand)
      : world_(std::move(world)), hand_(std::move(hand)) {}

  /// Who has the world.
  class Turn {
   public:
    explicit Turn(World& world) : world_(world) {
      if (world_.busy_.exchange(true)) {
        throw std::runtime_error("another thread is using this World");
      }
    }
    ~Turn() { world_.busy_ = false; }
    Turn(const Turn&) = delete;
    RobotWorld* operator->() const { return &world_.world_; }

   private:
    World& world_;
  };

  void step(int count) {
    if (count < 0) throw py::value_error("count must not be negative");
    const Turn turn(*this);
    for (int done = 0; done < count; done += kBlock) {
      {
        const py::gil_scoped_release release;
        for (int i = done; i < std::min(count, done + kBlock); ++i) turn->step();
      }
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    }
  }
  void run(double seconds) {
    if (!(seconds >= 0) || seconds > 1e6) {
      throw py::value_error(fmt::format("{} s is no time to simulate", seconds));
    }
    step(static_cast<int>(std::lround(seconds / world_.options().step)));
  }

  void move_hand(const Eigen::VectorXd& position, double speed, bool until_contact,
                 const std::optional<Eigen::VectorXd>& effort) {
    simulation::HandCommand command;
    command.position = position;
    command.speed = speed;
    command.until_contact = until_contact;
    if (effort) command.effort = *effort;
    Turn(*this)->move_hand(command);
  }

  void follow(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions) {
    const Turn turn(*this);
    if (times.size() != positions.rows()) {
      throw py::value_error(fmt::format("there are {} times and {} positions; give as many",
                                        times.size(), positions.rows()));
    }
    const robot::KinematicChain& chain = turn->arm().chain();
    simulation::TrajectoryRequest request;
    for (const auto& joint : chain.joints()) request.joints.push_back(joint.name);
    for (Eigen::Index i = 0; i < times.size(); ++i) {
      const Eigen::VectorXd row = positions.row(i);
      request.points.push_back({times[i], {row.begin(), row.end()}, {}, {}});
    }
    turn->follow(request);
  }

  void add_object(const std::string& name, const geometry::TriangleMesh& mesh, double mass,
                  double friction, bool fixed) {
    const Turn turn(*this);
    turn->add_object(name, mesh, mass, fixed, friction);
    // The body's frame is the middle of its mesh; what was raised onto the table is told so.
    X_BM_[name] = Eigen::Translation3d(-geometry::bounds(mesh).center());
  }
  void remove_object(const std::string& name) {
    if (!Turn(*this)->remove_object(name)) {
      throw geometry::InputError("There is no object '" + name + "'", "Add it first");
    }
  }
  py::dict object(const std::string& name) {
    const simulation::RobotBodyReading body = Turn(*this)->body(name);
    py::dict said;
    said["pose"] = Eigen::Matrix4d((body.X_WB * X_BM_.at(name)).matrix());
    said["velocity"] = body.velocity;
    said["angular_velocity"] = body.angular_velocity;
    said["mass"] = body.mass;
    said["height"] = body.height;
    said["touches_table"] = body.touches_table;
    said["touches_robot"] = body.touches_robot;
    return said;
  }

  const robot::HandModel& hand() const { return hand_; }

 private:
  RobotWorld world_;
  robot::HandModel hand_;
  std::map<std::string, geometry::RigidTransform>
      X_BM_;  // of an object's mesh in its body, by name
  std::atomic<bool> busy_{false};
};

using State = std::shared_ptr<const RobotWorld::State>;
struct SavedState {
  State state;
};

simulation::RobotWorldOptions options_of(double step, double gravity, double table_friction) {
  simulation::RobotWorldOptions options;
  options.step = step;
  options.gravity = gravity;
  options.table_friction = table_friction;
  return options;
}

std::unique_ptr<World> world_of_hand(const robot::HandModel& hand, const Eigen::Matrix4d& pose,
                                     const std::string& preshape, double step, double gravity,
                                     double table_friction) {
  return std::make_unique<World>(RobotWorld(hand, read_pose(pose, "pose"), preshape,
                                            options_of(step, gravity, table_friction)),
                                 hand);
}

std::unique_ptr<World> world_of_platform(const Arm& arm, const std::string& home, double step,
                                         double gravity, double table_friction) {
  simulation::Scene scene;
  scene.step = step;
  scene.gravity = gravity;
  scene.table.friction = table_friction;
  return std::make_unique<World>(
      RobotWorld(arm.platform, scene, home, options_of(step, gravity, table_friction)),
      arm.platform.hand);
}

py::dict pad_of(const simulation::HandPadReading& pad) {
  py::array_t<double> force({pad.rows, pad.columns});
  std::copy(pad.force.begin(), pad.force.end(), force.mutable_data());
  py::dict said;
  said["force"] = force;
  said["sum"] = pad.sum;
  return said;
}

}  // namespace

void bind_world(py::module_& m) {
  using Turn = World::Turn;
  py::class_<SavedState>(m, "WorldState", "Of a World, to go back to.");
  py::class_<World>(
      m, "World",
      "A table (z = 0), rigid objects, and a robot, simulated: soft contact with LuGre friction, "
      "pads, motors. A Hand alone is carried; a Platform's arm follows trajectories. The same "
      "calls "
      "give the same states, bit by bit. One thread at a time.")
      .def(py::init(&world_of_hand), py::arg("hand"), py::arg("pose"), py::arg("preshape") = "",
           py::kw_only(), py::arg("step") = 0.001, py::arg("gravity") = 9.81,
           py::arg("table_friction") = 0.5,
           "A hand alone, its root at `pose` (4 x 4), open as `preshape` (its first). step [s], "
           "gravity [m/s^2].")
      .def(py::init(&world_of_platform), py::arg("platform"), py::arg("home") = "home",
           py::kw_only(), py::arg("step") = 0.001, py::arg("gravity") = 9.81,
           py::arg("table_friction") = 0.5, "An arm with its hand, at one of its homes.")
      .def("add_object", &World::add_object, py::arg("name"), py::arg("mesh"), py::arg("mass"),
           py::arg("friction") = 0.7, py::arg("fixed") = false,
           "An object, closed, whose mesh is where it is in the world; it replaces one of that "
           "name. mass [kg]. fixed: nothing "
           "moves it. Raises InputError for a mesh that is no solid.")
      .def("remove_object", &World::remove_object, py::arg("name"))
      .def("step", &World::step, py::arg("count") = 1, "Goes on by so many steps.")
      .def("run", &World::run, py::arg("seconds"), "Goes on for so long, of its own time.")
      .def_property_readonly(
          "time", [](World& w) { return Turn(w)->time(); }, "s.")
      .def_property_readonly("hand", &World::hand)
      .def("object", &World::object, py::arg("name"),
           "A dict: pose (4 x 4, of its mesh as it was added), velocity [m/s], angular_velocity "
           "[rad/s], mass, height of its lowest point [m], touches_table, touches_robot.")
      .def_property_readonly(
          "objects",
          [](World& w) {
            const Turn turn(w);
            std::vector<std::string> names;
            for (std::size_t i = 0; i < turn->body_count(); ++i) {
              names.push_back(turn->body(i).name);
            }
            return names;
          },
          "Their names.")
      .def(
          "move_hand", &World::move_hand, py::arg("position"), py::arg("speed") = 0.3,
          py::arg("until_contact") = false, py::arg("effort") = py::none(),
          "Begins to move the hand's motors to `position` [rad or m], with `speed`, a share of the "
          "greatest. until_contact: presses where it is met by something, with `effort` [N m or N] "
          "of each motor. Raises ValueError for what is beyond limits.")
      .def("stop_hand", [](World& w) { Turn(w)->stop_hand(); })
      .def_property_readonly("motor_names", [](World& w) { return Turn(w)->motor_names(); })
      .def_property_readonly(
          "hand_positions", [](World& w) { return Turn(w)->hand_positions(); },
          "Of the motors [rad or m].")
      .def_property_readonly(
          "hand_moves", [](World& w) { return Turn(w)->hand().moving(); },
          "Whether the last motion has not ended.")
      .def("follow", &World::follow, py::arg("times"), py::arg("positions"),
           "The arm begins to follow a trajectory: times [s], and a row of positions [rad or m] "
           "each, from where it stands. Raises ValueError for what the arm cannot do.")
      .def_property_readonly(
          "arm_positions", [](World& w) { return Eigen::VectorXd(Turn(w)->arm().position()); },
          "rad or m.")
      .def_property_readonly("arm_moves", [](World& w) { return !Turn(w)->arm().is_idle(); })
      .def(
          "carry",
          [](World& w, const Eigen::Matrix4d& pose, double duration) {
            Turn(w)->carry(read_pose(pose, "pose"), duration);
          },
          py::arg("pose"), py::arg("duration"),
          "A hand alone begins to be moved straight to `pose` (4 x 4) in `duration` [s].")
      .def_property_readonly(
          "carried", [](World& w) { return Turn(w)->carried(); }, "Whether it is there.")
      .def_property_readonly(
          "hand_pose", [](World& w) { return Eigen::Matrix4d(Turn(w)->X_WH().matrix()); },
          "4 x 4: the hand's root.")
      .def_property_readonly(
          "joints",
          [](World& w) {
            py::dict all;
            for (const auto& joint : Turn(w)->joints()) {
              all[py::str(joint.name)] =
                  py::make_tuple(joint.position, joint.velocity, joint.effort);
            }
            return all;
          },
          "By name: (position [rad or m], velocity, effort [N m or N]).")
      .def_property_readonly(
          "pads",
          [](World& w) {
            py::dict all;
            for (const auto& pad : Turn(w)->pads()) all[py::str(pad.name)] = pad_of(pad);
            return all;
          },
          "By name: a dict of `force` (rows x columns) and `sum`, newtons.")
      .def_property_readonly(
          "wrist",
          [](World& w) {
            const simulation::ContactWrench wrench = Turn(w)->wrist_wrench();
            return py::make_tuple(wrench.force, wrench.torque);
          },
          "(force [N], torque [N m]) of what touches the hand, in its root's frame.")
      .def(
          "save", [](World& w) { return SavedState{Turn(w)->save()}; },
          "All that a step changes, as a WorldState.")
      .def(
          "restore", [](World& w, const SavedState& saved) { Turn(w)->restore(*saved.state); },
          py::arg("state"),
          "Goes back there. Raises ValueError when objects were added or removed since.");
}

}  // namespace prehend::python
