#include "prehend/simulation/hardware_yaml.h"

#include <stdexcept>
#include <string>

#include <fmt/format.h>

#include "prehend/robot/texel_law_yaml.h"
#include "prehend/simulation/sensors/sensor_registry.h"
#include "prehend/simulation/world_engine.h"
#include "prehend/text/yaml_map.h"

namespace prehend::simulation {

using text::YamlMap;
using Path = std::filesystem::path;

namespace {

// Another sensor begins from its own defaults.
void choose_sensor(const text::YamlMap& map, const std::string& name, TactileOptions& tactile) {
  if (name == tactile.sensor_name()) return;
  try {
    tactile.model = name == kDefaultSensor ? nullptr : SensorRegistry().create(name);
  } catch (const std::invalid_argument& error) {
    map.fail("sensor", std::string("names none: ") + error.what(),
             "Correct the name, or name its plug-in's folder in PREHEND_SENSORS");
  }
  tactile.parameters.clear();
}

void read_sensor_parameters(const YAML::Node& node, const Path& file, TactileOptions& tactile) {
  text::YamlMap map(node, file, "tactile.parameters");
  for (const PadSensorParameter& parameter : tactile.model->parameters()) {
    double value = parameter.default_value;
    if (const auto before = tactile.parameters.find(parameter.name);
        before != tactile.parameters.end()) {
      value = before->second;
    }
    map.read(parameter.name, value);
    if (!(value >= parameter.minimum && value <= parameter.maximum)) {
      map.fail(parameter.name, fmt::format("is {}", value),
               fmt::format("Write {} to {}", parameter.minimum, parameter.maximum));
    }
    if (node[parameter.name]) tactile.parameters[parameter.name] = value;
  }
  map.finish();
}

std::vector<int> read_indices(text::YamlMap& map, const std::string& key, std::vector<int> before) {
  const YAML::Node list = map.child(key);
  if (!list.IsDefined()) return before;
  if (!list.IsSequence()) map.fail(key, "is no list", "Write indices: [3, 17]");
  std::vector<int> indices;
  for (const YAML::Node& entry : list) {
    int index = 0;
    if (!entry.IsScalar() || !YAML::convert<int>::decode(entry, index)) {
      map.fail(key, "has an entry that is no whole number", "Write indices: [3, 17]");
    }
    indices.push_back(index);
  }
  return indices;
}

constexpr const char* kFoamKeys[] = {"realistic", "threshold",     "gain_spread", "pad_gain_spread",
                                     "spread",    "low_pass_time", "latency",     "offset",
                                     "drift",     "ageing",        "noise",       "dead",
                                     "dead_rows", "dead_columns",  "load_cycles"};

void read_foam(text::YamlMap& map, TactileOptions& tactile) {
  TactileSensorOptions& sensor = tactile.sensor;
  bool realistic = false;
  map.read("realistic", realistic);
  if (realistic) {
    sensor = TactileSensorOptions::realistic();
    tactile.foam = contact::FoamMemory::realistic();
  }
  map.read("threshold", sensor.threshold);
  map.read("gain_spread", sensor.gain_spread);
  map.read("pad_gain_spread", sensor.pad_gain_spread);
  map.read("spread", sensor.spread);
  map.read("low_pass_time", sensor.low_pass_time);
  map.read("latency", sensor.latency);
  map.read("offset", sensor.offset);
  map.read("drift", sensor.drift);
  map.read("ageing", sensor.ageing);
  map.read("load_cycles", sensor.load_cycles);
  map.read("noise", sensor.noise);
  sensor.dead = read_indices(map, "dead", sensor.dead);
  sensor.dead_rows = read_indices(map, "dead_rows", sensor.dead_rows);
  sensor.dead_columns = read_indices(map, "dead_columns", sensor.dead_columns);
}

void read_calibrations(text::YamlMap& map, const YAML::Node& node, const Path& file,
                       TactileOptions& tactile) {
  const YAML::Node files = map.child("calibration");
  if (!files.IsDefined()) return;
  const std::string mend = "Write calibration: left.yaml, or a list of one file for each pad";
  if (tactile.model) map.fail("calibration", "is of the sensor foam", "Take it out");
  for (const char* key : {"gain_spread", "pad_gain_spread", "offset", "noise"}) {
    if (node[key]) map.fail(key, "stands beside a calibration, which measured it", "Keep one");
  }
  tactile.calibrations.clear();
  const auto add = [&](const YAML::Node& entry) {
    if (!entry.IsScalar()) map.fail("calibration", "has an entry that is no path", mend);
    tactile.calibrations.push_back(
        robot::read_pad_calibration(file.parent_path() / entry.Scalar()));
  };
  if (files.IsSequence()) {
    for (const YAML::Node& entry : files) add(entry);
  } else {
    add(files);
  }
  if (tactile.calibrations.empty()) map.fail("calibration", "is empty", mend);
  // Measured: what `realistic` draws is not drawn.
  tactile.sensor.gain_spread = tactile.sensor.pad_gain_spread = tactile.sensor.offset = 0;
}

}  // namespace

void read_drive(const YAML::Node& node, const Path& file, Scene& scene) {
  text::YamlMap map(node, file, "drive");
  SpindleDriveModel& drive = scene.drive;
  // So that a static friction given here is kept in newtons.
  drive.static_friction = drive_of(scene.gripper, drive).static_friction;
  drive.coulomb_friction = scene.gripper.friction_force;
  map.read("supply", drive.supply);
  map.read("resistance", drive.resistance);
  map.read("rotor_inertia", drive.rotor_inertia);
  map.read("torque_constant", drive.torque_constant);
  map.read("gear_ratio", drive.gear_ratio);
  map.read("spindle_lead", drive.spindle_lead);
  if (const YAML::Node node_of_thread = map.child("thread")) {
    text::YamlMap thread(node_of_thread, file, "drive.thread");
    drive.thread = SpindleDriveModel::Thread{};  // not emplace(): clang would not have it
    thread.read("mean_diameter", drive.thread->mean_diameter);
    thread.read("friction", drive.thread->friction);
    thread.read("flank_angle", drive.thread->flank_angle);
    thread.finish();
  }
  map.read("static_friction", drive.static_friction);
  map.read("viscous_friction", drive.viscous_friction);
  map.read("stribeck_velocity", drive.stribeck_velocity);
  map.read("ambient", drive.ambient);
  map.read("thermal_resistance", drive.thermal_resistance);
  map.read("thermal_capacity", drive.thermal_capacity);
  map.read("hottest", drive.hottest);
  map.read("servo_stiffness", drive.servo_stiffness);
  map.read("velocity_gain", drive.velocity_gain);
  map.finish();
}

void read_tactile(const YAML::Node& node, const Path& file, Scene& scene) {
  text::YamlMap map(node, file, "tactile");
  TactileOptions& tactile = scene.tactile;
  std::string name = tactile.sensor_name();
  map.read("sensor", name);
  choose_sensor(map, name, tactile);
  for (const char* key : kFoamKeys) {
    if (!tactile.model || !node[key]) continue;
    map.fail(key, std::string("is of the sensor foam, not of ") + tactile.sensor_name(),
             "Take it out; what that one knows stands in `parameters`");
  }
  for (const char* key : {"hysteresis", "creep", "creep_time"}) {
    if (!node[key]) continue;
    map.fail(key, "is no matter of the electronics: it acts on the force",
             "Write creep: [{share: 0.06, time: 10}] or hysteresis: [{share: 0.06, depth: 0.0002}] "
             "into the pad's law");
  }
  read_foam(map, tactile);
  map.read("seed", tactile.sensor.seed);
  map.read("period", tactile.period);
  read_calibrations(map, node, file, tactile);
  const YAML::Node parameters = map.child("parameters");
  map.finish();
  if (!parameters.IsDefined()) return;
  if (!tactile.model) {
    map.fail("parameters", "are of a sensor that is a plug-in, and foam is none",
             "Write foam's keys beside, or name the plug-in by `sensor`");
  }
  read_sensor_parameters(parameters, file, tactile);
}

void read_wrench(const YAML::Node& node, const Path& file, Scene& scene) {
  text::YamlMap map(node, file, "wrench");
  if (!scene.wrench) scene.wrench.emplace();
  WrenchSensorOptions& sensor = *scene.wrench;
  map.read("force_noise", sensor.force_noise);
  map.read("torque_noise", sensor.torque_noise);
  map.read("force_resolution", sensor.force_resolution);
  map.read("torque_resolution", sensor.torque_resolution);
  map.read("force_range", sensor.force_range);
  map.read("torque_range", sensor.torque_range);
  Eigen::Vector3d force = sensor.bias.head<3>(), torque = sensor.bias.tail<3>();
  map.read("bias_force", force);
  map.read("bias_torque", torque);
  sensor.bias << force, torque;
  map.read("seed", sensor.seed);
  map.finish();
}

void read_physics(const YAML::Node& node, const Path& file, bool has_step, Scene& scene) {
  text::YamlMap map(node, file, "physics");
  PhysicsOptions& physics = scene.physics;
  map.choose<contact::Integration>("integration",
                                   {{"first_order", contact::Integration::kFirstOrder},
                                    {"second_order", contact::Integration::kSecondOrder}},
                                   physics.integration);
  map.read("engine", physics.engine);
  if (const auto trouble = engine_trouble(physics.engine)) {
    map.fail("engine", trouble->wrong, trouble->mend);
  }
  map.read("solver", physics.solver);
  const YAML::Node step = map.child("step");
  physics.adaptive = step.IsDefined() && step.IsScalar() && step.Scalar() == "adaptive";
  if (step.IsDefined() && !physics.adaptive && has_step) {
    map.fail("step", "stands beside the scene's own step", "Keep one of the two");
  }
  if (!physics.adaptive) map.read("step", scene.step);
  map.read("tolerance", physics.tolerance);
  map.read("velocity_tolerance", physics.velocity_tolerance);
  map.read("most_iterations", physics.most_iterations);
  map.choose<bool>("pads", {{"texels", false}, {"rigid", true}}, physics.rules.rigid_pads);
  if (const YAML::Node law = map.child("law")) {
    robot::read_texel_law(law, file, "physics.law", scene.gripper.pad.law);
  }
  if (const YAML::Node node_of_rules = map.child("rules")) {
    text::YamlMap rules(node_of_rules, file, "physics.rules");
    rules.read("gate_texels", physics.rules.gate_texels);
    rules.read("remember_triangles", physics.rules.remember_triangles);
    rules.read("skip_distant_pairs", physics.rules.skip_distant_pairs);
    rules.read("sleep", physics.rules.sleep);
    rules.read("out_of_reach", physics.rules.out_of_reach);
    rules.read("primitives", physics.rules.primitives);
    rules.finish();
  }
  map.finish();
}

}  // namespace prehend::simulation
