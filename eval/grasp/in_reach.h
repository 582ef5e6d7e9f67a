#pragma once

#include "prehend/robot/platform.h"

namespace prehend::eval {

/// The platform, moved along the table where its arm does not reach the world's origin, at which
/// evaluated objects stand, from above: to where the middle of what it reaches is there.
/// @throws geometry::InputError for an arm that reaches nothing on the table from above.
robot::Platform in_reach(robot::Platform platform);

}  // namespace prehend::eval
