#include "prehend/calibration/calibration_board.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "prehend/calibration/board_view.h"
#include "prehend/geometry/errors.h"
#include "tests/calibration/rendered_board.h"

namespace prehend::testing {
namespace {

using calibration::CalibrationBoard;
using ::testing::HasSubstr;

std::string refusal(const std::string& yaml) {
  try {
    calibration::parse_calibration_board(yaml, "board.yaml");
  } catch (const geometry::InputError& error) {
    return error.what();
  }
  return "";
}

TEST(CalibrationBoard, FilesAreReadStrictly) {
  const auto board = calibration::parse_calibration_board(
      "{kind: charuco, columns: 10, rows: 7, square: 0.03, marker: 0.022, dictionary: 5x5_100}",
      "board.yaml");
  EXPECT_EQ(board.corners(), 54);
  EXPECT_DOUBLE_EQ(board.size().x(), 0.3);
  EXPECT_THAT(refusal("{kind: charoco}"), HasSubstr("charuco"));
  EXPECT_THAT(refusal("{columns: 3}"), HasSubstr("kind"));
  EXPECT_THAT(refusal("{kind: chessboard, columns: 9, rows: 6}"), HasSubstr("square is missing"));
  EXPECT_THAT(refusal("{kind: chessboard, columns: 9, rows: 6, square: 0.02, marker: 0.01}"),
              HasSubstr("does not apply"));
  EXPECT_THAT(refusal("{kind: chessboard, columns: 9, rows: 6, square: 25}"), HasSubstr("metres"));
  EXPECT_THAT(refusal("{kind: chessboard, columns: 9, rows: 6, square: .nan}"),
              HasSubstr("square"));
  EXPECT_THAT(refusal("{kind: chessboard, columns: 2, rows: 6, square: 0.02}"),
              HasSubstr("not corners"));
  EXPECT_THAT(refusal("{kind: chessboard, colums: 9, rows: 6, square: 0.02}"),
              HasSubstr("columns"));
  EXPECT_THAT(refusal("{kind: charuco, columns: 10, rows: 7, square: 0.03, marker: 0.03, "
                      "dictionary: 5x5_100}"),
              HasSubstr("does not fit"));
  EXPECT_THAT(refusal("{kind: charuco, columns: 20, rows: 17, square: 0.03, marker: 0.02, "
                      "dictionary: 5x5_100}"),
              HasSubstr("has 100 markers"));
  EXPECT_THAT(refusal("{kind: charuco, columns: 10, rows: 7, square: 0.03, marker: 0.02, "
                      "dictionary: 5x5_10}"),
              HasSubstr("5x5_100"));
}

// What is drawn is what is found: every corner where the file's frame has it.
TEST(CalibrationBoard, DrawnCornersAreFoundWhereTheyAre) {
  perception::CameraCalibration camera = bent_camera();
  camera.distortion.clear();
  ImageFlaws none;
  none.blur = 0.7;
  none.noise = 0;
  for (const CalibrationBoard& board : {chessboard(), charuco_board(), apriltag_grid()}) {
    const BoardRenderer renderer(board, camera, none);
    std::mt19937 random(1);
    for (const double turn : {0.1, 1.0, 2.0, 3.0}) {  // also on its head
      geometry::RigidTransform X_CT = geometry::RigidTransform::Identity();
      X_CT.linear() = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
      X_CT.translation() =
          Eigen::Vector3d(0.003, 0.002, 0.5) - X_CT.linear() * Eigen::Vector3d(0.15, 0.1, 0);
      const auto view = calibration::find_board(renderer.image(X_CT, random), board);
      ASSERT_GE(view.ids.size(), 0.8 * board.corners()) << turn;
      double squares = 0;
      for (std::size_t i = 0; i < view.ids.size(); ++i) {
        squares +=
            (view.pixels[i] - calibration::project(camera, X_CT * board.corner_T(view.ids[i])))
                .squaredNorm();
      }
      EXPECT_LT(std::sqrt(squares / view.ids.size()), 0.1) << turn;
      const auto pose = calibration::board_pose(view, board, camera);
      ASSERT_TRUE(pose);
      EXPECT_LT((pose->X_CT.translation() - X_CT.translation()).norm(), 1e-3);
      EXPECT_LT(angle_between(pose->X_CT, X_CT), 3e-3);
    }
    // Nothing is found in nothing.
    EXPECT_TRUE(calibration::find_board(geometry::ColorImage(1280, 960), board).ids.empty());
  }
}

TEST(CalibrationBoard, ABoardThatCannotBeDrawnIsRefused) {
  EXPECT_THROW(calibration::draw_board(chessboard(), 4), std::invalid_argument);
  EXPECT_THROW(calibration::draw_board(chessboard(), 100000), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::testing
