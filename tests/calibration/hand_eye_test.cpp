#include "prehend/calibration/hand_eye.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "prehend/calibration/degenerate_data.h"
#include "prehend/calibration/hand_eye_poses.h"
#include "prehend/calibration/hand_eye_solvers.h"
#include "prehend/geometry/errors.h"
#include "prehend/motion/robot_in_world.h"
#include "prehend/motion/robot_spheres.h"
#include "prehend/robot/platform.h"
#include "tests/calibration/rendered_board.h"

namespace prehend::testing {
namespace {

using calibration::CalibrationBoard;
using calibration::CameraMount;
using calibration::DegenerateData;
using calibration::HandEyeFit;
using calibration::HandEyeOptions;
using calibration::HandEyePose;
using calibration::HandEyeUnknowns;
using ::testing::HasSubstr;

constexpr double kDegree = M_PI / 180;

geometry::RigidTransform pose_at(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.linear() = R;
  X.translation() = t;
  return X;
}

geometry::RigidTransform disturbed(const geometry::RigidTransform& X, double metres, double radians,
                                   std::mt19937& random) {
  std::normal_distribution<double> normal(0, 1);
  const Eigen::Vector3d turn =
      radians * Eigen::Vector3d(normal(random), normal(random), normal(random));
  const Eigen::Vector3d way =
      metres * Eigen::Vector3d(normal(random), normal(random), normal(random));
  return X * pose_at(turn.norm() > 0
                         ? Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix()
                         : Eigen::Matrix3d::Identity(),
                     way);
}

// The KUKA KR5 with the SDH-2 over a table.
class HandEye : public ::testing::Test {
 protected:
  HandEye() {
    motion::CollisionWorld world;
    world.add_plane("table", {Eigen::Vector3d::UnitZ(), -0.02});
    robot_ = std::make_unique<motion::RobotInWorld>(
        chain_, motion::make_robot_spheres(model_, platform_.base, platform_.flange), world);
    home_ = platform_.home("home").arm;
  }

  // Camera beside the hand; board on the table, upper side up: its z goes into the table.
  static HandEyeUnknowns on_hand() {
    Eigen::Matrix3d R_FC = (Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()) *
                            Eigen::AngleAxisd(1.5, Eigen::Vector3d::UnitZ()))
                               .toRotationMatrix();
    Eigen::Matrix3d R_BT;
    R_BT << 0, -1, 0, -1, 0, 0, 0, 0, -1;
    return {pose_at(R_FC, {0.09, 0.03, 0.04}), pose_at(R_BT, {0.6, 0.15, 0.0})};
  }
  // Camera on a post that looks at the arm; board on the flange.
  static HandEyeUnknowns in_world() {
    HandEyeUnknowns unknowns;
    unknowns.X_PC = geometry::look_at({1.25, 0.2, 0.75}, {0.45, 0, 0.55});
    unknowns.X_QT = pose_at(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix(),
                            {-0.15, 0.1, 0.22});
    return unknowns;
  }
  static HandEyeUnknowns truth(CameraMount mount) {
    return mount == CameraMount::kHand ? on_hand() : in_world();
  }
  // A guess by tape measure.
  static HandEyeUnknowns guess(CameraMount mount) {
    std::mt19937 random(77);
    HandEyeUnknowns unknowns = truth(mount);
    unknowns.X_PC = disturbed(unknowns.X_PC, 0.01, 0.03, random);
    unknowns.X_QT = disturbed(unknowns.X_QT, 0.01, 0.03, random);
    return unknowns;
  }

  calibration::PoseChoice choose(CameraMount mount, bool with_offsets = false) {
    calibration::PoseChoiceOptions options;
    options.hand_eye.mount = mount;
    if (with_offsets) options.hand_eye.chain = &chain_;
    options.candidates = 120;
    options.least_fill = 0.25;
    return calibration::choose_poses(chain_, *robot_, home_, guess(mount), board_, camera_,
                                     options);
  }

  // What a camera sees from there; the arm is not quite where it says, and its joints' zeros are
  // off by `offsets`.
  std::vector<HandEyePose> seen_from(const std::vector<robot::Positions>& qs, CameraMount mount,
                                     std::mt19937& random,
                                     const Eigen::VectorXd& offsets = Eigen::VectorXd::Zero(6)) {
    std::normal_distribution<double> off(0, 0.1);
    std::vector<HandEyePose> poses;
    for (const robot::Positions& q : qs) {
      HandEyePose pose;
      pose.name = "pose " + std::to_string(poses.size());
      pose.q = q;
      pose.X_BF = chain_.forward(q);
      const geometry::RigidTransform true_X_BF =
          disturbed(chain_.forward(q + offsets), 5e-5, 1e-4, random);
      const geometry::RigidTransform X_CT =
          calibration::board_in_camera(mount, truth(mount), true_X_BF);
      for (int id = 0; id < board_.corners(); ++id) {
        const Eigen::Vector3d p = X_CT * board_.corner_T(id);
        pose.view.ids.push_back(id);
        pose.view.pixels.push_back(calibration::project(camera_, p) +
                                   Eigen::Vector2d(off(random), off(random)));
      }
      poses.push_back(pose);
    }
    return poses;
  }

  static std::vector<robot::Positions> positions(const calibration::PoseChoice& choice) {
    std::vector<robot::Positions> qs;
    for (const auto& pose : choice.poses) qs.push_back(pose.q);
    return qs;
  }

  std::string refused_as(const std::vector<HandEyePose>& poses,
                         const HandEyeOptions& options = {}) {
    try {
      calibration::calibrate_hand_eye(poses, board_, camera_, options);
    } catch (const DegenerateData& error) {
      return error.name();
    }
    return "";
  }

  robot::Platform platform_ = robot::read_platform("config/robots/kr5_sdh.yaml");
  robot::KinematicChain chain_ = platform_.arm_chain();
  robot::RobotModel model_ =
      platform_.with_hand_at(platform_.hand.all_positions(platform_.hand.preshapes.front().open));
  std::unique_ptr<motion::RobotInWorld> robot_;
  robot::Positions home_;
  CalibrationBoard board_ = [] {
    CalibrationBoard board = charuco_board();
    board.square = 0.02;
    board.marker = 0.015;
    return board;
  }();
  perception::CameraCalibration camera_ = bent_camera();
};

TEST_F(HandEye, FifteenPosesThatTheArmDrivesToGiveOneMillimetre) {
  for (const CameraMount mount : {CameraMount::kHand, CameraMount::kWorld}) {
    std::mt19937 random(11);
    const calibration::PoseChoice choice = choose(mount);
    ASSERT_EQ(choice.poses.size(), 15u);
    robot::Positions at = home_;
    for (const auto& pose : choice.poses) {  // the arm gets there, and touches nothing
      EXPECT_TRUE(pose.path.waypoints.front().isApprox(at));
      EXPECT_TRUE(pose.path.waypoints.back().isApprox(pose.q));
      for (std::size_t i = 1; i < pose.path.waypoints.size(); ++i) {
        EXPECT_TRUE(robot_->is_swept_free(pose.path.waypoints[i - 1], pose.path.waypoints[i]));
      }
      EXPECT_TRUE(chain_.forward(pose.q).isApprox(pose.X_BF, 1e-6));
      at = pose.q;
    }
    HandEyeOptions options;
    options.mount = mount;
    const HandEyeFit fit = calibration::calibrate_hand_eye(
        seen_from(positions(choice), mount, random), board_, camera_, options);
    const HandEyeUnknowns expected = truth(mount);
    const double metres = (fit.unknowns.X_PC.translation() - expected.X_PC.translation()).norm();
    EXPECT_LE(metres, 1e-3);
    EXPECT_LE(angle_between(fit.unknowns.X_PC, expected.X_PC), 0.1 * kDegree);
    EXPECT_LE((fit.unknowns.X_QT.translation() - expected.X_QT.translation()).norm(), 1e-3);
    EXPECT_LE(angle_between(fit.unknowns.X_QT, expected.X_QT), 0.1 * kDegree);
    EXPECT_LE(metres, 5 * fit.position_deviation);  // and knows how well it knows it
    EXPECT_LE(fit.position_deviation, 1e-3);
    for (const auto& pose : fit.poses) EXPECT_TRUE(pose.used) << pose.why_not;
    // All of OpenCV's solvers were asked. Those of Tsai, Horaud and Daniilidis go wrong where two
    // poses differ by nearly half a turn; that is why the best one counts.
    ASSERT_EQ(fit.solvers.size(), 7u);
    int near = 0;
    for (const auto& solver : fit.solvers) {
      ASSERT_TRUE(solver.unknowns) << solver.method;
      near += (solver.unknowns->X_PC.translation() - expected.X_PC.translation()).norm() < 5e-3;
      // The fit lets the arm be a little off, so that this is not quite what it makes least.
      EXPECT_GE(solver.rms, 0.9 * fit.rms) << solver.method;
    }
    EXPECT_GE(near, 4);
    const std::string name = mount == CameraMount::kHand ? "hand" : "world";
    RecordProperty(name + "_error_mm", std::to_string(1e3 * metres));
    RecordProperty(name + "_error_degrees",
                   std::to_string(angle_between(fit.unknowns.X_PC, expected.X_PC) / kDegree));
    RecordProperty(name + "_log_det", std::to_string(choice.log_det));
  }
}

TEST_F(HandEye, OneBadPoseInFiveChangesNothing) {
  for (const CameraMount mount : {CameraMount::kHand, CameraMount::kWorld}) {
    const calibration::PoseChoice choice = choose(mount);
    for (const unsigned seed : {1u, 2u, 3u}) {
      std::mt19937 random(seed);
      std::vector<HandEyePose> poses = seen_from(positions(choice), mount, random);
      // The board was knocked by some cm, two images are of other poses.
      poses[2].X_BF = disturbed(poses[2].X_BF, 0.02, 0.05, random);
      poses[7].view = poses[3].view;
      poses[11].X_BF = disturbed(poses[11].X_BF, 0.01, 0.0, random);
      HandEyeOptions options;
      options.mount = mount;
      const HandEyeFit fit = calibration::calibrate_hand_eye(poses, board_, camera_, options);
      EXPECT_LE((fit.unknowns.X_PC.translation() - truth(mount).X_PC.translation()).norm(), 1e-3);
      EXPECT_LE(angle_between(fit.unknowns.X_PC, truth(mount).X_PC), 0.1 * kDegree);
      for (std::size_t i = 0; i < poses.size(); ++i) {
        EXPECT_EQ(fit.poses[i].used, i != 2 && i != 7 && i != 11) << i << fit.poses[i].why_not;
      }
      EXPECT_THAT(fit.poses[2].why_not, HasSubstr("does not agree"));
    }
  }
}

TEST_F(HandEye, ZeroOffsetsOfTheJointsAreFoundOnRequest) {
  const calibration::PoseChoice choice = choose(CameraMount::kHand, true);
  Eigen::VectorXd offsets(6);
  offsets << 0, 0.8, -0.5, 0.6, -1.0, 0;
  offsets *= kDegree;
  std::mt19937 random(5);
  HandEyeOptions options;
  options.chain = &chain_;
  options.position_noise = 5e-5;
  options.rotation_noise = 1e-4;
  const auto poses = seen_from(positions(choice), CameraMount::kHand, random, offsets);
  const HandEyeFit fit = calibration::calibrate_hand_eye(poses, board_, camera_, options);
  ASSERT_EQ(fit.offsets.size(), 6u);
  double worst = 0;
  for (int j = 0; j < 6; ++j) {
    const auto& offset = fit.offsets[static_cast<std::size_t>(j)];
    EXPECT_EQ(offset.is_free, j > 0 && j < 5);
    EXPECT_NEAR(offset.offset, offsets[j], 0.02 * kDegree) << offset.joint;
    worst = std::max(worst, std::abs(offset.offset - offsets[j]));
  }
  RecordProperty("worst_offset_error_degrees", std::to_string(worst / kDegree));
  EXPECT_LE((fit.unknowns.X_PC.translation() - on_hand().X_PC.translation()).norm(), 1e-3);
  // Without them the same poses do not fit so well.
  options.chain = nullptr;
  EXPECT_GT(calibration::calibrate_hand_eye(poses, board_, camera_, options).rms, 3 * fit.rms);
}

TEST_F(HandEye, ChosenPosesTellMoreThanRandomOnes) {
  const calibration::PoseChoice choice = choose(CameraMount::kHand);
  calibration::PoseChoiceOptions options;
  options.poses = options.candidates = 60;  // all that are found
  options.least_fill = 0.25;
  options.seed = 9;
  const auto pool = calibration::choose_poses(chain_, *robot_, home_, guess(CameraMount::kHand),
                                              board_, camera_, options);
  std::mt19937 random(1);
  const auto log_det = [&](const std::vector<calibration::ChosenPose>& poses) {
    std::vector<geometry::RigidTransform> X_BF;
    std::vector<robot::Positions> qs;
    for (const auto& pose : poses) {
      X_BF.push_back(pose.X_BF);
      qs.push_back(pose.q);
    }
    return calibration::information_log_det(X_BF, qs, guess(CameraMount::kHand), board_, camera_,
                                            options.hand_eye);
  };
  EXPECT_NEAR(log_det(choice.poses), choice.log_det, 1e-6 * choice.log_det);
  auto poses = pool.poses;
  double best = 0;
  for (int trial = 0; trial < 20; ++trial) {
    std::shuffle(poses.begin(), poses.end(), random);
    best = std::max(best, log_det({poses.begin(), poses.begin() + 15}));
  }
  EXPECT_GT(choice.log_det, best);
}

TEST_F(HandEye, DegenerateDataIsRefusedByName) {
  std::mt19937 random(3);
  const std::vector<robot::Positions> qs = positions(choose(CameraMount::kHand));
  const std::vector<HandEyePose> good = seen_from(qs, CameraMount::kHand, random);
  EXPECT_EQ(refused_as({}), "board not found");
  std::vector<HandEyePose> poses = good;
  for (HandEyePose& pose : poses) pose.view = {};
  EXPECT_EQ(refused_as(poses), "board not found");
  EXPECT_EQ(refused_as({good.begin(), good.begin() + 4}), "too few poses");
  // The same arm's pose again and again; only moved; turned about one axis alone.
  EXPECT_EQ(refused_as(std::vector<HandEyePose>(10, good[0])), "pure translations");
  const geometry::RigidTransform X_BF = good[0].X_BF;
  const auto with = [&](auto motion) {
    std::vector<HandEyePose> made;
    for (int i = 0; i < 12; ++i) {
      HandEyePose pose;
      pose.X_BF = motion(i);
      const auto X_CT = calibration::board_in_camera(CameraMount::kHand, on_hand(), pose.X_BF);
      for (int id = 0; id < board_.corners(); ++id) {
        pose.view.ids.push_back(id);
        pose.view.pixels.push_back(calibration::project(camera_, X_CT * board_.corner_T(id)));
      }
      made.push_back(pose);
    }
    return made;
  };
  EXPECT_EQ(
      refused_as(with([&](int i) {
        return geometry::RigidTransform(Eigen::Translation3d(0.005 * i, 0.004 * (i % 3), 0) * X_BF);
      })),
      "pure translations");
  EXPECT_EQ(refused_as(with([&](int i) {
              return geometry::RigidTransform(X_BF *
                                              Eigen::AngleAxisd(0.1 * i, Eigen::Vector3d::UnitZ()));
            })),
            "rotation axes parallel");
  // Every image is of another pose.
  poses = good;
  for (std::size_t i = 0; i < poses.size(); ++i) poses[i].view = good[(i * 7 + 3) % 15].view;
  EXPECT_EQ(refused_as(poses), "no consensus");
  board_ = chessboard();
  board_.rows = 8;
  EXPECT_EQ(refused_as(good), "board symmetric");
}

TEST_F(HandEye, BadOptionsAndGuessesAreRefused) {
  HandEyeOptions options;
  options.pixel_noise = 0;
  EXPECT_THROW(calibration::calibrate_hand_eye({}, board_, camera_, options),
               std::invalid_argument);
  options = {};
  options.chain = &chain_;
  EXPECT_THROW(calibration::calibrate_hand_eye({HandEyePose{}}, board_, camera_, options),
               std::invalid_argument);
  HandEyeUnknowns far = on_hand();
  far.X_QT.translation().x() = 5;
  try {
    calibration::PoseChoiceOptions few;
    few.candidates = 20;
    calibration::choose_poses(chain_, *robot_, home_, far, board_, camera_, few);
    FAIL();
  } catch (const geometry::InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("out of the arm's reach"));
  }
}

}  // namespace
}  // namespace prehend::testing
