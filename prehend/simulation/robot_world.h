#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/robot/platform.h"
#include "prehend/simulation/arm_drive.h"
#include "prehend/simulation/hand_drive.h"
#include "prehend/simulation/robot_touch.h"
#include "prehend/simulation/scene.h"
#include "prehend/simulation/world.h"

namespace prehend::simulation {

struct RobotWorldOptions {
  double step = 0.001;    // s
  double gravity = 9.81;  // m/s^2, along -z
  double table_friction = 0.5;
  /// Of a touching point [N/m, N s/m]: rubber of a few millimetres, 0.1 mm for 2 N.
  double contact_stiffness = 2e4;
  double contact_damping = 60;
  /// The same between objects and the table, hard on hard as World's: 0.1 mm for 10 N. On rubber,
  /// what stands with its weight near its edge falls over.
  double table_stiffness = 1e5;
  double table_damping = 200;
  HandMechanics mechanics;
  HandDriveOptions hand;
  ArmDriveOptions arm;
  /// Objects that nothing moves are left out until something that moves touches them. Error: what
  /// they would still have settled, measured below 1e-6 m.
  bool sleep = true;
  /// Boxes, balls and cans of the scene are met as what they are, see ModelRules::primitives.
  bool primitives = true;
  TactileOptions tactile;                     // the pads' electronics
  std::optional<WrenchSensorOptions> wrench;  // none: forces as they are
};

/// A moving joint of hand or arm.
struct JointReading {
  std::string name;
  double position = 0;  // rad or m
  double velocity = 0;  // rad/s or m/s
  double effort = 0;    // N m or N, of its motor; 0 for the arm and for joints that follow
};

/// What presses on a link.
struct LinkContact {
  std::string link;
  int points = 0;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // N, on the link, world
  double normal_force = 0;                          // N, sum over points
};

/// What a hand's pad feels: the points that press on its face, each on the texel below it.
struct HandPadReading {
  std::string name;
  int rows = 0, columns = 0;  // a mesh's cells are one row
  std::vector<double> force;  // N, rows * columns; of cells left out 0
  double sum = 0;             // N
  /// What its electronics show, rows * columns: of an ideal pad the present forces, else the last
  /// frame.
  std::vector<std::uint16_t> counts;
};

struct RobotBodyReading {
  std::string name;
  geometry::RigidTransform X_WB = geometry::RigidTransform::Identity();  // of its mesh
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();                    // m/s, centre of mass
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();            // rad/s, world
  double mass = 0;                                                       // kg
  double height = 0;  // m, of the lowest point over the table
  bool touches_table = false, touches_robot = false;
  bool asleep = false;
};

/// A table (z = 0), rigid objects, and a robot: an arm with a hand, or a hand alone that a carrier
/// moves. Engine: engines::Multibody, one implicit step for fingers, objects and contacts.
///
/// The arm and the palm are kinematic: they follow trajectories within limits and do not yield
/// (ArmDrive says why). Fingers are driven through their gears with limited effort, give way by
/// their loops' stiffness, and break away where the hand's file says so. Contacts: RobotTouch.
///
/// Same scene and same calls -> bitwise the same states. Not thread-safe.
class RobotWorld {
 public:
  /// Arm and hand at the home position `home`, the hand open as its first preshape. Objects of
  /// `scene`, its table's friction, gravity, step, `tactile`, `wrench`, rules.sleep and
  /// rules.primitives count; for the others see check_for_robot.
  /// @throws geometry::InputError for a robot that cannot be simulated (make_robot_bodies), an
  /// object's mesh that is not a solid, or what check_for_robot refuses, std::invalid_argument for
  /// options out of range.
  RobotWorld(const robot::Platform& platform, const Scene& scene, const std::string& home = "home",
             const RobotWorldOptions& options = {});
  /// A hand alone, its root frame H at X_WH, without objects; open as `preshape` (empty: its
  /// first).
  RobotWorld(const robot::HandModel& hand, const geometry::RigidTransform& X_WH,
             const std::string& preshape = "", const RobotWorldOptions& options = {});
  ~RobotWorld();
  RobotWorld(RobotWorld&&) noexcept;
  RobotWorld& operator=(RobotWorld&&) noexcept;

  /// Advances by options().step.
  void step();
  double time() const;  // s
  const RobotWorldOptions& options() const;
  const robot::HandModel& hand_model() const;
  bool has_arm() const;

  // The arm. @throws std::logic_error without one.
  ArmDrive& arm();
  const ArmDrive& arm() const;
  /// Checks and starts. @throws std::invalid_argument (check_trajectory).
  void follow(const TrajectoryRequest& request, const std::vector<double>& tolerance = {});
  /// Stops the arm when the wrist's contact force exceeds `force` [N] for 5 ms; 0: not.
  void stop_on_contact(double force);
  bool stopped_by_contact() const;

  // The carrier of a hand alone: straight to X_WH in `duration` [s] (at least one step), smoothly.
  void carry(const geometry::RigidTransform& X_WH, double duration);
  bool carried() const;  // it is there
  /// Sets the hand's root at once, at rest with all that hangs on it, before anything touches.
  void set_carrier(const geometry::RigidTransform& X_WH);

  // The hand: positions of its motors.
  const std::vector<std::string>& motor_names() const;
  HandDrive& hand();
  const HandDrive& hand() const;
  Eigen::VectorXd hand_positions() const;
  /// @throws std::invalid_argument (HandDrive::move).
  void move_hand(const HandCommand& command);
  /// @throws std::invalid_argument (HandDrive::command).
  void command_hand(const MotorsCommand& command);
  /// HandDrive::stop_commanded().
  bool stop_commanded_hand();
  void stop_hand();
  /// Sets motors at once, at rest and couplings unbroken, before anything touches.
  /// @throws std::invalid_argument for another number of values or one that is not finite.
  void set_hand(const Eigen::VectorXd& positions);

  // Readings.
  std::vector<JointReading> joints() const;
  std::vector<LinkContact> link_contacts() const;  // of links that something presses on
  std::vector<HandPadReading> pads() const;
  /// Contact forces on the hand, in frame H, about its origin; its own weight is not in it.
  ContactWrench wrist_wrench() const;
  geometry::RigidTransform X_WH() const;
  std::size_t body_count() const;
  RobotBodyReading body(std::size_t index) const;
  /// @throws std::invalid_argument when there is no such object.
  RobotBodyReading body(const std::string& name) const;
  /// Objects and the robot; without the latter after show_robot(false), as a camera's driver has it
  /// that masks the robot's own links.
  std::vector<VisibleBody> visible_bodies() const;
  void show_robot(bool show);
  /// Where the robot presses on an object, in the last step.
  struct ObjectTouch {
    Eigen::Vector3d p_W = Eigen::Vector3d::Zero();    // m
    Eigen::Vector3d force = Eigen::Vector3d::Zero();  // N, on the object
    std::string link;
    int finger = -1;  // of the hand; -1: palm or arm
  };
  std::vector<ObjectTouch> object_touches(const std::string& name) const;

  /// As World's. Contacts are found anew after it, without their bristles.
  void add_object(const std::string& name, const geometry::TriangleMesh& mesh_W, double mass,
                  bool is_static = false, double friction = 0.7, const Texture& texture = {});
  bool remove_object(const std::string& name);
  void place_object(const std::string& name, const geometry::RigidTransform& X_WB);
  std::uint64_t scene_generation() const;
  /// What is modelled how and what is left out, now; see explain.h.
  Explanation explained() const;

  /// Everything that changes in a step; for this world while no object was added or removed.
  struct State;
  std::shared_ptr<const State> save() const;
  /// @throws std::invalid_argument when objects were added or removed since.
  void restore(const State& state);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace prehend::simulation
