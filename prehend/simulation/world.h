#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/robot/command_modes.h"
#include "prehend/simulation/carrier.h"
#include "prehend/simulation/scene.h"
#include "prehend/simulation/texture.h"

namespace prehend::simulation {

struct WorldCommand;
struct Explanation;

using robot::GripperMode;
enum class PadSide { kLeft, kRight };  // left is at +y of the gripper frame

struct GripperReading {
  double opening = 0;   // m
  double velocity = 0;  // m/s, of the opening; negative closes
  double current = 0;   // A; negative closes
  bool moving = false;
  bool blocked = false;  // commanded to move but has not for 50 ms
};

struct CarrierReading {
  geometry::RigidTransform X_WG = geometry::RigidTransform::Identity();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // m/s, world
  double yaw_rate = 0;                                 // rad/s
  bool moving = false;
  double remaining = 0;  // m, to the target along the path
  double yaw = 0;        // rad, whole turns counted
};

/// What a pad's electronics would show: `rows` x `columns` counts, row by row, row 0 at the
/// fingertip, column 0 at -x of the gripper frame.
struct TactileImage {
  int rows = 0;
  int columns = 0;
  std::vector<std::uint16_t> counts;  // rows * columns, 0..full scale
  double sum = 0;                     // N, of the forces as the texels feel them, not quantised

  template <class Archive>
  void archive(Archive& archive) {
    archive(rows, columns, same_size(counts), sum);
  }
};

struct ContactWrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   // N
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();  // N m
};

struct BodyReading {
  std::string name;
  geometry::RigidTransform X_WB = geometry::RigidTransform::Identity();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();          // m/s, of the centre of mass
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  // rad/s, world
  double mass = 0;                                             // kg
  double height = 0;  // m, of the lowest point over the table
  bool touches_left_pad = false;
  bool touches_right_pad = false;
  bool touches_table = false;
  bool touches_gripper = false;  // fingers' backs, tips or housing
  bool asleep = false;           // left out of the step until something that moves touches it
};

/// A body as a camera sees it.
struct VisibleBody {
  std::string name;
  std::shared_ptr<const geometry::TriangleMesh> mesh_B;
  geometry::RigidTransform X_WB = geometry::RigidTransform::Identity();
  Texture texture;
  double height = 0;  // m, of the mesh, for the texture
};

/// The simulated world: a table (the plane z = 0), rigid objects with 6 degrees of freedom, a
/// parallel gripper with two tactile pads, and its carrier.
///
/// Pads are those of prehend/contact: each texel casts a ray from `thickness` behind the undeformed
/// face through its centre at boxes, balls and cans as such and at other objects' meshes; depths,
/// law and kernel as in GraspSystem. Where a ray meets several objects each presses the texel.
/// Fingers behind the pads, housing and table touch sampled points of an object's surface, with the
/// same law and stiffer constants. Normal direction: the pad's, the table's, the nearest face's.
///
/// The jaws share a slide (coordinate: minus the opening) that a SpindleDrive moves.
///
/// A step is implicit (contact/texel.h): velocities of all bodies that touch one another, with the
/// slide's, are solved in one symmetric positive definite system, again until friction, sliding
/// speed and active set agree with the solution. Stable for any step. What is left out of a scene,
/// by which rule: ModelRules.
///
/// With `physics.engine` objects and table are another engine's, see WorldEngine.
///
/// Same scene and same calls -> bitwise the same states. Not thread-safe: lock around it.
class World {
 public:
  /// Places objects on the table, opens the gripper. @throws std::invalid_argument (see validate),
  /// geometry::InputError for a bad mesh file.
  explicit World(const Scene& scene);
  ~World();
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;

  /// Advances by scene().step. Cost: 0.5 us, and 2 to 15 us for each object that is awake, held or
  /// not; more where objects touch one another. Allocates nothing once its buffers have grown.
  void step();
  /// Advances by `duration` [s], a whole number of scene().step. With fixed steps the same as that
  /// many step(). With `physics.adaptive` in steps of second order that are as long as can be, at
  /// most 0.1 s: each is taken whole and in halves, and is taken again shorter when the two differ
  /// by more than a tenth of `physics.tolerance` [m] in any point of a body that moves or in the
  /// jaws, down to scene().step / 64; the halves count. A step ends where the carrier's
  /// acceleration changes, where the drive begins to brake (while it speeds up or brakes steps are
  /// at most scene().step), and at the next tactile frame of pads that are not ideal. The carrier's
  /// ramps are exact. Errors against a fine run: tests/simulation/adaptive_test.cpp. The same calls
  /// repeat bitwise; another division of the duration need not.
  /// @throws std::invalid_argument when duration is negative or no such number.
  void advance(double duration);
  /// Advances by at most `steps` times scene().step, as above; ends with the one in or after which
  /// `ends` says so, which is asked after each step that is taken. Returns how many it were.
  std::int64_t advance(std::int64_t steps, const std::function<bool()>& ends);
  double time() const;  // s, number of steps times the step
  const Scene& scene() const;

  /// Drives the opening. kPosition: value [m] within 0..max_opening; kVelocity: [m/s], negative
  /// closes, cut to the model's maximum; kCurrent: [A], negative closes, cut to max_current;
  /// kVoltage: [V], negative closes, cut to the drive's supply, the speed to the model's maximum.
  /// `current_limit` [A]: 0 means nominal; cut to max_current. In kPosition `speed` [m/s] limits
  /// the speed; 0 means the maximum. Acceleration is the model's.
  /// @throws std::invalid_argument for a value that is not finite or an opening out of range.
  void set_gripper_command(GripperMode mode, double value, double current_limit = 0,
                           double speed = 0);

  /// Starts a straight line to `X_WG_target` with trapezoidal speed of at most `speed` [m/s] (yaw
  /// runs along, in time with it). A running motion is braked to a stand first.
  /// @throws std::invalid_argument when speed is not positive, the target is outside the carrier's
  /// limits or turned otherwise than in yaw.
  void move_carrier(const geometry::RigidTransform& X_WG_target, double speed);
  /// Moves with this velocity [m/s, world] and yaw rate [rad/s] from the next step on, until told
  /// otherwise: for whoever steers the carrier step by step (StageArm) and minds its limits of
  /// speed and acceleration. @throws std::invalid_argument when a value is not finite, or the next
  /// step would leave the carrier's limits.
  void drive_carrier(const Eigen::Vector3d& velocity_W, double yaw_rate);
  /// The same along a cubic, for whoever steers in longer pieces, as adaptive steps want them; at
  /// its end it goes on with the velocity there. @throws as drive_carrier(), of the path's end;
  /// when its duration is not positive.
  void guide_carrier(const CarrierPath& path);
  /// Brakes with the carrier's acceleration.
  void stop_carrier();

  GripperReading gripper() const;
  CarrierReading carrier() const;
  /// What the electronics show: of an ideal pad the present forces, else the last frame.
  /// @throws std::logic_error without touch.
  TactileImage tactile_image(PadSide side) const;
  /// False when the scene has rigid pads, without texels.
  bool has_touch() const;
  /// Contact forces of objects and table on the gripper, in gripper frame G, about its origin; the
  /// gripper's own weight is not in it.
  ContactWrench wrist_wrench() const;

  std::size_t body_count() const;
  BodyReading body(std::size_t index) const;
  /// @throws std::invalid_argument when there is no such body.
  BodyReading body(const std::string& name) const;
  /// Kinetic, gravity and contact spring energy of all objects [J]. For tests.
  double energy() const;

  /// Adds an object whose mesh is given in the world frame; its frame B has the world's axes and
  /// the centre of the mesh's bounds as origin. An object of that name is replaced. The mesh is
  /// raised when it reaches below the table, and convexity is not required.
  /// @throws std::invalid_argument when mass is not positive and finite;
  /// geometry::InputError when the mesh is empty, not finite or encloses no volume, or the
  /// engine cannot have it.
  void add_object(const std::string& name, const geometry::TriangleMesh& mesh_W, double mass,
                  bool is_static = false, double friction = 0.7, const Texture& texture = {});
  /// False when there is no such object.
  bool remove_object(const std::string& name);
  /// Puts an object down at a pose, at rest. @throws std::invalid_argument when there is none.
  void place_object(const std::string& name, const geometry::RigidTransform& X_WB);
  /// What of the scene is modelled how and what is left out, now; see explain.h.
  Explanation explained() const;

  /// Counts additions, removals and placements, from 1.
  std::uint64_t scene_generation() const;

  /// All bodies and the gripper's parts as a camera sees them. Cheap: meshes are shared.
  std::vector<VisibleBody> visible_bodies() const;
  /// False: without the gripper, as RobotWorld's.
  void show_robot(bool show);

  /// Everything that changes in a step; restoring it continues bitwise as before. Valid for this
  /// world while no object was added or removed. @throws std::invalid_argument otherwise;
  /// std::logic_error with a plug-in engine, as all saving and restoring.
  struct State;
  std::shared_ptr<const State> save() const;
  void restore(const State& state);

  /// The same as bytes and as a file, for a world of the same scene in this program or another:
  /// same physics, gripper and objects, added and removed in the same order. The format is
  /// prehend's own: version, length and checksum; little-endian. Continues bitwise on processors
  /// with the same vector registers (contact::vector_target()).
  std::string save_bytes() const;
  /// @throws geometry::InputError naming `what` and the mend when the bytes are foreign, of another
  /// version or scene, cut off or damaged; the world is then as it was.
  void restore_bytes(std::string_view bytes, const std::string& what = "the saved state");
  /// @throws geometry::InputError when the file cannot be written; it is there whole or not at all.
  void save_file(const std::filesystem::path& file) const;
  /// @throws as restore_bytes, and when the file cannot be read.
  void restore_file(const std::filesystem::path& file);

  std::int64_t step_count() const;
  /// Keeps what is asked of this world from now on (true: anew), see world_commands.h.
  void record_commands(bool on);
  const std::vector<WorldCommand>& recorded_commands() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace prehend::simulation
