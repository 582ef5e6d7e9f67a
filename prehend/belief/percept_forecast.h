#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/belief/percept_view.h"
#include "prehend/belief/percepts.h"
#include "prehend/planning/touch_prediction.h"
#include "prehend/surface/object_model.h"

// What is to be perceived of an act, by what is believed of the object.
namespace prehend::belief {

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
  /// After the lift: what was at p when it stood is at X_HO p in the hand's root frame.
  geometry::RigidTransform X_HO = geometry::RigidTransform::Identity();
  Eigen::VectorXd joints;  // then, of all of the hand's model [rad or m]
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

/// The shapes of a model: its mesh and its alternatives, by their weights, each of `mass` [kg], >
/// 0.
std::vector<PossibleShape> possible_shapes(const surface::ObjectModel& object,
                                           const geometry::Plane& table_W, double mass);

/// Who looks at what was lifted, and what of the robot but the hand may hide it then.
struct ViewAfterLift {
  geometry::PinholeCamera camera;
  geometry::RigidTransform X_WC = geometry::RigidTransform::Identity();  // optical frame
  geometry::RigidTransform X_WH = geometry::RigidTransform::Identity();  // the hand's root, lifted
  std::vector<geometry::TriangleMesh> arm_W;                             // its links, lifted
};

struct PerceptOptions {
  ActOptions act;
  /// m, >= 0, standard deviation of where the object is along the hand's closing direction and
  /// across it, level: calibration, and how far it may be pushed before it is felt.
  double place = 0.0017;
  double least_weight = 0.05;  // of shapes, by the likeliest's, in [0, 1]: what is less is left out
  int most_shapes = 3;         // >= 1
  std::optional<ViewAfterLift> view;  // none: nobody looks

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// What is to be perceived of a grasp under each of the likelier shapes, each at five places: where
/// it is believed (weight 1/3) and sqrt(3) `place` off to either side along both axes (1/6 each),
/// the sigma points of a normal distribution in the plane (Julier and Uhlmann, "A new extension of
/// the Kalman filter to nonlinear systems", 1997, kappa = 1). With place 0 once for each shape.
/// What a camera is to show is of the lifted hand where `view` says that it is then. Deterministic.
/// Cost: docs/belief.md, "Surprise".
/// @throws std::invalid_argument for values out of range or no shape with a weight.
PerceptForecast predict_percepts(const robot::HandModel& hand, const planning::GraspToFeel& grasp,
                                 std::vector<PossibleShape> shapes,
                                 const PerceptOptions& options = {});

}  // namespace prehend::belief
