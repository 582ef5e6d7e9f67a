#pragma once

#include <filesystem>
#include <string>

#include "eval/grasp/hand_under_test.h"

namespace prehend::eval {

/// A hand of `robots` (config/robots), NAME.yaml, without an arm: it comes from any side but
/// through the table. Each attempt is the next grasp of the plan, executed on the object as it
/// stood at first: a further one tells whether the list has a better grasp, not whether the hand
/// recovers.
/// @throws geometry::InputError as robot::read_hand_model().
HandUnderTest fingered_hand(const std::filesystem::path& robots, const std::string& name);

}  // namespace prehend::eval
