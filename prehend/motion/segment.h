#pragma once

namespace prehend::motion {

/// The parts of an arm's motion round a grasp, in the order in which they are run. The hand closes
/// between approach and lift, and opens between place and retreat. From 1: a message with
/// 0 does not say.
enum class SegmentKind {
  kReach = 1,  // to before the grasp
  kApproach,   // straight to where the hand closes
  kLift,       // straight up, with the object
  kCarry,      // with the object, to above its place
  kPlace,      // straight down, with the object
  kRetreat,    // straight back
};

/// "reach".
constexpr const char* to_string(SegmentKind kind) {
  switch (kind) {
    case SegmentKind::kReach:
      return "reach";
    case SegmentKind::kApproach:
      return "approach";
    case SegmentKind::kLift:
      return "lift";
    case SegmentKind::kCarry:
      return "carry";
    case SegmentKind::kPlace:
      return "place";
    case SegmentKind::kRetreat:
      return "retreat";
  }
  return "unknown";
}

}  // namespace prehend::motion
