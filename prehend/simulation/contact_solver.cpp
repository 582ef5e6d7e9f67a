#include "prehend/simulation/contact_solver.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

namespace prehend::simulation {
namespace {

constexpr int kLeastIterations = 2;
constexpr int kMostIterations = 6;

using Matrix36 = Eigen::Matrix<double, 3, 6>;

// Velocity of the point r from the centre of mass, as a matrix on (v, w): [1, -[r]x].
Matrix36 point_jacobian(const Eigen::Vector3d& r) {
  Matrix36 jacobian;
  jacobian << 1, 0, 0, 0, r.z(), -r.y(),  //
      0, 1, 0, -r.z(), 0, r.x(),          //
      0, 0, 1, r.y(), -r.x(), 0;
  return jacobian;
}

class Islands {
 public:
  explicit Islands(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int root(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  // The smaller index becomes the root, so that the result does not depend on the order.
  void join(int i, int j) {
    const int a = root(i), b = root(j);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<int> parent_;
};

class VelocitySolver {
 public:
  VelocitySolver(double h, const GripperDrive& drive, std::vector<SolverBody>& bodies,
                 double jaw_velocity)
      : h_(h),
        drive_(drive),
        bodies_(bodies),
        jaw_start_(jaw_velocity),
        jaw_end_(jaw_velocity),
        first_row_(bodies.size(), -1),
        saturation_(drive.last_saturation()) {
    for (const SolverBody& body : bodies) {
      Eigen::Matrix<double, 6, 1> u;
      u << body.velocity, body.angular_velocity;
      start_.push_back(u);
    }
    end_ = start_;
  }

  double jaw_velocity() const { return jaw_end_; }

  void solve_island(const std::vector<int>& members, bool with_jaws,
                    const std::vector<ContactPoint*>& contacts) {
    int size = 0;
    for (const int i : members) {
      first_row_[i] = size;
      size += 6;
    }
    jaw_row_ = with_jaws ? size++ : -1;
    lines_.assign(contacts.size(), {});
    update_guesses(contacts);
    for (int iteration = 0; iteration < kMostIterations; ++iteration) {
      matrix_.setZero(size, size);
      right_.setZero(size);
      for (const int i : members) add_body(i);
      if (with_jaws) add_drive();
      for (std::size_t c = 0; c < contacts.size(); ++c) add_contact(*contacts[c], lines_[c]);
      solution_ = matrix_.llt().solve(right_);
      for (const int i : members) end_[i] = solution_.segment<6>(first_row_[i]);
      if (with_jaws) jaw_end_ = solution_[jaw_row_];
      store_forces(contacts);
      bool changed = update_guesses(contacts);
      if (with_jaws) {
        const int saturation = drive_.next_saturation(h_, jaw_end_, saturation_);
        changed = changed || saturation != saturation_;
        saturation_ = saturation;
      }
      if (!changed && iteration + 1 >= kLeastIterations) break;
    }
    advance_bristles(contacts);
    for (const int i : members) {
      bodies_[i].velocity = end_[i].head<3>();
      bodies_[i].angular_velocity = end_[i].tail<3>();
      first_row_[i] = -1;
    }
  }

 private:
  Eigen::Vector3d relative_velocity(const ContactPoint& contact) const {
    Eigen::Vector3d v = point_velocity(contact.a, contact.point) - contact.partner_velocity -
                        jaw_end_ * contact.jaw_motion;
    if (contact.b >= 0) v -= point_velocity(contact.b, contact.point);
    return v;
  }

  Eigen::Vector3d point_velocity(int body, const Eigen::Vector3d& point) const {
    if (!bodies_[body].is_free) return Eigen::Vector3d::Zero();
    return end_[body].head<3>() +
           Eigen::Vector3d(end_[body].tail<3>()).cross(point - bodies_[body].center);
  }

  // Linearises at the present velocities; true when a contact began or ceased to press.
  bool update_guesses(const std::vector<ContactPoint*>& contacts) {
    bool changed = false;
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      const ContactPoint& contact = *contacts[c];
      const Eigen::Vector3d v = relative_velocity(contact);
      const double normal_speed = contact.normal.dot(v);
      const Eigen::Vector3d tangential = v - normal_speed * contact.normal;
      const auto line = contact::linearise(*contact.law, h_, contact.depth, -normal_speed,
                                           contact.bristle, tangential);
      changed = changed || line.presses != lines_[c].presses;
      lines_[c] = line;
    }
    return changed;
  }

  void add_body(int i) {
    const SolverBody& body = bodies_[i];
    const int row = first_row_[i];
    matrix_.block<3, 3>(row, row).diagonal().setConstant(body.mass);
    matrix_.block<3, 3>(row + 3, row + 3) = body.inertia_W;
    right_.segment<3>(row) = body.mass * start_[i].head<3>() + h_ * body.force;
    right_.segment<3>(row + 3) = body.inertia_W * start_[i].tail<3>() + h_ * body.torque;
  }

  void add_drive() {
    const GripperDrive::Force force = drive_.linearised(h_, jaw_end_, saturation_);
    matrix_(jaw_row_, jaw_row_) = drive_.effective_mass() + h_ * force.slope;
    right_[jaw_row_] = drive_.effective_mass() * jaw_start_ + h_ * force.constant;
  }

  // Force on body a = constant - resistance (relative velocity).
  static void affine_force(const ContactPoint& contact, const contact::LinearisedContact& law,
                           Eigen::Vector3d& constant, Eigen::Matrix3d& resistance) {
    const Eigen::Matrix3d along = contact.normal * contact.normal.transpose();
    constant = law.normal_offset * contact.normal - law.bristle_gain * contact.bristle;
    resistance =
        law.normal_damping * along + law.tangential_damping * (Eigen::Matrix3d::Identity() - along);
  }

  void add_contact(const ContactPoint& contact, const contact::LinearisedContact& line) {
    if (!line.presses) return;
    Eigen::Vector3d constant;
    Eigen::Matrix3d resistance;
    affine_force(contact, line, constant, resistance);
    constant += resistance * contact.partner_velocity;
    const int row_a = first_row_[contact.a];
    const int row_b = contact.b >= 0 ? first_row_[contact.b] : -1;
    const Matrix36 jacobian_a = point_jacobian(contact.point - bodies_[contact.a].center);
    Matrix36 weighted = h_ * resistance * jacobian_a;
    if (row_a >= 0) {
      matrix_.block<6, 6>(row_a, row_a).noalias() += jacobian_a.transpose() * weighted;
      right_.segment<6>(row_a).noalias() += h_ * jacobian_a.transpose() * constant;
    }
    if (row_b >= 0) {
      const Matrix36 jacobian_b = point_jacobian(contact.point - bodies_[contact.b].center);
      matrix_.block<6, 6>(row_b, row_b).noalias() +=
          h_ * jacobian_b.transpose() * resistance * jacobian_b;
      right_.segment<6>(row_b).noalias() -= h_ * jacobian_b.transpose() * constant;
      if (row_a >= 0) {
        const Eigen::Matrix<double, 6, 6> coupling = jacobian_b.transpose() * weighted;
        matrix_.block<6, 6>(row_b, row_a) -= coupling;
        matrix_.block<6, 6>(row_a, row_b) -= coupling.transpose();
      }
    }
    if (jaw_row_ >= 0 && !contact.jaw_motion.isZero(0)) {
      const Eigen::Vector3d& motion = contact.jaw_motion;
      matrix_(jaw_row_, jaw_row_) += h_ * motion.dot(resistance * motion);
      right_[jaw_row_] -= h_ * motion.dot(constant);
      if (row_a >= 0) {
        const Eigen::Matrix<double, 1, 6> coupling = motion.transpose() * weighted;
        matrix_.block<1, 6>(jaw_row_, row_a) -= coupling;
        matrix_.block<6, 1>(row_a, jaw_row_) -= coupling.transpose();
      }
    }
  }

  void store_forces(const std::vector<ContactPoint*>& contacts) {
    used_ = lines_;
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      ContactPoint& contact = *contacts[c];
      contact.force.setZero();
      contact.normal_force = 0;
      if (!lines_[c].presses) continue;
      Eigen::Vector3d constant;
      Eigen::Matrix3d resistance;
      affine_force(contact, lines_[c], constant, resistance);
      contact.force = constant - resistance * relative_velocity(contact);
      contact.normal_force = std::max(0.0, contact.normal.dot(contact.force));
    }
  }

  // The bristles at the step's end, from the last solution and the law it was solved with.
  void advance_bristles(const std::vector<ContactPoint*>& contacts) {
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      ContactPoint& contact = *contacts[c];
      if (contact.normal_force == 0) {
        contact.bristle.setZero();
        continue;
      }
      const Eigen::Vector3d v = relative_velocity(contact);
      const Eigen::Vector3d tangential = v - contact.normal.dot(v) * contact.normal;
      contact.bristle = contact::return_mapped(
          *contact.law, contact.normal_force,
          contact::advanced_bristle(used_[c], h_, contact.bristle, tangential));
    }
  }

  double h_;
  const GripperDrive& drive_;
  std::vector<SolverBody>& bodies_;
  double jaw_start_, jaw_end_;
  std::vector<int> first_row_;  // of each body in the present island, -1: not in it
  int jaw_row_ = -1;
  int saturation_;  // of the drive
  std::vector<Eigen::Matrix<double, 6, 1>> start_, end_;
  std::vector<contact::LinearisedContact> lines_, used_;
  Eigen::MatrixXd matrix_;
  Eigen::VectorXd right_, solution_;
};

}  // namespace

void solve_contacts(double h, const GripperDrive& drive, std::vector<SolverBody>& bodies,
                    std::vector<ContactPoint>& contacts, double& jaw_velocity) {
  const int jaws = static_cast<int>(bodies.size());
  Islands islands(bodies.size() + 1);
  const auto is_free = [&](int i) { return i >= 0 && bodies[i].is_free; };
  for (const ContactPoint& contact : contacts) {
    if (is_free(contact.a) && is_free(contact.b)) islands.join(contact.a, contact.b);
    const int any = is_free(contact.a) ? contact.a : is_free(contact.b) ? contact.b : -1;
    if (!contact.jaw_motion.isZero(0) && any >= 0) islands.join(any, jaws);
  }
  std::vector<std::vector<int>> members(bodies.size() + 1);
  std::vector<std::vector<ContactPoint*>> touching(bodies.size() + 1);
  for (int i = 0; i < jaws; ++i) {
    if (bodies[i].is_free) members[islands.root(i)].push_back(i);
  }
  for (ContactPoint& contact : contacts) {
    const int any = is_free(contact.a) ? contact.a : is_free(contact.b) ? contact.b : jaws;
    touching[islands.root(any)].push_back(&contact);
  }
  VelocitySolver solver(h, drive, bodies, jaw_velocity);
  for (int root = 0; root <= jaws; ++root) {
    const bool with_jaws = islands.root(jaws) == root;
    if (members[root].empty() && !with_jaws) continue;
    solver.solve_island(members[root], with_jaws, touching[root]);
  }
  jaw_velocity = solver.jaw_velocity();
}

}  // namespace prehend::simulation
