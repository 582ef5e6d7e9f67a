#pragma once

#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/grasp/collision.h"
#include "prehend/grasp/generator.h"
#include "prehend/grasp/hand_closing.h"
#include "prehend/grasp/ledger.h"
#include "prehend/grasp/uncertainty.h"
#include "prehend/surface/object_model.h"

namespace prehend::grasp {

struct HandScoreWeights {
  double quality = 0.4;      // epsilon / (epsilon + 0.05)
  double margin = 0.3;       // disturbance margin / (it + the weight)
  double centredness = 0.2;  // exp(-d / 30 mm), d from the centre of mass to the contacts' mean
  double pads = 0.1;         // share of the contacts that are on pads, or on a hand without pads
  /// The mean of the above is multiplied by 1 - guessed + guessed (mean share of the contacts that
  /// is on surface that is there), by vertex_confidence, ...
  double guessed = 0.5;  // 0..1
  /// ... and by 1 - robust + robust HandGrasp.robustness.
  double robust = 0.9;  // 0..1
};

/// A pose of the tool frame of a preshape.
struct HandCandidate {
  std::string preshape;  // by its name
  Candidate candidate;
};

struct HandPlannerOptions {
  HandPlannerOptions();

  std::vector<std::string> generators{"circles"};  // of generator_names(), at least one
  /// Tried as well when no grasp of the former holds in `enough` of its disturbed trials.
  std::vector<std::string> further_generators{"antipodal"};
  double enough = 0.5;                 // 0..1
  GeneratorOptions candidates;         // fewer than for a parallel gripper
  std::vector<std::string> preshapes;  // of the hand's; empty: all of them
  /// Every candidate also turned by half a turn about the approach, as hands are not symmetric.
  bool both_ways = true;
  /// To try instead of what the generators make, as PlannerOptions::given_W.
  std::vector<HandCandidate> given_W;
  HandClosingOptions closing;
  CollisionOptions collision;
  HandScoreWeights weights;
  UncertaintyOptions uncertainty;
  int robust_count = 8;             // >= 0, of the best grasps, are assessed for robustness; the
                                    // others count as if they never held
  int cone_edges = 8;               // >= 3, of the linearised friction cones
  double density = 800;             // kg/m^3, > 0, assumed of the unknown object
  double safety_factor = 1.5;       // >= 1, of the motors' limits against what the load needs
  double lift_acceleration = 1.0;   // m/s^2, >= 0, upwards on top of gravity
  double pregrasp_distance = 0.1;   // m, > 0, back along the approach
  double largest_shortfall = 0.03;  // m, >= 0, by which the hand may be stopped before its standoff
  int least_fingers = 2;            // > 0, that must touch the object (the palm counts as one)
  int largest_count = 32;           // > 0, of grasps in the result
  bool volume = false;              // also HandGrasp::volume, some ms for each grasp in the result
  double budget = 0;                // s of wall time, as PlannerOptions::budget
  int threads = 0;                  // >= 0; 0: all cores. The result does not depend on it
  /// Whether the arm reaches a pose of the hand's root; asked for the grasp and for the pregrasp,
  /// by several threads at once. Empty: it reaches all. Must give the same answer for the same
  /// pose.
  std::function<bool(const geometry::RigidTransform& X_WH)> reaches;

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

struct HandGrasp {
  std::string preshape;
  geometry::RigidTransform X_WH = geometry::RigidTransform::Identity();  // root when it closes
  geometry::RigidTransform X_WG = geometry::RigidTransform::Identity();  // preshape's tool frame
  Eigen::Vector3d approach_W = -Eigen::Vector3d::UnitZ();                // unit
  double roll = 0;                                                       // rad, about the approach
  double pregrasp_distance = 0;  // m, back along the approach
  Eigen::VectorXd open;          // of the motors: the preshape [rad or m]
  Eigen::VectorXd closed;        // of the motors, where the fingers touch
  Eigen::VectorXd closed_all;    // of all joints of the model
  std::vector<HandContact> contacts;
  Eigen::VectorXd torques;  // of the motors, that hold the load with the safety factor [N m or N]
  double effort = 0;   // share of the limits of the motor that needs most, with the safety factor
  double quality = 0;  // epsilon, see wrench_hull.h; torques over the object's radius
  double volume = 0;   // of the wrench space, see wrench_volume(); 0 unless asked for
  double margin = 0;   // N, see disturbance_margin(); torques over the object's radius
  double score = 0;    // what the list is ranked by, 0 to 1
  double robustness =
      -1;  // share of UncertaintyOptions.samples in which it holds; -1: not assessed
  double guessed_contact = 0;  // share of the contacts on surface that nobody saw
  std::string generator;       // whose candidate it was
  std::string remark;          // what to know of it, in words; often empty
};

struct HandPlan {
  std::vector<HandGrasp> grasps;      // best first
  std::vector<Rejection> rejections;  // where the other candidates fell, by reason and generator
  int candidates = 0;                 // = grasps + all rejections
  double mass = 0;                    // kg, of the object as predicted
  std::string problem;                // "cannot be grasped: ..." when there is no grasp, else empty
};

/// What a generator must know of a hand in a preshape: how far its fingertips reach while they
/// close, its pads' length, how far its fingers are apart when open.
HandReach hand_reach(const HandToClose& hand, const robot::Preshape& preshape);

/// Plans grasps of one object with a hand: each candidate with each preshape, the open hand moved
/// along the approach until it touches or is at its standoff, the fingers closed on the predicted
/// mesh (close_fingers()). Kept is what the arm reaches, what meets nothing on the way, what enough
/// fingers touch without the table or each other in between, what is force-closed with soft fingers
/// (wrench_hull()), and what the motors can hold against gravity and the lift's acceleration with
/// the safety factor (hold()). Whatever is refused is counted with its reason and nearest miss.
/// Contacts on surface that nobody saw are told in the remark. The best are closed again in
/// disturbed poses, with other friction, and on `object.alternatives_W`, as by plan_grasps().
///
/// Reentrant. Same input, same result, bit by bit, unless there is a budget.
/// @throws geometry::InputError for a mesh without triangles or volume, with NaN or bad indices, or
/// for an unknown preshape (with the nearest); std::invalid_argument for options out of range.
HandPlan plan_hand_grasps(const surface::ObjectModel& object, const geometry::Plane& table,
                          const Obstacles& obstacles, const HandToClose& hand,
                          const Reachability& reachability, const HandPlannerOptions& options = {});

}  // namespace prehend::grasp
