// prehend calibrate camera, stereo, wrench, table, board: on rendered images and simulated data,
// and on what a stranger would give them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <sstream>

#include <Eigen/Geometry>

#include "prehend/calibration/calibrate_stereo.h"
#include "prehend/perception/camera_calibration.h"
#include "prehend/perception/image_files.h"
#include "tests/calibration/rendered_board.h"
#include "tests/launch/child_program.h"

namespace prehend::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kBoard =
    "{kind: charuco, columns: 10, rows: 7, square: 0.03, marker: 0.022, dictionary: 5x5_100}";
constexpr int kPairs = 8;

// Where the right camera is of the left one.
geometry::RigidTransform beside() {
  geometry::RigidTransform X_RL = geometry::RigidTransform::Identity();
  X_RL.linear() = Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitY()).toRotationMatrix();
  X_RL.translation() = Eigen::Vector3d(-0.06, 0.001, 0);
  return X_RL;
}

class CalibrateCommand : public ::testing::Test {
 protected:
  // Images are rendered once for all tests.
  static void SetUpTestSuite() {
    images_ = std::make_unique<ScratchDirectory>();
    std::filesystem::create_directory(images_->path("left"));
    std::filesystem::create_directory(images_->path("right"));
    const BoardRenderer renderer(charuco_board(), small_camera());
    std::mt19937 random(3);
    int number = 0;
    for (const auto& X_CT : board_poses(charuco_board(), small_camera(), kPairs, random)) {
      const std::string name = "/" + std::to_string(++number) + ".png";
      perception::write_color_image(images_->path("left" + name), renderer.image(X_CT, random));
      perception::write_color_image(images_->path("right" + name),
                                    renderer.image(beside() * X_CT, random));
    }
  }
  static void TearDownTestSuite() { images_.reset(); }

  std::string run(std::vector<std::string> words) {
    words.insert(words.begin(), "calibrate");
    ChildProgram program("prehend", words, folder_.path("output"));
    exit_code_ = program.wait(std::chrono::seconds(60)).value_or(-1);
    return program.output();
  }
  // What it says when it refuses: last line.
  std::string refused(const std::vector<std::string>& words) {
    const std::string output = run(words);
    EXPECT_EQ(exit_code_, 1) << output;
    return output;
  }

  static std::unique_ptr<ScratchDirectory> images_;
  ScratchDirectory folder_;
  std::string board_ = folder_.write("board.yaml", kBoard);
  int exit_code_ = -1;
};
std::unique_ptr<ScratchDirectory> CalibrateCommand::images_;

TEST_F(CalibrateCommand, CameraEndsWithACalibrationAndAPageOfResiduals) {
  const std::string output = run({"camera", images_->path("left"), "--board", board_, "--views",
                                  "8", "--name", "eye", "-o", folder_.path("eye.yaml")});
  EXPECT_EQ(exit_code_, 0) << output;
  EXPECT_THAT(output, AllOf(HasSubstr("1 of 8"), HasSubstr("54 of 54 corners"),
                            HasSubstr("missing: 7 more views"), HasSubstr("pixels of reprojection"),
                            HasSubstr("eye.html")));
  const auto camera = perception::read_camera_calibration(folder_.path("eye.yaml"));
  EXPECT_EQ(camera.name, "eye");
  EXPECT_NEAR(camera.K(0, 0) / small_camera().K(0, 0), 1, 5e-3);
  EXPECT_THAT(text_of_file(folder_.path("eye.html")),
              AllOf(HasSubstr("Residuals of all corners"), HasSubstr("<svg"), HasSubstr("8.png"),
                    Not(HasSubstr("nan"))));
}

TEST_F(CalibrateCommand, StereoEndsWithAPairAndAPageOfResiduals) {
  const std::string output =
      run({"stereo", "--left", images_->path("left"), "--right", images_->path("right"), "--board",
           board_, "-o", folder_.path("pair"), "--report", folder_.path("page.html")});
  EXPECT_EQ(exit_code_, 0) << output;
  EXPECT_THAT(output, AllOf(HasSubstr("baseline"), HasSubstr("rows"), HasSubstr("page.html")));
  const auto left = perception::read_camera_calibration(folder_.path("pair/left.yaml"));
  const auto right = perception::read_camera_calibration(folder_.path("pair/right.yaml"));
  EXPECT_NEAR(perception::stereo_calibration(left, right).baseline(), beside().translation().norm(),
              3e-4);
  EXPECT_THAT(text_of_file(folder_.path("page.html")),
              AllOf(HasSubstr("Reprojection of each pair"), HasSubstr("The right camera alone")));
}

TEST_F(CalibrateCommand, CamerasRefuseWhatIsDegenerateByItsName) {
  const std::string left = images_->path("left"), right = images_->path("right");
  // The wrong board, and boards that are none.
  const auto with_board = [&](const std::string& yaml) {
    return refused({"camera", left, "--board", folder_.write("other.yaml", yaml)});
  };
  EXPECT_THAT(with_board("{kind: chessboard, columns: 14, rows: 11, square: 0.03}"),
              HasSubstr("prehend calibrate camera: board not found: in none of 8 images"));
  EXPECT_THAT(with_board("{kind: chesboard, columns: 10, rows: 7, square: 0.03}"),
              HasSubstr("chessboard"));
  // Too little, too alike.
  EXPECT_THAT(refused({"camera", left + "/1.png", "--board", board_}), HasSubstr("too few views"));
  const std::vector<std::string> same(6, left + "/1.png");
  std::vector<std::string> words{"camera", "--board", board_};
  words.insert(words.end(), same.begin(), same.end());
  EXPECT_THAT(refused(words), HasSubstr("all views parallel"));
  std::filesystem::create_directory(folder_.path("empty"));
  EXPECT_THAT(refused({"camera", folder_.path("empty"), "--board", board_}),
              HasSubstr("holds no image"));
  EXPECT_THAT(refused({"camera", folder_.write("bad.png", "no image"), "--board", board_}),
              HasSubstr("bad.png"));
  const std::string small = folder_.path("small.png");
  perception::write_color_image(small, geometry::ColorImage(64, 48));
  EXPECT_THAT(refused({"camera", left, small, "--board", board_}), HasSubstr("64 x 48"));
  // Pairs that are none.
  EXPECT_THAT(refused({"stereo", "--left", left, "--right", right + "/1.png", "--board", board_}),
              HasSubstr("8 left and 1 right"));
  EXPECT_THAT(refused({"stereo", "--left", right, "--right", left, "--board", board_}),
              HasSubstr("cameras exchanged"));
  const std::string shifted = folder_.path("shifted");  // each right image is of another moment
  std::filesystem::create_directory(shifted);
  for (int i = 1; i <= kPairs; ++i) {
    std::filesystem::copy_file(right + "/" + std::to_string(i % kPairs + 1) + ".png",
                               shifted + "/" + std::to_string(i) + ".png");
  }
  EXPECT_THAT(refused({"stereo", "--left", left, "--right", shifted, "--board", board_}),
              HasSubstr("pairs disagree"));
}

TEST_F(CalibrateCommand, BlurredImagesAreToldOf) {
  ImageFlaws flaws;
  flaws.blur = 9;
  const BoardRenderer renderer(charuco_board(), small_camera(), flaws);
  std::mt19937 random(3);
  std::filesystem::create_directory(folder_.path("blurred"));
  int number = 0;
  for (const auto& X_CT : board_poses(charuco_board(), small_camera(), 5, random)) {
    perception::write_color_image(folder_.path("blurred/" + std::to_string(++number) + ".png"),
                                  renderer.image(X_CT, random));
  }
  EXPECT_THAT(
      refused({"camera", folder_.path("blurred"), "--board", board_}),
      AllOf(HasSubstr("1.png: board not found"), HasSubstr("board not found: in none of 5")));
}

TEST_F(CalibrateCommand, ADrawnBoardIsFoundAgain) {
  const std::string png = folder_.path("new/board.png");
  EXPECT_THAT(run({"board", board_, "-o", png}),
              AllOf(HasSubstr("0.3000 m wide"), HasSubstr("0.2100 m high")));
  EXPECT_EQ(exit_code_, 0);
  EXPECT_EQ(calibration::find_board(perception::read_color_image(png), charuco_board()).ids.size(),
            54u);
  EXPECT_THAT(refused({"board", board_, "-o", folder_.path("board.xyz")}), HasSubstr("board.xyz"));
}

std::string wrench_rows(double mass, double tilt, double noise) {
  std::mt19937 random(2);
  std::normal_distribution<double> off(0, noise);
  std::ostringstream text;
  text << "fx,fy,fz,tx,ty,tz,qw,qx,qy,qz\n";
  for (int i = 0; i < 12; ++i) {
    const Eigen::Quaterniond q(Eigen::AngleAxisd(0.7 * i, Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(tilt * (i % 4) / 3, Eigen::Vector3d::UnitX()) *
                               Eigen::AngleAxisd(tilt * (i % 3) / 2, Eigen::Vector3d::UnitY()));
    const Eigen::Vector3d weight = q.conjugate() * Eigen::Vector3d(0, 0, -9.81 * mass);
    const Eigen::Vector3d torque = Eigen::Vector3d(0.01, 0, 0.08).cross(weight);
    text << weight.x() + 3 + off(random) << ',' << weight.y() - 5 + off(random) << ','
         << weight.z() + 12 + off(random) << ',' << torque.x() + 0.05 * off(random) << ','
         << torque.y() + 0.05 * off(random) << ',' << torque.z() + 0.05 * off(random) << ','
         << q.w() << ',' << q.x() << ',' << q.y() << ',' << q.z() << '\n';
  }
  return text.str();
}

TEST_F(CalibrateCommand, WrenchFindsBiasAndLoadAndRefusesByName) {
  const std::string rows = folder_.write("wrenches.csv", wrench_rows(1.5, 1.4, 0.05));
  const std::string output = run({"wrench", rows, "-o", folder_.path("tool.yaml")});
  EXPECT_EQ(exit_code_, 0) << output;
  EXPECT_THAT(output, AllOf(HasSubstr("5 of 12 poses; missing: too few poses"),
                            HasSubstr("12 of 12 poses; nothing is missing"), HasSubstr("mass 1.")));
  double mass = 0;
  const std::string yaml = text_of_file(folder_.path("tool.yaml"));
  ASSERT_EQ(std::sscanf(yaml.c_str() + yaml.find("mass:"), "mass: %lf", &mass), 1) << yaml;
  EXPECT_NEAR(mass, 1.5, 0.02);
  EXPECT_THAT(text_of_file(folder_.path("tool.html")), HasSubstr("Measured minus predicted"));

  EXPECT_THAT(refused({"wrench", folder_.write("w.csv", wrench_rows(1.5, 0, 0.05))}),
              HasSubstr("no tilt"));
  EXPECT_THAT(refused({"wrench", folder_.write("w.csv",
                                               "fx,fy,fz,tx,ty,tz,qw,qx,qy,qz\n"
                                               "0,0,nan,0,0,0,1,0,0,0\n")}),
              AllOf(HasSubstr("w.csv:2"), HasSubstr("fz is 'nan'")));
  EXPECT_THAT(refused({"wrench", folder_.write("w.csv",
                                               "fx,fy,fz,tx,ty,tz,qw,qx,qy,qz\n"
                                               "0,0,0,0,0,0,0,0,0,0\n")}),
              HasSubstr("the quaternion's length is 0"));
  EXPECT_THAT(refused({"wrench", folder_.write("w.csv", "fx,fy,fz,tx,ty,tz,qw,qx,qy,q_z\n1\n")}),
              HasSubstr("w.csv:2 has 1 fields for 10 columns"));
}

TEST_F(CalibrateCommand, TableFindsPlaneAndEdges) {
  // 0.8 m x 0.5 m in front of a camera that looks straight down from 0.9 m, 4 mm between points.
  std::ostringstream text;
  text << "ply\nformat ascii 1.0\nelement vertex " << 200 * 125
       << "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  std::mt19937 random(1);
  std::normal_distribution<double> off(0, 5e-4);
  for (int i = 0; i < 200; ++i) {
    for (int j = 0; j < 125; ++j) {
      text << -0.398 + 0.004 * i << ' ' << -0.248 + 0.004 * j << ' ' << 0.9 + off(random) << '\n';
    }
  }
  folder_.write("table.ply", text.str());
  const std::string views =
      folder_.write("views.csv", "cloud,x,y,z,qw,qx,qy,qz\ntable.ply,0.5,0,0.9,0,1,0,0\n");
  const std::string output = run({"table", views, "-o", folder_.path("table.yaml")});
  EXPECT_EQ(exit_code_, 0) << output;
  const std::string yaml = text_of_file(folder_.path("table.yaml"));
  double length = 0, width = 0, nx = 1, ny = 1, nz = 0;
  ASSERT_EQ(
      std::sscanf(yaml.c_str() + yaml.find("normal:"), "normal: [%lf, %lf, %lf]", &nx, &ny, &nz),
      3);
  ASSERT_EQ(std::sscanf(yaml.c_str() + yaml.find("length:"), "length: %lf", &length), 1);
  ASSERT_EQ(std::sscanf(yaml.c_str() + yaml.find("width:"), "width: %lf", &width), 1);
  EXPECT_NEAR(length, 0.8, 3e-3);
  EXPECT_NEAR(width, 0.5, 3e-3);
  EXPECT_NEAR(nz, 1, 1e-5);
  EXPECT_THAT(text_of_file(folder_.path("table.html")),
              HasSubstr("Distance from the common plane"));
  EXPECT_THAT(refused({"table", folder_.path("none.ply")}), HasSubstr("none.ply"));
  EXPECT_THAT(
      refused({"table", folder_.write("v.csv", "clud,x,y,z,qw,qx,qy,qz\na,0,0,0,1,0,0,0\n")}),
      HasSubstr("did you mean \"clud\""));
  EXPECT_THAT(
      refused({"table",
               folder_.write("v.csv", "cloud,x,y,z,qw,qx,qy,qz\ntable.ply,0,inf,0,1,0,0,0\n")}),
      HasSubstr("y is 'inf'"));
}

TEST_F(CalibrateCommand, MistypedWordsAreNamed) {
  run({"stero"});
  EXPECT_NE(exit_code_, 0);
  const std::string output = run({"camera", images_->path("left"), "--bord", board_});
  EXPECT_NE(exit_code_, 0);
  EXPECT_THAT(output, HasSubstr("board"));
  EXPECT_THAT(run({"hand-eye", folder_.path("p.csv"), "--board", board_, "--camera", board_,
                   "--mount", "hnad"}),
              HasSubstr("hand"));
  EXPECT_NE(exit_code_, 0);
  EXPECT_THAT(run({"camera", "--help"}), AllOf(HasSubstr("--report"), HasSubstr("Example")));
  EXPECT_EQ(exit_code_, 0);
}

}  // namespace
}  // namespace prehend::testing
