#pragma once

#include "msgs/objects.pb.h"
#include "prehend/grasp/load_bounds.h"

namespace prehend::convert {

msgs::Interval to_message(const grasp::Interval& interval);
/// @param what it is of, for errors. @throws geometry::InputError for a bound that is negative, not
/// finite, or below the other.
grasp::Interval from_message(const msgs::Interval& message, const char* what);

/// What the model says of its load; unbounded where it says nothing. @throws as from_message().
grasp::LoadBounds load_of(const msgs::ObjectModel& model);

}  // namespace prehend::convert
