// Actions of both versions of ROS, client and server, and what else goes over no wire.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>

#include "drivers/ros/driver/action_client.h"
#include "drivers/ros/driver/action_server.h"
#include "drivers/ros/driver/frame_tree.h"
#include "msgs/ros/to_ros.h"
#include "tests/drivers/ros/late_peer.h"

namespace prehend::drivers::ros_link {
namespace {

using recording::RosValue;
using testing::ElementsAre;
using Fields = RosValue::Fields;

constexpr const char* kAction = "/arm/grip";
constexpr const char* kType = "control_msgs/GripperCommand";

RosValue to_position(double position) {
  return RosValue(Fields{{"command", RosValue(Fields{{"position", ros::ros_number(position)}})}});
}
RosValue reached_at(double position) {
  return RosValue(
      Fields{{"position", ros::ros_number(position)}, {"reached_goal", ros::ros_integer(1)}});
}

class RosActions : public testing::TestWithParam<ros::Version> {
 protected:
  RosActions() {
    server_ = serve_action(peer_, kAction, kType,
                           {[this](const RosValue& goal) {
                              asked_ = goal["command"]["position"].number();
                              ++goals_;
                              return refusal_;
                            },
                            [this] { ++cancels_; }});
    client_ = action_client(peer_, kAction, kType);
  }
  RosActionClient::Done done() {
    return [this](GoalEnd end, const RosValue* result, const std::string& text) {
      ends_.push_back(end);
      texts_.push_back(text);
      position_ = result ? (*result)["position"].number() : -1;
    };
  }
  LatePeer peer_{GetParam()};
  std::string refusal_;
  double asked_ = 0, position_ = 0;
  int goals_ = 0;
  std::atomic<int> cancels_ = 0;
  std::vector<GoalEnd> ends_;
  std::vector<std::string> texts_;
  std::unique_ptr<RosActionServer> server_;
  std::unique_ptr<RosActionClient> client_;
};

TEST_P(RosActions, AGoalIsTakenAndItsResultTold) {
  EXPECT_TRUE(client_->has_server());
  client_->send(to_position(0.03), done());
  peer_.settle();
  EXPECT_EQ(asked_, 0.03);
  EXPECT_TRUE(ends_.empty());
  server_->feedback(reached_at(0.01));
  server_->finish(true, false, reached_at(0.03), "there");
  peer_.settle();
  EXPECT_THAT(ends_, ElementsAre(GoalEnd::kSucceeded));
  EXPECT_EQ(position_, 0.03);
  server_.reset();
  peer_.settle();
  EXPECT_FALSE(client_->has_server());
}

TEST_P(RosActions, AnAbortedOneHasItsResult) {
  client_->send(to_position(0), done());
  peer_.settle();
  server_->finish(false, false, reached_at(0.02), "stuck");
  peer_.settle();
  EXPECT_THAT(ends_, ElementsAre(GoalEnd::kAborted));
  EXPECT_EQ(position_, 0.02);
  if (GetParam() == ros::Version::kRos1) EXPECT_THAT(texts_, ElementsAre("stuck"));
}

TEST_P(RosActions, ARefusedOneIsRejected) {
  refusal_ = "not now";
  client_->send(to_position(0), done());
  peer_.settle();
  EXPECT_THAT(ends_, ElementsAre(GoalEnd::kRejected));
  refusal_.clear();
  client_->send(to_position(0), done());
  peer_.settle();
  // Another client's, while one runs.
  const auto other = action_client(peer_, kAction, kType);
  std::vector<GoalEnd> others;
  other->send(to_position(1),
              [&](GoalEnd end, const RosValue*, const std::string&) { others.push_back(end); });
  peer_.settle();
  EXPECT_THAT(others, ElementsAre(GoalEnd::kRejected));
  EXPECT_EQ(ends_.size(), 1U);
  server_->finish(true, false, reached_at(0), "");
  peer_.settle();
  EXPECT_EQ(ends_.size(), 2U);
  EXPECT_EQ(others.size(), 1U);
}

TEST_P(RosActions, CancellingReachesTheServer) {
  client_->send(to_position(0), done());
  peer_.settle();
  client_->cancel();
  peer_.settle();
  EXPECT_EQ(cancels_, 1);
  server_->finish(false, true, reached_at(0.01), "");
  peer_.settle();
  EXPECT_THAT(ends_, ElementsAre(GoalEnd::kCancelled));
  client_->cancel();  // nothing runs
  peer_.settle();
  EXPECT_EQ(cancels_, 1);
}

// Before its acceptance is known.
TEST_P(RosActions, CancellingAtOnceReachesTheServerToo) {
  client_->send(to_position(0), done());
  client_->cancel();
  peer_.settle();
  EXPECT_EQ(goals_, 1);
  EXPECT_EQ(cancels_, 1);
}

TEST_P(RosActions, OfAGoalBeforeNothingIsTold) {
  client_->send(to_position(0), done());
  peer_.settle();
  server_->finish(true, false, reached_at(0), "");
  client_->send(to_position(1), [this](GoalEnd, const RosValue*, const std::string&) {
    texts_.emplace_back("second");
  });
  peer_.settle();
  server_->finish(true, false, reached_at(1), "");
  peer_.settle();
  EXPECT_EQ(texts_.back(), "second");
  EXPECT_LE(ends_.size(), 1U);
}

INSTANTIATE_TEST_SUITE_P(Ros, RosActions,
                         testing::Values(ros::Version::kRos1, ros::Version::kRos2));

geometry::RigidTransform moved(double x, double y = 0) {
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.translation() = Eigen::Vector3d(x, y, 0);
  return X;
}

TEST(FrameTree, JoinsFramesOverTheirParents) {
  FrameTree tree;
  EXPECT_TRUE(tree.find("a", "a")->isApprox(geometry::RigidTransform::Identity()));
  EXPECT_FALSE(tree.find("world", "eye"));
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()));
  tree.set("world", "base", geometry::make_transform(turn, {1, 0, 0}));
  tree.set("base", "arm", moved(2));
  tree.set("/base", "/stand", moved(0, 3));
  tree.set("stand", "eye", moved(0.5));
  const auto X_arm_eye = tree.find("arm", "eye");
  ASSERT_TRUE(X_arm_eye);
  EXPECT_TRUE(X_arm_eye->isApprox(moved(-2).operator*(moved(0, 3)) * moved(0.5), 1e-12));
  const auto X_world_eye = tree.find("world", "/eye");
  ASSERT_TRUE(X_world_eye);
  EXPECT_TRUE(
      X_world_eye->isApprox(geometry::make_transform(turn, {1, 0, 0}) * moved(0.5, 3), 1e-12));
  EXPECT_TRUE(tree.find("eye", "world")->isApprox(X_world_eye->inverse(), 1e-12));
  EXPECT_FALSE(tree.find("world", "elsewhere"));
  tree.set("eye", "world", moved(1));  // a ring
  EXPECT_FALSE(tree.find("world", "elsewhere"));
}

}  // namespace
}  // namespace prehend::drivers::ros_link
