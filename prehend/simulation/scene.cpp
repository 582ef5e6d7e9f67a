#include "prehend/simulation/scene.h"

#include <cmath>
#include <set>
#include <stdexcept>

#include "prehend/contact/require.h"
#include "prehend/geometry/mesh_files.h"
#include "prehend/simulation/shapes.h"
#include "prehend/simulation/world_engine.h"

namespace prehend::simulation {
namespace {

using contact::require;
using contact::require_not_negative;
using contact::require_positive;

void validate_carrier(const CarrierModel& carrier) {
  require(carrier.minimum.allFinite() && carrier.maximum.allFinite() &&
              (carrier.maximum - carrier.minimum).minCoeff() >= 0,
          "carrier.minimum", "finite and at most carrier.maximum");
  require_positive(carrier.max_speed, "carrier.max_speed");
  require_positive(carrier.max_acceleration, "carrier.max_acceleration");
  require_positive(carrier.max_yaw_rate, "carrier.max_yaw_rate");
  require_positive(carrier.max_yaw_acceleration, "carrier.max_yaw_acceleration");
  require(carrier.start.allFinite() && (carrier.start - carrier.minimum).minCoeff() >= 0 &&
              (carrier.maximum - carrier.start).minCoeff() >= 0,
          "carrier.start", "within carrier.minimum and carrier.maximum");
  require(std::isfinite(carrier.start_yaw), "carrier.start_yaw", "finite");
  require(std::isfinite(carrier.mounting_tilt), "carrier.mounting_tilt", "finite");
}

void validate_camera(const CameraSetup& setup) {
  const geometry::PinholeCamera& left = setup.camera.left;
  require(left.width > 0 && left.width <= 8192, "camera.width", "1 to 8192 pixels");
  require(left.height > 0 && left.height <= 8192, "camera.height", "1 to 8192 pixels");
  require_positive(left.fx, "camera.fx");
  require_positive(left.fy, "camera.fy");
  require(std::isfinite(left.cx) && std::isfinite(left.cy), "camera.cx, cy", "finite");
  require_positive(setup.camera.baseline, "camera.baseline");
  require_not_negative(setup.noise, "camera.noise");
  const Eigen::Vector3d view = setup.target - setup.eye;
  require(view.allFinite() && view.norm() > 1e-6, "camera.target", "finite and away from the eye");
  require(view.cross(Eigen::Vector3d::UnitZ()).norm() > 1e-6 * view.norm(), "camera.target",
          "not straight above or below the eye");
}

void validate_texture(const Texture& texture, const std::string& owner) {
  const auto in_range = [](const Eigen::Vector3d& c) {
    return c.allFinite() && c.minCoeff() >= 0 && c.maxCoeff() <= 1;
  };
  require(in_range(texture.color), owner + ".texture.color", "three numbers from 0 to 1");
  require(in_range(texture.second_color), owner + ".texture.second_color",
          "three numbers from 0 to 1");
  require_not_negative(texture.contrast, owner + ".texture.contrast");
  require_positive(texture.scale, owner + ".texture.scale");
}

void validate_plug_in(const Scene& scene) {
  if (const auto trouble = engine_trouble(scene.physics.engine)) {
    throw std::invalid_argument("physics.engine " + trouble->wrong + ". " + trouble->mend);
  }
  const std::string engine = scene.physics.engine + " as engine";
  require(scene.physics.integration == contact::Integration::kFirstOrder,
          "physics.integration with " + engine, "first_order");
  require(!scene.physics.adaptive, "physics.step with " + engine, "a number");
}

}  // namespace

geometry::RigidTransform CarrierModel::gripper_pose(const Eigen::Vector3d& position,
                                                    double yaw) const {
  geometry::RigidTransform X_WG = geometry::RigidTransform::Identity();
  X_WG.linear() = (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(-mounting_tilt, Eigen::Vector3d::UnitY()))
                      .toRotationMatrix() *
                  Eigen::Vector3d(1, -1, -1).asDiagonal();
  X_WG.translation() = position;
  return X_WG;
}

void validate(const Scene& scene) {
  require(std::isfinite(scene.step) && scene.step > 0 && scene.step <= 0.1, "step",
          "above 0 and at most 0.1 s");
  require(std::isfinite(scene.gravity), "gravity", "finite");
  require_not_negative(scene.table.friction, "table.friction");
  require(scene.table.size.allFinite() && scene.table.size.minCoeff() > 0, "table.size",
          "finite and positive");
  require(scene.table.center.allFinite(), "table.center", "finite");
  validate_texture(scene.table.texture, "table");
  robot::validate(scene.gripper);
  require(std::isfinite(scene.start_opening) && scene.start_opening >= 0 &&
              scene.start_opening <= scene.gripper.max_opening,
          "start_opening", "from 0 to the gripper's max_opening");
  drive_of(scene.gripper, scene.drive);
  const contact::Integration integration = scene.physics.integration;
  require(integration == contact::Integration::kFirstOrder ||
              integration == contact::Integration::kSecondOrder,
          "physics.integration", "first_order or second_order");
  if (scene.physics.engine != "native")
    validate_plug_in(scene);
  else
    require(scene.physics.solver.empty(), "physics.solver", "left out: native has one");
  require_positive(scene.physics.tolerance, "physics.tolerance");
  require_positive(scene.physics.velocity_tolerance, "physics.velocity_tolerance");
  require(scene.physics.most_iterations >= 1 && scene.physics.most_iterations <= 100,
          "physics.most_iterations", "1 to 100");
  require_positive(scene.tactile.period, "tactile.period");
  TactileOptions tactile = scene.tactile;
  if (!scene.robot.empty()) tactile.calibrations.clear();  // of its own pads
  require(tactile.calibrations.size() <= 2, "tactile.calibration",
          "one file, or one for each of 2 pads");
  for (const int pad : {0, 1}) {
    PadElectronics{tactile, scene.gripper.pad, pad};
    if (scene.robot.empty()) contact::validate(tactile.law_of(scene.gripper.pad, pad));
  }
  if (scene.wrench) WrenchSensor{*scene.wrench};
  validate_carrier(scene.carrier);
  validate_camera(scene.camera);
  require(scene.light.direction.allFinite() && scene.light.direction.norm() > 1e-9,
          "light.direction", "finite and not zero");
  require(scene.light.ambient >= 0 && scene.light.ambient <= 1, "light.ambient", "from 0 to 1");
  std::set<std::string> names;
  for (const SceneObject& object : scene.objects) {
    const std::string owner = "object '" + object.name + "'";
    require(!object.name.empty(), "objects' name", "given");
    require(names.insert(object.name).second, owner, "the only one of its name");
    require_positive(object.mass, owner + ".mass");
    require_not_negative(object.friction, owner + ".friction");
    require(std::isfinite(object.x) && std::isfinite(object.y) && std::isfinite(object.yaw),
            owner + ".x, y, yaw", "finite");
    require(!object.X_WB || object.X_WB->matrix().allFinite(), owner + ".position", "finite");
    validate_texture(object.texture, owner);
  }
}

geometry::RigidTransform SceneObject::pose() const {
  if (X_WB) return *X_WB;
  geometry::RigidTransform upright = geometry::RigidTransform::Identity();
  upright.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  upright.translation() = Eigen::Vector3d(x, y, 0);
  return upright;
}

std::optional<FeltShape> primitive_shape(const SceneObject& object) {
  FeltShape felt;
  double middle = 0;
  if (object.shape == "box") {
    felt.shape = contact::Shape::box(object.size);
    middle = 0.5 * object.size.z();
  } else if (object.shape == "can") {
    felt.shape = contact::Shape::cylinder(object.radius, object.height);
    middle = 0.5 * object.height;
  } else if (object.shape == "ball") {
    felt.shape = contact::Shape::sphere(object.radius);
    middle = object.radius;
  } else {
    return std::nullopt;
  }
  felt.X_BS.translation().z() = middle;
  return felt;
}

geometry::TriangleMesh object_mesh(const SceneObject& object) {
  if (object.shape == "box") return make_standing_box(object.size);
  if (object.shape == "can") return make_can(object.radius, object.height);
  if (object.shape == "bottle") return make_bottle(object.radius, object.height);
  if (object.shape == "mug") return make_mug(object.radius, object.height, object.wall);
  if (object.shape == "ball") return make_ball(object.radius);
  if (object.shape == "spray_bottle") {
    return make_spray_bottle(object.size.x(), object.size.y(), object.size.z());
  }
  if (object.shape == "mesh") {
    geometry::TriangleMesh mesh = geometry::read_mesh_file(object.file, object.scale);
    const Eigen::AlignedBox3d box = geometry::bounds(mesh);
    const Eigen::Vector3d base(box.center().x(), box.center().y(), box.min().z());
    for (auto& v : mesh.vertices) v -= base;
    return mesh;
  }
  throw std::invalid_argument("object '" + object.name + "'.shape '" + object.shape +
                              "' is none of box, can, bottle, mug, spray_bottle, ball, mesh");
}

}  // namespace prehend::simulation
