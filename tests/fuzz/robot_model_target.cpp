// What a planner knows of a robot, as config/robots has it: `kind byte | file`, YAML of a platform,
// a hand or a parallel gripper (p, h, g), which may name the files that lie beside it, or a URDF
// (u).

#include <cstdint>
#include <string>

#include "prehend/geometry/errors.h"
#include "prehend/robot/gripper_model.h"
#include "prehend/robot/hand_model.h"
#include "prehend/robot/platform.h"
#include "prehend/robot/robot_model.h"
#include "tests/fuzz/folder.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace prehend;

constexpr std::string_view kArm = R"(<robot name='arm'><link name='base'/>
  <joint name='turn' type='revolute'><parent link='base'/><child link='upper'/>
  <origin xyz='0 0 0.3'/><axis xyz='0 0 1'/><limit lower='-2' upper='2' velocity='1' effort='9'/>
  </joint><link name='upper'/><joint name='reach' type='prismatic'><parent link='upper'/>
  <child link='flange'/><origin xyz='0.1 0 0' rpy='3.1 0 0'/><axis xyz='1 0 0'/>
  <limit lower='0' upper='0.5' velocity='0.2' effort='90'/></joint><link name='flange'/></robot>)";

constexpr std::string_view kHand = R"(<robot name='hand'><link name='palm'/>
  <joint name='left_joint' type='revolute'><parent link='palm'/><child link='left'/>
  <origin xyz='0 0.03 0.05'/><axis xyz='1 0 0'/>
  <limit lower='0' upper='1' velocity='1' effort='5'/></joint>
  <link name='left'><collision><origin xyz='0 0 0.03'/>
  <geometry><box size='0.02 0.01 0.06'/></geometry></collision></link>
  <joint name='right_joint' type='revolute'><parent link='palm'/><child link='right'/>
  <origin xyz='0 -0.03 0.05'/><axis xyz='-1 0 0'/><mimic joint='left_joint'/>
  <limit lower='0' upper='1' velocity='1' effort='5'/></joint>
  <link name='right'><collision><origin xyz='0 0 0.03'/>
  <geometry><box size='0.02 0.01 0.06'/></geometry></collision></link></robot>)";

constexpr std::string_view kHandYaml = R"(name: hand
urdf: hand.urdf
palm: palm
actuated: [left_joint]
fingers: {left: [left], right: [right]}
friction: 0.6
tool: {xyz: [0, 0, 0.1]}
preshapes: {open: {open: {left_joint: 0.1}, closing: {left_joint: -1}}}
)";

/// The files that an input may name.
class Neighbours {
 public:
  Neighbours() {
    folder_.write("arm.urdf", kArm);
    folder_.write("hand.urdf", kHand);
    folder_.write("hand.yaml", kHandYaml);
    folder_.write("gripper.yaml", "name: g\nmax_opening: 0.07\nmax_speed: 0.08\n");
  }
  std::filesystem::path input(std::string_view content) const {
    return folder_.write("input", content);
  }

 private:
  const fuzz::Folder folder_;
};

void read(const std::filesystem::path& file, char kind) {
  if (kind == 'p') {
    const robot::Platform platform = robot::read_platform(file);
    FUZZ_CHECK(!platform.homes.empty() && !platform.hand.preshapes.empty());
    FUZZ_CHECK(platform.arm_chain().size() > 0);
  } else if (kind == 'h') {
    const robot::HandModel hand = robot::read_hand_model(file);
    FUZZ_CHECK(!hand.fingers.empty() && !hand.preshapes.empty());
    for (const auto& preshape : hand.preshapes) FUZZ_CHECK(preshape.open.allFinite());
  } else if (kind == 'u') {
    const robot::RobotModel model = robot::read_urdf(file);
    FUZZ_CHECK(!model.links.empty());
    const int links = static_cast<int>(model.links.size());
    for (const robot::Joint& joint : model.joints) {
      FUZZ_CHECK(joint.parent >= 0 && joint.parent < links);
      FUZZ_CHECK(joint.child >= 0 && joint.child < links);
      FUZZ_CHECK(joint.X_PJ.matrix().allFinite() && joint.axis_J.allFinite());
    }
  } else {
    const robot::GripperModel gripper = robot::read_gripper_model(file);
    FUZZ_CHECK(gripper.max_opening > 0 && gripper.pad.rows > 0 && gripper.pad.columns > 0);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Neighbours neighbours;
  fuzz::FuzzInput input(data, size);
  const char kind = static_cast<char>(input.byte());
  const auto file = neighbours.input(input.rest());
  try {
    read(file, kind);
  } catch (const geometry::InputError&) {
  }
  return 0;
}
