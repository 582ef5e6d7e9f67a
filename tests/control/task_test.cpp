// Tasks: what their files say, and what keeps one from being done.

#include "prehend/control/task.h"

#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"

namespace prehend::control {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

const char* const kWhole = R"(description: lift and put back
start: look
states:
  look: {do: look, done: approach, otherwise: failure}
  approach: {do: approach, done: grasp, failed: failure}
  grasp: {do: grasp, done: lift, failed: failure}
  lift: {do: lift, done: down, otherwise: failure}
  down: {do: move, to: lowered, done: open, otherwise: failure}
  open: {do: release, done: leave, failed: leave}
  leave: {do: retreat, done: success, failed: failure}
)";

/// The whole task with `from` replaced.
std::string changed(const std::string& from, const std::string& to) {
  std::string text = kWhole;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string refusal(const std::string& yaml) {
  try {
    parse_task(yaml, "mine.yaml");
  } catch (const geometry::InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Task, EveryOneThatShipsCanBeDone) {
  const std::filesystem::path folder = "config/tasks";
  const std::vector<std::string> names = task_names(folder);
  for (const char* name :
       {"pick_and_place", "work_cycle", "sort", "clear_table", "shake_test", "inspect"}) {
    EXPECT_THAT(names, Contains(name));
  }
  for (const std::string& name : names) {
    const Task task = read_task(task_file(folder, name));
    EXPECT_EQ(task.name, name);
    EXPECT_FALSE(task.description.empty()) << name;
    for (const TaskState& state : task.states) {
      for (const Outcome outcome : outcomes_of(state.action.primitive)) {
        EXPECT_EQ(state.next.count(outcome), 1u) << name << " " << state.name;
      }
    }
  }
  EXPECT_EQ(pick_and_place().name, "pick_and_place");
  try {
    task_file(folder, "pick_and_plase");
    ADD_FAILURE();
  } catch (const geometry::InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("The nearest is 'pick_and_place'"));
  }
}

TEST(Task, SaysWhatItsFileSays) {
  const Task task = parse_task(kWhole, "folder/mine.yaml");
  EXPECT_EQ(task.name, "mine");
  EXPECT_EQ(task.states.size(), 7u);
  EXPECT_EQ(task.name_of(task.start), "look");
  const TaskState& down = task.states[4];
  EXPECT_EQ(down.action.goal, Action::Goal::kLowered);
  EXPECT_EQ(task.name_of(down.next.at(Outcome::kLost)), "failure");
  EXPECT_EQ(task.name_of(down.next.at(Outcome::kDone)), "open");
}

TEST(Task, PutsThingsByTheirSize) {
  const Task sort = read_task("config/tasks/sort.yaml");
  EXPECT_TRUE(sort.all_objects);
  EXPECT_EQ(sort.place_for(0.05)->name, "small");
  EXPECT_EQ(sort.place_for(0.2)->name, "large");
  EXPECT_TRUE(sort.is_placed(sort.places[0].center));
  EXPECT_FALSE(sort.is_placed({0, 0}));
  EXPECT_EQ(pick_and_place().place_for(1), nullptr);
  Task small = sort;
  small.places.pop_back();
  EXPECT_THROW(small.place_for(1), geometry::InputError);
}

// For the whole chain, and by one of the two.
TEST(Task, SaysHowWellItsChainIsToBe) {
  EXPECT_EQ(parse_task(kWhole, "mine.yaml").asked_at, "");
  const Task budget = parse_task(changed("start: look", "budget: 1.1\nstart: look"), "mine.yaml");
  EXPECT_EQ(budget.budget, 1.1);
  EXPECT_EQ(budget.tolerance, 0);
  EXPECT_EQ(budget.asked_at, "mine.yaml:2: budget");
  const Task tolerance = parse_task(std::string(kWhole) + "tolerance: 0.003\n", "mine.yaml");
  EXPECT_EQ(tolerance.budget, 0);
  EXPECT_EQ(tolerance.tolerance, 0.003);
  EXPECT_THAT(tolerance.asked_at, AllOf(HasSubstr("mine.yaml:"), HasSubstr(": tolerance")));
}

TEST(Task, RefusesABudgetThatIsNone) {
  for (const char* number : {"0", "-1"}) {
    EXPECT_THAT(
        refusal(changed("start: look", std::string("start: look\nbudget: ") + number)),
        AllOf(HasSubstr("mine.yaml:3"), HasSubstr("budget"), HasSubstr("seconds of processor")))
        << number;
  }
  EXPECT_THAT(refusal(changed("start: look", "start: look\nbudget: .nan")),
              AllOf(HasSubstr("mine.yaml:3"), HasSubstr("budget is no finite number")));
  EXPECT_THAT(refusal(changed("start: look", "start: look\ntolerance: 0")),
              AllOf(HasSubstr("mine.yaml:3"), HasSubstr("metres, as 0.003")));
  EXPECT_THAT(refusal(changed("start: look", "budget: 1\nstart: look\ntolerance: 0.003")),
              AllOf(HasSubstr("mine.yaml:4"), HasSubstr("Leave one of them out")));
  EXPECT_THAT(refusal(changed("start: look", "budgt: 1\nstart: look")),
              HasSubstr("nearest is 'budget'"));
  EXPECT_THAT(refusal(changed("start: look", "budget: fast\nstart: look")), HasSubstr("budget"));
}

TEST(Task, RefusesWhatIsMistyped) {
  EXPECT_THAT(
      refusal(changed("do: look", "do: loock")),
      AllOf(HasSubstr("mine.yaml:4"), HasSubstr("'loock'"), HasSubstr("nearest is 'look'")));
  EXPECT_THAT(refusal(changed("done: approach", "done: aproach")),
              AllOf(HasSubstr("names no state: 'aproach'"), HasSubstr("nearest is 'approach'")));
  EXPECT_THAT(refusal(changed("start: look", "start: loook")), HasSubstr("nearest is 'look'"));
  EXPECT_THAT(refusal(changed("otherwise:", "othrwise:")), HasSubstr("otherwise"));
  EXPECT_THAT(refusal(changed("to: lowered", "to: below")),
              AllOf(HasSubstr("'below'"), HasSubstr("place, lowered, lifted")));
  EXPECT_THAT(refusal(changed("to: lowered", "to: lowered, share: 1.5")), HasSubstr("(0, 1]"));
  EXPECT_THAT(refusal(changed("do: lift", "do: lift, share: 0.5")), HasSubstr("share"));
}

TEST(Task, RefusesWhatIsMissingOrThereTwice) {
  EXPECT_THAT(refusal(changed("{do: grasp, ", "{")),
              AllOf(HasSubstr("mine.yaml:6"), HasSubstr("'grasp' has no `do`")));
  EXPECT_THAT(refusal(changed("start: look\n", "")), HasSubstr("start is missing"));
  EXPECT_THAT(refusal(changed("start: look", "start: look\nstart: lift")), HasSubstr("start"));
  EXPECT_THAT(refusal(changed("start: look", "start: [look, lift]")), HasSubstr("start"));
  EXPECT_THAT(refusal(changed("  grasp: {", "  look: {")), HasSubstr("look"));
  EXPECT_THAT(refusal(changed(", failed: leave}", "}")),
              AllOf(HasSubstr("does not say where it goes on"), HasSubstr("'failed'")));
  EXPECT_THAT(refusal("start: look\n"), HasSubstr("states is missing"));
  EXPECT_THAT(refusal("start: look\nstates: {}\n"), HasSubstr("states"));
  EXPECT_THAT(refusal(""), HasSubstr("mine.yaml"));
  EXPECT_THAT(refusal(changed("lift:", "success:")), HasSubstr("is an end of every task"));
  EXPECT_THAT(refusal(changed("leave: {do",
                              "alone: {do: release, done: alone, failed: alone}\n"
                              "  leave: {do")),
              HasSubstr("cannot be reached"));
}

TEST(Task, RefusesWhatCannotEnd) {
  // Round and round between two states.
  const std::string shaken =
      changed("done: open, otherwise: failure}", "done: up, otherwise: open}") +
      "  up: {do: move, to: lifted, done: down, otherwise: open}\n";
  EXPECT_THAT(refusal(shaken), HasSubstr("can go round for ever"));
  std::string bounded = shaken;
  bounded.replace(bounded.find("to: lifted"), 10, "to: lifted, times: 3, then: again");
  EXPECT_EQ(refusal(bounded + "  again: {do: move, to: lowered, done: open, otherwise: open}\n"),
            "accepted");
  EXPECT_EQ(refusal(changed("done: success, failed: failure", "done: look, failed: failure")),
            "accepted")
      << "a look ends it";
  EXPECT_THAT(refusal("start: a\nstates:\n  a: {do: wait, seconds: 1, done: b}\n"
                      "  b: {do: wait, seconds: 1, done: a}\n"),
              HasSubstr("never comes to an end"));
  EXPECT_THAT(refusal("start: a\nstates:\n  a: {do: wait, seconds: -1, done: success}\n"),
              HasSubstr("seconds"));
  EXPECT_THAT(refusal(changed("states:", "objects: all\nstates:")), HasSubstr("no places"));
}

// A lift of nothing was once found out by the arm.
TEST(Task, RefusesActionsWhereTheyMakeNoSense) {
  EXPECT_THAT(refusal(changed("done: grasp, failed: failure}", "done: lift, failed: failure}")),
              AllOf(HasSubstr("cannot lift"), HasSubstr("comes from 'approach'"),
                    HasSubstr("the hand is open round the object")));
  EXPECT_THAT(refusal(changed("start: look", "start: approach")),
              AllOf(HasSubstr("cannot approach"), HasSubstr("no object is chosen")));
  EXPECT_THAT(refusal(changed("to: lowered, ", "to: lowered, share: 0.5, ")),
              AllOf(HasSubstr("cannot release"), HasSubstr("lowered in part")));
  EXPECT_THAT(refusal(changed("lift: {do: lift, done: down, otherwise: failure}",
                              "lift: {do: lift, done: leave, otherwise: failure}")),
              HasSubstr("cannot retreat"));
}

}  // namespace
}  // namespace prehend::control
