#include "prehend/calibration/calibrate_camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "prehend/calibration/calibrate_stereo.h"
#include "prehend/calibration/degenerate_data.h"
#include "prehend/calibration/view_collection.h"
#include "tests/calibration/rendered_board.h"

namespace prehend::testing {
namespace {

using calibration::BoardView;
using calibration::CalibrationBoard;
using calibration::CameraFit;
using calibration::DegenerateData;
using calibration::StereoView;
using ::testing::HasSubstr;

constexpr double kDegree = M_PI / 180;

// Name of the degeneracy that `act` refuses.
template <class Act>
std::string refused_as(Act act) {
  try {
    act();
  } catch (const DegenerateData& error) {
    return error.name();
  }
  return "";
}

// Corners where the camera must see them, off by `noise` pixels.
BoardView exact_view(const CalibrationBoard& board, const perception::CameraCalibration& camera,
                     const geometry::RigidTransform& X_CT, double noise, std::mt19937& random) {
  std::normal_distribution<double> off(0, noise);
  BoardView view;
  for (int id = 0; id < board.corners(); ++id) {
    view.ids.push_back(id);
    view.pixels.push_back(calibration::project(camera, X_CT * board.corner_T(id)) +
                          Eigen::Vector2d(off(random), off(random)));
  }
  return view;
}

class EachBoard : public ::testing::TestWithParam<CalibrationBoard> {};

TEST_P(EachBoard, StereoPairIsCalibratedFromTwentyRenderedPoses) {
  const CalibrationBoard board = GetParam();
  perception::CameraCalibration left = bent_camera(), right = bent_camera();
  right.K(0, 0) = 1196.2;
  right.K(1, 1) = 1198.8;
  right.K(0, 2) = 633.8;
  right.distortion = {-0.10, 0.06, -0.0004, 0.0006, 0};
  geometry::RigidTransform X_RL = geometry::RigidTransform::Identity();
  X_RL.linear() = (Eigen::AngleAxisd(1.2 * kDegree, Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(-0.7 * kDegree, Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  X_RL.translation() = Eigen::Vector3d(-0.06, 0.001, -0.0015);
  const BoardRenderer in_left(board, left), in_right(board, right);
  std::mt19937 random(7);
  std::vector<StereoView> views;
  double share = 0;
  for (const auto& X_CT : board_poses(board, left, 20, random)) {
    StereoView view;
    view.left = calibration::find_board(in_left.image(X_CT, random), board);
    view.right = calibration::find_board(in_right.image(X_RL * X_CT, random), board);
    share += view.left.ids.size() / 20.0 / board.corners();
    // Each corner is that corner.
    for (std::size_t i = 0; i < view.left.ids.size(); ++i) {
      const Eigen::Vector2d truth =
          calibration::project(left, X_CT * board.corner_T(view.left.ids[i]));
      EXPECT_LT((view.left.pixels[i] - truth).norm(), 1.0) << view.left.ids[i];
    }
    views.push_back(view);
  }
  EXPECT_GE(share, board.kind == CalibrationBoard::Kind::kAprilTagGrid ? 0.5 : 0.95);
  const auto fit = calibration::calibrate_stereo(views, board, left.width, left.height);
  const auto& found = fit.calibration;
  EXPECT_LE(fit.rms, 0.2);
  EXPECT_LE(fit.left.rms, 0.2);
  EXPECT_LE(fit.row_rms, 0.2);
  EXPECT_NEAR(found.K_left(0, 0) / left.K(0, 0), 1, 1e-3);
  EXPECT_NEAR(found.K_left(1, 1) / left.K(1, 1), 1, 1e-3);
  EXPECT_NEAR(found.K_right(0, 0) / right.K(0, 0), 1, 1e-3);
  EXPECT_NEAR(found.K_right(1, 1) / right.K(1, 1), 1, 1e-3);
  EXPECT_NEAR(fit.left.calibration.K(0, 0) / left.K(0, 0), 1, 1e-3);
  EXPECT_LE(angle_between(found.X_RL, X_RL), 0.02 * kDegree);
  EXPECT_LE((found.X_RL.translation() - X_RL.translation()).norm(), 1e-4);
  RecordProperty("rms_pixels", std::to_string(fit.rms));
  RecordProperty("focal_error_percent",
                 std::to_string(100 * std::abs(found.K_left(0, 0) / left.K(0, 0) - 1)));
  RecordProperty("rotation_error_degrees",
                 std::to_string(angle_between(found.X_RL, X_RL) / kDegree));
}

INSTANTIATE_TEST_SUITE_P(
    Camera, EachBoard, ::testing::Values(chessboard(), charuco_board(), apriltag_grid()),
    [](const auto& board) {
      return std::string(std::array{"Chessboard", "Charuco", "AprilTagGrid"}[board.index]);
    });

TEST(Camera, StandardDeviationsAreThoseOfRepeatedTrials) {
  // Focal lengths of many sets of the same poses with other noise scatter as each fit says.
  const CalibrationBoard board = charuco_board();
  const perception::CameraCalibration camera = bent_camera();
  std::mt19937 random(3);
  const auto poses = board_poses(board, camera, 12, random);
  double sum = 0, squares = 0, said = 0;
  constexpr int kTrials = 25;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<BoardView> views;
    for (const auto& X_CT : poses) views.push_back(exact_view(board, camera, X_CT, 0.1, random));
    const CameraFit fit = calibration::calibrate_camera(views, board, 1280, 960);
    const double off = fit.calibration.K(0, 0) - camera.K(0, 0);
    sum += off;
    squares += off * off;
    said += fit.fx_deviation / kTrials;
  }
  const double deviation = std::sqrt(squares / kTrials - std::pow(sum / kTrials, 2));
  EXPECT_GT(deviation, 0.6 * said);
  EXPECT_LT(deviation, 1.5 * said);
  EXPECT_LT(std::abs(sum / kTrials), 4 * said / std::sqrt(double(kTrials)));
}

TEST(Camera, AViewWhoseBoardMovedIsLeftOut) {
  const CalibrationBoard board = charuco_board();
  const perception::CameraCalibration camera = bent_camera();
  std::mt19937 random(5);
  std::vector<BoardView> views;
  for (const auto& X_CT : board_poses(board, camera, 16, random)) {
    views.push_back(exact_view(board, camera, X_CT, 0.05, random));
  }
  for (std::size_t i = 0; i < views[4].pixels.size(); ++i) {
    views[4].pixels[i].x() += i % 2 == 0 ? 3 : -3;
  }
  const CameraFit fit = calibration::calibrate_camera(views, board, 1280, 960);
  EXPECT_FALSE(fit.views[4].used);
  EXPECT_THAT(fit.views[4].why_not, HasSubstr("off by"));
  int used = 0;
  for (const auto& view : fit.views) used += view.used;
  EXPECT_EQ(used, 15);
  EXPECT_NEAR(fit.calibration.K(0, 0) / camera.K(0, 0), 1, 1e-3);
}

TEST(Camera, DegenerateDataIsRefusedByName) {
  const CalibrationBoard board = charuco_board();
  const perception::CameraCalibration camera = bent_camera();
  std::mt19937 random(9);
  const auto calibrate = [&](const std::vector<BoardView>& views) {
    return refused_as([&] { calibration::calibrate_camera(views, board, 1280, 960); });
  };
  EXPECT_EQ(calibrate({}), "board not found");
  EXPECT_EQ(calibrate(std::vector<BoardView>(20)), "board not found");

  const auto poses = board_poses(board, camera, 12, random);
  std::vector<BoardView> good, parallel, tilted_alike, in_a_line, small;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    good.push_back(exact_view(board, camera, poses[i], 0.05, random));
    geometry::RigidTransform X_CT = geometry::RigidTransform::Identity();
    X_CT.translation() = Eigen::Vector3d(-0.15 + 0.01 * i, -0.1, 0.4 + 0.02 * i);
    parallel.push_back(exact_view(board, camera, X_CT, 0.05, random));
    X_CT.linear() = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitX()).toRotationMatrix();
    tilted_alike.push_back(exact_view(board, camera, X_CT, 0.05, random));
    in_a_line.push_back(good.back());
    in_a_line.back().ids.resize(8);
    in_a_line.back().pixels.resize(8);
    X_CT = poses[i];
    X_CT.translation() = Eigen::Vector3d(0, 0, 3);
    small.push_back(exact_view(board, camera, X_CT, 0.05, random));
  }
  EXPECT_EQ(calibrate({good.begin(), good.begin() + 3}), "too few views");
  EXPECT_EQ(calibrate(parallel), "all views parallel");
  EXPECT_EQ(calibrate(tilted_alike), "all views parallel");
  EXPECT_EQ(calibrate(in_a_line), "board not found");
  EXPECT_EQ(calibrate(small), "corners in a small part of the image alone");
  EXPECT_EQ(calibrate(std::vector<BoardView>(10, good[0])), "all views parallel");
  EXPECT_EQ(calibrate(good), "");
}

TEST(Stereo, DegenerateDataIsRefusedByName) {
  CalibrationBoard board = charuco_board();
  const perception::CameraCalibration camera = bent_camera();
  std::mt19937 random(2);
  std::vector<StereoView> apart;
  for (const auto& X_CT : board_poses(board, camera, 12, random)) {
    const BoardView view = exact_view(board, camera, X_CT, 0.05, random);
    apart.push_back({view, view});
    // The left camera sees the upper half, the right one the lower.
    apart.back().left.ids.resize(27);
    apart.back().left.pixels.resize(27);
    apart.back().right.ids.erase(apart.back().right.ids.begin(),
                                 apart.back().right.ids.begin() + 27);
    apart.back().right.pixels.erase(apart.back().right.pixels.begin(),
                                    apart.back().right.pixels.begin() + 27);
  }
  const auto calibrate = [&] {
    return refused_as([&] { calibration::calibrate_stereo(apart, board, 1280, 960); });
  };
  EXPECT_EQ(calibrate(), "too few views");
  for (StereoView& view : apart) view.right = {};
  EXPECT_EQ(calibrate(), "board not found");
  board = chessboard();
  board.rows = 8;
  EXPECT_EQ(calibrate(), "board symmetric");
}

TEST(Collection, SaysWhatIsMissingUntilNothingIs) {
  const CalibrationBoard board = charuco_board();
  const perception::CameraCalibration camera = bent_camera();
  std::mt19937 random(4);
  geometry::RigidTransform X_CT = geometry::RigidTransform::Identity();
  X_CT.translation() = Eigen::Vector3d(-0.15, -0.1, 0.7);
  std::vector<BoardView> views{exact_view(board, camera, X_CT, 0.05, random)};
  const auto text = [&] {
    std::string all;
    for (const auto& one : calibration::still_missing(views, board, 1280, 960)) all += one + "; ";
    return all;
  };
  EXPECT_THAT(text(), HasSubstr("19 more views"));
  EXPECT_THAT(text(), HasSubstr("upper left"));
  EXPECT_THAT(text(), HasSubstr("right edge 20 degrees nearer"));
  // z away from the camera: turned about y, the right edge comes nearer.
  X_CT.linear() = Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitY()).toRotationMatrix();
  views.push_back(exact_view(board, camera, X_CT, 0.05, random));
  ASSERT_LT((X_CT * board.corner_T(board.columns - 2)).z(), (X_CT * board.corner_T(0)).z());
  EXPECT_THAT(text(), ::testing::Not(HasSubstr("right edge")));
  EXPECT_THAT(text(), HasSubstr("left edge"));
  for (const auto& pose : board_poses(board, camera, 40, random)) {
    views.push_back(exact_view(board, camera, pose, 0.05, random));
  }
  EXPECT_EQ(text(), "");
}

}  // namespace
}  // namespace prehend::testing
