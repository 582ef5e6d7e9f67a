#pragma once

#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "prehend/contact/pad_contact.h"
#include "prehend/contact/slide_step.h"
#include "prehend/simulation/contact_point.h"

namespace prehend::simulation {

/// A body's share of the velocity system.
struct SolverBody {
  bool is_free = true;  // false: stands still, whatever pushes it
  double mass = 0;      // kg
  double radius = 0;    // m, of a ball round the centre of mass that holds it
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Identity();  // kg m^2, about the centre of mass, in B
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();
  Eigen::Vector3d center = Eigen::Vector3d::Zero();            // m, centre of mass
  Eigen::Vector3d force = Eigen::Vector3d::Zero();             // N, outer
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();            // N m, outer
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();          // m/s: before, then after the step
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  // rad/s: before, then after
  Eigen::Vector3d velocity_guess = Eigen::Vector3d::Zero();    // m/s, of the step's end
  Eigen::Vector3d angular_velocity_guess = Eigen::Vector3d::Zero();  // rad/s
};

/// The gripper's slide over the step, with the ends of its stroke as stiff stops.
struct SolverSlide {
  contact::SlideStep* step = nullptr;
  double mass = 0;            // kg
  double lower = 0;           // m, stops
  double upper = 0;           // m
  double position = 0;        // m, before the step
  double bristle = 0;         // m, before the step
  double end_time = 0;        // s, at which the drive's command is taken
  double velocity = 0;        // m/s: before, then after
  double velocity_guess = 0;  // m/s, of the step's end
};

/// A pad some of whose rays meet a body.
struct PadContact {
  int body = -1;
  const contact::PadMount* mount = nullptr;
  const contact::PadPlacement* place = nullptr;
  const contact::TexelLaw* law = nullptr;
  contact::PadState* state = nullptr;      // depths and bristles; then forces and bristles
  contact::PadScratch* scratch = nullptr;  //
  contact::PadResponse* response = nullptr;
  contact::Vector6 wrench_W = contact::Vector6::Zero();  // result: on the body, about P's origin
};

/// Advances velocities of bodies and slide over an implicit step under linearised contacts. Bodies
/// that touch one another, and the slide with those that touch the jaws, are one dense symmetric
/// positive definite system each. It is solved until the velocities change by less than a
/// tolerance, at most so often; see SolveOptions. Keeps its buffers: no allocation once they are
/// large enough.
class ContactSolver {
 public:
  ContactSolver(double velocity_tolerance, int most_iterations)
      : tolerance_(velocity_tolerance), most_iterations_(most_iterations) {}

  /// Fills velocities, the contacts' forces and bristles, the pads' states and wrenches.
  void solve(double h, SolverSlide& slide, std::vector<SolverBody>& bodies,
             std::vector<ContactPoint>& contacts, std::vector<PadContact>& pads);

 private:
  using Matrix36 = Eigen::Matrix<double, 3, 6>;

  void find_islands();
  int root(int i);
  void join(int i, int j);
  void solve_island(int root);
  void solve_equations();
  void add_body(int i);
  void add_slide();
  void add_pad(PadContact& pad);
  void add_point(const ContactPoint& contact, const contact::LinearisedContact& line);
  contact::LinearisedContact linearised(const ContactPoint& contact) const;
  Eigen::Vector3d relative_velocity(const ContactPoint& contact) const;
  Eigen::Vector3d point_velocity(int body, const Eigen::Vector3d& point) const;
  contact::Vector6 pad_twist(const PadContact& pad) const;
  double take_solution();  // m/s, the largest change
  void finish_points();
  void finish_pads();

  double tolerance_;
  int most_iterations_;
  double h_ = 0;
  SolverSlide* slide_ = nullptr;
  std::vector<SolverBody>* bodies_ = nullptr;
  std::vector<ContactPoint>* contacts_ = nullptr;
  std::vector<PadContact>* pads_ = nullptr;

  std::vector<int> parent_;     // of each body and, last, of the slide
  std::vector<int> first_row_;  // of each body in the island under way, -1: not in it
  int slide_row_ = -1;
  // Of the island under way.
  std::vector<int> members_, points_, touched_pads_;
  std::vector<contact::LinearisedContact> lines_;
  Eigen::Index size_ = 0;
  std::vector<double> matrix_, right_;  // size_ x size_, size_
};

}  // namespace prehend::simulation
