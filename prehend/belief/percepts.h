#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/image.h"

// What a robot perceives of an act; what it is to perceive by what is believed of the object:
// percept_forecast.h.
namespace prehend::belief {

/// Force and torque of what touches the hand, in its root's frame H about its origin.
struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   // N
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();  // N m
};

/// A pad as it feels at a moment.
struct PadImage {
  std::vector<double> texels;                          // N, rows * columns; empty: no sensor
  double force = 0;                                    // N, their sum
  Eigen::Vector3d center_P = Eigen::Vector3d::Zero();  // m, their mean by force, see HandPad
  double area = 0;                                     // m^2, of texels above the touch threshold
};

/// Of one pad over the act.
struct PerceivedPad {
  std::string name;
  std::array<PadImage, 2> at;  // closed, lifted
  /// rad, robot::ClosingWay::closure() when it first felt GripOptions::touch_force; none: it never
  /// did while the hand closed.
  std::optional<double> touched_at;
};

/// Of one motor: where it stood at either moment, and when it stopped.
struct PerceivedMotor {
  std::string name;
  std::array<std::optional<double>, 2> at;  // rad or m, closed, lifted; none: no sensor
  /// s, from the beginning; of a jaw, which may come with any speed to where it touches, from the
  /// first touch of a pad (negative: before it). From then on it stood within 0.02 rad (2 mm of a
  /// jaw) of where it was when closed. None: no sensor, or a jaw that touched nothing.
  std::optional<double> stopped_after;
};

/// What a camera shows of what the hand has lifted, the hand itself left out.
struct PerceivedView {
  /// m, of it alone, NaN elsewhere: the part of the picture where it may be; see percept_view.h.
  geometry::DepthImage depth;
  double area = 0;                                     // m^2, across the line of sight; 0: none
  Eigen::Vector3d center_C = Eigen::Vector3d::Zero();  // m, its middle from the hand's origin,
                                                       // along the camera's axes
  Eigen::Vector2d spread = Eigen::Vector2d::Zero();    // m, standard, along the picture's axes
};

inline constexpr std::size_t kClosed = 0, kLifted = 1;

/// What was perceived of an act: a hand closes where it stands, and lifts. What a robot has no
/// sensor for is left out: an empty list, image or optional.
struct Percepts {
  std::vector<PerceivedPad> pads;              // in the hand's order
  std::vector<PerceivedMotor> motors;          // in the hand's order
  std::optional<Wrench> closing;               // mean over the closing
  std::array<std::optional<Wrench>, 2> wrist;  // closed, lifted
  std::optional<double> weight;                // N, that the wrist carries after the lift
  std::optional<PerceivedView> view;           // after the lift
};

/// @throws std::invalid_argument naming the first value that is not finite, e.g.
/// "Percepts: pad 'finger_1_distal', closed: force is not finite".
void check_percepts(const Percepts& percepts);

/// One of the things that may be perceived.
struct PossiblePercepts {
  std::string shape;  // PossibleShape::name
  double along = 0;   // m, of the object against where it is believed to be, tool's y
  double across = 0;  // m, tool's x
  double weight = 0;  // of all 1
  Percepts percepts;
};

struct PerceptForecast {
  std::vector<PossiblePercepts> possible;
  /// Of shapes that could not be simulated, "name: why"; the others' weights make up for them.
  std::vector<std::string> problems;
};

}  // namespace prehend::belief
