#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

// What a robot is to do, whatever its body: a small state machine of primitive actions.
namespace prehend::control {

/// From 1: a message with 0 does not say.
enum class Primitive {
  kLook = 1,  // chooses an object and a grasp of it
  kApproach,  // opens the hand and goes to where it closes
  kTouch,     // the same until something is met
  kGrasp,     // closes the hand
  kLift,      // straight up; looks whether something is held
  kMove,      // what is held: to above its place, or down and up again where it was lifted
  kPlace,     // down to its place
  kRelease,   // opens the hand
  kRetreat,   // away from the object, along the plan or back the way it came
  kWait,
  kDecide,   // what is worth most: to grasp now, to feel it first, or to leave it
  kProbe,    // goes straight with one fingertip to where most is to be learnt, until it meets
             // something
  kInspect,  // turns what is held before a camera, and looks at it from each of the plan's views
  kView,     // brings the camera that the arm carries to the plan's look, looks, and comes back
  kPush,     // of what cannot be grasped as it stands: along the table, as the plan says
};

/// How an action ends.
enum class Outcome {
  kDone,
  kNothing,  // look: none is left; touch: met nothing; move: the plan has no place; decide: it
             // is not worth an attempt; probe: the plan has none, or it was felt enough; inspect:
             // the plan has no views, or nobody looks; view: the plan has no look, it was looked
             // at enough, or the look gave no grasp; push: the plan has none, or it was pushed
             // enough
  kFailed,
  kLost,      // what was held is
  kDoubtful,  // decide: it is to be felt first
};

std::string to_string(Primitive primitive);  // "look", as in a task's file
std::string to_string(Outcome outcome);      // "done"
/// Those that an action of that kind can end by, kDone first.
const std::vector<Outcome>& outcomes_of(Primitive primitive);

struct Action {
  enum class Goal { kPlace, kLowered, kLifted };  // of kMove
  Primitive primitive = Primitive::kLook;
  Goal goal = Goal::kPlace;
  double share = 1;     // of the lift's height, in (0, 1], of kLowered
  double seconds = 0;   // s, >= 0, of kWait
  bool gently = false;  // of kGrasp: until it touches, and no further
};

/// Where a task ends. As indices of states.
enum TaskEnd : int { kSuccess = -1, kFailure = -2 };

struct TaskState {
  std::string name;
  Action action;
  std::map<Outcome, int> next;  // of each of outcomes_of(action.primitive)
  /// The so many-th time that it is done it goes on at `then`; 0: never.
  int times = 0;
  int then = kSuccess;
};

/// A part of the table where objects are put.
struct TaskPlace {
  std::string name;
  Eigen::Vector2d center = Eigen::Vector2d::Zero();  // m, world
  Eigen::Vector2d size = Eigen::Vector2d::Zero();    // m, along x and y
  std::optional<double> up_to;                       // m, see Task::place_for()
  bool holds(const Eigen::Vector2d& p_W) const {
    return ((p_W - center).cwiseAbs().array() <= 0.5 * size.array()).all();
  }
};

struct Task {
  std::string name;
  std::string description;
  std::vector<TaskState> states;
  int start = 0;
  /// Every object in turn, as long as one is left that is in no place; else one.
  bool all_objects = false;
  int most_objects = 20;          // > 0, that are moved at most
  std::vector<TaskPlace> places;  // none: what is held is put where there is room
  /// What the whole chain from images to ranked grasps is asked for, as
  /// fidelity::choose_for_stage() has it: at most one is above 0.
  double budget = 0;     // s of processor
  double tolerance = 0;  // m, mean error of the meshes
  std::string asked_at;  // "file:line: budget", where it stands; empty: nothing is asked for

  /// The first place for things of this size, the longest side of the upright box round them [m];
  /// null: wherever there is room. @throws geometry::InputError when there are places and all are
  /// for smaller things.
  const TaskPlace* place_for(double size) const;
  /// Whether something that stands there is where it was to be put.
  bool is_placed(const Eigen::Vector2d& p_W) const;
  std::string name_of(int state) const;  // "success" and "failure", too
  bool does(Primitive primitive) const;  // in one of its states
};

/// Reads a task (config/tasks/README.md says what may stand in it) and looks whether it can be
/// done: every state says where each outcome leads to and can be reached, an end can be reached
/// from everywhere, what goes round ends by `times` or by a look that finds nothing more, and no
/// action begins where it makes no sense (a lift of nothing).
/// @throws geometry::InputError "file:line: what is wrong" with the nearest name and the mend.
Task read_task(const std::filesystem::path& path);
/// The same of a text; `path` says in errors where it is from.
Task parse_task(const std::string& yaml, const std::filesystem::path& path);
/// config/tasks/pick_and_place.yaml (text::tree_file()).
const Task& pick_and_place();

/// The tasks' names (files without .yaml) in a folder, sorted.
std::vector<std::string> task_names(const std::filesystem::path& folder);
/// The file of one of them. @throws geometry::InputError with the nearest name.
std::filesystem::path task_file(const std::filesystem::path& folder, const std::string& name);

}  // namespace prehend::control
