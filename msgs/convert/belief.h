#pragma once

#include "msgs/belief.pb.h"
#include "prehend/belief/attempt.h"
#include "prehend/belief/attempt_memory.h"

// What hands find out, and what it makes of objects.
namespace prehend::convert {

/// Without header, ids and the hand's name.
msgs::AttemptEvidence to_message(const belief::Attempt& attempt);
/// @throws geometry::InputError where something is not finite, a deviation is negative, a contact's
/// is not positive, or a normal is not of unit length.
belief::Attempt from_message(const msgs::AttemptEvidence& message);

/// Without header and id.
msgs::Belief to_message(const belief::Recollection& recollection);

}  // namespace prehend::convert
