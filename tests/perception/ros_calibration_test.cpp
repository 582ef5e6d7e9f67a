#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/perception/calibration.h"

namespace prehend::perception {
namespace {

using ::testing::HasSubstr;

class RosCalibration : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = std::filesystem::temp_directory_path() / "prehend-ros-XXXXXX";
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  // As camera_calibration writes it; `turn` about y of the rectification.
  std::filesystem::path write_camera(const std::string& name, double turn, double tx,
                                     const std::string& model = "plumb_bob") const {
    const double c = std::cos(turn), s = std::sin(turn);
    const auto number = [](double value) { return std::to_string(value); };
    return write(name,
                 "image_width: 640\nimage_height: 480\ncamera_name: x\ncamera_matrix:\n"
                 "  rows: 3\n  cols: 3\n  data: [500, 0, 320, 0, 501, 240, 0, 0, 1]\n"
                 "distortion_model: " +
                     model +
                     "\ndistortion_coefficients:\n  rows: 1\n"
                     "  cols: 5\n  data: [-0.1, 0.01, 0, 0, 0]\nrectification_matrix:\n"
                     "  rows: 3\n  cols: 3\n  data: [" +
                     number(c) + ", 0, " + number(s) + ", 0, 1, 0, " + number(-s) + ", 0, " +
                     number(c) +
                     "]\n"
                     "projection_matrix:\n  rows: 3\n  cols: 4\n  data: [480, 0, 330, " +
                     number(tx) + ", 0, 480, 240, 0, 0, 0, 1, 0]\n");
  }

  std::string error_of(const std::filesystem::path& left,
                       const std::filesystem::path& right) const {
    try {
      read_ros_stereo_calibration(left, right);
    } catch (const geometry::InputError& error) {
      return error.what();
    }
    return "";
  }

  std::filesystem::path folder_;
};

TEST_F(RosCalibration, PoseFollowsFromTheRectification) {
  const StereoCalibration calibration = read_ros_stereo_calibration(
      write_camera("left.yaml", 0.02, 0), write_camera("right.yaml", -0.03, -480 * 0.12));
  EXPECT_EQ(calibration.width, 640);
  EXPECT_EQ(calibration.K_left(1, 1), 501);
  EXPECT_EQ(calibration.distortion_left.size(), 5U);
  EXPECT_NEAR(calibration.baseline(), 0.12, 1e-6);
  EXPECT_FALSE(calibration.is_rectified());
  // A point on both rectified rays: p_rr = p_rl - (0.12, 0, 0).
  const auto about_y = [](double a) {
    return Eigen::AngleAxisd(a, Eigen::Vector3d::UnitY()).toRotationMatrix();
  };
  const Eigen::Vector3d p_L(0.1, -0.05, 1);
  const Eigen::Vector3d p_R = calibration.X_RL * p_L;
  EXPECT_TRUE(
      (about_y(-0.03) * p_R).isApprox(about_y(0.02) * p_L - Eigen::Vector3d(0.12, 0, 0), 1e-5));
}

TEST_F(RosCalibration, PrintedMessagesAreUnderstood) {
  const auto text = [](double tx) {
    return "header: \n  seq: 1\nheight: 480\nwidth: 640\ndistortion_model: \"plumb_bob\"\nD: [0, "
           "0, "
           "0, 0, 0]\nK: [500, 0, 320, 0, 500, 240, 0, 0, 1]\nR: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
           "P: [500, 0, 320, " +
           std::to_string(tx) + ", 0, 500, 240, 0, 0, 0, 1, 0]\n";
  };
  const StereoCalibration calibration =
      read_ros_stereo_calibration(write("l", text(0)), write("r", text(-50)));
  EXPECT_TRUE(calibration.is_rectified());
  EXPECT_NEAR(rectified_camera(calibration, 640, 480).baseline, 0.1, 1e-9);
}

TEST_F(RosCalibration, SaysWhatIsWrong) {
  const auto left = write_camera("left.yaml", 0, 0);
  const auto right = write_camera("right.yaml", 0, -480 * 0.12);
  EXPECT_THAT(error_of(right, left), HasSubstr("Swap the two files"));
  EXPECT_THAT(error_of(left, left), HasSubstr("not a positive length"));
  EXPECT_THAT(error_of(left, write_camera("mm.yaml", 0, -480 * 120)), HasSubstr("millimetres"));
  EXPECT_THAT(error_of(left, write_camera("fisheye.yaml", 0, -50, "equidistant")),
              HasSubstr("equidistant"));
  EXPECT_THAT(error_of(left, folder_ / "none.yaml"), HasSubstr("none.yaml"));
  EXPECT_THAT(error_of(left, write("text", "hello")), HasSubstr("is no calibration"));
  EXPECT_THAT(error_of(left, write("few", "image_width: 640\nimage_height: 480\n")),
              HasSubstr("camera_matrix"));
}

}  // namespace
}  // namespace prehend::perception
