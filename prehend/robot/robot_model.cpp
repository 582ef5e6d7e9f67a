#include "prehend/robot/robot_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include <urdf_model/model.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/mesh_shape.h"
#include "prehend/robot/urdf_document.h"
#include "prehend/text/nearest_match.h"

namespace prehend::robot {
namespace {

using geometry::InputError;

constexpr double kFarthest = 1000;  // rad or m, of a joint

template <class Item>
int index_of(const std::vector<Item>& items, const std::string& name, const std::string& what,
             const std::string& robot) {
  const auto found =
      std::find_if(items.begin(), items.end(), [&](const Item& item) { return item.name == name; });
  if (found != items.end()) return static_cast<int>(found - items.begin());
  std::vector<std::string> names;
  for (const Item& item : items) names.push_back(item.name);
  throw InputError("Robot '" + robot + "' has no " + what + " '" + name + "'",
                   text::nearest_match_mend(name, names));
}

CollisionShape shape_of(const urdf::Collision& given) {
  CollisionShape shape;
  shape.X_LS = to_transform(given.origin);
  switch (given.geometry->type) {
    case urdf::Geometry::BOX: {
      const auto& box = static_cast<const urdf::Box&>(*given.geometry);
      shape.kind = CollisionShape::Kind::kBox;
      shape.size = {box.dim.x, box.dim.y, box.dim.z};
      break;
    }
    case urdf::Geometry::SPHERE:
      shape.kind = CollisionShape::Kind::kSphere;
      shape.radius = static_cast<const urdf::Sphere&>(*given.geometry).radius;
      break;
    case urdf::Geometry::CYLINDER: {
      const auto& cylinder = static_cast<const urdf::Cylinder&>(*given.geometry);
      shape.kind = CollisionShape::Kind::kCylinder;
      shape.radius = cylinder.radius;
      shape.length = cylinder.length;
      break;
    }
    default: {
      const auto& mesh = static_cast<const urdf::Mesh&>(*given.geometry);
      shape.kind = CollisionShape::Kind::kMesh;
      shape.mesh = mesh.filename;
      shape.size = {mesh.scale.x, mesh.scale.y, mesh.scale.z};
      break;
    }
  }
  return shape;
}

class Reader {
 public:
  Reader(const urdf::ModelInterface& document, const std::string& file,
         std::filesystem::path folder)
      : document_(document), file_(file), folder_(std::move(folder)) {
    model_.name = document.getName();
  }

  RobotModel read() {
    add(*document_.getRoot());
    for (auto& [joint, given] : mimics_) set_mimic(joint, *given);
    check_mimics();
    return std::move(model_);
  }

 private:
  [[noreturn]] void fail(const std::string& what, const std::string& mend) const {
    throw InputError("'" + file_ + "': " + what, mend);
  }

  void add(const urdf::Link& given) {
    Link link;
    link.name = given.name;
    if (given.inertial) link.mass = given.inertial->mass;
    if (!(link.mass >= 0) || !std::isfinite(link.mass)) {
      fail("link '" + given.name + "' has a mass that cannot be", "Give kilograms, 0 or more");
    }
    for (const auto& collision : given.collision_array) {
      if (!collision || !collision->geometry) continue;
      link.shapes.push_back(shape_of(*collision));
      complete(link.shapes.back(), given.name);
    }
    if (link.shapes.empty() && !given.visual_array.empty()) {
      model_.remarks.push_back("link '" + given.name +
                               "' can be seen but has no <collision>: nothing can touch it");
    }
    const int parent = static_cast<int>(model_.links.size());
    model_.links.push_back(std::move(link));
    for (const auto& given_joint : given.child_joints) {
      Joint joint = joint_of(*given_joint);
      joint.parent = parent;
      joint.child = static_cast<int>(model_.links.size());
      if (given_joint->mimic) {
        mimics_.emplace_back(static_cast<int>(model_.joints.size()), given_joint->mimic.get());
      }
      model_.joints.push_back(std::move(joint));
      add(*document_.getLink(given_joint->child_link_name));
    }
  }

  /// Checks a shape's sizes, and reads a mesh.
  void complete(CollisionShape& shape, const std::string& link) {
    const std::string place = "link '" + link + "'";
    if (!shape.X_LS.matrix().allFinite()) {
      fail(place + " has a collision shape at a place that is no number", "Mend its <origin>");
    }
    using Kind = CollisionShape::Kind;
    if (shape.kind == Kind::kMesh) {
      read_mesh(shape, place);
      return;
    }
    const double least = shape.kind == Kind::kBox      ? shape.size.minCoeff()
                         : shape.kind == Kind::kSphere ? shape.radius
                                                       : std::min(shape.radius, shape.length);
    const double sum = shape.size.sum() + shape.radius + shape.length;
    if (!(least > 0) || !std::isfinite(sum)) {
      fail(place + " has a collision shape without volume", "Give positive sizes in metres");
    }
  }

  void read_mesh(CollisionShape& shape, const std::string& place) {
    std::vector<std::filesystem::path> looked;
    std::filesystem::path file;
    try {
      file = find_mesh_file(shape.mesh, folder_, &looked);
    } catch (const InputError& error) {
      fail(place + ": its mesh " + error.problem(),
           "Name a file in its package, or one by its path");
    }
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file, ignored)) {
      std::string places;
      for (const auto& one : looked) places += (places.empty() ? "'" : ", '") + one.string() + "'";
      const bool packed = shape.mesh.find("://") != std::string::npos && looked.size() != 1;
      fail(place + ": its mesh '" + shape.mesh + "' is not there; looked for " + places,
           packed ? "Put the package's folder beside or above the URDF, or where ROS_PACKAGE_PATH "
                    "lists it"
                  : "Paths are relative to the URDF's folder");
    }
    try {
      const std::array<double, 3> scale{shape.size.x(), shape.size.y(), shape.size.z()};
      auto known = meshes_.find({file, scale});
      if (known == meshes_.end()) {
        known = meshes_.emplace(std::pair{file, scale}, read_solid_mesh(file, shape.size)).first;
      }
      shape.solid = known->second.mesh;
      if (!known->second.remark.empty()) {
        model_.remarks.push_back(place + ": " + known->second.remark);
      }
    } catch (const InputError& error) {
      const std::string mend = std::string(error.what()).substr(error.problem().size() + 2);
      fail(place + ": its mesh " + error.problem(), mend.substr(0, mend.size() - 1));
    }
  }

  Joint joint_of(const urdf::Joint& given) const {
    Joint joint;
    joint.name = given.name;
    joint.X_PJ = to_transform(given.parent_to_joint_origin_transform);
    switch (given.type) {
      case urdf::Joint::FIXED:
        return joint;
      case urdf::Joint::REVOLUTE:
      case urdf::Joint::CONTINUOUS:
        joint.kind = Joint::Kind::kRevolute;
        break;
      case urdf::Joint::PRISMATIC:
        joint.kind = Joint::Kind::kPrismatic;
        break;
      default:
        fail("joint '" + given.name + "' is neither fixed, revolute, continuous nor prismatic",
             "Replace it by joints of these kinds");
    }
    joint.axis_J = {given.axis.x, given.axis.y, given.axis.z};
    if (!(joint.axis_J.norm() > 1e-9) || !joint.axis_J.allFinite()) {
      fail("joint '" + given.name + "' has an axis without length", "Give a direction like 0 0 1");
    }
    joint.axis_J.normalize();
    if (given.limits) {
      if (given.type != urdf::Joint::CONTINUOUS) {
        joint.lower = given.limits->lower;
        joint.upper = given.limits->upper;
        if (!(joint.lower <= joint.upper)) {
          fail("joint '" + given.name + "' has a lower limit above the upper one",
               "Swap them, or mend them");
        }
        if (!(std::max(std::abs(joint.lower), std::abs(joint.upper)) <= kFarthest)) {
          fail("joint '" + given.name + "' has a limit that nothing reaches",
               "Give rad or m, or make it continuous");
        }
      }
      if (!(given.limits->velocity >= 0) || !(given.limits->effort >= 0)) {
        fail("joint '" + given.name + "' has a negative velocity or effort", "Give what it can do");
      }
      if (given.limits->velocity > 0) joint.max_velocity = given.limits->velocity;
      if (given.limits->effort > 0) joint.max_effort = given.limits->effort;
    }
    return joint;
  }

  void set_mimic(int index, const urdf::JointMimic& given) {
    const std::string& name = model_.joints[static_cast<std::size_t>(index)].name;
    const auto found = std::find_if(model_.joints.begin(), model_.joints.end(),
                                    [&](const Joint& j) { return j.name == given.joint_name; });
    if (found == model_.joints.end()) {
      std::vector<std::string> names;
      for (const Joint& joint : model_.joints) {
        if (joint.name != name) names.push_back(joint.name);
      }
      fail("joint '" + name + "' mimics '" + given.joint_name + "', which is not there",
           text::nearest_match_mend(given.joint_name, names));
    }
    if (given.multiplier == 0 || !std::isfinite(given.multiplier) || !std::isfinite(given.offset)) {
      fail("joint '" + name + "' mimics '" + given.joint_name +
               "' with a multiplier of 0 or no number",
           "Make it fixed, or give the ratio");
    }
    model_.joints[static_cast<std::size_t>(index)].mimic =
        Mimic{static_cast<int>(found - model_.joints.begin()), given.multiplier, given.offset};
  }

  void check_mimics() const {
    for (const Joint& joint : model_.joints) {
      const Joint* at = &joint;
      for (std::size_t steps = 0; at->mimic; ++steps) {
        if (steps > model_.joints.size()) {
          fail("joint '" + joint.name + "' mimics itself over others", "Break the circle");
        }
        at = &model_.joints[static_cast<std::size_t>(at->mimic->joint)];
      }
    }
  }

  const urdf::ModelInterface& document_;
  const std::string& file_;
  std::filesystem::path folder_;
  RobotModel model_;
  /// By file and scale: fingers share theirs.
  std::map<std::pair<std::filesystem::path, std::array<double, 3>>, SolidMesh> meshes_;
  std::vector<std::pair<int, const urdf::JointMimic*>> mimics_;
};

}  // namespace

geometry::RigidTransform Joint::pose_at(double position) const {
  geometry::RigidTransform X_PC = X_PJ;
  if (kind == Kind::kRevolute) {
    X_PC.rotate(Eigen::AngleAxisd(position, axis_J));
  } else if (kind == Kind::kPrismatic) {
    X_PC.translate(position * axis_J);
  }
  return X_PC;
}

int RobotModel::link_index(const std::string& link) const {
  return index_of(links, link, "link", name);
}

int RobotModel::joint_index(const std::string& joint) const {
  return index_of(joints, joint, "joint", name);
}

std::optional<int> RobotModel::joint_above(int link) const {
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (joints[i].child == link) return static_cast<int>(i);
  }
  return std::nullopt;
}

RobotModel read_urdf(const std::filesystem::path& file) {
  return Reader(*read_urdf_document(file), file.string(), file.parent_path()).read();
}

RobotModel parse_urdf(const std::string& text, const std::string& name,
                      const std::filesystem::path& folder) {
  return Reader(*parse_urdf_document(text, name), name, folder).read();
}

}  // namespace prehend::robot
