#include "prehend/robot/pose_yaml.h"

#include "prehend/text/yaml_map.h"

namespace prehend::robot {

geometry::RigidTransform read_pose(const YAML::Node& node, const std::filesystem::path& path,
                                   const std::string& place) {
  text::YamlMap map(node, path, place);
  Eigen::Vector3d xyz = Eigen::Vector3d::Zero(), rpy = Eigen::Vector3d::Zero();
  map.read("xyz", xyz);
  map.read("rpy", rpy);
  map.finish();
  geometry::RigidTransform pose = geometry::RigidTransform::Identity();
  pose.linear() = (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  pose.translation() = xyz;
  return pose;
}

}  // namespace prehend::robot
