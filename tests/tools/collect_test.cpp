// prehend calibrate collect: an arm drives itself from pose to pose, a rendered camera looks.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <mutex>
#include <random>
#include <thread>

#include <Eigen/Geometry>

#include "msgs/actions.pb.h"
#include "msgs/convert/images.h"
#include "msgs/sensors.pb.h"
#include "prehend/calibration/calibration_space.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"
#include "tests/calibration/rendered_board.h"
#include "tests/launch/child_program.h"

namespace prehend::testing {
namespace {

using namespace std::chrono_literals;
using calibration::CameraMount;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kDegree = M_PI / 180;

calibration::CalibrationBoard small_board() {
  calibration::CalibrationBoard board = charuco_board();
  board.columns = 6;
  board.rows = 5;
  board.square = 0.035;
  board.marker = 0.027;
  return board;
}

perception::CameraCalibration pinhole() {
  perception::CameraCalibration camera = small_camera();
  camera.distortion.clear();
  return camera;
}

geometry::RigidTransform posed(double x, double y, double z, const Eigen::Matrix3d& R) {
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.translation() = Eigen::Vector3d(x, y, z);
  X.linear() = R;
  return X;
}

Eigen::Matrix3d rpy(double roll, double pitch, double yaw) {
  return (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

/// A KUKA KR5 with the SDH-2 that goes where it is told, ten times as fast as its clock says, with
/// a camera beside the hand over a board on the table. What it is told must be free and in order.
class Collect : public ::testing::Test {
 protected:
  Collect() : registry_({.endpoint = "tcp://127.0.0.1:*"}), node_(options()) {
    calibration::CalibrationSurroundings around;
    around.guess = truth_;
    around.table = -0.02;
    // Less than what the command keeps, as it knows the poses roughly.
    around.camera_radius = 0.045;
    around.clearance = 0.01;
    space_ = calibration::calibration_space(
        platform_, platform_.hand.all_positions(platform_.hand.preshapes.front().open),
        small_board(), around);
    states_ = node_.advertise<msgs::JointState>("/joint_states", graph::QoS::queue(50));
    infos_ = node_.advertise<msgs::CameraInfo>("/camera/info", graph::QoS::latched(1));
    pairs_ = node_.advertise<msgs::StereoPair>("/camera/stereo", graph::QoS::latest());
    geometry::StereoCamera stereo;
    stereo.left = {pinhole().width,   pinhole().height,  pinhole().K(0, 0),
                   pinhole().K(1, 1), pinhole().K(0, 2), pinhole().K(1, 2)};
    stereo.baseline = 0.06;
    infos_.publish(convert::to_message(stereo, std::nullopt));
    follow_ = node_.serve_action<msgs::FollowTrajectoryGoal, msgs::FollowTrajectoryFeedback,
                                 msgs::FollowTrajectoryResult>(
        "/arm/follow", [this](const msgs::FollowTrajectoryGoal& goal, Context& context) {
          return follow(goal, context);
        });
    timer_ = node_.create_timer(0.005, [this] { publish(); });
    node_.spin_in_background();
  }

  using Context = graph::ActionContext<msgs::FollowTrajectoryFeedback>;

  graph::NodeOptions options() const {
    graph::NodeOptions options;
    options.name = "robot";
    options.registry = registry_.endpoint();
    return options;
  }

  msgs::FollowTrajectoryResult follow(const msgs::FollowTrajectoryGoal& goal, Context& context) {
    msgs::FollowTrajectoryResult result;
    ++goals_;
    if (goals_ == fails_at_) {
      result.set_reason("the drives are off");
      return result;
    }
    const auto& path = goal.trajectory();
    robot::Positions before;
    double time = 0;
    for (const auto& point : path.points()) {
      const robot::Positions q =
          Eigen::Map<const robot::Positions>(point.position().data(), point.position_size());
      if (before.size() == 0) {
        const std::lock_guard lock(mutex_);
        EXPECT_LT((q - q_).cwiseAbs().maxCoeff(), 1e-6) << "begins where the arm stands";
      } else {
        const double h = point.time() - time;
        for (Eigen::Index j = 0; j < q.size(); ++j) {
          const double most = chain_.joints()[static_cast<std::size_t>(j)].max_velocity;
          EXPECT_LE(std::abs(q[j] - before[j]) / h, 0.5 * most * 1.001) << "slower than told";
        }
      }
      EXPECT_TRUE(space_->is_free(q)) << space_->problem(q);
      before = q;
      time = point.time();
    }
    while (never_arrives_ && !context.cancelled()) context.sleep_for(5ms);
    if (context.cancelled()) {
      stopped_ = true;
      result.set_reason("cancelled");
      return result;
    }
    const std::lock_guard lock(mutex_);
    q_ = before;
    is_new_ = true;
    result.set_reached(true);
    return result;
  }

  void publish() {
    const std::lock_guard lock(mutex_);
    stamp_ += 50'000'000;
    msgs::JointState state;
    state.mutable_header()->set_stamp(stamp_);
    for (int j = 0; j < chain_.size(); ++j) {
      state.add_name(chain_.joints()[static_cast<std::size_t>(j)].name);
      state.add_position(q_[j]);
    }
    states_.publish(state);
    if (!has_camera_) return;
    if (is_new_) {
      const auto X_CT =
          calibration::board_in_camera(CameraMount::kHand, truth_, chain_.forward(q_));
      const geometry::ColorImage image = renderer_.image(X_CT, random_);
      pair_ = convert::to_message(convert::StereoImages{image, image});
      is_new_ = false;
    }
    if (pair_.width() == 0) return;
    pair_.mutable_header()->set_stamp(stamp_);
    pairs_.publish(pair_);
  }

  std::vector<std::string> words() const {
    return {"calibrate",
            "collect",
            "--platform",
            "config/robots/kr5_sdh.yaml",
            "--board",
            board_,
            "--mount",
            "hand",
            "--camera-pose=0.085,0.035,0.045,0.08,0.02,1.52",
            "--board-pose=0.61,0.145,0.002,3.1416,0,-1.55",
            "--table=-0.02",
            "--speed=0.5",
            "--patience=5",
            "-o",
            folder_.path("collected")};
  }

  robot::Platform platform_ = robot::read_platform("config/robots/kr5_sdh.yaml");
  robot::KinematicChain chain_ = platform_.arm_chain();
  calibration::HandEyeUnknowns truth_{posed(0.09, 0.03, 0.04, rpy(0.1, 0, 1.5)),
                                      posed(0.6, 0.15, 0, rpy(M_PI, 0, -0.5 * M_PI))};
  std::unique_ptr<motion::RobotInWorld> space_;
  BoardRenderer renderer_{small_board(), pinhole()};
  ScratchDirectory folder_;
  std::string board_ = folder_.write(
      "board.yaml",
      "{kind: charuco, columns: 6, rows: 5, square: 0.035, marker: 0.027, dictionary: 5x5_100}");
  std::mutex mutex_;
  robot::Positions q_ = platform_.home("home").arm;
  std::int64_t stamp_ = 1'000'000'000;
  bool is_new_ = false, has_camera_ = true;
  int fails_at_ = 0;
  std::atomic<int> goals_ = 0;
  std::atomic<bool> never_arrives_ = false, stopped_ = false;
  msgs::StereoPair pair_;
  std::mt19937 random_{1};
  graph::Registry registry_;
  graph::Node node_;
  graph::Publisher<msgs::JointState> states_;
  graph::Publisher<msgs::CameraInfo> infos_;
  graph::Publisher<msgs::StereoPair> pairs_;
  graph::ActionServer follow_;
  graph::Node::Timer timer_;
};

TEST_F(Collect, TheArmDrivesItselfThroughFifteenPosesAndTheCameraIsFound) {
  ChildProgram program("prehend", words(), folder_.path("output"), registry_.endpoint());
  ASSERT_EQ(program.wait(60s).value_or(-1), 0) << program.output();
  EXPECT_EQ(goals_, 15);
  EXPECT_THAT(program.output(), AllOf(HasSubstr("1 of 15  pose_01.png: 20 of 20 corners; missing"),
                                      HasSubstr("nothing is missing"), HasSubstr("solver park")));
  const std::string yaml = text_of_file(folder_.path("collected/hand_eye.yaml"));
  double x = 0, y = 0, z = 0, roll = 0, pitch = 0, yaw = 0;
  ASSERT_NE(yaml.find("X_FC:"), std::string::npos) << yaml;
  ASSERT_EQ(std::sscanf(yaml.c_str() + yaml.find("X_FC:"),
                        "X_FC: {xyz: [%lf, %lf, %lf], rpy: [%lf, %lf, %lf]}", &x, &y, &z, &roll,
                        &pitch, &yaw),
            6)
      << yaml;
  const auto found = posed(x, y, z, rpy(roll, pitch, yaw));
  EXPECT_LE((found.translation() - truth_.X_PC.translation()).norm(), 1e-3);
  EXPECT_LE(angle_between(found, truth_.X_PC), 0.1 * kDegree);
  EXPECT_THAT(text_of_file(folder_.path("collected/hand_eye.html")),
              HasSubstr("Board seen against predicted"));
  // What was recorded gives the same again.
  ChildProgram again("prehend",
                     {"calibrate", "hand-eye", folder_.path("collected/poses.csv"), "--platform",
                      "config/robots/kr5_sdh.yaml", "--board", board_, "--camera",
                      folder_.path("collected/camera.yaml"), "-o", folder_.path("again.yaml")},
                     folder_.path("again"));
  ASSERT_EQ(again.wait(60s).value_or(-1), 0) << again.output();
  const std::string again_yaml = text_of_file(folder_.path("again.yaml"));
  double again_x = 0;
  ASSERT_EQ(
      std::sscanf(again_yaml.c_str() + again_yaml.find("X_FC:"), "X_FC: {xyz: [%lf", &again_x), 1);
  EXPECT_NEAR(again_x, x, 1e-6);
}

TEST_F(Collect, CtrlCStopsTheArm) {
  never_arrives_ = true;
  ChildProgram program("prehend", words(), folder_.path("output"), registry_.endpoint());
  ASSERT_TRUE(eventually([&] { return goals_ > 0; }, 30s)) << program.output();
  ::kill(program.pid(), SIGINT);
  EXPECT_EQ(program.wait(10s).value_or(-1), 1);
  EXPECT_THAT(program.output(), HasSubstr("at pose 1 of 15: interrupted: the arm was stopped"));
  EXPECT_TRUE(eventually([&] { return stopped_.load(); }));
}

TEST_F(Collect, WhatFailsOnTheWayIsNamedAndWhatWasRecordedStays) {
  fails_at_ = 3;
  ChildProgram program("prehend", words(), folder_.path("output"), registry_.endpoint());
  EXPECT_EQ(program.wait(30s).value_or(-1), 1);
  EXPECT_THAT(program.output(), HasSubstr("at pose 3 of 15: /arm/follow: the drives are off"));
  EXPECT_TRUE(std::filesystem::exists(folder_.path("collected/poses.csv")));
  EXPECT_TRUE(std::filesystem::exists(folder_.path("collected/pose_02.png")));
  // The folder is not written over.
  ChildProgram again("prehend", words(), folder_.path("again"), registry_.endpoint());
  EXPECT_EQ(again.wait(30s).value_or(-1), 1);
  EXPECT_THAT(again.output(), HasSubstr("is not empty"));
}

TEST_F(Collect, WithoutACameraItSaysSo) {
  has_camera_ = false;
  std::vector<std::string> given = words();
  given.push_back("--patience=0.5");
  given.erase(std::find(given.begin(), given.end(), "--patience=5"));
  ChildProgram program("prehend", given, folder_.path("output"), registry_.endpoint());
  EXPECT_EQ(program.wait(30s).value_or(-1), 1);
  EXPECT_THAT(program.output(),
              HasSubstr("/camera/stereo with an image of the arm at rest did not come within"));
}

}  // namespace
}  // namespace prehend::testing
