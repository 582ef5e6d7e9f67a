#include "prehend/perception/calibration.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "prehend/geometry/errors.h"

namespace prehend::perception {
namespace {

using ::testing::HasSubstr;

class CalibrationFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("prehend_calibration_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& text, const std::string& name = "c.yaml") {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }

  // The message of the error that reading `text` gives.
  std::string error_of(const std::string& text) {
    try {
      read_stereo_calibration(write(text));
    } catch (const geometry::InputError& error) {
      return error.what();
    }
    return "no error";
  }

  std::filesystem::path folder_;
};

const std::string kPlain =
    "{width: 640, height: 480, fx: 500, fy: 501, cx: 320, cy: 240, baseline: 0.1}";

std::string opencv_matrix(const std::string& name, int rows, int columns, const std::string& data) {
  return name + ": !!opencv-matrix\n   rows: " + std::to_string(rows) +
         "\n   cols: " + std::to_string(columns) + "\n   dt: d\n   data: [ " + data + " ]\n";
}

std::string opencv_file(const std::string& rotation, const std::string& translation,
                        const std::string& distortion) {
  return "%YAML:1.0\n---\n" +
         opencv_matrix("M1", 3, 3, "500., 0., 320., 0., 500., 240., 0., 0., 1.") +
         opencv_matrix("D1", 1, 5, distortion) +
         opencv_matrix("M2", 3, 3, "500., 0., 320., 0., 500., 240., 0., 0., 1.") +
         opencv_matrix("D2", 1, 5, distortion) + opencv_matrix("R", 3, 3, rotation) +
         opencv_matrix("T", 3, 1, translation);
}

const std::string kNoRotation = "1., 0., 0., 0., 1., 0., 0., 0., 1.";
const std::string kNoDistortion = "0., 0., 0., 0., 0.";

TEST_F(CalibrationFile, PlainYaml) {
  const StereoCalibration calibration = read_stereo_calibration(write(kPlain));
  EXPECT_TRUE(calibration.is_rectified());
  const geometry::StereoCamera camera = rectified_camera(calibration, 640, 480);
  EXPECT_EQ(camera.left.fx, 500);
  EXPECT_EQ(camera.left.fy, 501);
  EXPECT_EQ(camera.left.cx, 320);
  EXPECT_EQ(camera.left.cy, 240);
  EXPECT_EQ(camera.baseline, 0.1);
  EXPECT_THROW(rectified_camera(calibration, 320, 240), geometry::InputError);
}

TEST_F(CalibrationFile, NineNumbersAndTheBaseline) {
  const StereoCalibration calibration =
      read_stereo_calibration(write("754.67 0.0 489.4 0.0 754.67 265.2 0.0 0.0 1.0 \n0.063\n"));
  const geometry::StereoCamera camera = rectified_camera(calibration, 960, 540);
  EXPECT_EQ(camera.left.fx, 754.67);
  EXPECT_EQ(camera.left.cy, 265.2);
  EXPECT_EQ(camera.baseline, 0.063);
}

TEST_F(CalibrationFile, OpenCvYaml) {
  const StereoCalibration rectified =
      read_stereo_calibration(write(opencv_file(kNoRotation, "-0.12, 0., 0.", kNoDistortion)));
  EXPECT_TRUE(rectified.is_rectified());
  EXPECT_NEAR(rectified.baseline(), 0.12, 1e-12);
  const StereoCalibration distorted = read_stereo_calibration(
      write(opencv_file(kNoRotation, "-0.12, 0., 0.", "-0.1, 0.02, 0., 0., 0.")));
  EXPECT_FALSE(distorted.is_rectified());
  EXPECT_EQ(distorted.distortion_left.size(), 5U);
  const StereoCalibration one_matrix = read_stereo_calibration(write(
      "%YAML:1.0\n---\n" + opencv_matrix("K", 3, 3, "500., 0., 320., 0., 500., 240., 0., 0., 1.") +
      "baseline: 0.05\n"));
  EXPECT_EQ(rectified_camera(one_matrix, 640, 480).baseline, 0.05);
}

TEST_F(CalibrationFile, NamesTheMissingKey) {
  EXPECT_THAT(error_of("{width: 640, height: 480, fx: 500, fy: 500, cx: 320, cy: 240}"),
              AllOf(HasSubstr("c.yaml"), HasSubstr("'baseline'")));
  EXPECT_THAT(error_of("{fx: 500, cx: 320, cy: 240, baseline: 0.1}"), HasSubstr("'fy'"));
  EXPECT_THAT(error_of("{width: 640}"), HasSubstr("'fx'"));
  std::string without_R = opencv_file(kNoRotation, "-0.12, 0., 0.", kNoDistortion);
  without_R.replace(without_R.find("R: !!"), 1, "Q");
  EXPECT_THAT(error_of(without_R), HasSubstr("'R'"));
}

TEST_F(CalibrationFile, RejectsBaselinesThatCannotBe) {
  for (const char* baseline : {"0", "-0.1", ".nan", ".inf", "wide", "63", "[]"}) {
    EXPECT_THAT(
        error_of(std::string("{fx: 500, fy: 500, cx: 320, cy: 240, baseline: ") + baseline + "}"),
        HasSubstr("'baseline'"))
        << baseline;
  }
  EXPECT_THAT(error_of(opencv_file(kNoRotation, "0., 0., 0.", kNoDistortion)), HasSubstr("'T'"));
  EXPECT_THAT(error_of("500 0 320 0 500 240 0 0 1 0"), HasSubstr("'baseline'"));
}

TEST_F(CalibrationFile, RejectsNonsense) {
  EXPECT_THAT(error_of("{fx: 0, fy: 500, cx: 320, cy: 240, baseline: 0.1}"), HasSubstr("fx"));
  EXPECT_THAT(error_of("{fx: .nan, fy: 500, cx: 320, cy: 240, baseline: 0.1}"), HasSubstr("'fx'"));
  EXPECT_THAT(
      error_of(opencv_file("1., 1., 0., 0., 1., 0., 0., 0., 1.", "-0.1, 0., 0.", kNoDistortion)),
      HasSubstr("'R'"));
  EXPECT_THAT(error_of(opencv_file(kNoRotation, "-0.1, 0., 0.", "0., 0., 0.")), HasSubstr("'D1'"));
  EXPECT_THAT(error_of("1 2 3"), HasSubstr("10"));
  EXPECT_THAT(error_of("just words"), HasSubstr("c.yaml"));
  EXPECT_THAT(error_of("a: [1, 2"), HasSubstr("c.yaml"));
  EXPECT_THAT(error_of(""), HasSubstr("empty"));
  EXPECT_THAT(error_of(std::string("\x89PNG\0\0\0", 7)), HasSubstr("text"));
  EXPECT_THROW(read_stereo_calibration(folder_ / "none.yaml"), geometry::InputError);
  EXPECT_THROW(read_stereo_calibration(folder_), geometry::InputError);
}

}  // namespace
}  // namespace prehend::perception
