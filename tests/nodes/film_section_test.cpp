#include "nodes/report/film_section.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "msgs/convert/geometry.h"
#include "msgs/convert/objects.h"
#include "nodes/report/truth_section.h"
#include "prehend/geometry/errors.h"
#include "prehend/simulation/shapes.h"

namespace prehend::nodes {
namespace {

using testing::HasSubstr;

const robot::Platform& platform() {
  static const robot::Platform arm = robot::read_platform("config/robots/kr5_sdh.yaml");
  return arm;
}

// An arm that stands for a second, and turns its first joint in the next; it lifts from 1 s on.
Collected run() {
  Collected collected;
  const robot::KinematicChain chain = platform().arm_chain();
  const robot::Positions home = platform().home("home").arm;
  for (int step = 0; step <= 20; ++step) {
    const double time = 0.1 * step;
    for (int i = 0; i < chain.size(); ++i) {
      const double turned = i == 0 && time > 1 ? 0.2 * (time - 1) : 0;
      collected.joints[chain.joints()[static_cast<std::size_t>(i)].name].emplace_back(
          time, home[i] + turned);
    }
    for (const std::string& name : platform().hand.actuated_names()) {
      collected.joints["hand_" + name].emplace_back(time, 0.1);
    }
  }
  collected.phases = {{0, control::Phase::kApproach}, {1, control::Phase::kLift}};
  surface::ObjectModel model;
  model.mesh_W = simulation::make_standing_box({0.05, 0.05, 0.1});
  msgs::ObjectModel message = convert::to_message(model);
  message.set_id(0);
  message.set_valid(true);
  message.mutable_table()->mutable_normal()->set_z(1);
  collected.models[0] = message;
  collected.result.emplace();
  return collected;
}

std::string page_of(const Collected& collected) {
  report::Page page("t");
  add_film(page, collected, platform());
  return page.html();
}

TEST(FilmSection, ShowsRobotTableAndObjectOverTime) {
  const std::string html = page_of(run());
  for (const std::string name : {"arm", "hand", "table", "object 0"}) {
    EXPECT_THAT(html, HasSubstr("\"name\":\"" + name + "\""));
  }
  EXPECT_THAT(html, HasSubstr("\"approach\""));
  EXPECT_THAT(html, HasSubstr("\"lift\""));
}

// Nobody says where bodies are: the hand takes the object along; where somebody does, that counts.
TEST(FilmSection, WhatIsGraspedGoesWithTheHandOrItsBody) {
  const auto poses_of_object = [](const std::string& html) {
    const auto object = html.find("\"name\":\"object 0\"");
    const auto begin = html.find("\"poses\":\"", object) + 9;
    return html.substr(begin, html.find('"', begin) - begin);
  };
  Collected collected = run();
  const std::string with_hand = poses_of_object(page_of(collected));
  EXPECT_GT(with_hand.size(), 100u) << "it moves";
  collected.result->set_object_id(7);
  EXPECT_LT(poses_of_object(page_of(collected)).size(), 50u) << "another one is held: it stays";
  collected.result->set_object_id(0);
  BodyHistory& body = collected.bodies["box"];
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  body.poses = {{0, X}};
  X.translation().z() = 0.2;
  body.poses.emplace_back(1.5, X);
  const std::string with_body = poses_of_object(page_of(collected));
  EXPECT_GT(with_body.size(), 100u);
  EXPECT_NE(with_body, with_hand);
}

void add_true_box(Collected& collected, double width) {
  BodyHistory& body = collected.bodies["box"];
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.translation() = Eigen::Vector3d(0.01, 0, 0);
  body.poses = {{0, X}, {1, X}};
  msgs::TruthShapes::Shape& shape = *collected.true_shapes.add_shapes();
  shape.set_name("box");
  *shape.mutable_mesh() = convert::to_message(simulation::make_standing_box({width, 0.05, 0.1}));
}

TEST(FilmSection, ShowsTrueShapesWhereTheyAreNotThePredictedOnes) {
  Collected collected = run();
  add_true_box(collected, 0.05);
  EXPECT_THAT(page_of(collected), HasSubstr("true shapes"));
  collected.on_prediction = true;
  EXPECT_THAT(page_of(collected), testing::Not(HasSubstr("true shapes")));
}

TEST(TruthSection, SaysVolumesDistancesAndSections) {
  Collected collected = run();
  add_true_box(collected, 0.1);
  report::Page page("t");
  add_truth(page, collected);
  const std::string html = page.html();
  EXPECT_THAT(html, HasSubstr("<td>250</td><td>500 (-50 %)</td>"));
  EXPECT_THAT(html, HasSubstr("Object 0 (box), upright"));
  EXPECT_THAT(html, HasSubstr("Object 0 (box), level"));
  collected.bodies["box"].poses = {{0, geometry::RigidTransform(Eigen::Translation3d(1, 0, 0))}};
  report::Page far("t");
  add_truth(far, collected);
  EXPECT_THAT(far.html(), HasSubstr("Nothing that was predicted stands"));
}

TEST(FilmSection, SaysWhatIsMissing) {
  Collected collected = run();
  collected.joints.erase(platform().arm_chain().joints().front().name);
  EXPECT_THROW(page_of(collected), geometry::InputError);
  collected.joints.clear();
  EXPECT_THROW(page_of(collected), geometry::InputError);
  collected = run();
  collected.models[0].set_valid(false);
  EXPECT_THAT(page_of(collected), HasSubstr("\"name\":\"arm\"")) << "the robot alone moves, too";
}

}  // namespace
}  // namespace prehend::nodes
