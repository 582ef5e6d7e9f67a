#pragma once

#include "msgs/belief.pb.h"
#include "prehend/belief/load_belief.h"
#include "prehend/grasp/load_bounds.h"

// What is known of an object's load.
namespace prehend::convert {

msgs::LoadEvidence to_message(const belief::LoadEvidence& load);
/// @throws geometry::InputError where something is negative or not finite.
belief::LoadEvidence from_message(const msgs::LoadEvidence& message);

/// Those that are known; the others are left absent.
void set_load(const grasp::LoadBounds& load, msgs::ObjectModel* model);
void set_load(const grasp::LoadBounds& load, msgs::Belief* belief);

}  // namespace prehend::convert
