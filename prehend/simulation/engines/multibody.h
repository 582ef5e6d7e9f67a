#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "prehend/contact/texel.h"
#include "prehend/simulation/engines/convex_contact.h"
#include "prehend/simulation/engines/engine.h"
#include "prehend/simulation/engines/multibody_joints.h"
#include "prehend/simulation/engines/pad_on_body.h"
#include "prehend/simulation/engines/twist_rows.h"

namespace prehend::simulation::engines {

/// A point where two bodies touch, or nearly.
struct TouchPoint {
  int a = 0, b = -1;                                           // bodies; b -1: the ground
  ConvexContact at;                                            // at the step's start
  Eigen::Vector3d p_A = Eigen::Vector3d::Zero();               // m, in A: by this it is known again
  Eigen::Vector3d bristle_at_start = Eigen::Vector3d::Zero();  // m, world, in the tangent plane
  Eigen::Vector3d bristle = Eigen::Vector3d::Zero();           // m, at the step's end
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();              // rad, of the bristle in the step
  double normal_force = 0;                                     // N, in the step
  /// Depth [m] at which the spring begins: what is found beyond the depth that the pair had by its
  /// velocities, because bodies turn within a step or stood in one another at the start. So springs
  /// give no energy back that they never took; bodies part at kPushOut.
  double unborne = 0;
  double foreseen = 0;  // m, depth at the step's end by the velocities there
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // N, world, on A in the step
};

/// What a pad does to a body that it feels, in a step.
struct PadLoad {
  bool is_near = false;                           // else all is zero
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  // m, P's origin
  Vector6 wrench_W = Vector6::Zero();             // on the body, about p_W
  double normal_force = 0;                        // N, sum over texels
};

struct MultibodyState {
  double time = 0;  // s
  /// Of all bodies, and momenta about their centres of mass [kg m/s, kg m^2/s].
  std::vector<geometry::RigidTransform> X_WB;
  std::vector<Vector6> momenta;
  Eigen::VectorXd positions;   // of joints that follow none [m, rad]
  Eigen::VectorXd velocities;  // generalised: joints that follow none, then 6 of each free body
  std::vector<TouchPoint> touches;
  // Of pad_touches().
  std::vector<contact::PadState> pads;
  std::vector<PadLoad> pad_loads;
};

class Multibody;

/// Finds where bodies touch in place of Multibody, for shapes that engines do not know.
class TouchFinder {
 public:
  virtual ~TouchFinder() = default;
  /// Appends a, b, at and p_A of all touches at `base` and of gaps that may close within `h` [s] by
  /// the velocities `u`; touches of one pair of bodies in one run. Bodies that are neither free nor
  /// on joints may touch each other: their force is told and moves nothing.
  virtual void find(const Multibody& system, const MultibodyState& base, double h,
                    const Eigen::VectorXd& u, std::vector<TouchPoint>& touches) = 0;
};

/// Bodies, chains of joints, contacts and pads in generalised coordinates, coupled implicitly.
///
/// A step of length h finds velocities u at its end from d'Alembert's principle over the step,
///   sum_b J_b' [M_b J_b u - momentum_b - h wrench_b(u)] = h tau,
/// with the bodies' Jacobians J_b and inertias at the end: momenta stand for inertial forces, so
/// that Coriolis terms need no formula and a free body's linear and angular momentum is kept to
/// rounding. Contacts and pads enter wrench_b as affine functions of u (contact/texel.h), which
/// makes the matrix symmetric and positive definite for every h; it is solved directly (Cholesky),
/// so the ratio of masses does not matter. Configuration and linearisation are renewed until u
/// settles. Joints may have stops, friction, drives and clutches (multibody_joints.h), all part of
/// the same implicit step. Bodies that are fixed may be moved along prescribed paths. A step
/// allocates nothing once its buffers have grown.
///
/// Contacts are springs as stiff as kSink says, critically damped for the heaviest body, with
/// elasto-plastic bristles and return map; gaps that may close within a step are looked at ahead
/// (see contact::linearise).
class Multibody {
 public:
  /// How far its weight presses the scene's heaviest body into another [m], on one point. The same
  /// stiffness for all pairs: light bodies bear heavy ones.
  static constexpr double kSink = 1e-5;
  static constexpr double kPushOut = 0.1;    // m/s
  static constexpr double kSurprise = 1e-4;  // m, of depth that springs bear all the same
  static constexpr int kMostIterations = 30;
  static constexpr double kTolerance = 1e-10;  // m/s, of any body's surface

  /// @pre validate(scene).
  explicit Multibody(const EngineScene& scene);

  MultibodyState initial_state() const;
  /// One step of backward Euler from `base` (whose momenta and bristles count, not its velocities)
  /// to `end`, at first guessed to have the velocities of `guess`.
  void implicit_euler(const MultibodyState& base, double h, const MultibodyState& guess,
                      MultibodyState& end);
  /// y0 + share (y1 - y0), for the stages of SDIRK2 (contact/sdirk.h): configurations, momenta,
  /// bristles. Of the pads' foam nothing is extrapolated.
  void extrapolate(const MultibodyState& y0, const MultibodyState& y1, double share,
                   MultibodyState& out) const;

  /// @throws std::invalid_argument for a value that is not finite, std::out_of_range for an index.
  void set_joint_force(int joint, double force);  // N, N m
  void set_body_wrench(int body, const Vector6& wrench_W);
  /// Of joints that follow none. @throws std::invalid_argument naming the field that is wrong.
  void set_mechanics(int joint, const JointMechanics& mechanics);
  void set_drive(int joint, const JointDrive& drive);
  void add_coupling(const JointCoupling& coupling);
  /// What the drive gave in the last step [N m or N].
  double drive_force(int joint) const { return drive_force_.at(joint); }
  /// All of them, to keep and to give back.
  const std::vector<double>& drive_forces() const { return drive_force_; }
  void set_drive_forces(const std::vector<double>& forces) { drive_force_ = forces; }
  /// In the next step the fixed body moves to X_WB, at constant velocity; later ones leave it
  /// there.
  /// @throws std::invalid_argument for a body that is not fixed or a pose that is not finite.
  void prescribe(int body, const geometry::RigidTransform& X_WB);
  /// A free body that sleeps stays where it is, and others touch it as if it were fixed.
  void set_asleep(int body, bool asleep);
  bool asleep(int body) const { return asleep_.at(body) != 0; }
  /// Another finder than the own one; null: the own. It must outlive its use.
  void set_touch_finder(TouchFinder* finder) { finder_ = finder; }
  /// Of contacts, in place of what kSink says [N/m, N s/m], > 0.
  void set_contact_stiffness(double stiffness, double damping);
  /// The same of free bodies on the ground alone; call it after set_contact_stiffness().
  void set_ground_stiffness(double stiffness, double damping);
  const EngineScene& scene() const { return scene_; }
  /// Of a body by the velocities of the step under way: linear, of the origin, and angular; world.
  Vector6 twist(int body, const Eigen::VectorXd& u) const { return twist_of(body, at_, u); }
  double joint_position(const MultibodyState& state, int joint) const;
  BodyMotion motion(const MultibodyState& state, int body) const;
  /// Kinetic and gravity's [J].
  double energy(const MultibodyState& state) const;
  const std::vector<PadOnBody>& pad_touches() const { return pads_; }
  /// Poses and momenta from positions and velocities, and the poses of free bodies that are there.
  void complete(MultibodyState& state) const;

 private:
  using Matrix6X = Eigen::Matrix<double, 6, Eigen::Dynamic>;
  struct Configuration {
    std::vector<geometry::RigidTransform> X_WB;
    std::vector<Matrix6X> jacobian;  // columns as columns_ says
    std::vector<Vector6> drift;      // what prescribed motion adds to a body's twist
  };
  /// Of two bodies that touch: what one's twist does to the other's wrench.
  struct PairBlock {
    int a, b;
    Matrix6 resistance;
  };

  void place(const Eigen::VectorXd& positions, const std::vector<geometry::RigidTransform>& free,
             Configuration& out) const;
  void advance_free(const MultibodyState& base, double h, const Eigen::VectorXd& u,
                    std::vector<geometry::RigidTransform>& X_WB) const;
  Vector6 twist_of(int body, const Configuration& at, const Eigen::VectorXd& u) const;
  Eigen::Matrix3d inertia_W(int body, const geometry::RigidTransform& X_WB) const;
  void find_touches(const MultibodyState& base, double h, const Eigen::VectorXd& u,
                    MultibodyState& end);
  contact::TexelLaw contact_law(int a, int b) const;
  void match_touches(const MultibodyState& base, double h, MultibodyState& end) const;
  /// Adds an interaction of bodies a and b (-1: the world): force f0 - R (P_a t_a - P_b t_b) on a
  /// and its opposite on b, P rows of 6.
  template <class Rows, class Resistance, class Constant>
  void add(int a, const Rows& rows_a, int b, const Rows& rows_b, const Resistance& resistance,
           const Constant& constant, double h);
  void number_active();
  void clear_blocks();
  void project_blocks();
  void project(int a, const Matrix6& resistance, int b, double factor);
  void begin_rows(const MultibodyState& base, double h, const Eigen::VectorXd& u);
  void add_rows(double h);
  void add_joints(const MultibodyState& base, double h);
  void add_inertia(const MultibodyState& base, double h);
  void add_touch(const MultibodyState& base, TouchPoint& touch, double h, const Eigen::VectorXd& u);
  void add_pad(std::size_t index, const MultibodyState& base, double h, const Eigen::VectorXd& u,
               contact::PadState& state);
  Vector6 pad_twist(std::size_t index, const Eigen::VectorXd& u) const;
  /// How much the velocities of surfaces differ [m/s].
  double surface_change(const Configuration& at, const Eigen::VectorXd& from,
                        const Eigen::VectorXd& to) const;
  void finish(const MultibodyState& base, double h, const Eigen::VectorXd& u, MultibodyState& end);

  EngineScene scene_;
  std::vector<int> joint_of_;              // of each body, -1: none
  std::vector<int> coordinate_;            // of each joint
  std::vector<std::vector<int>> columns_;  // of each body: coordinates that move it
  std::vector<int> free_;                  // first of six coordinates of a free body, -1: none
  std::vector<char> padded_;               // has pads
  std::vector<Eigen::Vector3d> moments_;   // kg m^2
  std::vector<double> reach_;              // m, from the origin to the farthest surface point
  int joint_coordinates_ = 0, size_ = 0;
  std::vector<double> joint_force_, drive_force_;
  std::vector<JointMechanics> mechanics_;
  std::vector<JointDrive> drives_;
  std::vector<JointCoupling> couplings_;
  std::vector<char> prescribed_;  // has a new pose
  std::vector<geometry::RigidTransform> X_WPrescribed_;
  std::vector<char> asleep_;
  TouchFinder* finder_ = nullptr;
  std::vector<Vector6> wrench_;
  std::vector<PadOnBody> pads_;
  contact::TexelLaw law_, ground_law_;  // of contacts, and of free bodies' on the ground, without
                                        // friction

  // Of the step under way.
  mutable Configuration completed_;
  std::vector<Vector6> drift_;  // twists of prescribed bodies
  Configuration at_;
  std::vector<geometry::RigidTransform> free_poses_;
  std::vector<double> travel_;
  std::vector<ConvexContact> found_;
  std::vector<Matrix6> block_;
  std::vector<Vector6> block_force_;
  std::vector<PairBlock> pairs_;
  std::vector<JointRow> rows_;
  std::vector<int> drive_row_;  // of each joint, -1: none
  std::vector<int> active_;     // of each coordinate its place in the system, -1: asleep
  int active_size_ = 0;
  Eigen::VectorXd u_, solved_, positions_;
  std::vector<contact::LinearisedContact> linearised_;
  std::vector<PadOnBody::Place> pad_places_;
  std::vector<char> pad_near_;
  Eigen::MatrixXd matrix_;
  Eigen::VectorXd right_;
};

}  // namespace prehend::simulation::engines
