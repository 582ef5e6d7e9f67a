#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/planning/touch_prediction.h"

// What a robot perceives of an act, and what it is to perceive by what is believed of the object.
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
  std::optional<double> stopped_after;  // s, from the beginning; from then on it stood within 0.02
                                        // rad (1 mm of a jaw) of where it was when closed
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
};

/// @throws std::invalid_argument naming the first value that is not finite, e.g.
/// "Percepts: pad 'finger_1_distal', closed: force is not finite".
void check_percepts(const Percepts& percepts);

struct ActOptions {
  planning::TouchPredictionOptions touch;
  double lift_height = 0.05;  // m, > 0
  double lift_time = 0.5;     // s, > 0

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// What an act gave, and what became of the object.
struct SimulatedAct {
  Percepts percepts;
  /// The open hand touched the object before it began to close: a hand on an arm would not have got
  /// there.
  bool begins_in_touch = false;
  double slide = 0;   // m, of the object in the hand, from when it had closed to after the lift
  double raised = 0;  // m, of the object's lowest point, by the lift
};

/// Closes the hand on the object in the simulated world and lifts it: planning::predict_touch()
/// with all that is perceived, whatever comes of it; that fingers close on nothing is a percept,
/// too. Same arguments, same answer.
/// @throws geometry::InputError when the object does not stand or cannot be simulated,
/// std::invalid_argument for values out of range.
SimulatedAct simulate_act(const robot::HandModel& hand, const planning::GraspToFeel& grasp,
                          const planning::ObjectToFeel& object, const ActOptions& options = {});

/// What an object may be.
struct PossibleShape {
  std::string name;
  planning::ObjectToFeel object;
  double weight = 0;  // >= 0
};

struct PerceptOptions {
  ActOptions act;
  /// m, >= 0, standard deviation of where the object is along the hand's closing direction and
  /// across it, level: calibration, and how far it may be pushed before it is felt.
  double place = 0.0017;
  double least_weight = 0.05;  // of shapes, by the likeliest's, in [0, 1]: what is less is left out
  int most_shapes = 3;         // >= 1

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

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

/// What is to be perceived of a grasp under each of the likelier shapes, each at five places: where
/// it is believed (weight 1/3) and sqrt(3) `place` off to either side along both axes (1/6 each),
/// the sigma points of a normal distribution in the plane (Julier and Uhlmann, "A new extension of
/// the Kalman filter to nonlinear systems", 1997, kappa = 1). With place 0 once for each shape.
/// Deterministic. Cost: docs/belief.md, "Surprise".
/// @throws std::invalid_argument for values out of range or no shape with a weight.
PerceptForecast predict_percepts(const robot::HandModel& hand, const planning::GraspToFeel& grasp,
                                 std::vector<PossibleShape> shapes,
                                 const PerceptOptions& options = {});

}  // namespace prehend::belief
