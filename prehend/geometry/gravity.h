#pragma once

namespace prehend::geometry {

/// What weighs on everything, in m/s^2, where nothing else is said.
inline constexpr double kGravity = 9.81;

}  // namespace prehend::geometry
