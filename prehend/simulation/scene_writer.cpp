#include <fstream>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/simulation/scene.h"

namespace prehend::simulation {
namespace {

std::string list_of(const Eigen::Vector3d& v) {
  return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", v.x(), v.y(), v.z());
}

std::string text_of(const Texture& texture) {
  static constexpr const char* kPatterns[] = {"noise", "stripes", "label", "wood"};
  return fmt::format(
      "{{pattern: {}, color: {}, second_color: {}, contrast: {:.6g}, scale: {:.6g}, seed: {}}}",
      kPatterns[static_cast<std::size_t>(texture.pattern)], list_of(texture.color),
      list_of(texture.second_color), texture.contrast, texture.scale, texture.seed);
}

// What of the shape counts.
std::string shape_of(const SceneObject& object, const std::filesystem::path& folder) {
  std::string text = "shape: " + object.shape;
  if (object.shape == "box" || object.shape == "spray_bottle") {
    return text + ", size: " + list_of(object.size);
  }
  if (object.shape == "mesh") {
    const std::filesystem::path file = std::filesystem::absolute(object.file)
                                           .lexically_normal()
                                           .lexically_proximate(std::filesystem::absolute(folder));
    text += fmt::format(", file: \"{}\"", file.string());
    if (object.scale != 1) text += fmt::format(", scale: {:.9g}", object.scale);
    return text;
  }
  text += fmt::format(", radius: {:.6g}", object.radius);
  if (object.shape != "ball") text += fmt::format(", height: {:.6g}", object.height);
  if (object.shape == "mug") text += fmt::format(", wall: {:.6g}", object.wall);
  return text;
}

std::string pose_of(const SceneObject& object) {
  if (!object.X_WB) {
    return fmt::format("x: {:.6g}, y: {:.6g}, yaw: {:.6g}", object.x, object.y, object.yaw);
  }
  const Eigen::Quaterniond q(object.X_WB->linear());
  return fmt::format("position: {}, orientation: [{:.9g}, {:.9g}, {:.9g}, {:.9g}]",
                     list_of(object.X_WB->translation()), q.w(), q.x(), q.y(), q.z());
}

std::string camera_of(const CameraSetup& setup) {
  const geometry::PinholeCamera& left = setup.camera.left;
  return fmt::format(
      "{{width: {}, height: {}, fx: {:.9g}, fy: {:.9g}, cx: {:.9g}, cy: {:.9g}, baseline: {:.6g}, "
      "eye: {}, target: {}, noise: {:.6g}, seed: {}}}",
      left.width, left.height, left.fx, left.fy, left.cx, left.cy, setup.camera.baseline,
      list_of(setup.eye), list_of(setup.target), setup.noise, setup.seed);
}

}  // namespace

void write_scene(const std::filesystem::path& path, const Scene& scene, const std::string& remark) {
  std::string text = "# " + remark + "\n";
  const TableModel& table = scene.table;
  text += fmt::format(
      "table: {{friction: {:.6g}, center: [{:.6g}, {:.6g}], size: [{:.6g}, {:.6g}], texture: "
      "{}}}\n",
      table.friction, table.center.x(), table.center.y(), table.size.x(), table.size.y(),
      text_of(table.texture));
  text += "camera: " + camera_of(scene.camera) + "\n";
  text += fmt::format("light: {{direction: {}, ambient: {:.6g}}}\n", list_of(scene.light.direction),
                      scene.light.ambient);
  text += scene.objects.empty() ? "objects: []\n" : "objects:\n";
  for (const SceneObject& object : scene.objects) {
    text += fmt::format(
        "  - {{name: \"{}\", {}, mass: {:.6g}, friction: {:.6g}, {},\n     texture: {}}}\n",
        object.name, shape_of(object, path.parent_path()), object.mass, object.friction,
        pose_of(object), text_of(object.texture));
  }
  std::ofstream file(path);
  file << text;
  file.flush();
  if (!file) {
    throw geometry::InputError("'" + path.string() + "' cannot be written",
                               "Check that its folder is there and may be written to");
  }
}

}  // namespace prehend::simulation
