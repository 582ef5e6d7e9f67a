// The node grasp_planning as a process: whatever is wrong with one object of a view is its own
// problem. Once one exception lost all other objects of the view.

#include <chrono>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "msgs/convert/geometry.h"
#include "msgs/convert/objects.h"
#include "msgs/graph.pb.h"
#include "msgs/grasp.pb.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"
#include "prehend/surface/model.h"
#include "tests/robot/without_pads.h"
#include "tests/system/launched.h"

namespace prehend::testing {
namespace {

using std::chrono::seconds;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

class GraspPlanningNode : public ::testing::Test {
 protected:
  GraspPlanningNode() : node_(options()) {
    models_ = node_.advertise<msgs::ObjectModel>("/models", graph::QoS::latched(32));
    plans_ = node_.subscribe<msgs::GraspPlan>("/plans", graph::QoS::latched(32),
                                              [this](const graph::Received<msgs::GraspPlan>& p) {
                                                const std::lock_guard lock(mutex_);
                                                received_[p->header().stamp()][p->id()] = *p;
                                              });
    diagnostics_ = node_.subscribe<msgs::graph::Diagnostic>(
        "/diagnostics", graph::QoS::latched(64),
        [this](const graph::Received<msgs::graph::Diagnostic>& diagnostic) {
          const std::lock_guard lock(mutex_);
          if (diagnostic->node() == "grasp_planning") told_ += diagnostic->text() + "\n";
        });
    node_.spin_in_background();
  }

  void start(const std::vector<std::string>& parameters) {
    std::vector<std::string> arguments{"--registry", registry_.endpoint()};
    for (const std::string& parameter : parameters) {
      arguments.insert(arguments.end(), {"--param", parameter});
    }
    planning_.emplace("grasp_planning", arguments, scratch_.path() / "output.txt");
  }

  // A carton of a view at x [m].
  static msgs::ObjectModel carton(std::int64_t stamp, std::uint32_t id, double x) {
    auto model = convert::to_message(surface::model_of_mesh(geometry::transformed(
        geometry::make_box({0.05, 0.05, 0.12}),
        geometry::make_transform(Eigen::Quaterniond::Identity(), {x, 0, 0.06}))));
    model.mutable_header()->set_stamp(stamp);
    model.set_id(id);
    model.set_object_count(3);
    model.set_valid(true);
    *model.mutable_table() = convert::to_message(geometry::Plane{});
    return model;
  }

  // The plans of a view by object, when all three have come.
  std::map<std::uint32_t, msgs::GraspPlan> plans(std::int64_t stamp) {
    const auto end = std::chrono::steady_clock::now() + seconds(60);
    while (std::chrono::steady_clock::now() < end) {
      {
        const std::lock_guard lock(mutex_);
        if (received_[stamp].size() == 3) return received_[stamp];
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    const std::lock_guard lock(mutex_);
    return received_[stamp];
  }
  std::string told() {
    const std::lock_guard lock(mutex_);
    return told_;
  }
  void expect_others_planned(std::int64_t stamp, msgs::GraspPlan::Outcome outcome_of_1,
                             const std::string& problem_of_1) {
    const auto all = plans(stamp);
    ASSERT_EQ(all.size(), 3u) << planning_->output();
    for (const std::uint32_t id : {0u, 2u}) {
      EXPECT_THAT(all.at(id).problem(), IsEmpty()) << "object " << id;
      EXPECT_GT(all.at(id).grasps_size(), 0) << "object " << id;
      EXPECT_EQ(all.at(id).outcome(), msgs::GraspPlan::GRASPABLE) << "object " << id;
    }
    EXPECT_EQ(all.at(1).outcome(), outcome_of_1);
    EXPECT_THAT(all.at(1).problem(), HasSubstr(problem_of_1));
    EXPECT_EQ(all.at(1).grasps_size(), 0);
    EXPECT_EQ(all.at(1).object_count(), 3u);
  }

 private:
  graph::NodeOptions options() {
    graph::NodeOptions options;
    options.name = "test";
    options.registry = registry_.endpoint();
    return options;
  }

 protected:
  ScratchFolder scratch_;
  graph::Registry registry_{{.endpoint = "tcp://127.0.0.1:*"}};
  std::optional<Launched> planning_;
  std::mutex mutex_;
  std::map<std::int64_t, std::map<std::uint32_t, msgs::GraspPlan>> received_;
  std::string told_;
  graph::Node node_;
  graph::Publisher<msgs::ObjectModel> models_;
  graph::Subscription plans_, diagnostics_;
};

// Planning the arm's motion threw something that the node did not expect.
TEST_F(GraspPlanningNode, AnUnexpectedExceptionIsTheProblemOfItsObject) {
  start({"platform:=kr5_sdh", "home:=side", "motions:=1"});
  for (const std::int64_t stamp : {1, 2}) {  // the node lives on
    models_.publish(carton(stamp, 0, 0));
    auto without_pieces = carton(stamp, 1, 0.15);
    without_pieces.clear_convex_pieces();
    models_.publish(without_pieces);
    models_.publish(carton(stamp, 2, -0.15));
    expect_others_planned(stamp, msgs::GraspPlan::FAILED, "planning failed: ");
  }
  EXPECT_THAT(told(), HasSubstr("object 1: "));
}

// What would help is in the message, and in the reason that the cycle gives up with.
TEST_F(GraspPlanningNode, WhatIsTooWideComesWithWhatWouldHelp) {
  start({"platform:=kr5_pg70", "approach:=down", "motions:=1", "remedy_budget:=60"});
  models_.publish(carton(1, 0, -0.2));
  auto wide = convert::to_message(surface::model_of_mesh(geometry::transformed(
      geometry::make_box({0.08, 0.09, 0.12}),
      geometry::make_transform(Eigen::Quaterniond::Identity(), {0, 0, 0.06}))));
  wide.mutable_header()->CopyFrom(carton(1, 1, 0).header());
  wide.set_id(1);
  wide.set_object_count(3);
  wide.set_valid(true);
  *wide.mutable_table() = convert::to_message(geometry::Plane{});
  models_.publish(wide);
  models_.publish(carton(1, 2, 0.2));
  const auto all = plans(1);
  ASSERT_EQ(all.size(), 3u) << planning_->output();
  const msgs::GraspPlan& plan = all.at(1);
  ASSERT_EQ(plan.outcome(), msgs::GraspPlan::UNGRASPABLE);
  ASSERT_GT(plan.remedies_size(), 0) << plan.problem();
  const msgs::Remedy& first = plan.remedies(0);
  ASSERT_EQ(first.amounts_size(), 1);
  EXPECT_EQ(first.amounts(0).change(), msgs::RemedyAmount::OPENING);
  EXPECT_DOUBLE_EQ(first.amounts(0).planned(), 0.069);
  EXPECT_GT(first.amounts(0).needed(), 0.08);
  EXPECT_GT(first.grasps(), 0u);
  EXPECT_THAT(plan.problem(), HasSubstr("It would help: " + first.text()));
  EXPECT_EQ(all.at(0).remedies_size(), 0);
}

// In clutter each look would else take the budget as often as there are objects without a grasp.
TEST_F(GraspPlanningNode, TheObjectsOfAViewShareTheBudgetForWhatWouldHelp) {
  start({"platform:=kr5_pg70", "approach:=down", "motions:=1", "remedy_budget:=0.001"});
  for (const std::uint32_t id : {0u, 1u, 2u}) {
    auto wide = convert::to_message(surface::model_of_mesh(geometry::transformed(
        geometry::make_box({0.08, 0.09, 0.12}),
        geometry::make_transform(Eigen::Quaterniond::Identity(), {0, 0.2 * id, 0.06}))));
    wide.mutable_header()->CopyFrom(carton(1, id, 0).header());
    wide.set_id(id);
    wide.set_object_count(3);
    wide.set_valid(true);
    *wide.mutable_table() = convert::to_message(geometry::Plane{});
    models_.publish(wide);
  }
  const auto all = plans(1);
  ASSERT_EQ(all.size(), 3u) << planning_->output();
  int sought = 0;
  for (const auto& [id, plan] : all) {
    EXPECT_TRUE(plan.remedies_incomplete()) << id;
    for (const auto& time : plan.times()) sought += time.stage() == "remedies";
  }
  EXPECT_EQ(sought, 1);
}

// With a platform the node once planned on circles whatever its generators said.
TEST_F(GraspPlanningNode, APlatformTakesGenerators) {
  start({"platform:=kr5_sdh", "home:=side", "motions:=1", "generators:=[segments]"});
  for (const std::uint32_t id : {0u, 1u, 2u}) models_.publish(carton(1, id, 0.15 * (id - 1.0)));
  const auto all = plans(1);
  ASSERT_EQ(all.size(), 3u) << planning_->output();
  int grasps = 0;
  for (const auto& [id, plan] : all) {
    for (const auto& grasp : plan.grasps()) EXPECT_EQ(grasp.generator(), "segments");
    grasps += plan.grasps_size();
  }
  EXPECT_GT(grasps, 0) << planning_->output();
}

TEST_F(GraspPlanningNode, PlannerAndCheckerAreChosenByName) {
  start({"platform:=kr5_sdh", "home:=side", "motions:=1", "path_planner:=ompl_rrt_connect",
         "collision_checker:=bullet"});
  for (const std::uint32_t id : {0u, 1u, 2u}) models_.publish(carton(1, id, 0.15 * (id - 1.0)));
  int with_motion = 0;
  for (const auto& [id, plan] : plans(1)) {
    for (const auto& grasp : plan.grasps()) with_motion += grasp.arm_size() > 0;
  }
  EXPECT_GT(with_motion, 0) << planning_->output();
}

// Grasps that the arm can execute say what their pads should feel, and where the hand stops.
TEST_F(GraspPlanningNode, TouchOfThePadsGoesWithThePlan) {
  start({"platform:=kr5_sdh", "home:=side", "motions:=1", "grip_force:=8"});
  for (const std::uint32_t id : {0u, 1u, 2u}) models_.publish(carton(1, id, 0.15 * (id - 1.0)));
  const auto all = plans(1);
  ASSERT_EQ(all.size(), 3u) << planning_->output();
  int predicted = 0;
  for (const auto& [id, plan] : all) {
    ASSERT_GT(plan.grasps_size(), 0) << "object " << id;
    const msgs::Grasp& best = plan.grasps(0);
    EXPECT_EQ(best.grasp_force(), 8);
    if (!best.predicted().not_predicted().empty()) continue;
    ++predicted;
    EXPECT_GT(best.predicted().tactile_sum(), 4);
    EXPECT_GT(best.predicted().contact_area(), 0);
    EXPECT_EQ(best.predicted().stop_position_size(), best.hand_joint_name_size());
    ASSERT_GT(best.predicted().pads_size(), 0);
    const msgs::TactileFrame& image = best.predicted().pads(0).image();
    EXPECT_EQ(static_cast<std::uint32_t>(image.intensity_size()), image.rows() * image.columns());
    for (int i = 1; i < plan.grasps_size(); ++i) {
      EXPECT_EQ(plan.grasps(i).predicted().pads_size(), 0) << "it gets no motion";
    }
  }
  EXPECT_GT(predicted, 0) << planning_->output();
}

TEST_F(GraspPlanningNode, TouchIsNotPredictedWhereNobodyAsksForIt) {
  start({"platform:=kr5_sdh", "home:=side", "motions:=1", "predict_touch:=false"});
  for (const std::uint32_t id : {0u, 1u, 2u}) models_.publish(carton(1, id, 0.15 * (id - 1.0)));
  for (const auto& [id, plan] : plans(1)) {
    ASSERT_GT(plan.grasps_size(), 0) << "object " << id;
    EXPECT_EQ(plan.grasps(0).predicted().pads_size(), 0);
    EXPECT_EQ(plan.grasps(0).predicted().tactile_sum(), 0);
    EXPECT_FALSE(plan.has_touch_fidelity());
    EXPECT_THAT(plan.grasps(0).predicted().not_predicted(), IsEmpty());
    EXPECT_GT(plan.grasps(0).predicted().lifted_mass(), 0);
  }
}

// The step of predicted touch is that of the front's setting, and is said; it goes with the plan.
TEST_F(GraspPlanningNode, TheFrontChoosesTheStepsOfPredictedTouch) {
  const std::string front = (scratch_.path() / "front.yaml").string();
  std::ofstream(front) << "subject: touch_hand\nerror_name: e\nerror_unit: of the largest sum\n"
                          "machine: a test\nsettings:\n"
                          "  - {milliseconds: 3, error: 0.04, knobs: {step: 0.008}}\n"
                          "  - {milliseconds: 9, error: 0.02, knobs: {step: 0.003}}\n";
  start({"platform:=kr5_sdh", "home:=side", "motions:=1", "touch_front:=" + front,
         "touch_tolerance:=0.03"});
  EXPECT_TRUE(planning_->wait_for_output(
      "steps of predicted touch chosen: step 0.003: 9 ms of processor", seconds(20)))
      << planning_->output();
  for (const std::uint32_t id : {0u, 1u, 2u}) models_.publish(carton(1, id, 0.15 * (id - 1.0)));
  for (const auto& [id, plan] : plans(1)) {
    ASSERT_TRUE(plan.has_touch_fidelity()) << "object " << id;
    EXPECT_EQ(plan.touch_fidelity().knobs(), "step 0.003");
    EXPECT_EQ(plan.touch_fidelity().seconds(), 0.009);
    EXPECT_EQ(plan.touch_fidelity().error(), 0.02);
  }
}

// What means nothing beside the other parameters was ignored.
TEST_F(GraspPlanningNode, WhatDoesNotApplyIsRefused) {
  const auto refusal = [this](const std::vector<std::string>& parameters) {
    start(parameters);
    EXPECT_EQ(planning_->wait(seconds(20)), 2);
    return planning_->output();
  };
  EXPECT_THAT(refusal({"platform:=kr5_sdh", "friction:=0.5"}),
              HasSubstr("'friction' does not apply with a hand of fingers"));
  EXPECT_THAT(refusal({"platform:=kr5_sdh", "front:=config/fidelity/plan.yaml"}),
              HasSubstr("'front' does not apply with a hand of fingers"));
  EXPECT_THAT(refusal({"platform:=kr5_sdh", "gripper:=config/robots/pg70_dsa.yaml"}),
              HasSubstr("gripper does not apply: the platform has its own hand"));
  EXPECT_THAT(refusal({"platform:="}), HasSubstr("There is no platform ''"));
  const std::string unfeeling =
      "platform:=" + platform_without_pads(scratch_.path() / "robots").string();
  EXPECT_THAT(refusal({unfeeling, "grip_force:=8"}),
              HasSubstr("'grip_force' does not apply with the hand 'bh8': it has no tactile pads"));
  EXPECT_THAT(refusal({unfeeling, "predict_touch:=true"}),
              HasSubstr("'predict_touch' does not apply with the hand 'bh8'"));
  EXPECT_THAT(refusal({"platform:=stage_pg70", "predict_touch:=true"}),
              HasSubstr("'predict_touch' does not apply with the hand 'pg70'"));
  EXPECT_THAT(refusal({"platform:=stage_pg70", "touch_tolerance:=0.5"}),
              HasSubstr("'touch_tolerance' does not apply with the hand 'pg70'"));
  EXPECT_THAT(refusal({unfeeling, "touch_budget:=1"}),
              HasSubstr("'touch_budget' does not apply with the hand 'bh8': it has no tactile"));
  EXPECT_THAT(refusal({"platform:=kr5_sdh", "predict_touch:=false", "touch_budget:=1"}),
              HasSubstr("do not apply with predict_touch:=false"));
  EXPECT_THAT(refusal({"platform:=kr5_sdh", "touch_tolerance:=1e-9"}),
              HasSubstr("Allow as much as the most accurate one"));
  EXPECT_THAT(refusal({"platform:=kr5_pg70", "grip_force:=8"}), HasSubstr("its force is planned"));
  EXPECT_THAT(refusal({"platform:=kr5_sdh", "path_planner:=rrt_conect"}),
              AllOf(HasSubstr("ompl_bitrrt"), HasSubstr("the nearest is rrt_connect")));
  EXPECT_THAT(refusal({"budget:=0.3", "rolls:=4"}),
              HasSubstr("'rolls' does not apply beside a budget"));
  EXPECT_THAT(refusal({"budget:=0.3", "front:=config/fidelity/plan.yaml", "generators:=[boxes]"}),
              HasSubstr("'generators' does not apply beside a budget"));
}

// Of the whole graph: it does not begin with what cannot be kept, while a parameter that nothing
// keeps cuts planning off.
TEST_F(GraspPlanningNode, ATaskThatNoChainKeepsIsRefused) {
  std::ifstream in("config/tasks/pick_and_place.yaml");
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  const auto refusal = [&](const std::string& key, std::vector<std::string> parameters) {
    std::ofstream(scratch_.path() / "mine.yaml") << key << "\n" << text;
    parameters.insert(parameters.end(), {"task:=mine", "tasks:=" + scratch_.path().string()});
    start(parameters);
    EXPECT_EQ(planning_->wait(seconds(20)), 2);
    return planning_->output();
  };
  const std::string chain = "front:=config/fidelity/chain.yaml";
  EXPECT_THAT(refusal("budget: 0.001", {chain}),
              AllOf(HasSubstr("mine.yaml:1: budget"), HasSubstr("Give at least 0.")));
  EXPECT_THAT(refusal("budget: 1.1", {chain, "budget:=1"}),
              AllOf(HasSubstr("mine.yaml:1: budget"), HasSubstr("Leave one of them out")));
  EXPECT_THAT(refusal("tolerance: 0.003", {chain, "rolls:=4"}),
              HasSubstr("'rolls' does not apply beside a budget"));
  EXPECT_THAT(refusal("tolerance: 0.003", {chain, "motions:=2"}),
              HasSubstr("'motions' does not apply beside a budget of the whole chain"));
  EXPECT_THAT(
      refusal("tolerance: 0.003", {"front:=config/fidelity/chain_cloud.yaml", "first_share:=2"}),
      HasSubstr("'first_share' does not apply beside a budget of the whole chain"));
  EXPECT_THAT(refusal("tolerance: 0.003", {}), HasSubstr("front is empty"));
}

// A sliver among the pieces is one of them.
TEST_F(GraspPlanningNode, FlatPiecesAreObstaclesAndCanBeHeld) {
  start({"platform:=kr5_sdh", "home:=side", "motions:=1"});
  for (const std::uint32_t id : {0u, 1u, 2u}) {
    auto model = carton(1, id, 0.15 * (id - 1.0));
    const double x = 0.15 * (id - 1.0);
    *model.add_convex_pieces() = convert::to_message(
        geometry::TriangleMesh{{{x, 0, 0.05}, {x + 0.02, 0, 0.05}, {x, 0, 0.1}}, {{0, 1, 2}}});
    models_.publish(model);
  }
  const auto all = plans(1);
  ASSERT_EQ(all.size(), 3u) << planning_->output();
  for (const auto& [id, plan] : all) {
    EXPECT_THAT(plan.problem(), IsEmpty()) << "object " << id;
    ASSERT_GT(plan.grasps_size(), 0) << "object " << id;
    EXPECT_GT(plan.grasps(0).arm_size(), 0) << "object " << id;
  }
}

// Of a stage too: its joints' motions, the gripper's own words, and the gripper they are for.
TEST_F(GraspPlanningNode, AStageIsAPlatformLikeTheOthers) {
  start({"gripper:=config/robots/pg70_dsa.yaml", "motions:=2"});
  for (const std::uint32_t id : {0u, 1u, 2u}) models_.publish(carton(1, id, 0.2 * (id - 1.0)));
  const auto all = plans(1);
  ASSERT_EQ(all.size(), 3u) << planning_->output();
  for (const auto& [id, plan] : all) {
    EXPECT_THAT(plan.problem(), IsEmpty()) << "object " << id;
    EXPECT_TRUE(plan.has_gripper());
    ASSERT_GT(plan.grasps_size(), 0) << "object " << id;
    const msgs::Grasp& grasp = plan.grasps(0);
    ASSERT_EQ(grasp.arm_size(), 6) << "object " << id;
    const auto& names = grasp.arm(0).trajectory().joint_name();
    EXPECT_EQ(std::vector<std::string>(names.begin(), names.end()),
              (std::vector<std::string>{"arm_x", "arm_y", "arm_z", "arm_yaw"}));
    // At the end of the approach the slides are where the grasp is.
    const auto& points = grasp.arm(1).trajectory().points();
    const auto& last = points[points.size() - 1];
    EXPECT_NEAR(last.position(0), grasp.x_wg().position().x(), 1e-6);
    EXPECT_NEAR(last.position(2), grasp.x_wg().position().z(), 1e-6);
    EXPECT_GT(grasp.pregrasp_opening(), 0.05);
    EXPECT_GT(grasp.contacts_size(), 0);
  }
}

// Once the other objects could not be grasped, as their neighbour's mesh could not be read.
TEST_F(GraspPlanningNode, AModelThatCannotBeReadIsItsOwnProblem) {
  start({"gripper:=config/robots/pg70_dsa.yaml"});
  models_.publish(carton(1, 0, 0));
  auto damaged = carton(1, 1, 0.15);
  damaged.mutable_mesh()->clear_data();
  models_.publish(damaged);
  models_.publish(carton(1, 2, -0.15));
  expect_others_planned(1, msgs::GraspPlan::UNGRASPABLE, "mesh");
  EXPECT_THAT(told(), HasSubstr("object 1 is left out as an obstacle"));
}

}  // namespace
}  // namespace prehend::testing
