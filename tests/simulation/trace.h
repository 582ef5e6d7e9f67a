#pragma once

#include <string>

#include "prehend/simulation/state_bytes.h"
#include "prehend/simulation/world.h"

namespace prehend::simulation::testing {

/// All that can be seen of `world` over the next `seconds`, as bytes.
inline std::string trace(World& world, double seconds) {
  StateWriter seen;
  const auto steps = static_cast<int>(seconds / world.scene().step + 0.5);
  for (int i = 0; i < steps; ++i) {
    world.step();
    for (std::size_t b = 0; b < world.body_count(); ++b) {
      const BodyReading body = world.body(b);
      seen(body.X_WB.matrix(), body.velocity, body.angular_velocity);
    }
    const ContactWrench wrench = world.wrist_wrench();
    const GripperReading gripper = world.gripper();
    seen(wrench.force, wrench.torque, gripper.opening, gripper.velocity, gripper.current,
         gripper.blocked, world.carrier().X_WG.matrix());
    if (!world.has_touch()) continue;
    for (const PadSide side : {PadSide::kLeft, PadSide::kRight}) {
      const TactileImage image = world.tactile_image(side);
      seen(image.counts, image.sum);
    }
  }
  return seen.bytes();
}

}  // namespace prehend::simulation::testing
