#include "eval/touch/felt_cycles.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "eval/processor_time.h"
#include "eval/touch/hold.h"
#include "prehend/simulation/robot_world.h"
#include "prehend/simulation/shapes.h"
#include "prehend/text/tree_file.h"

namespace prehend::eval::touch {
namespace {

using simulation::GripperMode;
using simulation::PadSide;

constexpr double kFramePeriod = 0.01;                   // s, as the node publishes
constexpr double kCycleLift = 0.1, kCycleSpeed = 0.05;  // m, m/s
// m, at first and at last; the pads meet the object between two frames.
constexpr double kCycleOpening = 0.06005;

struct CycleObject {
  double mass, coverage;
  bool is_can;
};
constexpr std::array<CycleObject, kCycleObjects> kObjects{
    {{0.1, 0.52, false}, {0.3, 0.6, true}, {1, 1, false}}};

// Advances in frames and notes each.
class Recorder {
 public:
  Recorder(std::function<void(double)> advance, std::function<void(FeltRun&)> note)
      : advance_(std::move(advance)), note_(std::move(note)), begin_(processor_time()) {}

  void run(double seconds) {
    for (long i = std::lround(seconds / kFramePeriod); i > 0; --i) {
      advance_(kFramePeriod);
      note_(run_.felt);
    }
  }
  CycleRun take() {
    const auto frames = static_cast<double>(run_.felt.frames.size());
    run_.seconds = (processor_time() - begin_) / (frames * kFramePeriod);
    return std::move(run_);
  }

 private:
  std::function<void(double)> advance_;
  std::function<void(FeltRun&)> note_;
  double begin_;
  CycleRun run_;
};

}  // namespace

const std::array<const char*, kCycleObjects> kCycleNames{"box of 0.1 kg", "can of 0.3 kg",
                                                         "box of 1 kg"};

simulation::Scene cycle_scene(int object, int rows, int columns) {
  const CycleObject& chosen = kObjects.at(static_cast<std::size_t>(object));
  simulation::Scene scene = simulation::read_scene(text::tree_file("config/scenes/demo.yaml"));
  robot::TactilePadModel& pad = scene.gripper.pad;
  // Texels are square: another grid divides the pad's width and length alike.
  pad.texel_pitch *= static_cast<double>(pad.rows) / rows;
  pad.rows = rows;
  pad.columns = columns;
  scene.tactile = {};
  pad.full_scale = 65535;
  // The deepest that a texel can be pressed, 3 mm of the finest grid, is within this.
  pad.newton_per_count = 1e-4 * std::max(1.0, 84.0 / (rows * columns));
  scene.start_opening = kCycleOpening;
  simulation::SceneObject felt;
  felt.name = "object";
  felt.mass = chosen.mass;
  felt.size = {0.07, 0.048, 0.1};
  if (chosen.is_can) {
    felt.shape = "can";
    felt.radius = 0.024;
    felt.height = 0.1;
  }
  scene.objects = {felt};
  scene.carrier.start = {0, 0, 0.1 + (0.5 - chosen.coverage) * pad.length()};
  return scene;
}

CycleRun run_gripper_cycle(const simulation::Scene& scene) {
  simulation::World world(scene);
  const auto note = [&world, &scene](FeltRun& felt) {
    std::vector<PadFrame> pads;
    for (const PadSide side : {PadSide::kLeft, PadSide::kRight}) {
      const simulation::TactileImage image = world.tactile_image(side);
      PadFrame frame{image.rows, image.columns, {}};
      for (const auto count : image.counts) {
        frame.force.push_back(count * scene.gripper.pad.newton_per_count);
      }
      pads.push_back(std::move(frame));
    }
    felt.frames.push_back(std::move(pads));
    felt.path.push_back(world.body(0).X_WB.translation());
  };
  Recorder cycle([&world](double seconds) { world.advance(seconds); }, note);
  const auto move = [&](double height, double seconds) {
    world.move_carrier(scene.carrier.gripper_pose({0, 0, height}, 0), kCycleSpeed);
    cycle.run(seconds);
  };
  const simulation::SpindleDriveModel drive = drive_of(scene.gripper, scene.drive);
  const double force = std::max(12.0, 20 * scene.objects.front().mass);
  const double current = (force + drive.static_friction) / drive.force_per_current();
  const double low = scene.carrier.start.z();
  world.set_gripper_command(GripperMode::kVelocity, -0.01, 0.4);
  cycle.run(2);
  // The current rises slowly: friction of the drive takes up to its stiction of the force.
  for (int i = 1; i <= 100; ++i) {
    world.set_gripper_command(GripperMode::kCurrent, -current * i / 100);
    cycle.run(kFramePeriod);
  }
  cycle.run(0.5);
  move(low + kCycleLift, 3);
  move(low + 0.0005, 3);
  world.set_gripper_command(GripperMode::kPosition, kCycleOpening, 0, 0.02);
  cycle.run(1.5);
  move(low + kCycleLift, 1);
  return cycle.take();
}

CycleRun run_hand_cycle(const std::string& hand_name, double mass, double step) {
  const robot::HandModel hand =
      robot::read_hand_model(text::tree_file("config/robots/" + hand_name + ".yaml"));
  simulation::RobotWorld world = hand_over_box(hand, mass, step);
  const auto note = [&world](FeltRun& felt) {
    std::vector<PadFrame> pads;
    for (simulation::HandPadReading& pad : world.pads()) {
      pads.push_back({pad.rows, pad.columns, std::move(pad.force)});
    }
    felt.frames.push_back(std::move(pads));
    felt.path.push_back(world.body(0).X_WB.translation());
  };
  const auto advance = [&world](double seconds) {
    for (long i = std::lround(seconds / world.options().step); i > 0; --i) world.step();
  };
  Recorder cycle(advance, note);
  const auto carry = [&](double up, double seconds) {
    geometry::RigidTransform X_WH = world.X_WH();
    X_WH.translation().z() += up;
    world.carry(X_WH, 1);
    cycle.run(seconds);
  };
  world.move_hand(closing_on_box(hand));
  cycle.run(3);
  carry(0.05, 2);
  carry(-0.05, 2);
  simulation::HandCommand open;
  open.position = hand.preshapes.front().open;
  world.move_hand(open);
  cycle.run(2);
  return cycle.take();
}

}  // namespace prehend::eval::touch
