#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "prehend/contact/grasp_model.h"
#include "prehend/contact/pad_contact.h"
#include "prehend/contact/pad_kernel.h"
#include "prehend/contact/pad_state.h"
#include "prehend/contact/slide_step.h"

namespace prehend::contact {

/// What changes of a grasp: copy it to save it, assign it to restore; steps from equal states are
/// bitwise equal.
struct GraspState {
  double time = 0;                                 // s
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();  // m, centre of mass
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();          // m/s
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  // rad/s, world
  std::vector<double> slide_position, slide_velocity;          // m, m/s
  std::vector<double> slide_bristle;                           // m
  std::vector<double> slide_force;                             // N, of the drive in the last step
  std::vector<PadState> pads;
  std::vector<Eigen::Vector3d> ground_bristles;  // m, world
  std::vector<double> ground_forces;             // N, normal, in the last step

  geometry::RigidTransform X_WB() const {
    geometry::RigidTransform X = geometry::RigidTransform::Identity();
    X.linear() = q_WB.toRotationMatrix();
    X.translation() = p_WB;
    return X;
  }
};

struct SolveOptions {
  /// The linearisation is renewed until velocities change by less than this [m/s, at the pads] ...
  double velocity_tolerance = 1e-9;
  /// ... or this often. Two suffice for stability, more sharpen stick-slip transitions.
  int most_iterations = 6;
  /// Depths are found again at the step's end when turning within the step moves a texel's
  /// penetration by more than this beyond the linear term [m]; infinity: never.
  double geometry_tolerance = 1e-10;
  /// See find_depths and MeshHits.
  bool gated = true;
  bool reuse_triangles = true;
};

/// Equations of motion of a GraspModel and the implicit step. Allocates in the constructor only.
class GraspSystem {
 public:
  /// @throws std::invalid_argument, see validate(GraspModel).
  explicit GraspSystem(GraspModel model, const SolveOptions& options = {});

  const GraspModel& model() const { return model_; }
  GraspState initial_state() const;

  /// Commands hold from now on; SlideCommand::reference counts from `time` [s].
  /// @throws std::invalid_argument for a value that is not finite or a slide that is not there.
  void set_command(int slide, const SlideCommand& command, double time);
  void set_gripper_motion(const GripperMotion& motion);
  const GripperMotion& gripper_motion() const { return motion_; }
  /// Outer wrench on the body about its centre of mass, world [N, N m]. @throws as set_command.
  void set_body_wrench(const Vector6& wrench);

  /// One backward Euler step of `h` [s] from `base` to `end` (which keeps its buffers). `t_end` [s]
  /// is the time at which drives and the gripper's motion are taken; it need not be base.time + h:
  /// the stages of higher-order steps start from extrapolated states. The first linearisation is at
  /// the velocities of `guess`, e.g. `base`. @pre `end` is neither of the others.
  void implicit_euler(const GraspState& base, double h, double t_end, const GraspState& guess,
                      GraspState& end);
  /// The paper's explicit step: forces at the start, then velocities, then positions with them.
  void explicit_euler(const GraspState& base, double h, GraspState& end);

  int last_iterations() const { return iterations_; }
  /// Smallest gap [m] along a ray between a texel and the body, at most `horizon`; 0 when one
  /// touches. Costs a query of all pads that can reach that far.
  double gap(const GraspState& state, double horizon);
  /// Fastest approach of the body and any pad [m/s], a bound.
  double approach_speed(const GraspState& state) const;

  double body_radius() const { return body_radius_; }  // m, of a ball round B that holds the body
  geometry::RigidTransform pad_pose(const GraspState& state, int pad) const;  // X_WP
  /// Kinetic, gravity, normal springs (linear law, and the foam's), bristles of pads and ground
  /// [J].
  double energy(const GraspState& state) const;
  /// Sum of a pad's normal forces in the last step [N].
  double pad_force(const GraspState& state, int pad) const;

 private:
  static constexpr int kMost = 6 + GraspModel::kMostSlides;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMost, kMost>;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMost, 1>;

  struct PadWork {
    explicit PadWork(const PadLayout& layout) : reach(layout), scratch(layout) {}
    PadReach reach;
    PadScratch scratch;
    PadResponse response;
    MeshHits hits, end_hits;  // at the step's start, at its end
    bool near = false;        // some ray meets the body
    PadPlacement place;
  };
  struct GroundWork {
    Eigen::Vector3d arm;  // m, from the centre of mass, world
    double depth = 0;     // m
    double offset = 0, normal = 0, gain = 0, drag = 0, inverse_decay = 0;
  };

  struct Guess {
    Eigen::Vector3d velocity, angular_velocity;
    std::array<double, GraspModel::kMostSlides> slides;
  };
  static Guess guess_from(const GraspState& state);
  Guess guess_from(const Vector& u) const;
  double change(const Guess& a, const Guess& b) const;  // m/s

  double slide_velocity(const PadMount& mount, const Guess& guess) const {
    return mount.slide >= 0 ? guess.slides[mount.slide] : 0.0;
  }
  void place_pads(const GraspState& base, double h, double t_end);
  void find_all_depths(const GraspState& base, double h, const Guess& guess, GraspState& end);
  void correct_depths(const GraspState& base, double h, double t_end, const Guess& guess,
                      GraspState& end);
  bool moves_too_far(double h, double t_end, const Guess& guess) const;
  Vector6 twist_on(std::size_t pad, const Guess& guess, const Eigen::Vector3d& p_WB) const;
  void prepare_ground(const GraspState& base, double h, const Guess& guess);
  void linearise_ground(const GraspState& base, double h, const Guess& guess);
  bool update_saturation(const GraspState& base, double h, double t_end, const Guess& guess,
                         bool first);
  void start_equations(const GraspState& base, double h, const Guess& guess);
  void add_pad(const PadWork& work, int slide, double h, const Eigen::Vector3d& p_WB);
  void add_ground(double h);
  void finish(const GraspState& base, double h, double t_end, const Guess& solved, GraspState& end);
  const Eigen::Vector3d& ground_bristle(std::size_t i) const { return (*base_bristles_)[i]; }

  GraspModel model_;
  SolveOptions options_;
  GripperMotion motion_;
  Vector6 body_wrench_ = Vector6::Zero();
  double body_radius_ = 0;    // m, of a ball round the centre of mass that holds the body
  double ground_radius_ = 0;  // m

  std::vector<PadWork> pad_work_;
  std::vector<PadState> gap_states_;  // of gap()
  std::vector<GroundWork> ground_work_;
  std::vector<SlideStep> slide_work_;
  bool ground_near_ = false;
  const std::vector<Eigen::Vector3d>* base_bristles_ = nullptr;  // of the step under way
  Matrix matrix_;
  Vector right_, solution_;
  int iterations_ = 0;
};

}  // namespace prehend::contact
