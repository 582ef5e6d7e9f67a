#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "prehend/control/balance.h"
#include "prehend/control/cycle.h"
#include "prehend/control/grip_judge.h"
#include "prehend/control/holding.h"
#include "prehend/control/input_watch.h"
#include "prehend/control/joint_trajectory.h"
#include "prehend/control/pad_percept.h"
#include "prehend/motion/segment.h"
#include "prehend/robot/closing_way.h"
#include "prehend/robot/grip.h"
#include "prehend/touch/grasp_stability.h"
#include "prehend/touch/hold_slip.h"

namespace prehend::control {

/// A planned grasp with the arm's motion round it.
struct ArmGrasp {
  GraspPose pose;
  /// In the order in which they are run; some may lack.
  std::vector<std::pair<motion::SegmentKind, JointTrajectory>> segments;
  double approach_length = 0;  // m, of the straight way of the segment kApproach; 0: not known
  std::vector<std::string> hand_joints;
  robot::ClosingWay hand;   // of hand_joints
  double lifted_mass = 0;   // kg, predicted; 0: not predicted. Compared, but decides nothing
  double score = 0;         // expected success, 0 to 1
  double robustness = -1;   // share of disturbed trials in which it holds; -1: not assessed
  double force = 0;         // N, per pad, that it is to be held with; 0: as the motors press
  bool knows_slip = false;  // that force is by how the object slipped before
  double effort = 1;        // share of what the hand can that this is thought to take, in (0, 1]
  std::vector<double> largest_effort;  // N m or N, of hand_joints; empty: not known
  /// What the pads that touch are predicted to feel then, their mean [m^2, N]; 0: not predicted.
  double contact_area = 0, tactile_sum = 0;
  double closure = 0;  // rad, predicted, that the hand has closed when it meets it, by ClosingWay
  /// How it can adapt to a thing that is beside its prediction, and how it feels that: of
  /// hand_joints, see displacement_felt(). Empty: it does not, as where no simulated hand has said
  /// where its motors are stopped.
  std::vector<HandShift> shifts;
  robot::FingertipWays fingertips;  // in the world
  Eigen::VectorXd stops;            // rad or m, where it is predicted to be stopped by the thing
  /// It is no grasp but a probe: the fingertip's foremost point on its way, in the hand's root
  /// frame [m]. Unset: a grasp.
  std::optional<Eigen::Vector3d> probe_H;
};

/// "grasp 2 (score 0.71, held in 80 % of the disturbed trials)".
std::string described(const ArmGrasp& grasp, int index);

/// What the cycle asks of an arm. Calls return at once.
class ArmPort {
 public:
  virtual ~ArmPort() = default;
  /// Stops when the wrist force exceeds `contact_force` [N] if that is positive.
  virtual void follow(const JointTrajectory& path, double contact_force) = 0;
  virtual MotionStatus motion() = 0;  // of the last follow; kContact: stopped by it
  /// Seconds since who carries out the last follow gave a word of it; 0 when it has ended or
  /// answers at once, infinity when he is gone.
  virtual double answer_age() { return 0; }
  virtual std::string problem() = 0;  // why that failed, in words
  virtual void stop() = 0;
};

struct ArmPercepts;

/// What the cycle asks of a hand. Calls return at once.
class HandPort {
 public:
  virtual ~HandPort() = default;
  /// Speeds are shares of the joints' greatest. @param until_contact fingers stop where they press,
  /// with `effort` of each joint [N m or N]; empty: the hand's own.
  virtual void move(const std::vector<std::string>& joints, const std::vector<double>& positions,
                    double speed, bool until_contact, const std::vector<double>& effort) = 0;
  virtual MotionStatus motion() = 0;         // of the last move; kContact: fingers press
  virtual double answer_age() { return 0; }  // as ArmPort's
  virtual std::string problem() = 0;
  /// Of its joints where the last motion ended [rad or m]; empty: not known.
  virtual std::vector<double> positions() = 0;
  virtual void stop() = 0;

  /// It controls its force by its pads from press() on, and tells by them and by its opening
  /// whether it holds something. What follows is of such hands.
  virtual bool feels_its_grip() const { return false; }
  virtual void prepare(const ArmGrasp& /*grasp*/) {}           // an attempt with it begins
  virtual void step(const ArmPercepts& /*percepts*/) {}        // in each step of the cycle
  virtual std::vector<InputAge> inputs() const { return {}; }  // that it relies on
  virtual std::string fault() const { return {}; }  // that ends all, in words; empty: none
  virtual bool touches() const { return false; }    // something, while the arm approaches
  /// After a closing that ended in contact: to the force of the grasp; motion() is of it then.
  virtual void press() {}
  /// After press(): to so many times the force, and no more than it can; motion() is of it then.
  /// False: it does not.
  virtual bool press_harder(double /*factor*/) { return false; }
  /// While it holds: from now on with so many times the force, and no more than `largest` [N per
  /// pad; 0: no limit but its own]. Returns at once. False: it already holds as hard as it can.
  virtual bool hold_harder(double /*factor*/, double /*largest*/) { return false; }
  virtual double opening() const { return 0; }  // m, now
  /// Why what was gripped is not held any more, in words; empty: it is. @param rests on something
  virtual std::string lost(bool /*rests*/) const { return {}; }
  virtual std::string grip() const { return {}; }        // how it holds, in words
  virtual std::string still_felt() const { return {}; }  // after it has let go; empty: nothing
};

/// What a parallel gripper's drive says.
struct GripperPercept {
  double opening = 0;    // m
  bool blocked = false;  // commanded to move but does not
  unsigned error = 0;    // the device's code, 0 none
  double age = 0;        // s, at the percepts' time
};

/// All the cycle knows of the world.
struct ArmPercepts {
  double time = 0;  // s, now, of the graph's clock
  std::vector<std::string> names;
  std::vector<double> positions;  // rad, of arm and hand
  /// N, of contact on the hand, with what it holds, in a frame that moves with the hand.
  std::optional<Eigen::Vector3d> wrist_force;
  std::vector<PadPercept> pads = {};         // that have spoken; ages at `time`
  std::vector<touch::PadFrame> frames = {};  // of the same pads
  double joints_age = 0;                     // s, at `time`; 0: read in the same instant
  double wrist_age = 0;                      // s
  std::optional<GripperPercept> gripper = std::nullopt;  // of a hand that is one
  /// N m, with wrist_force, about the origin of the hand's root frame; none: not known.
  std::optional<Eigen::Vector3d> wrist_torque = std::nullopt;
};

struct ArmCycleOptions : SharedCycleOptions, robot::GripOptions {
  /// The arm stops where the hand touches while it approaches (UJI's platform), jaws whose pads are
  /// beside the object by then go back a little and close there (`largest_shortfall`), and fingers
  /// that close on something beside its prediction put the hand in its middle and close again,
  /// where the plan has ArmGrasp::shifts; otherwise the plan is executed without looking (KTH's:
  /// open loop).
  bool reacts = false;
  double contact_force = 5;     // N
  double collision_force = 60;  // N
  double opening_speed = 0.6;
  double rest_time = 0.2;            // s
  double check_time = 0.4;           // s
  double motion_timeout = 60;        // s
  double largest_detour = 0.5;       // rad
  double largest_shortfall = 0.012;  // m
  double shift_tolerance = 0.006;    // m
  int adaptations = 2;
  double small_opening = 0.25;  // rad
  double minimum_stability = 0;
  double slip_force_factor = 1.5;
  double largest_grip_force = 0;  // N
  double slip_settle_time = 0.1;  // s
  double largest_slide = 0.008;   // m
  double probe_force = 1;         // N
  HoldingOptions holding;
  touch::HoldSlipOptions slip;

  /// See text/knob.h.
  template <class Self, class Visit>
  static void knobs(Self& self, Visit&& visit) {
    using text::Knob;
    visit(Knob{"contact_force", self.contact_force, "N", 0.1, 1000,
               "at the wrist, that counts as contact on the approach"});
    visit(Knob{"collision_force", self.collision_force, "N", 1, 10000,
               "at the wrist, on every other way, beyond what is held: the arm has hit something "
               "and stops"});
    visit(Knob{"opening_speed", self.opening_speed, "", 0.01, 1,
               "of the hand, share of its joints' greatest"});
    visit(Knob{"rest_time", self.rest_time, "s", 0, 10,
               "before the approach: the wrist's force at rest, its noise"});
    visit(Knob{"check_time", self.check_time, "s", 0, 10,
               "at rest after the lift, and after the retreat"});
    visit(Knob{"motion_timeout", self.motion_timeout, "s", 1, 3600, "of each motion"});
    visit(Knob{"largest_detour", self.largest_detour, "rad", 0.001, 3.2,
               "that a path may begin away from where the arm stands"});
    visit(
        Knob{"largest_shortfall", self.largest_shortfall, "m", 0, 0.1,
             "with reacts, of a gripper that regulates its grip: jaws that touch something on the "
             "approach no farther than this before its end go back a little and close there; 0: "
             "they let go"});
    visit(Knob{"shift_tolerance", self.shift_tolerance, "m", 0.0005, 0.1,
               "with reacts: a thing that the fingers feel this much beside its prediction is not "
               "in the hand's middle"});
    visit(Knob{"adaptations", self.adaptations, "", 0, 20,
               "with reacts: times that fingers let go, the hand is shifted to the middle of what "
               "they felt, and they close again; 0: they grip where they touch"});
    visit(
        Knob{"small_opening", self.small_opening, "rad", 0.01, 3.2,
             "that fingers open from where they gripped, when the hand has opened all the way and "
             "takes along what it has put down: it is put back, and left so"});
    visit(
        Knob{"minimum_stability", self.minimum_stability, "", 0, 1,
             "probability that the lift holds, by what the pads feel when the hand has closed and "
             "again when it has risen by 10 mm, below which it presses harder where that helps, "
             "else lets go and looks again; 0: it is said and changes nothing"});
    visit(Knob{"slip_force_factor", self.slip_force_factor, "", 1, 10,
               "times the force, that is held with when the pads feel that what is held slips, as "
               "often as it does; 1: it is said and changes nothing"});
    visit(Knob{"largest_grip_force", self.largest_grip_force, "N", 0, 1000,
               "per pad, that the object bears: what slips is not held harder; 0: what the motors "
               "give"});
    visit(Knob{"probe_force", self.probe_force, "N", 0.1, 100,
               "at the wrist, at which a fingertip that probes the object is stopped; a pad that "
               "touches stops it, too"});
    visit(Knob{"slip_settle_time", self.slip_settle_time, "s", 0, 10,
               "for the force to rise, before it is watched again whether what is held slips"});
    visit(
        Knob{"largest_slide", self.largest_slide, "m", 0, 0.5,
             "over the pads, since it was lifted, of what cannot be held harder: beyond it, it is "
             "put down while it is lifted, up to it, most comes to rest"});
  }

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// Executes a task with an arm and a hand: opens the hand, reach, approach, close, lift, weighs
/// what is held, carry, place, open, retreat, weighs the empty hand. While it lifts, carries and
/// lowers, what is held is watched (Holding): by its weight where nothing else bears it, which is
/// all but the end of lowering, and by the fingers all the time.
///
/// A hand that feels its grip (HandPort) decides by its pads and its opening instead of the weight.
/// Where it touches something on the approach it lets go; with `reacts` and near the approach's end
/// (`largest_shortfall`), where its pads are beside the object already, it goes back from what is
/// under its jaws and closes there.
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
/// What is felt is compared with what was predicted (surprises), and no attempt fails without one.
/// Where fingers that open press on something at a place, the hand goes up from it, and they go on.
/// It retreats as planned from a place, else back the way it came, as far as it came. Fingers that
/// take along what was put down (one that stood in a cup hooks it when it opens) put it back, open
/// by little, and leave again. Looks again (Cycle) are taken from where the arm stood at first;
/// after a place only where the retreat has led onto the way there, as from straight above, else
/// from the retreat's end.
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
    kWait
  };

  void begin(const Action& action) override;
  void prepare_attempt() override;
  void clear_view() override;
  std::optional<int> probe_grasp() const override;
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
  std::optional<double> closure() const;
  double felt_contact(double borne) const;
  /// Gives up when what is held is lost; true then.
  bool watch_held();
  void check();
  void verify();
  /// Goes back a little from what the jaws touch near the end of the approach; false: it is too far
  /// from there.
  bool back_off();
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
  void open_hand(Step step, const std::string& detail);
  void open_to_release();
  /// Puts down again what the hand has taken along, to leave it with fingers that open less.
  void put_back();
  void open_less();
  void go_back();
  void fail(const std::string& reason);

  ArmCycleOptions options_;
  ArmPort& arm_;
  HandPort& hand_;
  std::vector<ArmGrasp> grasps_;
  std::optional<GripJudge> judge_;
  std::optional<double> stability_;  // that the lift holds, as judged last
  bool pressed_harder_ = false;      // in this attempt
  touch::HoldSlip hold_slip_;
  bool holds_ = false;  // from the lift on: whether it slips is watched
  double slid_ = 0;     // m, in this attempt
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
  bool opens_on_ = false;        // after the last one
  bool opened_less_ = false;     // to leave what the hand had taken along
  int adapted_ = 0;              // times in this attempt
  FollowedShift shift_;          // that comes next
  std::vector<double> shifted_;  // rad or m, of the arm's joints, by all shifts of this attempt
  bool clears_ = false;          // it goes back to look again
  std::map<std::string, double> sums_at_rest_;  // N, of pads, before the approach
  std::vector<JointTrajectory>
      gone_;  // that were begun in this attempt, and lead back when reversed
  InputWatch watch_;
  ArmPercepts percepts_;
  Holding holding_;
};

}  // namespace prehend::control
