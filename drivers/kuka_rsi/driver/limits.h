#pragma once

#include <array>
#include <optional>
#include <string>

#include "drivers/kuka_rsi/codec/telegram.h"
#include "prehend/robot/kinematic_chain.h"

namespace prehend::drivers::kuka_rsi {

/// Corners of an upright box in the world [m].
struct ToolBox {
  Eigen::Vector3d lower = Eigen::Vector3d::Zero(), upper = Eigen::Vector3d::Zero();

  bool contains(const Eigen::Vector3d& p_W) const {
    return (p_W.array() >= lower.array()).all() && (p_W.array() <= upper.array()).all();
  }
};

/// What a set point may break.
enum class Breach {
  kNone,
  kNotFinite,
  kPosition,
  kSpeed,
  kAcceleration,
  kCorrection,  ///< too far from where the controller's program stands
  kTool,        ///< the tool leaves its box
};
/// "is beyond its limit of position", of an axis or the tool.
const char* to_string(Breach breach);

struct Broken {
  Breach breach = Breach::kNone;
  std::size_t axis = 0;

  explicit operator bool() const { return breach != Breach::kNone; }
};

/// What the arm is held to, whatever is asked of it: axes in rad, rad/s, rad/s^2.
class Limits {
 public:
  struct Options {
    double speed_share = 1;    // of the joints' greatest speeds, in (0, 1]
    double acceleration = 12;  // rad/s^2, > 0: what none of KUKA's papers says (ArmDriveOptions)
    double largest_correction = 1.5708;  // rad, of an axis from where the program stands, > 0
    std::optional<ToolBox> box;
    geometry::RigidTransform X_WB =
        geometry::RigidTransform::Identity();        // arm's base in the world
    Eigen::Vector3d p_FT = Eigen::Vector3d::Zero();  // tool's place on the flange [m]
  };

  /// Positions and speeds are the chain's.
  /// @throws std::invalid_argument for a chain that has not six turning joints with limits, and for
  /// options out of range.
  Limits(robot::KinematicChain chain, const Options& options);

  /// Whether the set point `next` may follow `now`, which was reached at `velocity`, `cycle` [s]
  /// later; `reference` is where the controller's program stands. Allocates nothing.
  Broken check(const Axes& reference, const Axes& now, const Axes& velocity, const Axes& next,
               double cycle) const;
  /// Whether the tool is in its box; true where there is none. Allocates nothing.
  bool tool_is_inside(const Axes& q) const;
  Eigen::Vector3d tool_at(const Axes& q) const;

  /// One cycle of braking: each axis loses its greatest acceleration's worth of speed. An axis that
  /// kept its limits of position and acceleration until now keeps them so: it stops no later than
  /// where it would have had to.
  void brake(Axes& q, Axes& velocity, double cycle) const;

  const robot::KinematicChain& chain() const { return chain_; }
  const Options& options() const { return options_; }
  double lower(std::size_t axis) const { return chain_.joints()[axis].lower; }
  double upper(std::size_t axis) const { return chain_.joints()[axis].upper; }
  double speed(std::size_t axis) const {
    return options_.speed_share * chain_.joints()[axis].max_velocity;
  }

 private:
  robot::KinematicChain chain_;
  Options options_;
};

}  // namespace prehend::drivers::kuka_rsi
