#include <cmath>
#include <stdexcept>
#include <vector>

#include "prehend/geometry/errors.h"
#include "prehend/simulation/hardware_yaml.h"
#include "prehend/simulation/scene.h"
#include "prehend/text/yaml_map.h"

namespace prehend::simulation {
namespace {

using text::YamlMap;
using Path = std::filesystem::path;

void read_texture(const YAML::Node& node, const Path& file, const std::string& owner,
                  Texture& texture) {
  text::YamlMap map(node, file, owner + ".texture");
  std::string pattern;
  map.read("pattern", pattern);
  if (pattern == "noise")
    texture.pattern = Texture::Pattern::kNoise;
  else if (pattern == "stripes")
    texture.pattern = Texture::Pattern::kStripes;
  else if (pattern == "label")
    texture.pattern = Texture::Pattern::kLabel;
  else if (pattern == "wood")
    texture.pattern = Texture::Pattern::kWood;
  else if (!pattern.empty()) {
    map.fail("pattern", "is '" + pattern + "'", "Write noise, stripes, label or wood");
  }
  map.read("color", texture.color);
  map.read("second_color", texture.second_color);
  map.read("contrast", texture.contrast);
  map.read("scale", texture.scale);
  map.read("seed", texture.seed);
  map.finish();
}

void read_table(const YAML::Node& node, const Path& file, TableModel& table) {
  text::YamlMap map(node, file, "table");
  map.read("friction", table.friction);
  map.read("center", table.center);
  map.read("size", table.size);
  if (const YAML::Node texture = map.child("texture")) {
    read_texture(texture, file, "table", table.texture);
  }
  map.finish();
}

void read_carrier(const YAML::Node& node, const Path& file, CarrierModel& carrier) {
  text::YamlMap map(node, file, "carrier");
  map.read("minimum", carrier.minimum);
  map.read("maximum", carrier.maximum);
  map.read("max_speed", carrier.max_speed);
  map.read("max_acceleration", carrier.max_acceleration);
  map.read("max_yaw_rate", carrier.max_yaw_rate);
  map.read("max_yaw_acceleration", carrier.max_yaw_acceleration);
  map.read("start", carrier.start);
  map.read("start_yaw", carrier.start_yaw);
  map.read("mounting_tilt", carrier.mounting_tilt);
  map.finish();
}

void read_camera(const YAML::Node& node, const Path& file, CameraSetup& setup) {
  text::YamlMap map(node, file, "camera");
  map.read("width", setup.camera.left.width);
  map.read("height", setup.camera.left.height);
  map.read("fx", setup.camera.left.fx);
  map.read("fy", setup.camera.left.fy);
  map.read("cx", setup.camera.left.cx);
  map.read("cy", setup.camera.left.cy);
  map.read("baseline", setup.camera.baseline);
  map.read("eye", setup.eye);
  map.read("target", setup.target);
  map.read("noise", setup.noise);
  map.read("seed", setup.seed);
  map.finish();
}

void read_light(const YAML::Node& node, const Path& file, Light& light) {
  text::YamlMap map(node, file, "light");
  map.read("direction", light.direction);
  map.read("ambient", light.ambient);
  map.finish();
}

void read_sensors(const YAML::Node& gripper, const Path& file, Scene& scene) {
  if (const YAML::Node tactile = gripper["tactile"]) read_tactile(tactile, file, scene);
  if (const YAML::Node wrench = gripper["wrench"]) read_wrench(wrench, file, scene);
}

void read_gripper(const Path& file, Scene& scene) {
  scene.gripper = robot::read_gripper_model(file);
  scene.gripper_file = file;
  const YAML::Node node = text::load_yaml_map(file);
  if (const YAML::Node drive = node["drive"]) read_drive(drive, file, scene);
  if (scene.robot.empty()) read_sensors(node, file, scene);
}

// Of the parallel gripper that the platform's hand is, if it is one.
void read_robots_sensors(Scene& scene) {
  Path file = scene.robot;
  for (const char* next : {"hand", "gripper"}) {
    const YAML::Node node = text::load_yaml_map(file)[next];
    if (!node.IsDefined() || !node.IsScalar()) return;  // what is wrong, read_platform says
    file = file.parent_path() / node.Scalar();
  }
  read_sensors(text::load_yaml_map(file), file, scene);
}

void note_keys(const YAML::Node& map, const std::string& prefix, std::map<std::string, int>& keys) {
  for (const auto& entry : map) {
    if (!entry.first.IsScalar()) continue;
    const std::string key = prefix + entry.first.Scalar();
    if (entry.second.IsMap()) {
      note_keys(entry.second, key + ".", keys);
    } else {
      keys[key] = entry.first.Mark().line + 1;
    }
  }
}

// `position` and `orientation`, or neither.
void read_pose(text::YamlMap& map, SceneObject& object) {
  const bool lies = map.child("position").IsDefined();
  const YAML::Node orientation = map.child("orientation");
  if (!lies) {
    if (orientation.IsDefined()) {
      map.fail("orientation", "is given without a position", "Add `position: [x, y, z]` in metres");
    }
    return;
  }
  for (const char* upright : {"x", "y", "yaw"}) {
    if (map.child(upright).IsDefined()) {
      map.fail(upright, "is given beside a position", "Leave one of them out");
    }
  }
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  map.read("position", position);
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();
  if (orientation.IsDefined()) {
    const char* mend = "Write the quaternion [w, x, y, z] of unit length";
    std::vector<double> numbers;
    try {
      numbers = orientation.as<std::vector<double>>();
    } catch (const YAML::Exception&) {
      map.fail("orientation", "is no list of four numbers", mend);
    }
    if (numbers.size() != 4) map.fail("orientation", "is no list of four numbers", mend);
    q_WB = Eigen::Quaterniond(numbers[0], numbers[1], numbers[2], numbers[3]);
    if (!(std::abs(q_WB.norm() - 1) < 1e-3)) {
      map.fail("orientation", "is not of unit length", mend);
    }
  }
  object.X_WB = geometry::make_transform(q_WB, position);
}

SceneObject read_object(const YAML::Node& node, const Path& file, std::size_t index) {
  SceneObject object;
  text::YamlMap map(node, file, "objects[" + std::to_string(index) + "]");
  map.read("name", object.name);
  map.read("shape", object.shape);
  map.read("size", object.size);
  map.read("radius", object.radius);
  map.read("height", object.height);
  map.read("wall", object.wall);
  std::string mesh_file;
  map.read("file", mesh_file);
  object.file = file.parent_path() / mesh_file;
  map.read("scale", object.scale);
  map.read("mass", object.mass);
  map.read("friction", object.friction);
  map.read("x", object.x);
  map.read("y", object.y);
  map.read("yaw", object.yaw);
  read_pose(map, object);
  if (const YAML::Node texture = map.child("texture")) {
    read_texture(texture, file, "object '" + object.name + "'", object.texture);
  }
  map.finish();
  if (object.shape == "mesh" && mesh_file.empty()) {
    map.fail("shape", "is mesh without a file", "Add `file: NAME`");
  }
  return object;
}

}  // namespace

Scene read_scene(const std::filesystem::path& path, const std::filesystem::path& robot) {
  Scene scene;
  scene.file = path;
  const YAML::Node top = text::load_yaml_map(path);
  note_keys(top, "", scene.given);
  text::YamlMap map(top, path, "scene");
  map.read("step", scene.step);
  map.read("gravity", scene.gravity);
  map.read("start_opening", scene.start_opening);
  std::string gripper, own_robot;
  map.read("gripper", gripper);
  map.read("robot", own_robot);
  if (!own_robot.empty()) scene.robot = path.parent_path() / own_robot;
  if (!robot.empty()) scene.robot = robot;
  map.read("robot_home", scene.robot_home);
  if (!gripper.empty()) read_gripper(path.parent_path() / gripper, scene);
  if (!scene.robot.empty()) read_robots_sensors(scene);
  if (const YAML::Node node = map.child("tactile")) read_tactile(node, path, scene);
  if (const YAML::Node node = map.child("wrench")) read_wrench(node, path, scene);
  if (const YAML::Node node = map.child("physics")) {
    read_physics(node, path, map.child("step").IsDefined(), scene);
  }
  if (const YAML::Node node = map.child("table")) read_table(node, path, scene.table);
  if (const YAML::Node node = map.child("carrier")) read_carrier(node, path, scene.carrier);
  if (const YAML::Node node = map.child("camera")) read_camera(node, path, scene.camera);
  if (const YAML::Node node = map.child("light")) read_light(node, path, scene.light);
  const YAML::Node objects = map.child("objects");
  if (objects.IsDefined() && !objects.IsNull()) {
    if (!objects.IsSequence()) map.fail("objects", "is no list", "Write one `- name: ...` each");
    for (std::size_t i = 0; i < objects.size(); ++i) {
      scene.objects.push_back(read_object(objects[i], path, i));
    }
  }
  map.finish();
  try {
    validate(scene);
    for (const SceneObject& object : scene.objects) object_mesh(object);
  } catch (const std::invalid_argument& error) {
    throw geometry::InputError(path.string() + ": " + error.what(), "Correct that value");
  }
  return scene;
}

}  // namespace prehend::simulation
