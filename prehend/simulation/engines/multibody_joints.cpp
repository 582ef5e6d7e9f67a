// Stops, friction, drives and clutches of joints: rows of a step's equations.

#include "prehend/simulation/engines/multibody_joints.h"

#include <cmath>
#include <string>

#include "prehend/contact/require.h"
#include "prehend/simulation/engines/multibody.h"

namespace prehend::simulation::engines {
namespace {

using contact::require;
using contact::require_not_negative;

/// How much stiffer than its inertia over a step a stop, sticking friction and a closed clutch are:
/// what they let through of a motion in a step is one part in this.
constexpr double kRigid = 1e6;

void require_limit(double value, const std::string& field) {
  require(value >= 0, field, "a number not negative");  // infinity is one
}

}  // namespace

bool JointRow::choose(const Eigen::VectorXd& u) {
  const double free = offset - gain * velocity(u);
  int now = free < least ? -1 : (free > most ? 1 : 0);
  if (now * cut < 0) now = 0;
  const bool changed = now != cut;
  cut = now;
  return changed;
}

void validate(const JointMechanics& mechanics, int joint) {
  const std::string owner = "joint " + std::to_string(joint) + ".";
  require(mechanics.lower < mechanics.upper, owner + "lower", "below its upper limit");
  require_not_negative(mechanics.damping, owner + "damping");
  require_not_negative(mechanics.dry_friction, owner + "dry_friction");
  require_not_negative(mechanics.rotor_inertia, owner + "rotor_inertia");
}

void validate(const JointDrive& drive, int joint) {
  const std::string owner = "the drive of joint " + std::to_string(joint) + ": ";
  require(std::isfinite(drive.target), owner + "target", "finite");
  require(std::isfinite(drive.target_velocity), owner + "target_velocity", "finite");
  require_not_negative(drive.stiffness, owner + "stiffness");
  require_not_negative(drive.damping, owner + "damping");
  require_limit(drive.limit, owner + "limit");
  require(std::isfinite(drive.force), owner + "force", "finite");
  require(std::isfinite(drive.share), owner + "share", "finite");
  require(drive.along < 0 || drive.along != joint, owner + "along", "another joint");
}

void Multibody::set_mechanics(int joint, const JointMechanics& mechanics) {
  validate(mechanics, joint);
  require(scene_.joints.at(joint).follows < 0, "joint " + std::to_string(joint),
          "one that follows none to have mechanics");
  mechanics_[joint] = mechanics;
}

void Multibody::set_drive(int joint, const JointDrive& drive) {
  validate(drive, joint);
  require(scene_.joints.at(joint).follows < 0, "joint " + std::to_string(joint),
          "one that follows none to be driven");
  require(drive.along < 0 || scene_.joints.at(drive.along).follows < 0,
          "joint " + std::to_string(drive.along), "one that follows none to be driven along");
  drives_[joint] = drive;
}

void Multibody::add_coupling(const JointCoupling& coupling) {
  for (const int joint : {coupling.first, coupling.second}) {
    require(joint >= 0 && joint < static_cast<int>(scene_.joints.size()) &&
                scene_.joints[joint].follows < 0,
            "JointCoupling: joint " + std::to_string(joint), "one of the scene that follows none");
  }
  require(coupling.first != coupling.second, "JointCoupling::second", "another joint than first");
  require(std::isfinite(coupling.ratio), "JointCoupling::ratio", "finite");
  require(coupling.breakaway > 0, "JointCoupling::breakaway", "positive");
  couplings_.push_back(coupling);
  rows_.reserve(4 * scene_.joints.size() + couplings_.size());
}

// `matrix_` holds the inertia alone.
void Multibody::begin_rows(const MultibodyState& base, double h, const Eigen::VectorXd& u) {
  rows_.clear();
  const auto rigid = [&](int coordinate) {
    const int k = active_[coordinate];
    return kRigid * matrix_(k, k) / h;
  };
  for (std::size_t j = 0; j < scene_.joints.size(); ++j) {
    drive_row_[j] = -1;
    const int c = coordinate_[j];
    if (scene_.joints[j].follows >= 0) continue;
    const JointMechanics& own = mechanics_[j];
    const double q = base.positions[c];
    JointRow row;
    row.i = c;
    if (own.dry_friction > 0) {
      row.gain = rigid(c);
      row.most = own.dry_friction;
      row.least = -own.dry_friction;
      rows_.push_back(row);
    }
    if (std::isfinite(own.lower)) {
      row.gain = rigid(c);
      row.offset = row.gain * (own.lower - q) / h;
      row.least = 0;
      row.most = std::numeric_limits<double>::infinity();
      rows_.push_back(row);
    }
    if (std::isfinite(own.upper)) {
      row.gain = rigid(c);
      row.offset = row.gain * (own.upper - q) / h;
      row.least = -std::numeric_limits<double>::infinity();
      row.most = 0;
      rows_.push_back(row);
    }
    const JointDrive& drive = drives_[j];
    if (drive.mode == JointDrive::Mode::kNone) continue;
    const bool positions = drive.mode == JointDrive::Mode::kPosition;
    double driven = q;
    if (drive.along >= 0) {
      row.j = coordinate_[drive.along];
      row.weight = -drive.share;
      driven += drive.share * base.positions[row.j];
    }
    row.gain = drive.damping + (positions ? h * drive.stiffness : 0.0);
    row.offset = positions ? drive.stiffness * (drive.target - driven) +
                                 drive.damping * drive.target_velocity
                           : drive.damping * drive.target;
    row.offset += drive.force;
    row.most = drive.force + drive.limit;
    row.least = drive.force - drive.limit;
    drive_row_[j] = static_cast<int>(rows_.size());
    rows_.push_back(row);
  }
  for (const JointCoupling& coupling : couplings_) {
    JointRow row;
    row.i = coordinate_[coupling.first];
    row.j = coordinate_[coupling.second];
    row.weight = coupling.ratio;
    row.gain = rigid(row.i) + coupling.ratio * coupling.ratio * rigid(row.j);
    row.most = coupling.breakaway;
    row.least = -coupling.breakaway;
    rows_.push_back(row);
  }
  for (JointRow& row : rows_) row.choose(u);
}

void Multibody::add_joints(const MultibodyState& base, double h) {
  for (std::size_t j = 0; j < scene_.joints.size(); ++j) {
    const EngineJoint& joint = scene_.joints[j];
    const int k = active_[coordinate_[j]];
    right_[k] += h * (joint.follows >= 0 ? joint.ratio : 1.0) * joint_force_[j];
    const JointMechanics& own = mechanics_[j];
    matrix_(k, k) += h * own.damping + own.rotor_inertia;
    right_[k] += own.rotor_inertia * base.velocities[coordinate_[j]];
  }
}

void Multibody::add_rows(double h) {
  for (const JointRow& row : rows_) {
    const int i = active_[row.i], j = row.j < 0 ? -1 : active_[row.j];
    double force = row.offset;
    if (row.cut != 0) {
      force = row.cut < 0 ? row.least : row.most;
    } else {
      matrix_(i, i) += h * row.gain;
      if (j >= 0) {
        matrix_(i, j) -= h * row.gain * row.weight;
        matrix_(j, i) -= h * row.gain * row.weight;
        matrix_(j, j) += h * row.gain * row.weight * row.weight;
      }
    }
    right_[i] += h * force;
    if (j >= 0) right_[j] -= h * row.weight * force;
  }
}

}  // namespace prehend::simulation::engines
