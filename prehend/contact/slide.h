#pragma once

#include <limits>

namespace prehend::contact {

/// A prismatic joint of the gripper: a jaw, or several jaws that one drive couples. Friction is a
/// stiff LuGre bristle: it holds still below `static_friction`.
struct SlideModel {
  double mass = 0.05;                // kg, of the coordinate (1/2 sum m (dx/dq)^2)
  double start = 0;                  // m
  double static_friction = 0;        // N
  double dynamic_friction = 0;       // N, <= static_friction
  double viscous_friction = 0;       // N s/m
  double stribeck_velocity = 0.005;  // m/s
  double bristle_stiffness = 1e6;    // N/m
};

/// What drives a slide: force + clamp(stiffness (reference - q) + damping (speed - dq/dt), limit).
/// The reference moves with `speed` from the moment of the command.
struct SlideCommand {
  double force = 0;                                        // N
  double stiffness = 0;                                    // N/m
  double reference = 0;                                    // m
  double damping = 0;                                      // N s/m
  double speed = 0;                                        // m/s
  double limit = std::numeric_limits<double>::infinity();  // N, of the servo's part
  double more_friction = 0;  // N, >= 0, on top of the slide's, static and dynamic
};

/// @throws std::invalid_argument naming the field.
void validate(const SlideCommand& command);

}  // namespace prehend::contact
