// The emulated hand does what is known of the real one.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "drivers/sdh/emulator/hand.h"

namespace prehend::drivers::sdh {
namespace {

using ::testing::HasSubstr;

/// A hand to talk to by hand.
class Talk {
 public:
  explicit Talk(HandOptions options = {})
      : hand(with_plant(options),
             [this](Bytes bytes) { said.append(bytes.begin(), bytes.end()); }) {
    run(0.01);
  }
  void run(double seconds) {
    constexpr Time kStep = std::chrono::milliseconds(2);
    for (const Time end = now + to_time(seconds); now < end;) {
      now += kStep;
      hand.update(now);
      for (std::size_t i = 0; i < kAxes; ++i) {
        fastest = std::max(fastest, std::abs(hand.motion().velocity[i]));
      }
    }
  }
  /// What it says to this line, without its end.
  std::string ask(const std::string& line) {
    said.clear();
    const std::string text = line + "\r\n";
    hand.receive({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, now);
    run(0.03);
    std::string answer = said;
    while (!answer.empty() && (answer.back() == '\n' || answer.back() == '\r')) answer.pop_back();
    return answer;
  }
  double degrees(std::size_t axis) const { return hand.motion().position[axis] / kDegree; }

  Time now = std::chrono::seconds(5);
  SimpleHand plant;
  std::string said;
  Hand hand;
  double fastest = 0;  // rad/s

 private:
  HandOptions with_plant(HandOptions options) {
    options.plant = &plant;
    return options;
  }
};

TEST(SdhEmulator, AnswersAsTheLibraryParses) {
  Talk hand;
  EXPECT_EQ(hand.ask("ver"), "VER=0.0.3.3");
  EXPECT_EQ(hand.ask("con=0"), "CON=0");
  EXPECT_EQ(hand.ask("v"), "V=40.00,40.00,40.00,40.00,40.00,40.00,40.00");
  EXPECT_EQ(hand.ask("v(2)=      12.500"), "V(2)=12.50");
  EXPECT_EQ(hand.ask("ilim(2)"), "ILIM(2)=0.50");
  EXPECT_EQ(hand.ask("state"), "STATE=6,6,6,6,6,6,6");
  EXPECT_EQ(hand.ask("stop"), "STOP");
  EXPECT_EQ(hand.ask(" "), "");
  EXPECT_EQ(hand.ask("nosuch"), "E13");
  EXPECT_EQ(hand.ask("p=1"), "E11");
  EXPECT_EQ(hand.ask("p(9)=1"), "E26");
  EXPECT_EQ(hand.ask("p(0)=-20"), "E24");
  EXPECT_EQ(hand.ask("ilim(1)=1.5"), "E24");
  EXPECT_EQ(hand.ask("pos=1,2,3,4,5,6,7"), "E12");
  EXPECT_THAT(hand.ask("temp"), HasSubstr("TEMP=25.00,"));
}

TEST(SdhEmulator, AxesStartAndEndTogetherWithinTheTimeThatItTells) {
  for (const char* profile : {"vp=0", "vp=1"}) {
    Talk hand;
    hand.ask(profile);
    EXPECT_EQ(hand.ask("p=0,40,0,-20,0,0,0").substr(0, 2), "P=");
    const std::string reply = hand.ask("m");
    ASSERT_EQ(reply.substr(0, 2), "M=");
    const double duration = std::stod(reply.substr(2));
    EXPECT_EQ(hand.hand.state(1), AxisState::kPositioning);
    hand.run(0.5 * duration - 0.03);
    EXPECT_NEAR(hand.degrees(1), 20, 1) << "half of the way at half of the time";
    EXPECT_NEAR(hand.degrees(3), -10, 0.5);
    hand.run(0.5 * duration - 0.05);
    EXPECT_TRUE(hand.hand.is_moving());
    hand.run(0.15);
    EXPECT_FALSE(hand.hand.is_moving()) << profile;
    EXPECT_NEAR(hand.degrees(1), 40, 0.2);
    EXPECT_NEAR(hand.degrees(3), -20, 0.2);
    EXPECT_LE(hand.fastest, 40 * kDegree * 1.001) << "v is the greatest speed of both profiles";
    EXPECT_EQ(hand.ask("state"), "STATE=0,0,0,0,0,0,0");
  }
}

TEST(SdhEmulator, StopHaltsAndTheTargetStays) {
  Talk hand;
  hand.ask("p=0,40,0,0,0,0,0");
  hand.ask("m");
  hand.run(0.8);
  hand.ask("stop");
  const double stopped = hand.degrees(1);
  EXPECT_GT(stopped, 1);
  EXPECT_LT(stopped, 39);
  hand.run(0.5);
  EXPECT_NEAR(hand.degrees(1), stopped, 0.2);
  EXPECT_EQ(hand.ask("p(1)"), "P(1)=40.00");
}

TEST(SdhEmulator, BlockedAxisShowsItAndPressesWithItsLimit) {
  Talk hand;
  hand.plant.put_object(3, 10 * kDegree);
  hand.ask("ilim(3)=0.3");
  hand.ask("p=0,0,0,30,0,0,0");
  hand.ask("m");
  hand.run(3);
  EXPECT_EQ(hand.hand.state(3), AxisState::kBlockedClockwise);
  EXPECT_NEAR(hand.hand.motion().current[3], 0.3, 1e-9);
  EXPECT_NEAR(hand.degrees(3), 10, 0.01);
  hand.plant.remove_object();
  hand.run(2);
  EXPECT_NEAR(hand.degrees(3), 30, 0.2) << "it goes on when the thing gives way";
}

TEST(SdhEmulator, VelocityControllersRunToTheLimit) {
  for (const char* controller : {"con=1", "con=2"}) {
    Talk hand;
    hand.ask("power=1,1,1,1,1,1,1");
    hand.ask(controller);
    EXPECT_EQ(hand.ask("v"), "V=0.00,0.00,0.00,0.00,0.00,0.00,0.00");
    hand.ask("v=0,-60,0,0,0,0,0");
    hand.run(0.5);
    EXPECT_EQ(hand.hand.state(1), AxisState::kSpeed);
    hand.run(4);
    EXPECT_EQ(hand.hand.state(1), AxisState::kLimitReached);
    EXPECT_NEAR(hand.degrees(1), -90, 0.5);
    EXPECT_EQ(hand.ask("m"), "E23");
  }
}

TEST(SdhEmulator, GripCannotBeStoppedButSwitchedOff) {
  Talk hand;
  hand.ask("selgrip=1");
  EXPECT_EQ(hand.ask("grip=1,30").substr(0, 5), "GRIP=");
  hand.run(0.5);
  hand.ask("stop");
  EXPECT_TRUE(hand.hand.is_moving());
  EXPECT_EQ(hand.hand.current_limits()[0], 1.0) << "igrip has overwritten ilim";
  hand.ask("power=0,0,0,0,0,0,0");
  const double there = hand.degrees(1);
  hand.run(1);
  EXPECT_EQ(hand.degrees(1), there);
  EXPECT_FALSE(hand.hand.is_powered(1));
}

TEST(SdhEmulator, SupplyOffAndOnForgetsLimitsAndTargets) {
  Talk hand;
  hand.ask("ilim(1)=0.1");
  hand.ask("p=0,40,0,0,0,0,0");
  hand.ask("m");
  hand.run(0.5);
  hand.hand.reboot(hand.now);
  EXPECT_EQ(hand.ask("ver"), "") << "it boots";
  hand.run(2.1);
  EXPECT_EQ(hand.ask("ilim(1)"), "ILIM(1)=0.50");
  EXPECT_EQ(hand.ask("p(1)"), "P(1)=0.00");
  EXPECT_EQ(hand.ask("state(1)"), "STATE(1)=6");
}

TEST(SdhEmulator, OldFirmwareSaysDebugLinesAndKnowsLess) {
  HandOptions options;
  options.firmware = {{0, 0, 2, 6}};
  Talk hand(options);
  EXPECT_THAT(hand.ask("m"), HasSubstr("@Enabling all axis\r\nM"));
  EXPECT_EQ(hand.ask("vp=1"), "E24");
  EXPECT_EQ(hand.ask("alim"), "E13");
}

TEST(SdhEmulator, HotHandRefusesToMove) {
  Talk hand;
  hand.hand.set_temperature(95);
  EXPECT_EQ(hand.ask("m"), "E29");
}

}  // namespace
}  // namespace prehend::drivers::sdh
