#pragma once

#include "prehend/robot/grip.h"

namespace prehend::control {

using robot::mean_touch;
using robot::MeanTouch;
using robot::PadPercept;

}  // namespace prehend::control
