// An arm and a gripper whose drivers are ROS's.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "drivers/ros/driver/action_server.h"
#include "drivers/ros/driver/ros_arm.h"
#include "drivers/ros/driver/ros_gripper.h"
#include "msgs/joints.pb.h"
#include "msgs/ros/from_ros.h"
#include "msgs/ros/to_ros.h"
#include "prehend/robot/platform.h"
#include "tests/drivers/ros/late_peer.h"

namespace prehend::drivers::ros_link {
namespace {

using recording::RosValue;
using testing::HasSubstr;
using Fields = RosValue::Fields;
using Status = simulation::ArmDrive::Status;

std::string joint_state(const std::vector<std::string>& names, double position,
                        ros::Version version) {
  msgs::JointState joints;
  joints.mutable_header()->set_stamp(1);
  for (const std::string& name : names) {
    joints.add_name(name);
    joints.add_position(position);
  }
  return ros::to_ros(joints, "sensor_msgs/JointState", version);
}

class ArmOfRos : public testing::Test {
 protected:
  ArmOfRos() {
    options_.action = "/controller/follow";
    options_.joint_states = "/joint_states";
    options_.settle_time = 0.2;
    options_.loss_time = 0.3;
    const robot::Platform platform = robot::read_platform("config/robots/kr5_sdh.yaml");
    const robot::KinematicChain chain = platform.arm_chain();
    for (const robot::ChainJoint& joint : chain.joints()) {
      names_.push_back(joint.name);
      options_.joints[joint.name] = "ros_" + joint.name;
      ros_names_.push_back("ros_" + joint.name);
    }
    q_ = chain.middle();
    server_ = serve_action(
        peer_, options_.action, "control_msgs/FollowJointTrajectory",
        {[this](const RosValue& goal) {
           joint_names_.clear();
           for (const RosValue& name : goal["trajectory"]["joint_names"].list()) {
             joint_names_.emplace_back(name.text());
           }
           last_position_ = goal["trajectory"]["points"].list().back()["positions"].numbers();
           last_time_ =
               ros::ros_nanoseconds(goal["trajectory"]["points"].list().back()["time_from_start"]);
           return refusal_;
         },
         [this] { ++cancels_; }});
    joints_ =
        peer_.advertise(options_.joint_states, "sensor_msgs/JointState", {}, RosChannel::kTopic);
    arm_ = std::make_unique<RosArm>(peer_, options_, chain,
                                    [this](const std::string& problem) { problems_ += problem; });
  }
  void tell_joints() {
    msgs::JointState joints;
    joints.mutable_header()->set_stamp(1);
    for (std::size_t i = 0; i < ros_names_.size(); ++i) {
      joints.add_name(ros_names_[i]);
      joints.add_position(q_[static_cast<Eigen::Index>(i)]);
    }
    joints_->publish(ros::to_ros(joints, "sensor_msgs/JointState", peer_.version()));
    peer_.settle();
  }
  simulation::TrajectoryRequest motion(double by, double seconds) const {
    simulation::TrajectoryRequest request;
    request.joints = names_;
    for (const double share : {0.0, 1.0}) {
      simulation::TrajectoryRequest::Point point;
      point.time = share * seconds;
      for (Eigen::Index i = 0; i < q_.size(); ++i) point.position.push_back(q_[i] + share * by);
      request.points.push_back(point);
    }
    return request;
  }
  std::string refusal_of(const simulation::TrajectoryRequest& request) {
    try {
      arm_->follow(request, {}, 0);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return {};
  }
  LatePeer peer_{ros::Version::kRos2};
  Mapping::Arm options_;
  std::vector<std::string> names_, ros_names_, joint_names_;
  robot::Positions q_;
  std::vector<double> last_position_;
  std::int64_t last_time_ = 0;
  std::string refusal_, problems_;
  std::atomic<int> cancels_ = 0;
  std::unique_ptr<RosActionServer> server_;
  std::unique_ptr<RosPublisher> joints_;
  std::unique_ptr<RosArm> arm_;
};

TEST_F(ArmOfRos, FollowsByRossNames) {
  tell_joints();
  EXPECT_EQ(arm_->obstacle(), "");
  arm_->take_arm();
  arm_->follow(motion(0.05, 0.5), {}, 0);
  peer_.settle();
  EXPECT_EQ(joint_names_, ros_names_);
  EXPECT_EQ(last_time_, 500'000'000);
  EXPECT_NEAR(last_position_.front(), q_[0] + 0.05, 1e-12);
  EXPECT_EQ(arm_->arm_state().status, Status::kMoving);
  EXPECT_FALSE(arm_->arm_state().at_rest);
  server_->finish(true, false, RosValue(Fields{}), "");
  peer_.settle();
  EXPECT_EQ(arm_->arm_state().status, Status::kReached);
  EXPECT_TRUE(arm_->arm_state().at_rest);
}

TEST_F(ArmOfRos, TakesNothingWithoutJointsServerOrWithinLimits) {
  EXPECT_THAT(refusal_of(motion(0.05, 0.5)), HasSubstr("ros_" + names_[0]));
  tell_joints();
  EXPECT_THAT(refusal_of(motion(100, 0.5)), HasSubstr("is outside"));
  EXPECT_THAT(refusal_of(motion(0.5, 0.001)), HasSubstr("is faster than"));
  server_.reset();
  peer_.settle();
  EXPECT_THAT(refusal_of(motion(0.05, 0.5)), HasSubstr("/controller/follow"));
}

TEST_F(ArmOfRos, SaysWhyTheControllerDidNot) {
  tell_joints();
  arm_->follow(motion(0.05, 0.5), {}, 0);
  peer_.settle();
  server_->finish(false, false,
                  RosValue(Fields{{"error_code", ros::ros_integer(-4)},
                                  {"error_string", ros::ros_text("joint 3 was off")}}),
                  "");
  peer_.settle();
  EXPECT_EQ(arm_->arm_state().status, Status::kOffPath);
  EXPECT_THAT(arm_->arm_state().reason, HasSubstr("path tolerance violated"));
  EXPECT_THAT(arm_->arm_state().reason, HasSubstr("joint 3 was off"));
}

TEST_F(ArmOfRos, StopsByTheTicketAndByContact) {
  tell_joints();
  const std::uint64_t old = arm_->take_arm();
  const std::uint64_t ticket = arm_->take_arm();
  arm_->follow(motion(0.05, 0.5), {}, 20);
  peer_.settle();
  arm_->stop_arm(old);
  arm_->feel(19);
  peer_.settle();
  EXPECT_EQ(cancels_, 0);
  arm_->feel(21);
  arm_->feel(22);
  peer_.settle();
  EXPECT_EQ(cancels_, 1);
  EXPECT_TRUE(arm_->arm_state().contact);
  EXPECT_FALSE(arm_->arm_state().at_rest);  // until the controller says so
  server_->finish(false, true, RosValue(Fields{}), "");
  peer_.settle();
  EXPECT_TRUE(arm_->arm_state().at_rest);
  EXPECT_EQ(arm_->arm_state().status, Status::kStopped);
  arm_->follow(motion(0.05, 0.5), {}, 0);
  peer_.settle();
  arm_->feel(100);  // contact is not minded
  arm_->stop_arm(ticket);
  peer_.settle();
  EXPECT_EQ(cancels_, 2);
}

TEST_F(ArmOfRos, IsStoppedWhenItsJointsFallSilent) {
  tell_joints();
  arm_->follow(motion(0.05, 5), {}, 0);
  peer_.settle();
  arm_->look();
  EXPECT_EQ(cancels_, 0);
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  arm_->look();
  peer_.settle();
  EXPECT_EQ(cancels_, 1);
  EXPECT_THAT(arm_->arm_state().reason, HasSubstr("nothing comes of joint"));
}

TEST_F(ArmOfRos, AnActionThatDoesNotEndIsCancelledThenGivenUp) {
  tell_joints();
  arm_->follow(motion(0.01, 0.1), {}, 0);
  peer_.settle();
  const auto begin = std::chrono::steady_clock::now();
  while (!arm_->arm_state().at_rest &&
         std::chrono::steady_clock::now() - begin < std::chrono::seconds(5)) {
    tell_joints();
    arm_->look();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_EQ(cancels_, 1);
  EXPECT_THAT(arm_->arm_state().reason, HasSubstr("did not end"));
  EXPECT_THAT(problems_, HasSubstr("does not say that the arm stands"));
}

TEST_F(ArmOfRos, NamesOfNoJointAreRefused) {
  options_.joints["elbow"] = "ros_elbow";
  const robot::Platform platform = robot::read_platform("config/robots/kr5_sdh.yaml");
  EXPECT_THROW(RosArm(peer_, options_, platform.arm_chain(), [](const std::string&) {}),
               std::invalid_argument);
}

class GripperOfRos : public testing::Test {
 protected:
  GripperOfRos() {
    options_.action = "/gripper/cmd";
    options_.joint_states = "/joint_states";
    options_.joint = "finger";
    options_.position_per_opening = -10;
    options_.closed_position = 0.8;
    options_.effort_per_current = 20;
    options_.loss_time = 0.3;
    server_ = serve_action(peer_, options_.action, "control_msgs/GripperCommand",
                           {[this](const RosValue& goal) {
                              position_ = goal["command"]["position"].number();
                              effort_ = goal["command"]["max_effort"].number();
                              return std::string();
                            },
                            [this] { ++cancels_; }});
    joints_ =
        peer_.advertise(options_.joint_states, "sensor_msgs/JointState", {}, RosChannel::kTopic);
    gripper_ = std::make_unique<RosGripper>(peer_, options_, robot::GripperModel(),
                                            [](const std::string&) {});
  }
  void tell(double position) {
    joints_->publish(joint_state({"finger"}, position, peer_.version()));
    peer_.settle();
  }
  void end(const char* how) {
    server_->finish(true, false, RosValue(Fields{{how, ros::ros_integer(1)}}), "");
    peer_.settle();
  }
  LatePeer peer_{ros::Version::kRos1};
  Mapping::Gripper options_;
  double position_ = 0, effort_ = 0;
  std::atomic<int> cancels_ = 0;
  std::unique_ptr<RosActionServer> server_;
  std::unique_ptr<RosPublisher> joints_;
  std::unique_ptr<RosGripper> gripper_;
};

TEST_F(GripperOfRos, OpeningsArePositionsOfItsJoint) {
  EXPECT_FALSE(gripper_->state().is_known);
  tell(0.5);
  EXPECT_NEAR(gripper_->state().opening, 0.03, 1e-12);
  std::uint64_t ticket = 0;
  EXPECT_EQ(gripper_->move_to(0.02, 1.5, ticket), "");
  peer_.settle();
  EXPECT_NEAR(position_, 0.6, 1e-12);
  EXPECT_NEAR(effort_, 30, 1e-12);
  EXPECT_EQ(gripper_->motion(ticket).end, RosGripper::End::kRunning);
  end("reached_goal");
  EXPECT_EQ(gripper_->motion(ticket).end, RosGripper::End::kReached);
  EXPECT_EQ(gripper_->move_to(0, 0, ticket), "");
  peer_.settle();
  EXPECT_NEAR(effort_, 40, 1e-12);  // the nominal current's
  end("stalled");
  EXPECT_EQ(gripper_->motion(ticket).end, RosGripper::End::kBlocked);
  EXPECT_TRUE(gripper_->state().blocked);
}

TEST_F(GripperOfRos, LimitsAreItsModels) {
  tell(0.5);
  std::uint64_t ticket = 0;
  EXPECT_THAT(gripper_->move_to(0.5, 0, ticket), HasSubstr("0.5 m"));
  EXPECT_THAT(gripper_->move_to(-0.001, 0, ticket), HasSubstr("opening"));
  EXPECT_THAT(gripper_->move_to(std::nan(""), 0, ticket), HasSubstr("opening"));
  EXPECT_THAT(gripper_->move_to(0.02, 100, ticket), HasSubstr("current"));
}

TEST_F(GripperOfRos, SilenceEndsAMotion) {
  tell(0.5);
  std::uint64_t ticket = 0;
  ASSERT_EQ(gripper_->move_to(0.02, 1, ticket), "");
  peer_.settle();
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  gripper_->look();
  peer_.settle();
  EXPECT_EQ(cancels_, 1);
  EXPECT_EQ(gripper_->motion(ticket).end, RosGripper::End::kFailed);
  EXPECT_THAT(gripper_->move_to(0.02, 1, ticket), HasSubstr("nothing comes of joint 'finger'"));
}

}  // namespace
}  // namespace prehend::drivers::ros_link
