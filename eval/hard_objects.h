#pragma once

#include <vector>

#include "eval/evaluation_object.h"

namespace prehend::eval {

/// What people bring besides: vessels, flat and thin things, things that lean, lie on their handles
/// or on each other, stacks, things hidden by others or cut by the image, 9 mm to 60 cm, dark ones;
/// seen by stereo or structured light from 15 to 75 degrees above the table. Made by code, closed
/// and manifold. Cost: some seconds.
std::vector<EvaluationObject> hard_objects();

/// The same kinds of things in other shapes, sizes and arrangements, which nothing is tuned on.
std::vector<EvaluationObject> held_out_objects();

}  // namespace prehend::eval
