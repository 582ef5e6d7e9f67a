#pragma once

#include <vector>

#include "prehend/contact/pad_layout.h"
#include "prehend/contact/texel_law.h"
#include "prehend/robot/gripper_model.h"

// What the frames of tactile pads mean, be the pads simulated or real. All is in pad frame P (see
// contact::PadLayout) and SI units.
namespace prehend::touch {

/// A pad as far as its frames need it: where its texels are, how its foam gives way, what a count
/// is. Texel i of the layout is count i of a frame.
struct FeltPad {
  contact::PadLayout layout;
  contact::TexelLaw law;
  double newton_per_count = robot::kDsaNewtonPerCount;  // N
  int full_scale = 4095;                                // counts; a texel that says it is full
  int threshold = 10;  // counts; a texel that says no more is not touched
};

/// The flat pad of a robot file. `mirrored`: the frame's columns run against x, as those of the
/// right pad of a gripper on a stage, whose frames have the gripper's x from left to right.
/// @throws std::invalid_argument naming the field that is not positive and finite.
FeltPad felt_pad(const robot::TactilePadModel& model, bool mirrored = false);
/// The same with the texels of `grid`, as a device says them.
FeltPad felt_pad(const contact::PadGrid& grid, const robot::TactilePadModel& model, bool mirrored);

enum class Texel : unsigned char {
  kFree,       // says no more than the threshold
  kTouched,    //
  kFull,       // touched, and its force is above what it can say
  kUnreadable  // says what is no count: not finite, negative
};

struct FeltTexels {
  std::vector<Texel> state;
  std::vector<double> force;  // N, of the touched; 0 of the others; of kFull the least it can be
};

/// @throws std::invalid_argument for another number of counts than the pad has texels.
FeltTexels felt_texels(const FeltPad& pad, const std::vector<double>& counts);

/// How deep a force at rest presses a texel whose area is `scale` times the reference [m]: the
/// inverse of contact::normal_force without its damping. At most `thickness` [m].
double rest_depth(const contact::TexelLaw& law, double scale, double force, double thickness);

}  // namespace prehend::touch
