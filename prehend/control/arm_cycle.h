#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/control/arm_cycle_options.h"
#include "prehend/control/arm_grasp.h"
#include "prehend/control/arm_ports.h"
#include "prehend/control/cycle.h"
#include "prehend/control/grip_judge.h"
#include "prehend/control/holding.h"
#include "prehend/control/input_watch.h"
#include "prehend/control/joint_trajectory.h"
#include "prehend/touch/hold_slip.h"

namespace prehend::control {

/// Executes a task with an arm and a hand: opens the hand, reach, approach, close, lift, weighs
/// what is held, carry, place, open, retreat, weighs the empty hand. While it lifts, carries and
/// lowers, what is held is watched (Holding): by its weight where nothing else bears it, which is
/// all but the end of lowering, and by the fingers all the time.
///
/// A hand that feels its grip (HandPort) decides by its pads and its opening instead of the weight.
/// Where it touches something on the approach it lets go; with `reacts` and near the approach's end
/// (`largest_shortfall`), where its pads are beside the object already, it goes back from what is
/// under its jaws and closes there. Farther off it closes where a pad feels something: that is
/// between the jaws.
///
/// Of others, where the plan says a force and pads speak, the motors press harder until the mean of
/// the pads that touch feel it; what pads do not say is not compared.
///
/// Where pads feel and a judge was given (judge_grips()), what they feel tells how likely the lift
/// will hold: said in the result, and below `minimum_stability` the hand presses harder where the
/// judge thinks that this helps and it can, else the attempt fails before it lifts, or, when it has
/// risen by kAskedWhenRisen, before it rises further.
///
/// Where pads feel, what they show from the lift on tells whether what is held slips
/// (touch::HoldSlip, long before anybody sees it), while nothing else bears it. Then the hand holds
/// it `slip_force_factor` times as hard, as often as needed, within what its motors can and
/// `largest_grip_force`. Where that is not enough while it is lifted, and it slides by more than
/// `largest_slide`, it is put down again, and the attempt has failed; on the way to a place, it
/// goes on, as nothing else is nearer. The next grasp of the object begins with that much more than
/// it slipped with, unless it was planned by how it slipped (ArmGrasp::knows_slip).
///
/// With `reacts` and shifts of the plan, fingers that meet something too early on the approach, or
/// beside its prediction, tell by where they were stopped how far it is beside
/// (displacement_felt()). They let go, the hand follows as far as the plan says that it is free to
/// (ArmGrasp::shifts), goes on with what is left of the approach, and closes again, at most
/// `adaptations` times in an attempt.
///
/// A probe (ArmGrasp::probe_H) goes straight with the open hand until the wrist feels `probe_force`
/// or a pad more than at rest, by `touch_force`; stands a moment, so that all sensors tell of it,
/// and goes back.
///
/// A push (ArmGrasp::pushes) goes straight through what the hand meets, to its end or until the
/// wrist feels `push_force`, whatever its pads feel, and goes back.
///
/// What is felt is compared with what was predicted (surprises), and no attempt fails without one.
/// Where fingers that open press on something at a place, or jaws cannot open there for what stands
/// beside them, the hand goes up from it, and they go on. Jaws that feel nothing any more leave,
/// however far they are open. A retreat that has hit something goes on from there, as what was hit
/// may have given way, three times at most.
/// It retreats as planned from a place, else back the way it came, as far as it came. Fingers that
/// take along what was put down (one that stood in a cup hooks it when it opens) put it back, open
/// by little, and leave again. Looks again (Cycle) are taken from where the arm stood at first;
/// after a place only where the retreat has led onto the way there, as from straight above, else
/// from the retreat's end.
///
/// Where somebody looks at what was lifted (view_lifts_by()), it stands still after the lift until
/// that has ended. What the look finds changes nothing.
///
/// Inspecting (inspect_by()), the arm turns what is held to each of the plan's views and back, and
/// waits at each until it was looked at. A look that fails is no failed attempt.
///
/// It begins when joints and wrist have spoken. From then on, whenever one of them falls silent
/// (`stale_time`), or who carries out a motion (`answer_time`), arm and hand are stopped and the
/// cycle ends with that reason; not while it stands and waits for a new look.
///
/// Sources: Bohg et al., "Mind the Gap", ICRA 2011, section IV: KTH's platform open loop, UJI's
/// with reaction to contact. Not thread-safe. Never blocks, never throws after start().
class ArmCycle : public Cycle {
 public:
  /// Keeps references to the ports. @throws std::invalid_argument for options out of range.
  ArmCycle(const ArmCycleOptions& options, ArmPort& arm, HandPort& hand);

  /// That is tried now, or was last. @pre it has begun to try one
  const ArmGrasp& grasp() const { return grasps_[static_cast<std::size_t>(grasp_index())]; }

  /// From now on it says how likely lifts hold. @pre not started
  void judge_grips(GripJudge judge) { judge_ = std::move(judge); }

  /// From now on it is looked at what it turns before a camera. Keeps a reference.
  /// @pre not started
  void inspect_by(InspectionPort& inspection) { inspection_ = &inspection; }

  /// From now on what it has lifted is looked at, while it is weighed. Keeps a reference.
  /// @pre not started
  void view_lifts_by(InspectionPort& view) { lift_view_ = &view; }

  /// Starts from the first grasp. An empty list ends at once as failed, with `problem` as reason.
  /// @throws std::invalid_argument for a minimum_stability without a judge of grips.
  void start(std::vector<ArmGrasp> grasps, const std::string& problem = "", Advice advice = {});
  /// One step; call it at 20 Hz or more. @pre percepts.time does not decrease.
  void step(const ArmPercepts& percepts);
  /// Goes on with these, best first; none of a new look when empty, for the reason `problem`.
  /// @pre looks_since() is set
  void take_plan(std::vector<ArmGrasp> grasps, const std::string& problem = "", Advice advice = {});
  /// What it feels of the load of the present attempt.
  const Holding& holding() const { return holding_; }
  /// While a probe's fingertip stands at what it has met: its foremost point, in the hand's root
  /// frame [m].
  std::optional<Eigen::Vector3d> met_with_H() const;

 private:
  /// Parts of actions.
  enum class Step {
    kOpen,
    kReach,
    kRest,
    kApproach,
    kMet,
    kBackOff,
    kGather,
    kFeel,
    kLoosen,
    kShift,
    kClose,
    kPress,
    kHarder,
    kSettle,
    kLift,
    kCheck,
    kBrake,
    kSetDown,
    kCarry,
    kLower,
    kRaise,
    kPlace,
    kRelease,
    kRelieve,
    kPutBack,
    kLoosenHold,
    kRetreat,
    kVerify,
    kGoBack,
    kTurn,
    kStill,
    kInspect,
    kTurnBack,
    kToView,
    kAtView,
    kFromView,
    kWait
  };

  void begin(const Action& action) override;
  void prepare_attempt() override;
  void clear_view() override;
  std::optional<int> probe_grasp() const override;
  std::optional<int> push_grasp() const override;
  void go_to_view(const JointTrajectory& way) override;
  void leave_view() override;
  void stop_motion() override;
  void enter(Step step, const std::string& detail);
  bool moves_hand() const;
  bool waits() const;
  /// It lets go of what is held, or leaves it: what fails then is no attempt's failure.
  bool leaves() const;
  /// What the cycle relies on.
  std::vector<InputAge> inputs();
  void step_waiting();
  /// Stops and ends when something of it is lost; true then.
  bool stop_when_lost();
  /// Starts the segment that is gone in `step`; without it `step` ends.
  void begin_segment(Step step, double contact_force);
  void begin_move(const Action& action);
  /// Of the present step: what is held is turned before a camera.
  bool inspects() const;
  bool looks_at_lift();
  void begin_inspection();
  void begin_view();
  void look_at_held();
  void after_look();
  void next_view();
  using FromHere = decltype(&joined);
  void follow(const JointTrajectory& path, double contact_force, bool leads_back = true,
              FromHere from_here_on = joined);
  /// Of the present grasp; null when it has none.
  const JointTrajectory* segment(motion::SegmentKind kind) const;
  /// That is gone in a step; none in the others.
  static std::optional<motion::SegmentKind> segment_of(Step step);
  MotionStatus motion_status();
  void drive_fingers(double past);
  void gather();
  void close();
  void press();
  std::vector<double> efforts() const;  // N m or N, of the hand's joints now
  void after_pressing();
  double wanted_force() const;  // N, per pad; 0: none
  void compare_touch();
  /// It has gripped: asks the judge; presses harder, fails, or ends the grasp.
  void judge_grip();
  bool press_harder();
  /// Fails when the judge says while lifting that it will not hold; true then.
  bool judge_lift();
  std::string foretold() const;  // in words, for the result; empty: nothing
  void begin_hold();
  bool bears_alone() const;  // what is held
  bool hold_harder();
  /// Reacts when what is held slips; true when the step has ended by that.
  void remember_slip();
  bool watch_slip();
  void set_down();
  void begin_place();
  bool can_relieve() const;
  bool is_high() const;
  void after_setting_down();
  std::string slipped() const;  // in words, for the result; empty: it did not
  bool is_probe() const { return grasp().probe_H.has_value(); }
  /// A pad feels more than it did before the approach.
  bool pads_meet() const;
  void after_approach(MotionStatus status);
  void after_closing(MotionStatus status);
  void after_placing(MotionStatus status);
  void advance(MotionStatus status);
  /// The present step ends as planned where something is touched.
  bool reacts_to_contact() const;
  double contact_force_down() const;    // N, at which what is lowered is met
  double held_collision_force() const;  // N
  double pressed_force() const;         // N
  bool hits_on_lift();
  std::optional<double> closure() const;
  double felt_contact(double borne) const;
  /// Gives up when what is held is lost; true then.
  bool watch_held();
  void check();
  void verify();
  /// Goes back a little from what the jaws touch on the approach: near its end, or where what they
  /// touch is between them; false: it does not.
  bool back_off(bool is_between);
  /// Feels where the thing is on which the approach has ended early; false: it does not adapt.
  bool feel();
  /// Lets go to shift the hand, as the fingers were stopped beside the prediction; false: it stays.
  bool adapt(bool felt_only);
  void shift();
  void approach_again();
  void retreat();
  /// The hand presses on something at the place.
  bool presses() const;
  bool opens_onto_something() const;
  void relieve(bool opens_on);
  /// Of jaws that do not open: goes on all the same; true then.
  bool leaves_jammed();
  /// The retreat goes on from where it has hit something; true then.
  bool retreats_on();
  /// It goes off what it has hit on its way back, and no further; true then.
  bool stays_before_hit();
  void open_hand(Step step, const std::string& detail);
  void open_to_release();
  /// Puts down again what the hand has taken along, to leave it with fingers that open less.
  void put_back();
  void open_less();
  void go_back();
  /// The last way that was gone, as far as it came.
  void go_back_along();
  void fail(const std::string& reason);

  ArmCycleOptions options_;
  ArmPort& arm_;
  HandPort& hand_;
  std::vector<ArmGrasp> grasps_;
  std::optional<GripJudge> judge_;
  InspectionPort* inspection_ = nullptr;
  InspectionPort* lift_view_ = nullptr;
  bool lift_looked_at_ = false;      // in this attempt
  bool lift_is_free_ = false;        // of what the grip pressed on the table
  ArmPercepts gripped_percepts_;     // when the lift began
  std::size_t view_ = 0;             // of the plan's
  int views_seen_ = 0;               // of this inspection
  std::string view_problem_;         // of the last look that failed
  std::string last_found_;           // by the last look that was taken
  std::string inspected_;            // in words, for the result; empty: it was not
  std::optional<double> stability_;  // that the lift holds, as judged last
  bool pressed_harder_ = false;      // in this attempt
  touch::HoldSlip hold_slip_;
  bool holds_ = false;        // from the lift on: whether it slips is watched
  double slid_ = 0;           // m, in this attempt
  double time_to_stand_ = 0;  // s, of the way down that was begun last; 0: there is none
  Step step_ = Step::kWait;
  double wait_time_ = 0;                    // s
  double share_ = 1;                        // of the greatest effort, that the motors press with
  double pressed_since_ = 0;                // s
  bool put_down_ = false;                   // what is held stands where it stood, or at its place
  std::optional<JointTrajectory> lowered_;  // the last way down
  double least_force_ = 0;  // N, per pad, of grasps of this object, by how it slipped
  bool gently_ = false;     // closes until it touches
  bool lowers_fully_ = false;
  std::string refused_;          // why a segment could not begin
  double gripped_ = 0;           // rad, closure() when it had gripped
  int reliefs_ = 0;              // times that it went up from what it pressed on
  int hits_ = 0;                 // times that the retreat has hit something and went on
  bool opens_on_ = false;        // after the last one
  bool opened_less_ = false;     // to leave what the hand had taken along
  int adapted_ = 0;              // times in this attempt
  FollowedShift shift_;          // that comes next
  std::vector<double> shifted_;  // rad or m, of the arm's joints, by all shifts of this attempt
  bool clears_ = false;          // it goes back to look again
  std::map<std::string, double> sums_at_rest_;  // N, of pads, before the approach
  std::vector<JointTrajectory>
      gone_;                       // that were begun in this attempt, and lead back when reversed
  JointTrajectory way_back_;       // that is gone now, of one of them
  double pressed_at_release_ = 0;  // N, when the hand began to open
  InputWatch watch_;
  ArmPercepts percepts_;
  Holding holding_;
};

}  // namespace prehend::control
