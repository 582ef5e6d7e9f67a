#pragma once

#include "msgs/percepts.pb.h"
#include "prehend/belief/percept_surprise.h"
#include "prehend/belief/percepts.h"

// What robots perceive of their acts, and were to perceive.
namespace prehend::convert {

/// Texels as float32.
msgs::Percepts to_message(const belief::Percepts& percepts);
/// @throws geometry::InputError where something is not finite, a force of a texel or an area is
/// negative, or a view's depth is not of its size.
belief::Percepts from_message(const msgs::Percepts& message);

/// Depth to 0.1 mm.
msgs::PerceivedView to_message(const belief::PerceivedView& view);

msgs::PossiblePercepts to_message(const belief::PossiblePercepts& possible);

/// Without header and ids.
msgs::PerceptForecast to_message(const belief::PerceptForecast& forecast);

/// Without header and ids. @param forecast that the surprise is about.
msgs::PerceptSurprise to_message(const belief::PerceptSurprise& surprise,
                                 const belief::PerceptForecast& forecast,
                                 const belief::Percepts& perceived);

}  // namespace prehend::convert
