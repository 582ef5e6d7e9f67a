// A scene with a robot of arm and hand: every key that a scene may have changes what happens or
// what is seen, or is refused or remarked on by name.

#include "prehend/simulation/robot_scene.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "prehend/geometry/errors.h"
#include "prehend/simulation/engines/registry.h"
#include "prehend/simulation/robot_world.h"
#include "prehend/simulation/shapes.h"
#include "prehend/simulation/stereo_renderer.h"
#include "prehend/text/yaml_map.h"

namespace prehend::simulation {
namespace {

// What the keys are changed in: sensors have errors, so that the keys of these mean something.
constexpr const char* kBase = R"(
robot: ROBOTS/kr5_sdh.yaml
tactile: {realistic: true, load_cycles: 1000}
wrench: {force_noise: 0.01, torque_noise: 0.001}
camera: {width: 48, height: 36, fx: 40, fy: 40, cx: 24, cy: 18}
objects:
  - {name: box, shape: box, size: [0.05, 0.06, 0.07], x: 0.1}
  - {name: mug, shape: mug, radius: 0.04, height: 0.09, wall: 0.004, y: 0.2}
  - {name: mesh, shape: mesh, file: solid.obj, scale: 1, x: -0.1, y: -0.2}
)";

// Another value of each key, as YAML, and what comes of it.
enum class Comes { kChange, kRemark, kRefusal };
struct Other {
  const char* key;  // objects.0: the first object
  const char* value;
  Comes comes = Comes::kChange;
};
const std::vector<Other> kOthers{
    {"step", "0.002"},
    {"gravity", "5"},
    {"start_opening", "0.05", Comes::kRemark},
    {"gripper", "ROBOTS/pg70_dsa.yaml", Comes::kRemark},
    {"robot", "ROBOTS/kr5_pg70.yaml"},
    {"robot_home", "side"},
    {"tactile.realistic", "false"},
    {"tactile.threshold", "40"},
    {"tactile.gain_spread", "0.3"},
    {"tactile.pad_gain_spread", "0.3"},
    {"tactile.calibration",
     "[long.yaml, short.yaml, long.yaml, short.yaml, long.yaml, short.yaml]"},
    {"tactile.spread", "0.01"},
    {"tactile.latency", "0.1"},
    {"tactile.offset", "20"},
    {"tactile.drift", "1000"},
    {"tactile.ageing", "1e-4"},
    {"tactile.load_cycles", "1e6"},
    {"tactile.dead_rows", "[3, 4, 5, 6, 7]"},
    {"tactile.dead_columns", "[1, 2, 3, 4]"},
    {"tactile.low_pass_time", "0.1"},
    {"tactile.noise", "20"},
    {"tactile.seed", "7"},
    {"tactile.period", "0.05"},
    {"tactile.sensor", "dead_rows"},
    {"tactile.parameters", "{first: 3, count: 5}"},
    {"tactile.dead", "[20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31, 32, 33, 34, 35, 36, 37]"},
    {"wrench.force_noise", "2"},
    {"wrench.torque_noise", "2"},
    {"wrench.force_resolution", "1"},
    {"wrench.torque_resolution", "1"},
    {"wrench.force_range", "0.02"},
    {"wrench.torque_range", "0.002"},
    {"wrench.bias_force", "[1, 0, 0]"},
    {"wrench.bias_torque", "[1, 0, 0]"},
    {"wrench.seed", "7"},
    {"physics.engine", "mujoco", Comes::kRefusal},
    {"physics.solver", "noslip", Comes::kRefusal},
    {"physics.integration", "second_order", Comes::kRefusal},
    {"physics.step", "0.002"},
    {"physics.tolerance", "1e-4", Comes::kRefusal},
    {"physics.velocity_tolerance", "1e-4", Comes::kRefusal},
    {"physics.most_iterations", "2", Comes::kRefusal},
    {"physics.pads", "rigid", Comes::kRefusal},
    {"physics.law.stiffness", "900", Comes::kRefusal},
    {"physics.law.damping", "9", Comes::kRefusal},
    {"physics.law.bristle_stiffness", "190", Comes::kRefusal},
    {"physics.law.bristle_damping", "0.4", Comes::kRefusal},
    {"physics.law.viscous_friction", "0.3", Comes::kRefusal},
    {"physics.law.static_friction", "1.5", Comes::kRefusal},
    {"physics.law.dynamic_friction", "0.1", Comes::kRefusal},
    {"physics.law.stribeck_velocity", "0.02", Comes::kRefusal},
    {"physics.law.normal_law", "hunt_crossley", Comes::kRefusal},
    {"physics.law.exponent", "1.4", Comes::kRefusal},
    {"physics.law.bristle_law", "elasto_plastic", Comes::kRefusal},
    {"physics.law.elastic_limit", "0.6", Comes::kRefusal},
    {"physics.law.return_map", "true", Comes::kRefusal},
    {"physics.law.creep", "[{share: 0.1, time: 1}]", Comes::kRefusal},
    {"physics.law.hysteresis", "[{share: 0.1, depth: 0.0001}]", Comes::kRefusal},
    {"physics.law.curve", "[[0, 0], [0.001, 1], [0.002, 3]]", Comes::kRefusal},
    {"physics.rules.gate_texels", "false", Comes::kRefusal},
    {"physics.rules.remember_triangles", "false", Comes::kRefusal},
    {"physics.rules.skip_distant_pairs", "false", Comes::kRefusal},
    {"physics.rules.sleep", "false"},
    {"physics.rules.out_of_reach", "false", Comes::kRefusal},
    {"physics.rules.primitives", "false"},
    {"table.friction", "0.05"},
    {"table.center", "[0.7, 0]"},
    {"table.size", "[0.3, 0.3]"},
    {"table.texture.pattern", "noise"},
    {"table.texture.color", "[1, 0, 0]"},
    {"table.texture.second_color", "[1, 0, 0]"},
    {"table.texture.contrast", "0.9"},
    {"table.texture.scale", "0.1"},
    {"table.texture.seed", "99"},
    {"carrier.minimum", "[-0.5, -0.5, 0.01]", Comes::kRemark},
    {"carrier.maximum", "[0.5, 0.5, 0.7]", Comes::kRemark},
    {"carrier.max_speed", "0.4", Comes::kRemark},
    {"carrier.max_acceleration", "0.9", Comes::kRemark},
    {"carrier.max_yaw_rate", "1", Comes::kRemark},
    {"carrier.max_yaw_acceleration", "2", Comes::kRemark},
    {"carrier.start", "[0, 0, 0.4]", Comes::kRemark},
    {"carrier.start_yaw", "0.1", Comes::kRemark},
    {"carrier.mounting_tilt", "0.1", Comes::kRemark},
    {"camera.width", "40"},
    {"camera.height", "30"},
    {"camera.fx", "50"},
    {"camera.fy", "50"},
    {"camera.cx", "20"},
    {"camera.cy", "15"},
    {"camera.baseline", "0.2"},
    {"camera.eye", "[0.6, 0.1, 0.6]"},
    {"camera.target", "[0, 0.1, 0]"},
    {"camera.noise", "9"},
    {"camera.seed", "9"},
    {"light.direction", "[-1, 0, 1]"},
    {"light.ambient", "0.9"},
    {"objects.0.name", "carton"},
    {"objects.0.shape", "can"},
    {"objects.0.size", "[0.05, 0.06, 0.08]"},
    {"objects.1.radius", "0.03"},
    {"objects.1.height", "0.1"},
    {"objects.1.wall", "0.01"},
    {"objects.2.file", "other.obj"},
    {"objects.2.scale", "1.1"},
    {"objects.0.mass", "0.5"},
    {"objects.1.friction", "0.05"},
    {"objects.2.x", "-0.12"},
    {"objects.2.y", "0.02"},
    {"objects.2.yaw", "0.1"},
    {"objects.2.position", "[-0.1, 0.02, 0.01]"},
    {"objects.2.orientation", "[0.8, 0.6, 0, 0]"},
    {"objects.2.texture.pattern", "stripes"},
    {"objects.2.texture.color", "[1, 0, 0]"},
    {"objects.2.texture.second_color", "[1, 0, 0]"},
    {"objects.2.texture.contrast", "0.9"},
    {"objects.2.texture.scale", "0.1"},
    {"objects.2.texture.seed", "99"},
};

class RobotScene : public ::testing::Test {
 protected:
  RobotScene() {
    folder_ = std::filesystem::path(::testing::TempDir()) / "robot_scene";
    std::filesystem::create_directories(folder_);
    write_box("solid.obj", 0.06);
    write_box("other.obj", 0.05);
    std::ofstream(folder_ / "long.yaml") << "newton_per_count: 0.0005\n";
    std::ofstream(folder_ / "short.yaml") << "{rows: 13, newton_per_count: 0.0005}\n";
    setenv("PREHEND_SENSORS", PREHEND_SENSOR_EXAMPLE, 1);
  }
  ~RobotScene() override {
    unsetenv("PREHEND_SENSORS");
    std::filesystem::remove_all(folder_);
  }

  void write_box(const std::string& name, double side) const {
    const geometry::TriangleMesh mesh = geometry::make_box({side, side, side});
    std::ofstream file(folder_ / name);
    for (const Eigen::Vector3d& p : mesh.vertices) file << "v " << p.transpose() << '\n';
    for (const Eigen::Vector3i& t : mesh.triangles) {
      file << "f " << (t.array() + 1).matrix().transpose() << '\n';
    }
  }

  static std::string with_robots(std::string text) {
    for (std::size_t at; (at = text.find("ROBOTS")) != std::string::npos;) {
      text.replace(at, 6, std::filesystem::absolute("config/robots").string());
    }
    return text;
  }

  // The base with one key set.
  std::filesystem::path write(const std::string& key = "", const std::string& value = "") const {
    YAML::Node top = YAML::Load(with_robots(kBase));
    // A plug-in does not know what foam does.
    if (key == "tactile.sensor" || key == "tactile.parameters") {
      top["tactile"] = YAML::Load("{sensor: dead_rows}");
    }
    // An object stands somewhere or has a pose.
    if (key == "objects.2.position" || key == "objects.2.orientation") {
      YAML::Node object = top["objects"][2];
      for (const char* upright : {"x", "y", "yaw"}) object.remove(upright);
      object["position"] = YAML::Load("[-0.1, 0, 0]");
    }
    // An ideal pad does not age.
    if (key == "tactile.realistic") top["tactile"].remove("load_cycles");
    if (!key.empty()) {
      std::vector<YAML::Node> path{top};
      std::istringstream words(key);
      std::vector<std::string> names;
      for (std::string name; std::getline(words, name, '.');) names.push_back(name);
      for (std::size_t i = 0; i + 1 < names.size(); ++i) {
        const bool is_index = std::isdigit(static_cast<unsigned char>(names[i][0])) != 0;
        path.push_back(is_index ? path.back()[std::stoi(names[i])] : path.back()[names[i]]);
      }
      path.back()[names.back()] = YAML::Load(with_robots(value));
    }
    const std::filesystem::path file = folder_ / "scene.yaml";
    std::ofstream(file) << top;
    return file;
  }

  // All that can be read and seen of the world while the hand closes on the first object and the
  // mug slides on the table.
  static std::string course(const Scene& scene) {
    const robot::Platform platform = robot::read_platform(scene.robot);
    RobotWorld world(platform, scene, scene.robot_home);
    const robot::Preshape& shape = platform.hand.preshapes.front();
    const geometry::RigidTransform X_WG = world.X_WH() * platform.hand.X_HP * shape.X_PG;
    // Between the fingers, on a pedestal.
    Eigen::Vector3d below = X_WG.translation() - Eigen::Vector3d(0, 0, 0.035);
    world.place_object(scene.objects[0].name,
                       geometry::make_transform(Eigen::Quaterniond::Identity(), below));
    below.z() -= 0.005;
    world.add_object(
        "pedestal",
        geometry::transformed(geometry::make_box({0.02, 0.02, 0.01}),
                              geometry::make_transform(Eigen::Quaterniond::Identity(), below)),
        1, true);
    world.place_object("mug", geometry::make_transform(Eigen::Quaterniond(Eigen::AngleAxisd(
                                                           0.1, Eigen::Vector3d::UnitY())),
                                                       {0.3, 0.3, 0.01}));
    HandCommand close;
    close.position = shape.open;
    for (int i = 0; i < platform.hand.size(); ++i) {
      const std::size_t at = static_cast<std::size_t>(i);
      const robot::Joint& joint =
          platform.hand.model.joints[static_cast<std::size_t>(platform.hand.actuated[at])];
      close.position[i] =
          std::clamp(shape.open[i] + 1.2 * shape.closing[at].rate, joint.lower, joint.upper);
    }
    close.speed = 1;
    world.move_hand(close);
    std::ostringstream out;
    out.precision(17);
    const int steps = static_cast<int>(std::lround(0.4 / scene.step));
    for (int i = 0; i < steps; ++i) {
      world.step();
      if (i % (steps / 7) != 0) continue;
      out << world.time() << '\n' << world.wrist_wrench().force << world.wrist_wrench().torque;
      for (const HandPadReading& pad : world.pads()) {
        for (const std::uint16_t count : pad.counts) out << count << ' ';
      }
      for (std::size_t b = 0; b < world.body_count(); ++b) {
        const RobotBodyReading body = world.body(b);
        out << body.name << body.mass << body.asleep << body.X_WB.matrix();
      }
      for (const JointReading& joint : world.joints()) out << joint.position << ' ';
    }
    const StereoImages images = render_stereo(scene, world.visible_bodies());
    for (const auto* image : {&images.left, &images.right}) {
      out << image->width << ' ' << image->height;
      out.write(reinterpret_cast<const char*>(image->data.data()),
                static_cast<std::streamsize>(image->data.size() * sizeof(image->data[0])));
    }
    return out.str();
  }

  std::filesystem::path folder_;
};

TEST_F(RobotScene, EveryKeyChangesSomethingOrIsSaid) {
  const std::string base = course(read_scene(write()));
  ASSERT_EQ(base, course(read_scene(write()))) << "the same scene takes the same course";
  for (const Other& other : kOthers) {
    SCOPED_TRACE(other.key);
    const bool missing =
        other.key == std::string("physics.engine") && !engines::EngineRegistry().has(other.value);
    std::string said;
    try {
      const Scene scene = read_scene(write(other.key, other.value));
      for (const SceneRemark& remark : check_for_robot(scene, robot::read_platform(scene.robot))) {
        said += remark.text;
        EXPECT_FALSE(remark.replaced) << "the scene itself names the robot";
      }
      const std::string changed = course(scene);
      EXPECT_EQ(changed != base, other.comes == Comes::kChange) << said;
      EXPECT_EQ(!said.empty(), other.comes == Comes::kRemark) << said;
    } catch (const geometry::InputError& error) {
      said = error.what();
      EXPECT_EQ(other.comes, Comes::kRefusal) << said;
    }
    if (other.comes == Comes::kChange) continue;
    EXPECT_NE(said.find(other.key), std::string::npos) << said;
    EXPECT_NE(said.find("scene.yaml"), std::string::npos) << said;
    if (!missing && other.key != std::string("physics.solver")) {
      EXPECT_TRUE(said.find("Leave it out") != std::string::npos ||
                  said.find("Write it into") != std::string::npos)
          << said;
    }
  }
}

// The table above has all keys that the readers know.
TEST_F(RobotScene, NoKeyIsForgotten) {
  std::set<std::string> listed;
  for (const Other& other : kOthers) {
    std::string key = other.key;
    if (key.rfind("objects.", 0) == 0) key.erase(7, 2);
    listed.insert(key);
  }
  const text::KnownKeys known;
  for (const char* key : {"physics.law.stiffness", "physics.rules.sleep", "table.texture.seed",
                          "carrier.start", "light.ambient", "objects.2.texture.seed"}) {
    const Other& other = *std::find_if(kOthers.begin(), kOthers.end(),
                                       [&](const Other& o) { return o.key == std::string(key); });
    read_scene(write(key, other.value));
  }
  std::set<std::string> sections;
  for (const auto& [place, key] : known.keys()) {
    std::string prefix = place == "scene" ? "" : place + ".";
    if (place.rfind("objects[", 0) == 0) prefix = "objects.";
    if (place == "object 'mesh'.texture") prefix = "objects.texture.";
    sections.insert(prefix + key);
  }
  for (const std::string& key : sections) {
    const bool is_section = std::any_of(listed.begin(), listed.end(), [&](const std::string& k) {
      return k.rfind(key + ".", 0) == 0;
    });
    EXPECT_TRUE(is_section || listed.count(key) > 0) << key << " is not in the table";
  }
  for (const std::string& key : listed) EXPECT_EQ(sections.count(key), 1u) << "no key: " << key;
}

TEST_F(RobotScene, EnginesAndAdaptiveStepsAreRefusedWithTheirMend) {
  const auto refusal = [&](const Scene& scene) {
    try {
      RobotWorld world(robot::read_platform("config/robots/kr5_sdh.yaml"), scene);
    } catch (const geometry::InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string adaptive = refusal(read_scene(write("physics.step", "adaptive")));
  EXPECT_NE(adaptive.find("physics.step is adaptive"), std::string::npos) << adaptive;
  EXPECT_NE(adaptive.find("Give a number"), std::string::npos) << adaptive;
  // Made in code, without a file.
  Scene scene;
  EXPECT_EQ(refusal(scene), "");
  scene.physics.engine = "mujoco";
  const std::string engine = refusal(scene);
  EXPECT_NE(engine.find("physics.engine is 'mujoco', which does not simulate robots"),
            std::string::npos)
      << engine;
  EXPECT_NE(engine.find("platform:=stage_pg70"), std::string::npos) << engine;
}

// A scene for the gripper into which a robot is put: its gripper is replaced, as was asked for.
TEST_F(RobotScene, ARobotThatIsPutInReplacesTheGripper) {
  std::ofstream(folder_ / "gripper.yaml") << std::ifstream("config/robots/pg70_dsa.yaml").rdbuf()
                                          << "\ntactile: {noise: 9}\nwrench: {force_noise: 9}\n";
  std::ofstream(folder_ / "mine.yaml") << "gripper: gripper.yaml\ncarrier: {max_speed: 0.3}\n"
                                          "tactile: {threshold: 3}\n";
  const Scene own = read_scene(folder_ / "mine.yaml");
  EXPECT_EQ(own.tactile.sensor.noise, 9);
  EXPECT_TRUE(own.wrench);
  const Scene scene = read_scene(folder_ / "mine.yaml", "config/robots/pa10_barrett.yaml");
  EXPECT_EQ(scene.robot, "config/robots/pa10_barrett.yaml");
  EXPECT_EQ(scene.tactile.sensor.noise, 0) << "of the gripper that is not there";
  EXPECT_EQ(scene.tactile.sensor.threshold, 3);
  EXPECT_FALSE(scene.wrench);
  int replaced = 0;
  std::string others;
  robot::Platform platform = robot::read_platform(scene.robot);
  platform.hand.pads.clear();
  for (const SceneRemark& remark : check_for_robot(scene, platform)) {
    replaced += remark.replaced ? 1 : 0;
    if (!remark.replaced) others += remark.text;
  }
  EXPECT_EQ(replaced, 2) << "gripper and carrier.max_speed";
  EXPECT_NE(others.find("mine.yaml:3: tactile.threshold has no effect: the hand of pa10_barrett "
                        "has no pads"),
            std::string::npos)
      << others;
}

// A platform whose hand is a parallel gripper has what that gripper's file says of its sensors.
TEST_F(RobotScene, TheHandsGrippersFileCountsForARobot) {
  for (const auto& entry : std::filesystem::directory_iterator("config/robots")) {
    std::filesystem::copy(entry.path(), folder_ / entry.path().filename(),
                          std::filesystem::copy_options::recursive);
  }
  std::ofstream(folder_ / "pg70_dsa.yaml", std::ios::app)
      << "\ntactile: {noise: 9, threshold: 7}\nwrench: {force_noise: 8}\n";
  std::ofstream(folder_ / "mine.yaml") << "robot: kr5_pg70.yaml\ntactile: {threshold: 3}\n";
  const Scene scene = read_scene(folder_ / "mine.yaml");
  EXPECT_EQ(scene.tactile.sensor.noise, 9);
  EXPECT_EQ(scene.tactile.sensor.threshold, 3) << "the scene goes before";
  ASSERT_TRUE(scene.wrench);
  EXPECT_EQ(scene.wrench->force_noise, 8);
}

}  // namespace
}  // namespace prehend::simulation
