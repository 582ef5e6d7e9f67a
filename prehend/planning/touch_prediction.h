#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/grasp/grasp.h"
#include "prehend/robot/grip.h"
#include "prehend/robot/hand_model.h"
#include "prehend/simulation/robot_world.h"
#include "prehend/surface/object_model.h"

// What a hand's pads will feel when it closes on a predicted object.
namespace prehend::planning {

/// A grasp to be simulated, as grasp::Grasp has its parts.
struct GraspToFeel {
  geometry::RigidTransform X_WG = geometry::RigidTransform::Identity();  // tool of the preshape
  std::string preshape;                                                  // of the hand
  Eigen::VectorXd open, closed;  // rad or m, of the motors; see grasp::Grasp
  double force = 0;              // N, per pad; 0: GripOptions::grip_force
  double effort = 1;             // share of what the hand can that is thought to hold it, (0, 1]
};

/// Of a planned grasp. One that needs next to no effort has the least that can be simulated.
GraspToFeel grasp_to_feel(const grasp::Grasp& grasp);

/// What is to be felt: one rigid body on its table.
struct ObjectToFeel {
  geometry::TriangleMesh mesh_W;
  geometry::Plane table_W;
  double mass = 0.3;  // kg, > 0
};

/// One pad as it should feel.
struct PredictedPad {
  std::string name;
  int rows = 0, columns = 0;
  std::vector<std::uint16_t> counts;  // rows * columns, as its electronics show them
  double sum = 0;                     // N
  double area = 0;                    // m^2, robot::touched_area()
  /// m, in the pad's frame P (robot::HandPad): where its touched texels are, their mean by their
  /// counts; 0 without any. On a curved pad it may lie below the face.
  Eigen::Vector3d center_P = Eigen::Vector3d::Zero();
};

enum class TouchOutcome {
  kNotAsked,
  kPredicted,
  kNoPads,        // of the hand
  kBudgetUsed,    // before it was known
  kNotSimulated,  // what is predicted is no solid body
  // From here on nothing of that grasp is to be felt.
  kNotStanding,  // the object does not stand as it was predicted
  kFallsOver,    // or flies off while the hand closes
  kMissed,       // the hand closes beside the object
  kBesidePads,   // the hand touches it, but no pad does
};

struct PredictedTouch {
  TouchOutcome outcome = TouchOutcome::kNotAsked;
  /// Why nothing is predicted, in words; empty when it is, or was not asked for.
  std::string problem;
  // Of kPredicted; else empty.
  std::vector<PredictedPad> pads;  // all of the hand
  robot::MeanTouch mean;           // of those that touch, as the cycle compares it
  Eigen::VectorXd stopped;         // rad or m, of the motors, where they met it

  /// The simulation says that there is nothing to be felt, not only that nobody knows.
  bool is_refuted() const { return outcome >= TouchOutcome::kNotStanding; }
};

struct TouchPredictionOptions {
  robot::GripOptions grip;                 // as the cycle's that will execute the grasp
  int touch_counts = robot::kTouchCounts;  // >= 0, above: a texel is touched
  simulation::RobotWorldOptions world = coarse();
  double friction = 0.7;       // of the object, >= 0; with the hand's the smaller counts
  double largest_tilt = 0.35;  // rad, > 0: an object that leans more has fallen over
  double budget = 0;           // s of wall time, >= 0; 0: as long as it takes
  int threads = 0;             // of predict_touches(); 0: as many as there are cores

  /// Steps of 4 ms: a third of the cost of the robot's world, of 1 ms. Sums differ by 1 %, by 7 %
  /// at most (docs/planning.md).
  static simulation::RobotWorldOptions coarse();

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// Closes the hand on the object in simulation::RobotWorld, as the cycle of arm and hand does it:
/// the hand stands still at the grasp, open; the object stands free on its table; fingers gather,
/// close until they press, press on until their pads feel the force, and rest. What the pads then
/// say is the prediction. The arm, the approach and neighbours are left out; gravity is along the
/// table's normal.
///
/// Whatever keeps it from a prediction is told (TouchOutcome), never guessed around.
///
/// Same arguments, same answer, unless a budget ends it. Cost: docs/planning.md, "Touch".
/// @throws std::invalid_argument for a grasp of another hand or values out of range,
/// geometry::InputError for an unknown preshape.
PredictedTouch predict_touch(const robot::HandModel& hand, const GraspToFeel& grasp,
                             const ObjectToFeel& object,
                             const TouchPredictionOptions& options = {});

/// Of several grasps, on several threads; the budget is that of all of them.
std::vector<PredictedTouch> predict_touches(const robot::HandModel& hand,
                                            const std::vector<GraspToFeel>& grasps,
                                            const ObjectToFeel& object,
                                            const TouchPredictionOptions& options = {});

/// The same of planned grasps of one object, in their order: adds to their `predicted` what is
/// felt. Where the simulation says that nothing is felt, `predicted` has no touch either; where it
/// does not know, it stays what it was. @throws as predict_touches().
std::vector<PredictedTouch> add_touch(const robot::HandModel& hand,
                                      const surface::ObjectModel& object,
                                      const geometry::Plane& table,
                                      const TouchPredictionOptions& options,
                                      std::vector<grasp::Grasp>* grasps);

}  // namespace prehend::planning
