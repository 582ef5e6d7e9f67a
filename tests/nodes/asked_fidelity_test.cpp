#include "nodes/stage_fidelity/asked_fidelity.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"

namespace prehend::nodes {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr const char* kChain = "config/fidelity/chain.yaml";

control::Task asking_task(double budget, double tolerance) {
  control::Task task;
  task.budget = budget;
  task.tolerance = tolerance;
  task.asked_at = budget > 0 ? "mine.yaml:3: budget" : "mine.yaml:3: tolerance";
  return task;
}

template <class Work>
std::string refusal_of(const Work& work) {
  try {
    work();
  } catch (const geometry::InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(AskedFidelity, IsTheTasksOrTheParameters) {
  EXPECT_FALSE(asked_fidelity({}, 0, 0).is_asked());
  EXPECT_EQ(asked_fidelity({}, 0.8, 0).budget, 0.8);
  EXPECT_EQ(asked_fidelity({}, 0.8, 0).task_at, "");
  const AskedFidelity asked = asked_fidelity(asking_task(0, 0.003), 0, 0);
  EXPECT_EQ(asked.budget, 0);
  EXPECT_EQ(asked.tolerance, 0.003);
  EXPECT_EQ(asked.task_at, "mine.yaml:3: tolerance");
  EXPECT_THAT(
      refusal_of([] { asked_fidelity(asking_task(1, 0), 2, 0); }),
      AllOf(HasSubstr("mine.yaml:3: budget"), HasSubstr("parameter budget"), HasSubstr("Leave")));
  EXPECT_THAT(refusal_of([] { asked_fidelity(asking_task(1, 0), 0, 0.002); }),
              AllOf(HasSubstr("mine.yaml:3: budget"), HasSubstr("parameter tolerance")));
}

// The fastest that the front has is offered, and is taken when it is written as it is offered.
TEST(AskedFidelity, WhatNothingKeepsNamesTheTasksLineAndWhatWouldDo) {
  const fidelity::Front front = fidelity::read_front(kChain);
  const std::string refused =
      refusal_of([&] { choose_asked(front, asked_fidelity(asking_task(1e-3, 0), 0, 0)); });
  EXPECT_THAT(refused, AllOf(HasSubstr("mine.yaml:3: budget"), HasSubstr("Give at least ")));
  const double offered = std::stod(refused.substr(refused.find("at least ") + 9));
  EXPECT_EQ(&choose_asked(front, asked_fidelity(asking_task(offered, 0), 0, 0)),
            &front.settings.front());
  const std::string too_fine =
      refusal_of([&] { choose_asked(front, asked_fidelity(asking_task(0, 1e-5), 0, 0)); });
  const double least = std::stod(too_fine.substr(too_fine.find("at least ") + 9));
  EXPECT_EQ(&choose_asked(front, asked_fidelity(asking_task(0, least), 0, 0)),
            &front.settings.back());
}

// A task speaks of the whole chain: a front of one stage would take its budget for that alone.
TEST(AskedFidelity, ATaskNeedsTheFrontOfAChain) {
  const AskedFidelity by_task = asked_fidelity(asking_task(1, 0), 0, 0);
  EXPECT_EQ(read_asked_front(kChain, by_task).subject, "chain");
  EXPECT_THAT(refusal_of([&] { read_asked_front("config/fidelity/shape.yaml", by_task); }),
              AllOf(HasSubstr("mine.yaml:3"), HasSubstr("'shape'"), HasSubstr("chain.yaml")));
  EXPECT_THAT(refusal_of([&] { read_asked_front("", by_task); }),
              AllOf(HasSubstr("mine.yaml:3"), HasSubstr("front is empty")));
  EXPECT_EQ(read_asked_front("config/fidelity/shape.yaml", {1, 0, ""}).subject, "shape");
}

}  // namespace
}  // namespace prehend::nodes
