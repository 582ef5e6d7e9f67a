#pragma once

#include "drivers/sdh/codec/codes.h"
#include "drivers/wire/hand/hand_plant.h"

namespace prehend::drivers::sdh {

/// What an emulated SDH-2 moves. SI units, axes as in codes.h.
using HandPlant = drivers::HandPlant<kAxes>;
using SimpleHand = drivers::SimpleHand<kAxes>;

}  // namespace prehend::drivers::sdh
