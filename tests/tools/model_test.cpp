// prehend model.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "prehend/geometry/mesh_files.h"
#include "prehend/robot/formats/robot_format.h"
#include "tests/launch/child_program.h"
#include "tools/robot_model/model_figure.h"

namespace prehend::testing {
namespace {

using robot::formats::LossReport;
using robot::formats::RobotDescription;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using tools::ModelFigure;

/// A finger that turns, and one that follows it half as far; the palm's name would end a script.
std::string hand_urdf(const std::string& shape = "<box size='0.1 0.1 0.02'/>") {
  return R"(<robot name="&lt;/script&gt;&lt;img src=x onerror=alert(1)&gt;">
  <link name="&lt;!--palm"><inertial><mass value="0.6"/><inertia ixx="0.002" iyy="0.002" izz="0.0036"
    ixy="0" ixz="0" iyz="0"/></inertial><visual><geometry>)" +
         shape + R"(</geometry></visual></link>
  <link name="a"/><link name="b"/>
  <joint name="ja" type="revolute"><parent link="&lt;!--palm"/><child link="a"/><axis xyz="0 0 1"/>
    <origin xyz="0.1 0 0"/><limit lower="0.2" upper="1.5" effort="2" velocity="3"/></joint>
  <joint name="jb" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.05" effort="2" velocity="0.1"/><mimic joint="ja" multiplier="0.5" offset="0.01"/></joint>
</robot>)";
}

class Model : public ::testing::Test {
 protected:
  std::string run(std::vector<std::string> words) {
    words.insert(words.begin(), "model");
    ChildProgram program("prehend", words, folder_.path("output"));
    exit_code_ = program.wait(std::chrono::seconds(60)).value_or(-1);
    return program.output();
  }
  std::string text_of(const std::string& file) const {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  ModelFigure figure_of(const std::string& urdf) {
    LossReport loss;
    const std::string file = folder_.write("hand.urdf", urdf);
    return tools::model_figure(robot::formats::read_robot(file, loss),
                               std::filesystem::path(file).parent_path());
  }

  ScratchDirectory folder_;
  int exit_code_ = -1;
};

TEST_F(Model, IsShownInAPageWhoseTextsAreTexts) {
  const std::string page = folder_.path("pages/hand.html");
  const std::string output = run({"show", folder_.write("hand.urdf", hand_urdf()), "--out", page});
  EXPECT_EQ(exit_code_, 0) << output;
  EXPECT_THAT(output, HasSubstr(page));
  const std::string text = text_of(page);
  EXPECT_THAT(text, AllOf(HasSubstr("<figure class=\"robot\">"), HasSubstr("11.46 to 85.94°"),
                          HasSubstr("0.5 * ja + 0.01"), HasSubstr("0 errors, ")));
  EXPECT_THAT(text, AllOf(Not(HasSubstr("<img")), Not(HasSubstr("<!--palm"))));
}

TEST_F(Model, OfTooManyLinksHasAPageWithoutPicture) {
  std::string urdf = "<robot name='chain'><link name='l0'/>";
  for (int i = 1; i <= 2000; ++i) {
    const std::string n = std::to_string(i), before = std::to_string(i - 1);
    urdf += "<link name='l" + n + "'/><joint name='j" + n + "' type='fixed'><parent link='l" +
            before + "'/><child link='l" + n + "'/></joint>";
  }
  const std::string page = folder_.path("chain.html");
  const std::string output =
      run({"show", folder_.write("chain.urdf", urdf + "</robot>"), "--out", page});
  EXPECT_EQ(exit_code_, 0) << output;
  EXPECT_THAT(text_of(page),
              AllOf(HasSubstr("It is not drawn: 2001 links are more than a page draws"),
                    HasSubstr("and 1501 more"), Not(HasSubstr("<figure"))));
}

TEST_F(Model, RefusesWhatItCannotReadOrWrite) {
  std::string output = run({"show", folder_.path("no_such.urdf")});
  EXPECT_EQ(exit_code_, 1);
  EXPECT_THAT(output, HasSubstr("no_such.urdf"));
  const std::string file = folder_.write("hand.urdf", hand_urdf());
  output = run({"show", file, "--out", file + "/page.html"});
  EXPECT_EQ(exit_code_, 1);
  EXPECT_THAT(output, HasSubstr("cannot write " + file + "/page.html"));
  run({"show", file, "--out"});
  EXPECT_EQ(exit_code_, 2);
}

TEST_F(Model, GetsCollisionShapesOfTheLinksThatAreAskedFor) {
  const std::string file = folder_.write("hand.urdf", hand_urdf());
  const std::string made = folder_.path("made.robot.json");
  EXPECT_THAT(run({"collision", file, made, "--as", "sphere"}), HasSubstr("<!--palm: 1 sphere"));
  EXPECT_EQ(exit_code_, 0);
  EXPECT_THAT(text_of(made), HasSubstr("\"kind\": \"sphere\""));
  EXPECT_THAT(run({"collision", file, made, "--link", "thumb"}),
              HasSubstr("There is no link 'thumb'. Name one of: "));
  EXPECT_EQ(exit_code_, 1);
  EXPECT_THAT(run({"collision", file, made, "--as", "box", "--concavity", "0.01"}),
              HasSubstr("--concavity is of pieces, not of a box"));
  EXPECT_THAT(run({"collision", file, made, "--link", "a"}), HasSubstr("nothing that is seen"));
  run({"collision", file, made, "--as", "cone"});
  EXPECT_EQ(exit_code_, 2);
}

TEST_F(Model, IsFreeOfLossOrNotWrittenWhereThatIsAsked) {
  const std::string file = folder_.write("hand.urdf", hand_urdf());
  EXPECT_THAT(run({"convert", file, folder_.path("hand.robot.json"), "--strict"}),
              HasSubstr("0 dropped"));
  EXPECT_EQ(exit_code_, 0);
  EXPECT_THAT(run({"diff", file, folder_.path("hand.robot.json")}), HasSubstr("at most 0 m"));
  EXPECT_EQ(exit_code_, 0);
}

TEST_F(Model, FigureSaysJointsBoxesOfInertiaAndWhatFollows) {
  const ModelFigure made = figure_of(hand_urdf());
  const auto& figure = made.figure;
  EXPECT_TRUE(made.remarks.empty());
  ASSERT_EQ(figure.joints.size(), 2U);
  const auto& turning = figure.joints[figure.joints[0].name == "ja" ? 0 : 1];
  const auto& sliding = figure.joints[figure.joints[0].name == "ja" ? 1 : 0];
  EXPECT_EQ(turning.start, 0.2);  // the limit nearest to 0
  EXPECT_EQ(turning.kind, report::RobotFigure::Joint::Kind::kRevolute);
  EXPECT_EQ(figure.joints[*sliding.leader].name, "ja");
  EXPECT_EQ(sliding.coefficients, (std::vector<double>{0.01, 0.5}));
  // 0.6 kg of 200 x 200 x 20 mm: m/12 (a^2 + b^2) = 0.00202, 0.00202, 0.004.
  const auto box = std::ranges::find(figure.shapes, "inertia", &report::RobotFigure::Shape::layer);
  ASSERT_NE(box, figure.shapes.end());
  const Eigen::Vector3d size = geometry::bounds(figure.meshes[box->mesh]).sizes();
  EXPECT_NEAR(size.minCoeff(), std::sqrt(6 / 0.6 * (0.004 - 0.0036)), 1e-9);
  EXPECT_NEAR(size.maxCoeff(), std::sqrt(6 / 0.6 * 0.0036), 1e-9);
}

TEST_F(Model, FigureHasNoMoreTrianglesThanAPageBears) {
  geometry::write_mesh_file(folder_.path("ball.stl"), geometry::make_sphere(0.1, 640));
  const ModelFigure made = figure_of(hand_urdf("<mesh filename='ball.stl'/>"));
  std::size_t triangles = 0;
  for (const auto& mesh : made.figure.meshes) triangles += mesh.triangles.size();
  EXPECT_LT(triangles, 330'000U);
  EXPECT_GT(triangles, 200'000U);
  ASSERT_FALSE(made.remarks.empty());
  EXPECT_THAT(made.remarks[0], HasSubstr("Meshes are drawn with "));
}

}  // namespace
}  // namespace prehend::testing
