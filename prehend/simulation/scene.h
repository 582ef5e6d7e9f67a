#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/robot/gripper_model.h"
#include "prehend/simulation/physics.h"
#include "prehend/simulation/rigid_body.h"
#include "prehend/simulation/sensors/pad_electronics.h"
#include "prehend/simulation/spindle_drive.h"
#include "prehend/simulation/tactile_sensor.h"
#include "prehend/simulation/texture.h"

namespace prehend::simulation {

/// The carrier of the gripper: axes x, y, z, yaw; kinematic (it does not yield to forces).
struct CarrierModel {
  Eigen::Vector3d minimum{-0.6, -0.6, 0.02};  // m, of the gripper frame's origin in the world
  Eigen::Vector3d maximum{0.6, 0.6, 0.8};     // m
  double max_speed = 0.5;                     // m/s
  double max_acceleration = 1.0;              // m/s^2
  double max_yaw_rate = 1.5;                  // rad/s
  double max_yaw_acceleration = 3.0;          // rad/s^2
  Eigen::Vector3d start{-0.35, 0, 0.45};      // m
  double start_yaw = 0;                       // rad
  /// Angle between the approach direction and straight down [rad]: 0 approaches along -z of the
  /// world, pi/2 along +x (at yaw 0).
  double mounting_tilt = 0;

  bool operator==(const CarrierModel&) const = default;

  /// Pose of the gripper frame at `position` [m] and `yaw` [rad]: R_WG = Rz(yaw) Ry(-tilt) Rx(pi).
  geometry::RigidTransform gripper_pose(const Eigen::Vector3d& position, double yaw) const;
};

struct CameraSetup {
  geometry::StereoCamera camera{{1024, 768, 1100, 1100, 511.5, 383.5}, 0.09};
  Eigen::Vector3d eye{0.54, 0, 0.5};   // m, of the left camera in the world
  Eigen::Vector3d target{0, 0, 0.05};  // m, seen in the image's centre
  double noise = 2.0;                  // grey levels, standard deviation of a pixel's noise
  std::uint32_t seed = 1;
  /// Of a camera that is carried: where it is, in place of `eye` and `target`. No key of a file.
  std::optional<geometry::RigidTransform> carried;

  geometry::RigidTransform X_WC() const {
    return carried ? *carried : geometry::look_at(eye, target);
  }
};

struct Light {
  Eigen::Vector3d direction{0.6, -0.3, 1};  // towards the light, need not be unit
  double ambient = 0.45;                    // 0..1, share of light that comes from everywhere
};

/// The plane z = 0 with a rectangle of visible top around `center`.
struct TableModel {
  double friction = 0.5;
  Eigen::Vector2d center{0, 0};    // m, of the visible top
  Eigen::Vector2d size{1.6, 1.6};  // m
  Texture texture{Texture::Pattern::kWood, {0.62, 0.47, 0.32}, {0.45, 0.32, 0.2}, 0.3, 0.02, 7};
};

/// One object that stands on the table at the start, or lies or leans where `X_WB` says.
struct SceneObject {
  std::string name;
  /// box (size), can, bottle (radius, height), mug (radius, height, wall), spray_bottle (size:
  /// width x, depth y, height z), ball (radius), mesh (file, scale)
  std::string shape = "box";
  Eigen::Vector3d size{0.05, 0.07, 0.12};  // m
  double radius = 0.03;                    // m
  double height = 0.12;                    // m
  double wall = 0.004;                     // m
  std::filesystem::path file;              // of shape mesh, relative to the scene file
  double scale = 1.0;                      // m per unit of the file
  double mass = 0.3;                       // kg
  double friction = 0.7;  // dynamic, between the object and pads; the ratio of the pad's static to
                          // dynamic friction is kept
  double x = 0;           // m
  double y = 0;           // m
  double yaw = 0;         // rad
  /// Of its mesh's frame B, in place of x, y and yaw. YAML: `position` [m] and `orientation`
  /// (quaternion, w first).
  std::optional<geometry::RigidTransform> X_WB;
  Texture texture;

  /// Where frame B is at the start.
  geometry::RigidTransform pose() const;
};

/// What a simulation starts from: config/scenes/*.yaml. Every key of the YAML is a field here, of
/// the same name; missing ones keep the defaults. `physics`, `tactile` and `wrench`, and `drive` of
/// the gripper's file: see hardware_yaml.h.
struct Scene {
  double step = 0.001;    // s
  double gravity = 9.81;  // m/s^2, along -z
  TableModel table;
  PhysicsOptions physics;
  robot::GripperModel gripper;  // YAML: path of config/robots/*.yaml, relative to the scene file
  std::filesystem::path gripper_file;  // where it was read; empty: the default one
  /// YAML: path of a platform of config/robots, relative to the scene file: an arm and a hand in
  /// place of gripper and carrier, for RobotWorld. Empty: none.
  std::filesystem::path robot;
  std::string robot_home = "home";  // of the platform's homes, where the arm stands at the start
  SpindleDriveModel drive = pg70_drive();  // what `gripper` says goes before, see drive_of
  TactileOptions tactile;
  std::optional<WrenchSensorOptions> wrench;  // none: forces as they are
  double start_opening = 0.069;               // m
  CarrierModel carrier;
  CameraSetup camera;
  Light light;
  std::vector<SceneObject> objects;

  std::filesystem::path file;        // where it was read; empty: made in code
  std::map<std::string, int> given;  // keys of the file, "carrier.max_speed", and their lines
};

/// Reads a scene file and the gripper model it names. With a robot the file of the hand's parallel
/// gripper, if it is one, stands in its place: `tactile` and `wrench` are that one's then.
/// @param robot a platform's file that goes before the scene's own `robot`; empty: none
/// @throws geometry::InputError "file:line: what is wrong" with the mend: missing or foreign file,
/// unknown key (with the nearest known one), wrong type, value out of range, two objects of a name.
Scene read_scene(const std::filesystem::path& path, const std::filesystem::path& robot = {});

/// Writes what a scene says of objects, table, camera and light, to be read by read_scene(); meshes
/// by their paths relative to the file's folder. All else stays as it is by default.
/// @throws geometry::InputError for a file that cannot be written.
void write_scene(const std::filesystem::path& path, const Scene& scene, const std::string& remark);

/// Checks every value of a scene made in code. @throws std::invalid_argument naming the field.
void validate(const Scene& scene);

/// What texels feel of `object` exactly, in its own frame B; none for shapes that are meshes.
std::optional<FeltShape> primitive_shape(const SceneObject& object);

/// The mesh of `object` in its own frame B (standing on z = 0, centred, yaw 0).
/// @throws std::invalid_argument for an unknown shape or bad dimensions, geometry::InputError for a
/// bad mesh file.
geometry::TriangleMesh object_mesh(const SceneObject& object);

}  // namespace prehend::simulation
