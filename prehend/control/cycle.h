#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "prehend/control/advice.h"
#include "prehend/control/failed_attempts.h"
#include "prehend/control/grasp_order.h"
#include "prehend/control/surprise.h"
#include "prehend/control/task.h"

namespace prehend::control {

/// How a motion that was started goes on.
enum class MotionStatus { kMoving, kReached, kContact, kFailed };

/// From 1: a message with 0 does not say.
enum class Phase {
  kWaiting = 1,
  kSpawn,  // before a cycle: objects are put into a simulation as they were predicted
  kApproach,
  kGrasp,
  kLift,
  kMove,
  kRelease,
  kDone,
  kFailed,
  kPush,
};

/// "waiting", "approach", ...
std::string to_string(Phase phase);

enum class CycleOutcome {
  kFailed,
  kUngraspable,  // an answer: nothing was tried, as the plan says that nothing can be grasped
  kSucceeded,
};

struct CycleResult {
  CycleOutcome outcome = CycleOutcome::kFailed;
  std::string reason;   // in words, for success too
  int grasp_index = 0;  // in the list given to start(), or to take_plan() since
  int attempts = 0;     // to lift something
  int touches = 0;      // of objects that were felt before
  int looks = 0;        // from elsewhere, at objects that nothing had touched
  int pushes = 0;       // of what could not be grasped as it stood
  int plans = 1;        // that were used: 1 + those taken after a new look
  int placed = 0;       // objects that were put at their place

  /// The object was approached to be lifted or to be felt.
  int tries() const { return attempts + touches; }
  bool success() const { return outcome == CycleOutcome::kSucceeded; }
};

/// What every cycle can be told, whatever robot it moves.
struct SharedCycleOptions {
  Task task = pick_and_place();
  int largest_attempts = 3;  // > 0, with one object
  int largest_touches = 1;   // >= 0, of one object, before it is lifted (`decide`)
  int largest_looks = 1;     // >= 0, the same, from elsewhere, by a camera that the arm carries
  int largest_pushes = 10;   // >= 0, one after the other, while nothing is put at a place (`push`)
  double stale_time = 0.25;  // s
  double answer_time = 2;    // s
  /// s, >= 0, to wait for a plan of what is there after a failed attempt; 0: the next grasp of the
  /// plan is taken at once.
  double look_timeout = 0;
  /// With a look_timeout: only grasps of a new look are tried after a failed attempt, and the look
  /// fails when none come.
  bool only_seen_again = false;
  SurpriseTolerances tolerances;

  /// See text/knob.h.
  template <class Self, class Visit>
  static void knobs(Self& self, Visit&& visit) {
    using text::Knob;
    visit(Knob{"stale_time", self.stale_time, "s", 0.02, 10,
               "without a word of something that the cycle moves by: all is stopped"});
    visit(Knob{"answer_time", self.answer_time, "s", 0.1, 60,
               "without feedback of a motion, which nobody carries out then: all is stopped"});
    visit(Knob{"largest_touches", self.largest_touches, "", 0, 10,
               "of one object before it is lifted, where the task decides"});
    visit(Knob{"largest_looks", self.largest_looks, "", 0, 10,
               "from elsewhere, at one object before it is lifted, where the task decides"});
    visit(Knob{"largest_pushes", self.largest_pushes, "", 0, 100,
               "one after the other, where the task pushes what cannot be grasped as it stands, "
               "while nothing is put at its place"});
  }

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// Executes a task (Task) on ranked grasps, whatever the robot: which action comes next, which
/// grasp is tried, when to look again, what surprised it, how it ended. How an action is carried
/// out, its robot's cycle knows.
///
/// `look` takes the first grasp of the plan. After a failed attempt with `look_timeout` it waits
/// for grasps planned on a new look (looks_since(), take_plan()), as the object may have moved;
/// when none come it takes the next grasp of the plan before. Grasps like one that failed come last
/// in either. It fails when `largest_attempts` were made. With a task of all objects it goes on
/// with the others then (any_object()), finds nothing when none is left, and fails when only those
/// are left that it gave up. What was given up is tried again once something else was put at its
/// place or pushed, as it lies otherwise then.
///
/// `push` moves what has no grasp by what a look has for that, when that look has no grasp of any
/// object; `largest_pushes` times, until something was put at its place. `look` looks for any
/// object then. A task that pushes begins without grasps, too, where there is a push.
///
/// `probe` touches the object with what the plan has for that, `largest_touches` times at most.
/// `view` looks from elsewhere by what the plan has for that, and `decide` follows the plan's
/// advice. What is touched is no attempt; afterwards `look` waits for a plan of the same object, or
/// takes the plan before. To look from elsewhere, the robot's cycle brings its camera there
/// (go_to_view()). It goes on from there with grasps planned on that look, and is decided anew;
/// when none come, it goes back (leave_view()) and on with the plan before.
class Cycle {
 public:
  virtual ~Cycle() = default;

  Phase phase() const;
  bool finished() const { return stage_ == Stage::kDone || stage_ == Stage::kFailed; }
  const std::string& detail() const { return detail_; }  // in words
  /// As CycleResult's; while it probes, one that is beyond the plan's grasps.
  int grasp_index() const { return grasp_index_; }
  const CycleResult& result() const { return result_; }  // final once finished()
  const std::vector<Surprise>& surprises() const { return surprises_; }
  const std::string& failure() const { return failure_; }  // of the present attempt; empty: none
  /// Seconds of each phase in the order they were entered.
  const std::vector<std::pair<std::string, double>>& phase_times() const { return phase_times_; }
  const Task& task() const { return shared_.task; }
  /// The task's states in the order they were entered, with the ends: indices as TaskState::next.
  const std::vector<int>& path() const { return path_; }

  /// Set while it waits for a new plan: of what was seen at this time [s] or later.
  std::optional<double> looks_since() const;
  /// It waits for a plan of any object that is at no place and was not given up; else of the one of
  /// the last attempt.
  bool any_object() const { return any_object_; }
  /// How many objects were given up since something was put at its place or pushed: the last
  /// attempt's is the newest of them.
  int given_up() const { return given_up_; }
  /// Stops all motion and ends as failed.
  void abort(const std::string& reason);

 protected:
  explicit Cycle(const SharedCycleOptions& options) : shared_(options) {}

  /// Starts the action; it calls ended(), now or later.
  virtual void begin(const Action& action) = 0;
  /// A new attempt, with grasp grasp_index(), begins.
  virtual void prepare_attempt() = 0;
  /// Before a new look: gets out of the way and calls look_now().
  virtual void clear_view() = 0;
  /// The grasp of the plan that is none but a probe, by its index; none: the plan has no probe.
  virtual std::optional<int> probe_grasp() const { return std::nullopt; }
  /// The one that is none but a push; none: nothing is to be pushed.
  virtual std::optional<int> push_grasp() const { return std::nullopt; }
  /// Brings the camera to the end of `way` and calls look_now(), or look_failed() where it cannot.
  virtual void go_to_view(const JointTrajectory& way) = 0;
  /// Back from there as far as it came; calls view_left().
  virtual void leave_view() = 0;
  virtual void stop_motion() = 0;

  /// Waits until begin_task(). Without grasps it has failed, with `problem` as reason.
  void start_task(std::vector<GraspPose> grasps, const std::string& problem, Advice advice = {});
  void begin_task();
  bool waits_for_inputs() const { return stage_ == Stage::kWaiting; }
  /// The present action ended so. `reason`: in words, of all but kDone, and of an end reached by
  /// it.
  void ended(Outcome outcome, const std::string& reason = "");
  /// What the task has come to, as reason of a success.
  void achieved(const std::string& text) { achieved_ = text; }
  void finish(bool success, const std::string& reason);

  /// The view is clear: waits for a plan of what is seen from now on.
  void look_now();
  /// While waits_for_plan().
  void step_look();
  void look_failed(const std::string& why);  // on the way to a view
  void view_left();
  bool waits_for_plan() const { return looking_; }
  /// The robot's cycle has taken these grasps, or none for the reason `problem`.
  /// @pre waits_for_plan()
  void plan_taken(std::vector<GraspPose> grasps, const std::string& problem, Advice advice = {});

  /// The clock of the percepts goes on to `time` [s].
  void advance_to(double time);
  double now() const { return now_; }               // s
  double spent() const { return now_ - entered_; }  // s, since the present step was entered
  /// A step of the present action begins.
  void entered(const std::string& detail);
  void add_surprise(SurpriseKind kind, double predicted, double felt, const std::string& reaction);
  void add_surprise(const Surprise& surprise) { surprises_.push_back(surprise); }
  /// The attempt has failed, and so has the present action. No attempt fails as predicted: `kind`
  /// is the surprise of one that had none.
  void give_up(const std::string& reason, SurpriseKind kind = SurpriseKind::kMotion,
               Outcome outcome = Outcome::kFailed);
  Primitive primitive() const;  // of the present action
  /// The present one is the first with this object, to lift or to feel it.
  bool is_first_try() const { return attempts_ + touches_ <= 1; }
  bool is_at_place() const { return at_place_; }  // the object was put there

  std::string detail_ = "waiting for a plan";

 private:
  enum class Stage { kWaiting, kActing, kDone, kFailed };
  void enter(int state);
  void look();
  void decide();
  void probe(const Action& action);
  void push(const Action& action);
  void view();
  void look_from_elsewhere(const Advice& advice);
  /// From the view back, and then.
  void after_view(std::function<void()> next);
  /// What was begun as an attempt is to feel the object with that grasp.
  void feel_with(int grasp_index);
  void next_grasp(const std::string& why);
  void attempt(int grasp_index);
  void object_ended();
  Outcome in_vain() const;

  SharedCycleOptions shared_;
  Stage stage_ = Stage::kWaiting;
  int state_ = 0;
  std::vector<int> done_;  // how often each state was, since `times` led on
  std::vector<int> path_;
  bool looking_ = false;  // waits for a plan
  bool fresh_ = false;    // a plan was taken of which nothing was tried
  bool any_object_ = false, at_place_ = false;
  bool touched_ = false;                        // the present object, and no attempt was made since
  bool probed_ = false;                         // that was no grasp of the plan
  bool pushed_ = false;                         // something, and `look` was not since
  bool push_is_made_ = false;                   // of the newest plan
  int pushes_ = 0;                              // since something was put at its place
  std::string stuck_;                           // why the last look gave no grasp
  int attempts_ = 0, touches_ = 0, looks_ = 0;  // with the present object
  bool viewing_ = false;                        // the camera is, or goes, where it looks from
  std::function<void()> after_view_;            // on the way back from there
  int given_up_ = 0;
  Advice advice_;  // of a plan that `decide` has not asked yet
  std::string achieved_;
  GraspOrder order_;
  CycleResult result_;
  std::vector<Surprise> surprises_;
  double entered_ = 0, now_ = 0;  // s
  int grasp_index_ = 0;
  std::string failure_;
  FailedAttempts failed_attempts_;
  std::size_t attempts_surprises_ = 0;  // that there were when the attempt began
  std::vector<std::pair<std::string, double>> phase_times_;
};

}  // namespace prehend::control
