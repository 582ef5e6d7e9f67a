#pragma once

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "prehend/robot/hand_model.h"
#include "prehend/simulation/robot_world.h"

namespace prehend::simulation::testing {

/// A hand of one flap on a vertical hinge and one jaw that slides horizontally, which touch
/// nothing: what moves them is all there is. `motor` is the hand file's section.
class Flap {
 public:
  static constexpr double kFlapMass = 0.1;                                  // kg
  static constexpr double kFlapInertia = kFlapMass * (0.0101 / 12 + 0.01);  // kg m^2, at the hinge
  static constexpr double kJawMass = 0.2;                                   // kg
  static constexpr double kMaxVelocity = 20, kMaxEffort = 2;                // of the hinge
  static constexpr double kMaxSlideVelocity = 0.5, kMaxForce = 100;         // of the slide

  explicit Flap(const std::string& motor = "", double upper = 100)
      : folder_(std::filesystem::temp_directory_path() /
                ("prehend_flap_" + std::to_string(getpid()) + "_" + std::to_string(count_++))) {
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "flap.urdf") << R"(<robot name="flap">
  <link name="palm"><collision><geometry><box size="0.02 0.02 0.02"/></geometry></collision></link>
  <link name="flap"><inertial><mass value="0.1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision><origin xyz="0.1 0 0"/><geometry><box size="0.1 0.01 0.01"/></geometry></collision></link>
  <link name="jaw"><inertial><mass value="0.2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision><geometry><box size="0.02 0.02 0.02"/></geometry></collision></link>
  <joint name="hinge" type="revolute"><parent link="palm"/><child link="flap"/><axis xyz="0 0 1"/>
    <limit lower=")" << -upper << R"(" upper=")"
                                         << upper << R"(" velocity="20" effort="2"/></joint>
  <joint name="slide" type="prismatic"><parent link="palm"/><child link="jaw"/><axis xyz="1 0 0"/>
    <origin xyz="0 0 0.5"/><limit lower="-1" upper="1" velocity="0.5" effort="100"/></joint>
</robot>
)";
    std::ofstream(file())
        << "name: flap\nurdf: flap.urdf\npalm: palm\nactuated: [hinge, slide]\n"
           "fingers: {flap: [flap], jaw: [jaw]}\nfriction: 0.5\n"
        << motor << "preshapes: {open: {open: {hinge: 0, slide: 0}, closing: {hinge: 1}}}\n";
  }
  ~Flap() { std::filesystem::remove_all(folder_); }
  Flap(const Flap&) = delete;
  Flap& operator=(const Flap&) = delete;

  std::filesystem::path file() const { return folder_ / "flap.yaml"; }
  /// One metre over the ground; `tilt` [rad] turns it about x.
  RobotWorld world(double step = 1e-3, double tilt = 0) const {
    geometry::RigidTransform X_WH = geometry::RigidTransform::Identity();
    X_WH.translation().z() = 1;
    X_WH.linear() = Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX()).toRotationMatrix();
    RobotWorldOptions options;
    options.step = step;
    return {robot::read_hand_model(file()), X_WH, "", options};
  }

 private:
  inline static int count_ = 0;
  std::filesystem::path folder_;
};

inline void run_for(RobotWorld& world, double seconds) {
  for (long i = std::lround(seconds / world.options().step); i > 0; --i) world.step();
}

inline JointReading joint(const RobotWorld& world, int motor) {
  for (const JointReading& reading : world.joints()) {
    if (reading.name == world.motor_names()[static_cast<std::size_t>(motor)]) return reading;
  }
  return {};
}

}  // namespace prehend::simulation::testing
