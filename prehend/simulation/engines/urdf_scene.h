#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "prehend/geometry/errors.h"
#include "prehend/simulation/engines/engine.h"

namespace prehend::simulation::engines {

struct UrdfOptions {
  geometry::RigidTransform X_WR = geometry::RigidTransform::Identity();  // where the root link is
  bool base_is_fixed = true;  // otherwise the root link floats
  /// Links whose collision geometry is a mesh pass through everything (with a remark) instead of
  /// being refused.
  bool meshes_pass_through = false;
  double friction = 0.8;  // of all links; URDF has none
};

/// A robot as bodies and joints. Position 0 of each joint is the file's.
struct UrdfScene {
  EngineScene scene;
  std::vector<std::string> joint_names;  // of scene.joints; bodies bear the names of their links
  /// What the file says and engines do not model: limits, damping, friction of joints, ...
  std::vector<std::string> remarks;
};

/// The subset of URDF that engines can do: links with at most one box, sphere or cylinder as
/// collision geometry (links joined by fixed joints count as one) and an inertial part; joints
/// prismatic, revolute, continuous, fixed; mimic without offset. Visual parts, transmissions and
/// sensors have no part in it. Format: http://wiki.ros.org/urdf/XML.
/// @throws geometry::InputError naming file, link or joint, and the mend: not readable, not URDF, a
/// joint of another type, a mesh, a moving link without mass or inertia, ...
UrdfScene load_urdf(const std::filesystem::path& file, const UrdfOptions& options = {});

/// The same from the text; `name` stands for the file in messages.
UrdfScene parse_urdf(const std::string& text, const std::string& name,
                     const UrdfOptions& options = {});

}  // namespace prehend::simulation::engines
