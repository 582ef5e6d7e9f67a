#pragma once

#include "eval/grasp/hand_under_test.h"

namespace prehend::eval {

/// The parallel gripper on the carrier that approaches from above, by the whole grasp cycle with
/// its three attempts. `lifted` is by 100 mm at least.
HandUnderTest parallel_gripper();

}  // namespace prehend::eval
