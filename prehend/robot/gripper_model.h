#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/contact/texel_law.h"

namespace prehend::robot {

/// Force of one count of a Weiss DSA 9205 texel [N]: 250 kPa of full scale on 3.4 mm x 3.4 mm in
/// 4095 steps. An estimate from quoted figures, not a calibration: see docs/touch.md.
constexpr double kDsaNewtonPerCount = 0.000706;

/// A tactile pad: `rows` x `columns` texels on a flat face. Rows run along the finger (row 0 at the
/// fingertip), columns across it.
struct TactilePadModel {
  int rows = 14;
  int columns = 6;
  double texel_pitch = 0.0034;  // m, square
  double thickness = 0.003;     // m, of the foam: the deepest penetration it can show
  double newton_per_count = kDsaNewtonPerCount;  // N per count of the 12-bit image
  int full_scale = 4095;                         // counts
  contact::TexelLaw law;

  double length() const { return rows * texel_pitch; }    // m, along the finger (z)
  double width() const { return columns * texel_pitch; }  // m, across the finger (x)
};

/// A parallel gripper with two synchronised fingers, the pads on their inner faces.
///
/// Gripper frame G: origin midway between the centres of the two pads; z the approach direction
/// (from the palm to the fingertips), y the closing direction (left finger at +y), x across the
/// fingers. With opening s the pads' undeformed faces are the planes y = +-s/2, their area
/// |x| <= width/2, |z| <= length/2. Each finger is a box behind its face, from the fingertip at
/// z = length/2 + tip_margin back to the housing; the housing is a box that ends at z =
/// -housing_distance.
struct GripperModel {
  std::string name = "pg70_dsa";
  double max_opening = 0.069;       // m
  double max_speed = 0.083;         // m/s of the opening
  double max_acceleration = 0.320;  // m/s^2 of the opening
  double nominal_current = 2.0;     // A
  double max_current = 6.5;         // A
  double force_per_current = 30;    // N of each finger per A
  double friction_force = 8;        // N, Coulomb friction of the drive felt at each finger
  double jaw_mass = 0.1;            // kg, of each jaw with its finger, without the drive's rotor
  double mass = 1.4;                // kg, all
  Eigen::Vector3d finger_size{0.024, 0.012, 0.110};   // m: x, y (depth behind the face), z
  double tip_margin = 0.002;                          // m, finger beyond the pad's edge
  Eigen::Vector3d housing_size{0.082, 0.114, 0.080};  // m
  TactilePadModel pad;

  double tip_z() const { return pad.length() / 2 + tip_margin; }        // m
  double housing_front_z() const { return tip_z() - finger_size.z(); }  // m, negative
};

/// Checks every value. @throws std::invalid_argument naming the field.
void validate(const TactilePadModel& pad);
void validate(const GripperModel& model);

/// Reads config/robots/*.yaml. Every key must be known; missing ones keep the defaults. The
/// sections drive, tactile and wrench are for the simulation, see simulation/hardware_yaml.h.
/// @throws geometry::InputError naming file, key and mend.
GripperModel read_gripper_model(const std::filesystem::path& path);
/// The same of a text; `path` says in errors where it is from.
GripperModel parse_gripper_model(const std::string& yaml, const std::filesystem::path& path);

/// In what two grippers differ, with both values: "max_opening: 0.069 and 0.12"; empty: in nothing.
std::vector<std::string> differences(const GripperModel& a, const GripperModel& b);

}  // namespace prehend::robot
