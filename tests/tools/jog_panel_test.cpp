// The lines that prehend jog shows.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "prehend/robot/platform.h"
#include "tools/jog/panel.h"

namespace prehend::tools {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

control::JogSession session_of(const robot::Platform& platform, int fingers) {
  std::vector<control::JogRow> hand;
  for (int i = 0; i < fingers; ++i) {
    hand.push_back({"hand_finger_" + std::to_string(i), true, true, -1, 1, 1});
  }
  return {control::ArmJog(platform.arm_chain(), platform.acceleration,
                          platform.X_FG(platform.hand.preshapes.front())),
          hand, std::vector<double>(static_cast<std::size_t>(fingers), 10.0)};
}

class Panel : public ::testing::Test {
 protected:
  explicit Panel(int fingers = 7) : session_(session_of(platform_, fingers)) {
    state_.title = "kr5_sdh";
    state_.session = &session_;
    state_.position.assign(session_.rows().size(), 0.5);
    state_.velocity.assign(session_.rows().size(), 0.0);
    state_.knows_pose = true;
  }
  std::string all(int width = 80, int height = 24) const {
    std::string text;
    for (const PanelLine& line : panel_lines(state_, width, height)) text += line.text + "\n";
    return text;
  }
  robot::Platform platform_ = robot::read_platform("config/robots/kr5_sdh.yaml");
  control::JogSession session_;
  PanelState state_;
};

TEST_F(Panel, FitsWhateverIsInIt) {
  state_.title = std::string(300, 't') + "\x1b[2J\n";
  state_.alarm = "the \x07lid\xff is open " + std::string(500, '!');
  state_.messages = {std::string(1000, 'm'), "\r\n\t"};
  state_.position[0] = 1e300;
  state_.velocity[1] = -1e300;
  for (const int height : {20, 24, 60}) {
    const auto lines = panel_lines(state_, 80, height);
    EXPECT_EQ(lines.size(), static_cast<std::size_t>(height));
    for (const PanelLine& line : lines) {
      EXPECT_LE(line.text.size(), 80u);
      for (const char c : line.text) EXPECT_TRUE(c >= 32 && c < 127) << line.text;
    }
  }
  for (const auto& [width, height] : {std::pair{79, 24}, {80, 19}, {1, 1}, {0, 0}, {-1, -1}}) {
    const auto lines = panel_lines(state_, width, height);
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_LE(static_cast<int>(lines[0].text.size()), std::max(0, width));
  }
  EXPECT_THAT(all(70, 24), HasSubstr("70 x 24 characters; 80 x 20 are needed"));
}

TEST_F(Panel, ShowsJointsInDegreesAndMarksThoseNearALimit) {
  EXPECT_THAT(all(), HasSubstr(">a  axis_1               28.65 deg  -170.0 ["));
  EXPECT_THAT(all(), HasSubstr(" h  finger_6             28.65 deg   -57.3 ["));
  state_.position[2] = 2.87;  // of 2.87979
  const auto lines = panel_lines(state_, 80, 24);
  EXPECT_THAT(lines, Contains(AllOf(Field(&PanelLine::text, StartsWith(" a! axis_3")),
                                    Field(&PanelLine::look, PanelLook::kNear))));
  state_.position[1] = std::nan("");
  EXPECT_THAT(all(), HasSubstr(" a  axis_2                   ? deg"));
  EXPECT_THAT(all(), HasSubstr("EMERGENCY STOP"));
}

TEST_F(Panel, ThePoseIsThatOfTheToolInBothFrames) {
  state_.X_BG.translation() = Eigen::Vector3d(0.5, -0.25, 0.125);
  state_.X_BG.linear() = Eigen::AngleAxisd(M_PI / 6, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  state_.X_WB.translation() = Eigen::Vector3d(-0.6, 0, 0);
  EXPECT_THAT(all(), AllOf(HasSubstr("tool in base  x   500.0 y  -250.0 z   125.0 mm"),
                           HasSubstr("tool in world x  -100.0 y  -250.0 z   125.0 mm"),
                           HasSubstr("rpy    0.0    0.0   30.0 deg")));
}

class LongPanel : public Panel {
 protected:
  LongPanel() : Panel(40) {}
};

TEST_F(LongPanel, TheChosenJointIsInView) {
  for (int i = 0; i < 46; ++i) {
    EXPECT_THAT(panel_lines(state_, 80, 24), Contains(Field(&PanelLine::text, StartsWith(">"))))
        << i;
    session_.key(control::JogKey::kNext, 0);
  }
  EXPECT_THAT(all(), Not(HasSubstr("finger_39")));
  session_.key(control::JogKey::kPrevious, 0);
  EXPECT_THAT(all(), HasSubstr(">h  finger_39"));
}

}  // namespace
}  // namespace prehend::tools
