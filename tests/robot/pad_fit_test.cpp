// Pads of a World, pressed by its drive and seen by their electronics, are found again.

#include "prehend/robot/pad_fit/pad_fit.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include <gtest/gtest.h>

#include "prehend/contact/foam_texel.h"
#include "prehend/geometry/errors.h"
#include "prehend/simulation/world.h"

namespace prehend::robot {
namespace {

using simulation::GripperMode;
using simulation::PadSide;
using simulation::Scene;
using simulation::World;

struct Stroke {
  double opening, speed, hold;  // m, m/s, s
};

// The pads of a PG70 on a block of 48 mm, by its position servo; rows as the frames come. A twin
// with ideal electronics is the scale under the left pad, with noise.
PressingLog pressed(const Scene& scene, const std::vector<Stroke>& strokes, double force_noise,
                    std::uint32_t seed) {
  Scene ideal = scene;
  ideal.gripper.pad.law = scene.tactile.law_of(scene.gripper.pad, 0);
  ideal.tactile = {};
  World world(scene), scale(ideal);
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, force_noise), encoder(0, 1e-6);
  PressingLog log;
  log.name = "presses";
  log.texels = 84;
  const int ticks = static_cast<int>(std::lround(scene.tactile.period / scene.step));
  double target = world.gripper().opening;
  const auto record = [&](double seconds, double speed, double to) {
    const int frames = static_cast<int>(std::lround(seconds / scene.tactile.period));
    for (int i = 0; i < frames; ++i) {
      for (int k = 0; k < ticks; ++k) {
        const double step = speed * scene.step;
        target = target < to ? std::min(to, target + step) : std::max(to, target - step);
        for (World* each : {&world, &scale}) {
          each->set_gripper_command(GripperMode::kPosition, target, 6);
          each->step();
        }
      }
      log.time.push_back(world.time());
      log.depth.push_back(-0.5 * world.gripper().opening + encoder(random));
      log.force.push_back(scale.tactile_image(PadSide::kLeft).sum + noise(random));
      const auto counts = world.tactile_image(PadSide::kLeft).counts;
      log.counts.insert(log.counts.end(), counts.begin(), counts.end());
    }
  };
  record(1, 0, target);
  for (const Stroke& stroke : strokes) {
    const double way = std::abs(stroke.opening - target);
    record(way / stroke.speed + stroke.hold, stroke.speed, stroke.opening);
  }
  return log;
}

const std::vector<Stroke> kStrokes{{0.0472, 0.002, 8}, {0.0484, 0.004, 3}, {0.0468, 0.01, 12},
                                   {0.0474, 0.002, 1}, {0.0468, 0.002, 1}, {0.0484, 0.02, 3},
                                   {0.0475, 0.005, 1}, {0.0478, 0.002, 1}, {0.0470, 0.005, 5},
                                   {0.0476, 0.002, 2}, {0.0484, 0.002, 3}, {0.0469, 0.02, 8},
                                   {0.0484, 0.01, 2}};
const std::vector<Stroke> kOtherStrokes{{0.0474, 0.005, 2}, {0.0470, 0.001, 4}, {0.0477, 0.01, 3},
                                        {0.0484, 0.005, 1}, {0.0467, 0.005, 6}, {0.0484, 0.01, 1}};

Scene scene_of(const PadCalibration& truth) {
  Scene scene;
  scene.start_opening = 0.0484;
  scene.carrier.start = {0, 0, 0.07};
  simulation::SceneObject block;
  block.name = "block";
  block.size = {0.07, 0.048, 0.1};
  block.mass = 3;
  scene.objects = {block};
  scene.tactile.calibrations = {truth};
  scene.tactile.sensor.low_pass_time = 0.005;
  return scene;
}

PadCalibration truth_of(std::uint32_t seed) {
  PadCalibration truth;
  truth.newton_per_count = 6.1e-4;
  truth.noise = 3;
  truth.stiffness = 870;
  truth.damping = 7;
  truth.memory = {{{0.12, 2.5}}, {{0.15, 1.5e-4}}};
  std::mt19937 random(seed);
  std::normal_distribution<double> gain(1, 0.08), zero(20, 4);
  double sum = 0;
  for (int i = 0; i < 84; ++i) {
    truth.gains.push_back(i == 17 ? 0 : gain(random));
    truth.zeros.push_back(zero(random));
    sum += truth.gains.back();
  }
  for (double& each : truth.gains) each *= 83 / sum;
  return truth;
}

double value_of(const PadFit& fit, const std::string& name) {
  for (const FittedValue& value : fit.values) {
    if (value.name == name) return value.value;
  }
  ADD_FAILURE() << "no " << name;
  return 0;
}

double deviation_of(const PadFit& fit, const std::string& name) {
  for (const FittedValue& value : fit.values) {
    if (value.name == name) return value.deviation;
  }
  return 0;
}

TEST(PadFit, FindsWhatAWorldsPadIsLikeAndPredictsOtherPresses) {
  for (const std::uint32_t seed : {1U, 2U}) {
    const PadCalibration truth = truth_of(seed);
    const Scene scene = scene_of(truth);
    const PadFit fit = fit_pad(pressed(scene, kStrokes, 0.1, seed), {});
    const std::vector<std::pair<std::string, double>> expected{
        {"newton_per_count", truth.newton_per_count},
        {"noise", truth.noise},
        {"stiffness", *truth.stiffness},
        {"damping", *truth.damping},
        {"creep[0].share", truth.memory.creep[0].share},
        {"creep[0].time", truth.memory.creep[0].time},
        {"hysteresis[0].share", truth.memory.hysteresis[0].share},
        {"hysteresis[0].depth", truth.memory.hysteresis[0].depth}};
    for (const auto& [name, value] : expected) {
      EXPECT_NEAR(value_of(fit, name), value, 0.1 * value)
          << name << " +- " << deviation_of(fit, name) << ", seed " << seed;
      // Error bars are neither lies nor idle.
      EXPECT_LT(deviation_of(fit, name), 0.1 * value) << name;
      if (name != "noise") {
        EXPECT_LT(std::abs(value_of(fit, name) - value), 0.02 * value + 5 * deviation_of(fit, name))
            << name;
      }
    }
    for (int i = 0; i < 84; ++i) {
      EXPECT_NEAR(fit.calibration.gains[i], truth.gains[i], 0.1) << i;
      if (i != 17) {
        EXPECT_NEAR(fit.calibration.zeros[i], truth.zeros[i], 6) << i;
      }
    }
    EXPECT_EQ(fit.calibration.gains[17], 0);
    ASSERT_EQ(fit.remarks.size(), 1u);
    EXPECT_NE(fit.remarks[0].find("17"), std::string::npos);

    const PressingLog others = pressed(scene, kOtherStrokes, 0.1, seed + 10);
    const FoamCheck check = check_foam(others, fit.foam.law, 84);
    EXPECT_LT(check.most_off, 0.05 * check.most_force);
    EXPECT_LT(check.off, 0.01 * check.most_force);
    // What the simulated pads read is what was found.
    const PadCalibration read = parse_pad_calibration(to_yaml(fit, "presses.csv"), "left.yaml");
    EXPECT_NEAR(read.newton_per_count, fit.calibration.newton_per_count, 1e-9);
    EXPECT_NEAR(*read.stiffness, *fit.calibration.stiffness, 1e-2);
    EXPECT_EQ(read.memory.creep.size(), 1u);
    EXPECT_EQ(read.gains.size(), 84u);
    EXPECT_NO_THROW(World{scene_of(read)});
  }
}

// A made log of one foam: F over depth by FoamTexel.
PressingLog made(const contact::TexelLaw& law, const std::vector<std::pair<double, double>>& way,
                 double noise_of_force = 0.05) {
  PressingLog log;
  log.name = "made";
  log.texels = 84;
  contact::FoamTexel texel(law);
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, noise_of_force);
  double depth = -1e-4;
  for (const auto& [to, seconds] : way) {
    const int rows = static_cast<int>(std::lround(seconds / 0.01));
    const double from = depth;
    for (int i = 1; i <= rows; ++i) {
      depth = from + (to - from) * i / rows;
      const double force = texel.press(0.01, depth);
      log.time.push_back(0.01 * static_cast<double>(log.time.size()));
      log.depth.push_back(depth);
      log.force.push_back(84 * force + noise(random));
      for (int t = 0; t < 84; ++t) {
        log.counts.push_back(static_cast<std::uint16_t>(std::lround(force / 7e-4)));
      }
    }
  }
  return log;
}

void refused(const PressingLog& log, const PadFitOptions& options, const std::string& part) {
  try {
    fit_pad(log, options);
    ADD_FAILURE() << part << " was not refused";
  } catch (const geometry::InputError& error) {
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

TEST(PadFit, SaysByNameWhatTheLogDoesNotDetermine) {
  contact::TexelLaw law;
  const std::vector<std::pair<double, double>> ramps{
      {-1e-4, 1}, {1e-3, 1}, {-1e-4, 1}, {1.5e-3, 1}, {-1e-4, 1}};
  refused(made(law, {{-1e-4, 1}, {1e-3, 1}}), {}, "1 press");
  // Foam that does not remember has neither creep nor hysteresis to be found.
  PadFitOptions options;
  refused(made(law, ramps), options, "does not determine");
  options.foam.creep_terms = options.foam.hysteresis_terms = 0;
  const PadFit plain = fit_pad(made(law, ramps), options);
  EXPECT_NEAR(value_of(plain, "stiffness"), 1000, 10);
  EXPECT_EQ(plain.calibration.memory.terms(), 0);
  // Creep far slower than the log.
  law.memory.creep = {{0.3, 1000}};
  options.foam.creep_terms = 1;
  refused(made(law, ramps), options, "creep[0]");
  // So slow that no damper is felt: left out, and said.
  law.memory = {};
  law.damping = 0.001;
  options.foam.creep_terms = 0;
  const PadFit slow = fit_pad(
      made(law, {{-1e-4, 1}, {1e-3, 20}, {-1e-4, 20}, {1.5e-3, 20}, {-1e-4, 20}}, 1), options);
  EXPECT_FALSE(slow.calibration.damping.has_value());
  ASSERT_EQ(slow.remarks.size(), 1u);
  EXPECT_NE(slow.remarks[0].find("damping"), std::string::npos);

  PressingLog upside = made(law, ramps);
  for (double& depth : upside.depth) depth = -depth;
  refused(upside, options, "does not grow with the depth");
  PadFitOptions other = options;
  other.rows = 13;
  refused(made(law, ramps), other, "84 texels");
  PressingLog full = made(law, ramps);
  std::fill(full.counts.begin(), full.counts.end(), std::uint16_t{4095});
  refused(full, options, "full scale");
  PressingLog silent = made(law, ramps);
  std::fill(silent.counts.begin(), silent.counts.end(), std::uint16_t{3});
  refused(silent, options, "no texel");
}

class PressingFile : public ::testing::Test {
 protected:
  PressingFile() : folder_(std::filesystem::path(::testing::TempDir()) / "pressing_file") {
    std::filesystem::create_directories(folder_);
  }
  ~PressingFile() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  void refused(const std::string& text, const std::string& part) const {
    try {
      read_pressing_log({write("log.csv", text)});
      ADD_FAILURE() << part << " was not refused";
    } catch (const geometry::InputError& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("log.csv"), std::string::npos) << error.what();
    }
  }
  std::filesystem::path folder_;
};

TEST_F(PressingFile, IsReadFromOneOrSeveralFiles) {
  const PressingLog one =
      read_pressing_log({write("one.csv",
                               "time,depth,force,count[0],count[1],note\n0,0,0,1,2,\"a, b\"\n"
                               "0.1,1e-3,+5,3,4,c\r\n")});
  EXPECT_EQ(one.texels, 2);
  EXPECT_EQ(one.depth, (std::vector<double>{0, 1e-3}));
  EXPECT_EQ(one.force[1], 5);
  EXPECT_EQ(one.count(1, 0), 3);
  // As bag export writes them; the jaws' opening and the scale at times of their own.
  const auto frames = write("frames.csv",
                            "log_time,intensity[0]\n1000000000,1\n1500000000,2\n2000000000,3\n"
                            "9000000000,4\n");
  const auto jaws = write("jaws.csv", "log_time,opening\n1000000000,0.05\n2000000000,0.04\n");
  const auto scale = write("scale.csv", "time,N\n0.5,0\n2.5,20\n");
  const PressingLog several = read_pressing_log({frames, jaws, scale}, {{"force", "N"}});
  ASSERT_EQ(several.size(), 3u) << "over the time that all share";
  EXPECT_NEAR(several.depth[1], -0.0225, 1e-9);
  EXPECT_NEAR(several.force[1], 10, 1e-6);
  EXPECT_EQ(several.count(2, 0), 3);
}

TEST_F(PressingFile, RefusesWhatIsNoLog) {
  refused("time,depht,force,count[0]\n0,0,0,0\n1,0,0,0\n",
          "no column 'depth'; did you mean \"depht\"");
  refused("time,depth,count[0]\n0,0,0\n1,0,0\n", "'force'");
  refused("depth,force,count[0]\n0,0,0\n1,0,0\n", "'time'");
  refused("time,depth,force\n0,0,0\n1,0,0\n", "count[0]");
  refused("time,depth,force,count[0]\n0,0,nan,0\n1,0,0,0\n", ":2: force is 'nan'");
  refused("time,depth,force,count[0]\n0,0,0,0\n1,0,,0\n", ":3: force is ''");
  refused("time,depth,force,count[0]\n1,0,0,0\n1,0,0,0\n", ":3: the time does not increase");
  refused("time,depth,force,count[0]\n0,0,0,0\n1,0,0\n", ":3 has 3 fields for 4 columns");
  refused("time,depth,force,count[0]\n0,0,0,-1\n1,0,0,0\n", "no count");
  refused("time,depth,force,count[0]\n", "fewer than 2 rows");
  refused("time,depth,opening,force,count[0]\n0,0,0,0,0\n1,0,0,0,0\n",
          "both a depth and an opening");
  EXPECT_THROW(read_pressing_log({folder_ / "none.csv"}), geometry::InputError);
  EXPECT_THROW(read_pressing_log({write("a.csv", "time\n0\n1\n")}, {{"weight", "N"}}),
               geometry::InputError);
}

}  // namespace
}  // namespace prehend::robot
