#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/grasp/closing/close_fingers.h"
#include "prehend/grasp/known/grasp_memory.h"
#include "prehend/grasp/load_bounds.h"
#include "prehend/planning/camera_look.h"
#include "prehend/planning/decision.h"
#include "prehend/planning/platform_pick.h"
#include "prehend/planning/probe_plan.h"
#include "prehend/planning/push_plan.h"
#include "prehend/planning/remedies.h"
#include "prehend/planning/touch_prediction.h"
#include "prehend/robot/platform.h"

// From an object to grasps that a platform can execute, as its node and its evaluation plan them.
namespace prehend::planning {

/// The other objects of a view, in the world frame. Pads keep from the meshes, fingers and arm from
/// their pieces.
struct Neighbours {
  std::vector<geometry::TriangleMesh> meshes_W;  // as predicted
  std::vector<geometry::TriangleMesh> pieces_W;  // convex, of the same
};

/// A grasp of a platform's hand and the arm's way round it.
struct PlannedPick {
  grasp::Grasp grasp;
  PredictedTouch touch;                       // of those with a motion
  std::vector<motion::PickSegment> segments;  // timed; empty: no motion was planned for it
  std::optional<Eigen::Vector3d> move_W;      // m, by which the object is put elsewhere
  double place_share = 1;                     // motion::PickMotion's
  std::vector<SidewaysShift> shifts;          // as PlatformPick's, of those with a motion
  HeldViews views = {};                       // the same
};

/// An answer, kGraspable when something can be executed, with what it is of.
struct PlatformPlan : grasp::PlanAnswer {
  /// Those with a motion, best first, then the others; of an unsure shape each turn of grasps that
  /// hold the same of it, the best grasp's first.
  std::vector<PlannedPick> picks;
  std::vector<grasp::Rejection> rejections;           // where other candidates fell
  std::vector<motion::PickRejection> arm_rejections;  // where grasps fell for want of a motion
  /// What may be done with it, best first, by the grasps with a motion; empty: their chances are
  /// not known.
  std::vector<Choice> choices;
  PlannedProbe probe;      // of PlatformPlanOptions::probes; no segments: none can be made
  PlannedLook look;        // of PlatformPlanOptions::carried_camera
  PlannedPush push;        // of PlatformPlanOptions::push
  Remedies remedies;       // where no grasp can be executed; in `problem`, too
  int candidates = 0;      // of the hand: = its grasps + all `rejections`
  double robustness = -1;  // the largest of the hand's grasps, with or without a motion; -1: none's
  double grasp_time = 0;   // s, that planning the hand's grasps took
  double touch_time = 0;   // s, that predicting touch took
  double probe_time = 0;   // s, that planning the probe took
  double look_time = 0;    // s, that planning the look took
  double push_time = 0;    // s, that planning the push took
  double remedy_time = 0;  // s, that finding out what would help took
};

struct PlatformPlanOptions {
  /// @param hand of the platform: its grasps are planned by its grasp::default_options().
  explicit PlatformPlanOptions(const robot::HandModel& hand)
      : grasps(grasp::default_options(hand)) {}

  grasp::PlannerOptions grasps;  // their `reaches` is the arm's
  PlatformPickOptions arm;       // its moves_W are those of `place`
  PlaceOptions place;
  /// 0..1, how sure the shape is. Below 0.9 it is moved guarded (PlatformPickOptions::guarded).
  /// Below 0.5 it may be several things: what stands at its place is what the hand holds there, not
  /// the middle of the shape, and it may help to push it, even where it has grasps.
  double shape_confidence = 1;
  int motions = 3;  // > 0, of the grasps get the arm's motion: one for each attempt
  /// > 0. Where hand and arm can execute no grasp of the usual candidates, those with so many times
  /// as many steps are tried; 1: they are not. Not where the hand is too small or too weak for it.
  int finer = 2;
  /// N, >= 0, that the pads of a hand with fingers are to feel; 0: as the motors press.
  double grip_force = 0;
  /// How what the pads will feel is predicted of the grasps with a motion, within what `grasps`
  /// leaves of its budget; none: it is not.
  std::optional<TouchPredictionOptions> touch;
  RemedyOptions remedies;  // beside the budgets of the others
  DecisionOptions decision;
  /// Of the object, by what attempts told: grasps are planned with a density, friction and force
  /// within it (within_load()).
  grasp::LoadBounds load;
  /// Where a fingertip would learn most of the object, best first; empty: no probe is planned.
  std::vector<ProbeWay> probes;
  ProbePlanOptions probe;
  /// How it can be pushed: where its shape is unsure, below 0.5; and where the arm can execute no
  /// grasp, as candidates fell for what stands beside it, or as it is less than 90 % sure and was
  /// not pushed before. None: no push is planned.
  std::optional<PushPlanOptions> push;
  /// The camera that the arm carries; none: no look from elsewhere is planned.
  std::optional<geometry::StereoCamera> carried_camera;
  ViewOptions look;
  /// What is held is turned before this camera (PlannedPick::views); none: it is not.
  std::optional<ViewingCamera> viewing;
  HeldViewOptions views;

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// What was assumed of any object, `options` and the hand's friction, within what is known of this
/// one's load, of so much volume [m^3]:
/// - the density is the greatest that its mass allows, and hollow it is no more than that;
/// - the friction that is planned with and what it is disturbed by are grasp::within() the known;
/// - `grip_force`, where there is one, is at least what the mass asks of two pads with that
/// friction
///   and the safety factor, when it has slipped.
/// Nothing changes where nothing is known. @pre volume > 0
void within_load(const grasp::LoadBounds& load, double volume, PlatformPlanOptions* options,
                 robot::HandModel* hand);

/// Plans grasps of a platform's hand and the motion of the arm that carries it: plan_grasps()
/// within the arm's reach, free_places_for(), and plan_platform_pick() for as many as get a motion.
class PlatformPlanner {
 public:
  explicit PlatformPlanner(robot::Platform platform);
  PlatformPlanner(const PlatformPlanner&) = delete;
  PlatformPlanner& operator=(const PlatformPlanner&) = delete;

  const robot::Platform& platform() const { return platform_; }
  /// Plans for this gripper, which the robot says it has. @pre platform().hand.gripper
  void set_gripper(const robot::GripperModel& gripper);

  /// @param object of which the convex pieces are what the arm keeps from.
  /// @param start of the arm's joints.
  /// @param database of grasps for an object that is `known`; null or unset: all are planned anew.
  /// @throws as plan_grasps(), free_places_for() and plan_platform_pick().
  PlatformPlan plan(const surface::ObjectModel& object, const geometry::Plane& table_W,
                    const Neighbours& neighbours, const grasp::Reachability& reachability,
                    const robot::Positions& start, const PlatformPlanOptions& options,
                    grasp::GraspDatabase* database = nullptr,
                    const std::optional<grasp::PlacedObject>& known = std::nullopt) const;

 private:
  /// Grasps that the arm reaches none of.
  struct Unreached {
    std::vector<PlatformGrasp> grasps;
    PlatformPickOptions arm;
  };
  /// Grasps by which the same of the object is put at a place, and where that may be.
  struct Turn {
    std::vector<grasp::Grasp> grasps;  // best first
    FreePlaces places;
  };
  std::vector<Turn> turns(std::vector<grasp::Grasp> grasps, const PlatformScene& scene,
                          const PlatformPlanOptions& options) const;
  Unreached add_motions(std::vector<grasp::Grasp> grasps, const PlatformScene& scene,
                        const robot::Positions& start, const PlatformPlanOptions& options,
                        PlatformPlan* plan) const;

  void add_probe(const grasp::HandToClose& hand, const surface::ObjectModel& object,
                 const PlatformScene& scene, const robot::Positions& start,
                 const PlatformPlanOptions& options, PlatformPlan* plan) const;

  void add_push(const grasp::HandToClose& hand, const surface::ObjectModel& object,
                const PlatformScene& scene, const robot::Positions& start,
                const PlatformPlanOptions& options, PlatformPlan* plan) const;

  void add_look(const surface::ObjectModel& object, const PlatformScene& scene,
                const robot::Positions& start, const PlatformPlanOptions& options,
                PlatformPlan* plan) const;

  void predict_touch(const surface::ObjectModel& object, const geometry::Plane& table_W,
                     const PlatformPlanOptions& options, PlatformPlan* plan) const;

  robot::Platform platform_;
  grasp::HandToClose hand_;  // of platform_
};

}  // namespace prehend::planning
