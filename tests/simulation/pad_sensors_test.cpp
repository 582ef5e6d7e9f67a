// Pads' electronics of another project (prehend/simulation/sensors/example), loaded at run time.

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "grasping.h"
#include "prehend/geometry/errors.h"
#include "prehend/simulation/explain.h"
#include "prehend/simulation/robot_sensors.h"
#include "prehend/simulation/robot_world.h"
#include "prehend/simulation/sensors/sensor_registry.h"
#include "trace.h"

namespace prehend::simulation {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::ElementsAre;
using testing::grasp;
using testing::grasp_scene;
using ::testing::HasSubstr;
using testing::run;
using testing::trace;

constexpr const char* kSensorExample = PREHEND_SENSOR_EXAMPLE;

Scene scene_with_dead_rows(std::map<std::string, double> parameters) {
  Scene scene = grasp_scene(0.3);
  scene.tactile.model = SensorRegistry({kSensorExample}).create("dead_rows");
  scene.tactile.parameters = std::move(parameters);
  return scene;
}

template <class Error, class Call>
std::string sensor_refusal(Call call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was refused";
}

int sum_of_rows(const std::vector<std::uint16_t>& counts, int columns, int first, int end) {
  int sum = 0;
  for (int i = first * columns; i < end * columns; ++i) sum += counts[static_cast<std::size_t>(i)];
  return sum;
}

// A still grasp: the mean of two frames is the frame, and so each live texel says what it feels.
TEST(PlugInSensor, OfAnotherProjectIsWhatTheGrippersPadsSay) {
  World world(scene_with_dead_rows({{"first", 3}, {"count", 4}}));
  World true_world(grasp_scene(0.3));
  for (World* each : {&world, &true_world}) {
    grasp(*each, 1.0);
    run(*each, 1.0);
  }
  const double newton = world.scene().gripper.pad.newton_per_count;
  for (const PadSide side : {PadSide::kLeft, PadSide::kRight}) {
    const TactileImage image = world.tactile_image(side), felt = true_world.tactile_image(side);
    EXPECT_EQ(sum_of_rows(image.counts, image.columns, 3, 7), 0);
    EXPECT_GT(sum_of_rows(image.counts, image.columns, 0, 3), 100);
    double sum = 0;
    for (std::size_t i = 0; i < image.counts.size(); ++i) {
      sum += newton * image.counts[i];
      const int row = static_cast<int>(i) / image.columns;
      if (row >= 3 && row < 7) continue;
      EXPECT_NEAR(image.counts[i], felt.counts[i], 1) << "down there, rounded here";
    }
    EXPECT_NEAR(image.sum, sum, 1e-9);
  }
}

TEST(PlugInSensor, IsWhatAHandsPadsSay) {
  const robot::Platform platform = robot::read_platform("config/robots/kr5_sdh.yaml");
  Scene scene = scene_with_dead_rows({{"count", 1}});
  RobotSensors sensors(platform.hand, scene.tactile, std::nullopt);
  EXPECT_FALSE(sensors.ideal_pads());
  const robot::TactilePadModel& pad = platform.hand.pads[1].model;
  const auto texels = static_cast<std::size_t>(pad.rows * pad.columns);
  for (int i = 0; i < 2; ++i) {
    sensors.take_frame(1, std::vector<double>(texels, 20.5 * pad.newton_per_count));
  }
  EXPECT_EQ(sum_of_rows(sensors.frame(1), pad.columns, 0, 1), 0);
  EXPECT_EQ(sum_of_rows(sensors.frame(1), pad.columns, 1, pad.rows),
            20 * pad.columns * (pad.rows - 1));
  RobotWorld world(platform, scene);
  for (int i = 0; i < 20; ++i) world.step();
  EXPECT_THAT(world.pads().front().counts, Each(0)) << "nothing is touched";
  scene.tactile.parameters["count"] = 1000;
  EXPECT_THAT(sensor_refusal<std::invalid_argument>([&] {
                RobotWorld{platform, scene};
              }),
              HasSubstr("has no row 999"));
}

// Frames keep what was before and draw at random: all of it is in the saved state.
TEST(PlugInSensor, IsSavedWithTheWorld) {
  const Scene scene = scene_with_dead_rows({{"jitter", 0.3}});
  World world(scene);
  world.set_gripper_command(GripperMode::kVelocity, -0.04, 0.4);
  run(world, 0.35);
  const std::string bytes = world.save_bytes();
  const auto kept = world.save();
  const std::string first = trace(world, 0.5);
  World other(scene);
  other.restore_bytes(bytes);
  EXPECT_EQ(other.save_bytes(), bytes);
  EXPECT_EQ(trace(other, 0.5), first);
  world.restore(*kept);
  EXPECT_EQ(trace(world, 0.5), first);
  // Of another sensor, or with other parameters, it is of another scene.
  for (const Scene& foreign : {scene_with_dead_rows({{"jitter", 0.2}}), grasp_scene(0.3)}) {
    World world_of(foreign);
    EXPECT_THAT(sensor_refusal<geometry::InputError>([&] { world_of.restore_bytes(bytes); }),
                HasSubstr("is of another scene"));
  }
  Scene same = scene;
  same.tactile.sensor.seed = 2;
  World others(same);
  EXPECT_NE(trace(others, 0.85), trace(world, 0.85));
}

TEST(PlugInSensor, GoesThroughAdaptiveSteps) {
  Scene scene = scene_with_dead_rows({{"jitter", 0.3}});
  scene.physics.adaptive = true;
  World a(scene), b(scene);
  for (World* world : {&a, &b}) {
    world->set_gripper_command(GripperMode::kVelocity, -0.04, 0.4);
    world->advance(0.6);
  }
  EXPECT_EQ(a.save_bytes(), b.save_bytes());
  EXPECT_GT(a.tactile_image(PadSide::kLeft).sum, 0.1);
}

/// Says `extra` counts more than there are texels, or one beyond the full scale.
class Liar final : public PadSensorModel {
 public:
  explicit Liar(int extra) : extra_(extra) {}
  std::string name() const override { return "liar"; }
  std::vector<PadSensorParameter> parameters() const override { return {{"gain", 1, 0.5, 2}}; }
  std::unique_ptr<PadSensor> make(const PadTexels& texels,
                                  const std::map<std::string, double>& /*values*/,
                                  std::uint32_t /*seed*/) const override {
    class Sensor final : public PadSensor {
     public:
      Sensor(int extra, int full_scale) : extra_(extra), full_scale_(full_scale) {}
      std::vector<std::uint16_t> read(const std::vector<double>& forces, double /*dt*/) override {
        return std::vector<std::uint16_t>(
            static_cast<std::size_t>(static_cast<int>(forces.size()) + extra_),
            static_cast<std::uint16_t>(full_scale_ + (extra_ == 0 ? 1 : 0)));
      }
      std::vector<double> save() const override { return {}; }
      void restore(const std::vector<double>& /*state*/) override {}

     private:
      int extra_, full_scale_;
    };
    return std::make_unique<Sensor>(extra_, texels.full_scale);
  }

 private:
  int extra_;
};

TEST(PlugInSensor, WhoseFramesAreNotThePadsIsRefused) {
  for (const auto& [extra, words] : {std::pair(1, "gave 85 counts, the largest 4095, for 84"),
                                     {-84, "gave 0 counts"},
                                     {0, "the largest 4096, for 84"}}) {
    Scene scene = grasp_scene(0.3);
    scene.tactile.model = std::make_shared<Liar>(extra);
    EXPECT_THAT(sensor_refusal<std::runtime_error>([&] { World{scene}; }),
                AllOf(HasSubstr("sensor 'liar', a plug-in"), HasSubstr(words)));
  }
}

TEST(PlugInSensor, ParametersOfASceneInCodeAreChecked) {
  Scene scene = grasp_scene(0.3);
  scene.tactile.model = std::make_shared<Liar>(0);
  scene.tactile.parameters = {{"gian", 1}};
  EXPECT_THAT(sensor_refusal<std::invalid_argument>([&] { validate(scene); }),
              AllOf(HasSubstr("sensor 'liar' has no 'gian'"), HasSubstr("\"gain\"")));
  scene.tactile.parameters = {{"gain", 3}};
  EXPECT_THAT(sensor_refusal<std::invalid_argument>([&] { validate(scene); }),
              HasSubstr("tactile.parameters.gain of sensor 'liar' must be from 0.5 to 2, not 3"));
}

TEST(SensorRegistry, SaysWhatThereIsAndWhatCannotBeUsed) {
  const SensorRegistry registry({PREHEND_OUTDATED_PLUG_IN, kSensorExample, kSensorExample});
  EXPECT_THAT(registry.names(), ElementsAre("dead_rows", "foam"));
  EXPECT_EQ(registry.create("foam"), nullptr);
  EXPECT_THAT(
      sensor_refusal<std::invalid_argument>([&] { registry.create("dead_row"); }),
      AllOf(HasSubstr("there is no sensor 'dead_row'; the nearest is 'dead_rows'"),
            HasSubstr("outdated_plug_in.so cannot be used: is built for interface 999"),
            HasSubstr("dead_rows.so cannot be used: its name 'dead_rows' is taken already")));
}

class SensorsFile : public ::testing::Test {
 protected:
  SensorsFile()
      : folder_(std::filesystem::path(::testing::TempDir()) /
                ("prehend_sensors_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
    setenv("PREHEND_SENSORS", kSensorExample, 1);
  }
  ~SensorsFile() override {
    unsetenv("PREHEND_SENSORS");
    std::filesystem::remove_all(folder_);
  }
  Scene read(const std::string& text) const {
    std::ofstream(folder_ / "scene.yaml") << text;
    return read_scene(folder_ / "scene.yaml");
  }
  std::string error_of(const std::string& text) const {
    return sensor_refusal<geometry::InputError>([&] { read(text); });
  }
  std::filesystem::path folder_;
};

TEST_F(SensorsFile, NamesTheSensorAndItsParameters) {
  const Scene scene = read(
      "tactile: {sensor: dead_rows, parameters: {first: 3, count: 1}, seed: 7, period: 0.02}\n");
  EXPECT_EQ(scene.tactile.sensor_name(), "dead_rows");
  EXPECT_THAT(scene.tactile.parameters, ElementsAre(std::pair("count", 1), std::pair("first", 3)));
  EXPECT_EQ(scene.tactile.sensor.seed, 7u);
  EXPECT_EQ(scene.tactile.period, 0.02);
  EXPECT_FALSE(scene.tactile.is_ideal());
  EXPECT_EQ(scene.tactile.about(), "dead_rows (count 1, first 3, jitter 0)");
  EXPECT_TRUE(read("tactile: {sensor: foam}\n").tactile.is_ideal());
  std::string explained;
  for (const auto& part : explain(scene).modelled) explained += part.what + ": " + part.how + "\n";
  EXPECT_THAT(explained, HasSubstr("electronics dead_rows (count 1, first 3, jitter 0)"));
}

TEST_F(SensorsFile, OfTheSceneGoesBeforeTheGrippers) {
  std::ofstream(folder_ / "mine.yaml")
      << std::ifstream("config/robots/pg70_dsa.yaml").rdbuf()
      << "\ntactile: {sensor: dead_rows, parameters: {first: 3, count: 1}}\n";
  const std::string gripper = "gripper: mine.yaml\n";
  EXPECT_EQ(read(gripper).tactile.about(), "dead_rows (count 1, first 3, jitter 0)");
  EXPECT_EQ(read(gripper + "tactile: {parameters: {count: 2}}\n").tactile.about(),
            "dead_rows (count 2, first 3, jitter 0)");
  EXPECT_EQ(read(gripper + "tactile: {sensor: foam, noise: 2}\n").tactile.about(), "realistic");
  EXPECT_THAT(
      error_of(gripper + "tactile: {noise: 2}\n"),
      AllOf(HasSubstr("scene.yaml:2"), HasSubstr("is of the sensor foam, not of dead_rows")));
}

TEST_F(SensorsFile, RefusesWhatTheSensorDoesNotKnow) {
  EXPECT_THAT(error_of("step: 0.001\ntactile: {sensor: dead_row}\n"),
              AllOf(HasSubstr("scene.yaml:2"), HasSubstr("no sensor 'dead_row'"),
                    HasSubstr("nearest is 'dead_rows'"), HasSubstr("PREHEND_SENSORS")));
  EXPECT_THAT(error_of("tactile: {sensor: dead_rows, noise: 3}\n"),
              HasSubstr("of the sensor foam"));
  EXPECT_THAT(error_of("tactile: {parameters: {count: 3}}\n"), HasSubstr("foam is none"));
  EXPECT_THAT(error_of("tactile:\n  sensor: dead_rows\n  parameters:\n    cuont: 3\n"),
              AllOf(HasSubstr("scene.yaml:4"), HasSubstr("cuont"), HasSubstr("count")));
  EXPECT_THAT(error_of("tactile: {sensor: dead_rows, parameters: {count: -1}}\n"),
              HasSubstr("Write 0 to 1000"));
  EXPECT_THAT(error_of("tactile: {sensor: dead_rows, parameters: {count: two}}\n"),
              HasSubstr("count"));
  EXPECT_THAT(error_of("tactile: {sensor: dead_rows, parameters: {first: 13, count: 2}}\n"),
              HasSubstr("has no row 14"));
}

}  // namespace
}  // namespace prehend::simulation
