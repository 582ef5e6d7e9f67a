#include "prehend/robot/pad_calibration.h"

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/gripper_model.h"

namespace prehend::robot {
namespace {

PadCalibration parsed(const std::string& yaml) { return parse_pad_calibration(yaml, "pad.yaml"); }

void refused(const std::string& yaml, const std::string& part) {
  try {
    parsed(yaml);
    ADD_FAILURE() << yaml << " was not refused";
  } catch (const geometry::InputError& error) {
    const std::string said = error.what();
    EXPECT_NE(said.find("pad.yaml"), std::string::npos) << said;
    EXPECT_NE(said.find(part), std::string::npos) << said;
  }
}

TEST(PadCalibration, IsReadWithWhatItMeasured) {
  const PadCalibration c = parsed(
      "rows: 1\ncolumns: 2\nnewton_per_count: 0.0005\ngains: [1.1, 0.9]\nzeros: [3, -1]\nnoise: 2\n"
      "law: {stiffness: 900, damping: 4, creep: [{share: 0.1, time: 3}],\n"
      "      hysteresis: [{share: 0.2, depth: 0.0001}]}\n");
  EXPECT_EQ(c.gains, (std::vector<double>{1.1, 0.9}));
  EXPECT_EQ(c.zeros, (std::vector<double>{3, -1}));
  contact::TexelLaw own;
  own.static_friction = 0.4;
  const contact::TexelLaw law = c.law_over(own);
  EXPECT_EQ(law.stiffness, 900);
  EXPECT_EQ(law.damping, 4);
  EXPECT_EQ(law.static_friction, 0.4) << "not measured: the pad's own";
  EXPECT_EQ(law.memory, (contact::FoamMemory{{{0.1, 3}}, {{0.2, 1e-4}}}));
}

TEST(PadCalibration, LeavesWhatItDidNotMeasure) {
  const PadCalibration c = parsed("newton_per_count: 0.0005\n");
  contact::TexelLaw own;
  own.stiffness = 700;
  own.memory = contact::FoamMemory::realistic();
  EXPECT_EQ(c.law_over(own).stiffness, 700);
  EXPECT_EQ(c.law_over(own).memory, own.memory);
}

TEST(PadCalibration, RefusesWhatIsNone) {
  refused("rows: 14\n", "newton_per_count");
  refused("newton_per_count: -1\n", "newton_per_count");
  refused("newton_per_count: 1\ngains: [1, 2]\n", "2 values for 84 texels");
  refused("newton_per_count: 1\nrows: 1\ncolumns: 1\ngains: [-1]\n", "gains");
  refused("newton_per_count: 1\nrows: 1\ncolumns: 1\ngains: [0]\n", "gains");
  refused("newton_per_count: 1\nrows: 1\ncolumns: 1\nzeros: [x]\n", "zeros");
  refused("newton_per_count: 1\ngain: 3\n", "gains");
  refused("newton_per_count: 1\nlaw: {static_friction: 0.4}\n", "static_friction");
  refused("newton_per_count: 1\nlaw: {creep: [{share: 0.1}]}\n", "time");
  refused("newton_per_count: 1\nlaw: {creep: [{share: 0.1, time: 1, depth: 2}]}\n", "depth");
  refused("newton_per_count: 1\nlaw: {hysteresis: 3}\n", "no list");
  TactilePadModel pad;
  PadCalibration other = parsed("{rows: 13, newton_per_count: 1}");
  EXPECT_THROW(require_of(other, pad), std::invalid_argument);
  other = parsed("{newton_per_count: 1, law: {stiffness: 5}}");
  pad.law.normal_law = contact::NormalLaw::kHuntCrossley;
  EXPECT_THROW(require_of(other, pad), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::robot
