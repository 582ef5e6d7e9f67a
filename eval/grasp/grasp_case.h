#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "eval/case_result.h"
#include "prehend/control/surprise.h"

namespace prehend::eval {

/// What grasps are planned on. They are executed on the truth all the same.
enum class PlannedOn { kPredicted, kTruth, kDelaunay };
inline constexpr PlannedOn kPlannedOn[] = {PlannedOn::kPredicted, PlannedOn::kTruth,
                                           PlannedOn::kDelaunay};
const char* to_string(PlannedOn planned_on);

/// The stage of a trial of which success was said, but is none.
inline constexpr const char* kSaidUntruly = "truth";

/// Planning and executing the grasps of one object by one setting of the planner.
struct GraspTrial {
  std::string setting;  // of the planner; "predicted", "truth", "delaunay" for the defaults
  std::string problem;  // why nothing was executed
  bool is_planned_only = false;  // as it was to tell whether the object fits
  std::string outcome;           // of the execution's first attempt, in words
  /// Where the first attempt ended that did not succeed: view, plan, arm (it has no motion), a
  /// phase of the cycle, or kSaidUntruly; else empty.
  std::string stage;
  int candidates = 0;               // of the plan
  int grasps = 0;                   // in the plan
  int attempts = 0;                 // that were executed
  int touches = 0;                  // of the object before it was lifted
  int plans = 1;                    // that they were of: 1 + those of new looks
  int recalled = 0;                 // of those, with what attempts before had found out
  bool lifted = false;              // and carried, and put down
  double plan_seconds = kUnknown;   // processor time of planning, one thread
  double grasp_seconds = kUnknown;  // of it: for the hand's grasps, without the arm's motion
  double slip = kUnknown;           // m, in the hand while it was lifted and carried
  double contact_error = kUnknown;  // m, mean, of the predicted contacts from the true surface
  /// Contact area predicted over that which was felt, less 1; of hands with pads.
  double area_error = kUnknown;
  /// m, of the opening at the touch, felt less predicted; of grippers that regulate their grip.
  double opening_error = kUnknown;
  double robustness = kUnknown;        // predicted of the executed grasp, the last
  double first_robustness = kUnknown;  // the same of the first attempt's
  double best_robustness = 0;          // predicted, of all grasps
  double guessed_contact = kUnknown;
  std::vector<control::Surprise> surprises;  // of all attempts; reactions and tolerances left out

  bool lifted_at_first() const { return lifted && attempts == 1; }
};

/// One view of an object, and what each way of planning made of it.
struct GraspCase {
  std::string case_name;
  std::string group;
  std::string data_set;
  std::string platform;
  int orientation = 0;                // degrees
  int others = 0;                     // bodies beside the object, which do not move
  std::string problem;                // nothing was segmented or completed, or the process crashed
  double predict_seconds = kUnknown;  // processor time from segmented cloud to mesh
  std::vector<GraspTrial> trials;

  const GraspTrial* trial(const std::string& setting) const;
  /// Trials that were to be executed.
  std::vector<GraspTrial> executed() const;
  /// Knowing the truth, the planner finds a grasp that holds in at least half of its disturbed
  /// trials (see grasp::UncertaintyOptions).
  bool fits() const;
};

/// As YAML, and back. @throws geometry::InputError for a text that is no result.
std::string to_text(const GraspCase& result);
GraspCase read_grasp_case(const std::string& text);

}  // namespace prehend::eval
