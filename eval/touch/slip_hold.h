#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "prehend/control/cycle.h"
#include "prehend/touch/hold_slip.h"

// Holds that slide and holds that do not, through what ships: the cycle with its detector of slip,
// the gripper that regulates its grip by its pads, the PG70's drive, the pads, and the world.
namespace prehend::eval::touch {

/// What is held. kBox has an edge along the pads' rows, kSlanted one that is aslant; a covering box
/// reaches beyond the pads on all sides, which shows nothing of its motion.
enum class HeldShape { kBox, kSlanted, kBall, kCan, kBottle, kCoveringBox };
std::string to_string(HeldShape shape);

enum class HoldKind {
  kSlipsWhenLifted,  // friction is lower than the grasp believes
  kSlipsWhenShaken,  // the load grows until it slides
  kHeldStill,
  kHeldShaken  // with a load below what friction bears
};
std::string to_string(HoldKind kind);

struct SlipHold {
  HeldShape shape = HeldShape::kBox;
  HoldKind kind = HoldKind::kHeldStill;
  Eigen::Vector3d size{0.05, 0.05, 0.07};  // m; of round ones the first is the diameter
  double slant = 0;                        // rad, of the upper edge
  double pad_height = 0.07;                // m, of the pads' centres over the table
  double beside = 0;                       // m, of the pads' centres beside the object's
  double friction = 0.7;                   // dynamic
  double mass = 0.3;                       // kg
  double force = 12;                       // N, per pad, of the grasp
  double shaking = 0;                      // m/s^2, amplitude at the end
  double frequency = 2;                    // Hz
  bool area_texels = true;  // texels feel over their area (3 x 3 rays each); else by one ray each
  bool realistic_pads = false;  // TactileSensorOptions and FoamMemory::realistic()
  bool stuck_drive = false;     // more stiction than the controller knows: force ripple
  double wrist_noise = 0;       // N, standard deviation
  std::uint32_t seed = 1;
};

/// A random hold of this kind. Same seed, same hold.
SlipHold random_slip_hold(HeldShape shape, HoldKind kind, std::uint32_t seed);

struct SlipHoldResult {
  bool gripped = false;  // the lift began
  /// m, the farthest that the object slid over the pads until the hold ended: its motion in the
  /// gripper less what the pads' bristles stretch by the load that the wrist bears
  double slide = 0;
  std::optional<double> told_at;     // m, of that slide, when the cycle said first that it slips
  std::optional<double> passed_3mm;  // s, of the world, when it had slid so far
  std::optional<double> told_time;   // s
  bool dropped = false;              // it fell out of the hand
  bool put_down = false;             // the cycle put it down, as it could not hold harder
  double force = 0;                  // N, per pad, felt at the end of the hold
  control::CycleResult cycle;
};

/// Grips, lifts by 0.1 m, shakes, holds still. @param reacts the cycle holds harder what slips, as
/// it ships; else it only says so. @param slip by which it sees that. @throws as run_stage_cycle().
SlipHoldResult run_slip_hold(const SlipHold& hold, bool reacts,
                             const prehend::touch::HoldSlipOptions& slip = {});

}  // namespace prehend::eval::touch
