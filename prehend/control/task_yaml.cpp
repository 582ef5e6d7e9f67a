// Tasks from files.

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "prehend/control/task.h"
#include "prehend/control/task_check.h"
#include "prehend/geometry/errors.h"
#include "prehend/text/input_error.h"
#include "prehend/text/nearest_match.h"
#include "prehend/text/tree_file.h"
#include "prehend/text/yaml_map.h"

namespace prehend::control {
namespace {

constexpr Primitive kPrimitives[] = {Primitive::kLook,    Primitive::kApproach, Primitive::kTouch,
                                     Primitive::kGrasp,   Primitive::kLift,     Primitive::kMove,
                                     Primitive::kPlace,   Primitive::kRelease,  Primitive::kWait,
                                     Primitive::kRetreat, Primitive::kDecide,   Primitive::kProbe,
                                     Primitive::kInspect, Primitive::kView,     Primitive::kPush};
constexpr int kMostStates = 100;
constexpr int kMostTimes = 1000;

Primitive primitive_of(const std::string& name, const text::YamlMap& map) {
  std::vector<std::string> names;
  for (const Primitive primitive : kPrimitives) {
    if (to_string(primitive) == name) return primitive;
    names.push_back(to_string(primitive));
  }
  map.fail("do", "names no primitive action: '" + name + "'",
           text::nearest_match_mend(name, names));
}

std::vector<std::string> keys_of(const YAML::Node& node) {
  std::vector<std::string> keys;
  for (const auto& entry : node) keys.push_back(entry.first.Scalar());
  return keys;
}

class TaskReader {
 public:
  TaskReader(const YAML::Node& root, const std::filesystem::path& path)
      : root_(root), path_(path), map_(root, path, "task") {}

  Task read() {
    task_.name = path_.stem().string();
    std::string start;
    map_.read("description", task_.description);
    map_.read("start", start);
    map_.choose("objects", std::vector<std::pair<std::string, bool>>{{"one", false}, {"all", true}},
                task_.all_objects);
    map_.read("most_objects", task_.most_objects);
    read_asked();
    const YAML::Node places = map_.child("places"), states = map_.child("states");
    map_.finish();
    if (task_.most_objects < 1) map_.fail("most_objects", "must be 1 or more", "Give a number");
    if (places.IsDefined()) read_places(places);
    if (task_.all_objects && task_.places.empty()) {
      map_.fail("objects", "are all, and the task has no places",
                "Give `places`, or the same objects are moved again and again");
    }
    if (!states.IsDefined()) map_.fail("states", "is missing", "Give the task its states");
    read_states(states);
    if (start.empty()) map_.fail("start", "is missing", "Name the state it starts with");
    task_.start = index_of(start, "start", map_);
    if (const TaskProblem problem = problem_of(task_); !problem.what.empty()) {
      const text::YamlMap map(states, path_, "task.states");
      map.fail(task_.name_of(problem.state), problem.what, problem.mend);
    }
    return std::move(task_);
  }

 private:
  // One of them speaks for all stages, as at a launch file.
  void read_asked() {
    for (const auto& [key, value] :
         {std::pair{"budget", &task_.budget}, std::pair{"tolerance", &task_.tolerance}}) {
      map_.read(key, *value);
      const YAML::Node given = root_[key];
      if (!given.IsDefined()) continue;
      if (!(*value > 0)) {
        map_.fail(key, "is not positive",
                  fmt::format("Give {}, or leave it out for the nodes' own settings",
                              value == &task_.budget ? "seconds of processor, as 1.1"
                                                     : "metres, as 0.003"));
      }
      if (!task_.asked_at.empty()) {
        map_.fail(key, "is given beside a budget", "Leave one of them out");
      }
      task_.asked_at = fmt::format("{}:{}: {}", path_.string(), given.Mark().line + 1, key);
    }
  }

  void read_places(const YAML::Node& node) {
    text::YamlMap names(node, path_, "task.places");
    for (const std::string& name : keys_of(node)) {
      text::YamlMap map(names.child(name), path_, "task.places." + name);
      TaskPlace place;
      place.name = name;
      double up_to = 0;
      map.read("center", place.center);
      map.read("size", place.size);
      map.read("up_to", up_to);
      map.finish();
      if (!(place.size.minCoeff() > 0)) {
        map.fail("size", "is not positive", "Give both sides in metres");
      }
      if (up_to < 0) map.fail("up_to", "is negative", "Give the longest side in metres");
      if (up_to > 0) place.up_to = up_to;
      task_.places.push_back(place);
    }
  }

  int index_of(const std::string& name, const std::string& key, const text::YamlMap& map) const {
    if (name == "success") return kSuccess;
    if (name == "failure") return kFailure;
    const auto found = std::find(names_.begin(), names_.end(), name);
    if (found != names_.end()) return static_cast<int>(found - names_.begin());
    std::vector<std::string> all = names_;
    all.insert(all.end(), {"success", "failure"});
    map.fail(key, "names no state: '" + name + "'", text::nearest_match_mend(name, all));
  }

  void read_states(const YAML::Node& node) {
    text::YamlMap names(node, path_, "task.states");
    names_ = keys_of(node);
    if (names_.empty()) map_.fail("states", "is empty", "Give the task its states");
    if (names_.size() > kMostStates) {
      map_.fail("states", "has more than " + std::to_string(kMostStates), "Take some out");
    }
    for (const char* end : {"success", "failure"}) {
      if (std::count(names_.begin(), names_.end(), end) == 0) continue;
      names.fail(end, "is an end of every task", "Give the state another name");
    }
    for (const std::string& name : names_) {
      task_.states.push_back(read_state(name, names.child(name)));
    }
  }

  TaskState read_state(const std::string& name, const YAML::Node& node) {
    text::YamlMap map(node, path_, "task.states." + name);
    TaskState state;
    state.name = name;
    std::string primitive, then, otherwise;
    map.read("do", primitive);
    if (primitive.empty()) {
      throw geometry::InputError(path_.string() + ":" + std::to_string(node.Mark().line + 1) +
                                     ": the state '" + name + "' has no `do`",
                                 "Name its primitive action");
    }
    state.action.primitive = primitive_of(primitive, map);
    read_action(map, state.action);
    map.read("times", state.times);
    map.read("then", then);
    map.read("otherwise", otherwise);
    std::map<Outcome, std::string> next;
    for (const Outcome outcome : outcomes_of(state.action.primitive)) {
      map.read(to_string(outcome), next[outcome]);
    }
    map.finish();
    bool uses_otherwise = false;
    for (const auto& [outcome, target] : next) {
      const std::string key = to_string(outcome);
      if (target.empty() && (otherwise.empty() || outcome == Outcome::kDone)) {
        map.fail("do", "does not say where it goes on when it ends as '" + key + "'",
                 "Add `" + key + ": STATE`" +
                     (outcome == Outcome::kDone ? "" : ", or `otherwise: STATE` for all but done"));
      }
      uses_otherwise = uses_otherwise || target.empty();
      state.next[outcome] =
          target.empty() ? index_of(otherwise, "otherwise", map) : index_of(target, key, map);
    }
    if (!otherwise.empty() && !uses_otherwise) {
      map.fail("otherwise", "is never used, as every outcome has its own way", "Take it out");
    }
    if (state.times < 0 || state.times > kMostTimes) {
      map.fail("times", "must be 1 to " + std::to_string(kMostTimes), "Correct it");
    }
    if ((state.times > 0) != !then.empty()) {
      map.fail(state.times > 0 ? "times" : "then", "needs `times` and `then`",
               "Give both: after so many times it goes on at `then`");
    }
    if (state.times > 0) state.then = index_of(then, "then", map);
    return state;
  }

  static void read_action(text::YamlMap& map, Action& action) {
    if (action.primitive == Primitive::kWait) {
      map.read("seconds", action.seconds);
      if (!(action.seconds > 0 && action.seconds <= 3600)) {
        map.fail("seconds", "must be above 0 and at most 3600", "Give how long it waits");
      }
    }
    if (action.primitive == Primitive::kGrasp) map.read("gently", action.gently);
    if (action.primitive != Primitive::kMove) return;
    using Goal = Action::Goal;
    map.choose("to",
               std::vector<std::pair<std::string, Goal>>{
                   {"place", Goal::kPlace}, {"lowered", Goal::kLowered}, {"lifted", Goal::kLifted}},
               action.goal);
    if (action.goal != Goal::kLowered) return;
    map.read("share", action.share);
    if (!(action.share > 0 && action.share <= 1)) {
      map.fail("share", "must be in (0, 1]", "Give the part of the lift that it goes down");
    }
  }

  YAML::Node root_;
  std::filesystem::path path_;
  text::YamlMap map_;
  Task task_;
  std::vector<std::string> names_;
};

}  // namespace

Task parse_task(const std::string& yaml, const std::filesystem::path& path) {
  return TaskReader(text::parse_yaml_map(yaml, path), path).read();
}

Task read_task(const std::filesystem::path& path) {
  return TaskReader(text::load_yaml_map(path), path).read();
}

const Task& pick_and_place() {
  static const Task task = read_task(text::tree_file("config/tasks/pick_and_place.yaml"));
  return task;
}

std::filesystem::path task_file(const std::filesystem::path& folder, const std::string& name) {
  const std::filesystem::path file = folder / (name + ".yaml");
  if (!name.empty() && std::filesystem::is_regular_file(file)) return file;
  throw text::InputError("There is no task '" + name + "' in '" + folder.string() + "'",
                         text::nearest_match_mend(name, task_names(folder)));
}

std::vector<std::string> task_names(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace prehend::control
