#pragma once

#include <vector>

#include "prehend/belief/evidence.h"
#include "prehend/belief/hand_evidence.h"

namespace prehend::belief {

/// What one act of a hand found out about an object.
struct Act {
  /// That it may have given the object, after the acts before it and before its contacts.
  Motion motion;
  /// Of the hand, through what is empty therefore, with the object where the act found it.
  std::vector<HandSample> free_way;
  std::vector<Contact> contacts;
};

/// The acts of one attempt at a grasp, in their order.
using Attempt = std::vector<Act>;

}  // namespace prehend::belief
