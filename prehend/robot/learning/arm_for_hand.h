#pragma once

#include <filesystem>
#include <string>

#include "prehend/robot/learning/learned_hand.h"

namespace prehend::robot::learning {

/// How a hand stands on a flange: its approach (mean of its preshapes' tools) along the flange's z,
/// its closing direction along y, what is hindmost of it at the flange. A hand whose root stands so
/// within 15 degrees, as hands do whose root is their mounting face, is put with its root there, or
/// as much farther out as it reaches back.
geometry::RigidTransform mount_on_flange(const LearnedHand& learned);

/// The text of a platform's file (read_platform()) with a platform's arm and the learned hand.
/// @param platform that file @param hand the hand's file @param out where the text will be, from
/// which both are named. @throws geometry::InputError when the platform's file cannot be read
std::string platform_yaml(const LearnedHand& learned, const std::filesystem::path& platform,
                          const std::filesystem::path& hand, const std::filesystem::path& out);

}  // namespace prehend::robot::learning
