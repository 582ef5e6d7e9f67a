#include "prehend/report/robot_figure.h"

#include <cmath>

#include "prehend/report/figure_data.h"
#include "prehend/text/json.h"
#include "prehend/text/require.h"

namespace prehend::report {
namespace {

using text::Json;

constexpr const char* kKindWords[] = {"fixed", "revolute", "prismatic", "other"};

Json numbers(std::initializer_list<double> values) {
  Json list = Json::array();
  for (const double value : values) list.add(value);
  return list;
}

Json pose_json(const geometry::RigidTransform& X) {
  const Eigen::Quaterniond q(X.linear());
  const Eigen::Vector3d p = X.translation();
  return numbers({p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()});
}

Json limit_json(const std::optional<double>& limit) { return limit ? Json(*limit) : Json::null(); }

// Each link hangs on one joint at most, and none on itself by any way.
void check_tree(const RobotFigure& figure) {
  const text::Require require{"RobotFigure: "};
  const std::size_t none = figure.links.size();
  std::vector<std::size_t> parent(none, none);
  for (const RobotFigure::Joint& joint : figure.joints) {
    const std::string name = "joint '" + joint.name + "': ";
    require(joint.parent < none && joint.child < none, name + "there is no such link");
    require(parent[joint.child] == none, name + "its child hangs on two joints");
    parent[joint.child] = joint.parent;
  }
  for (std::size_t link = 0; link < none; ++link) {
    std::size_t steps = 0;
    for (std::size_t at = link; parent[at] != none; at = parent[at]) {
      require(++steps <= none, "link '" + figure.links[link].name + "': it hangs on itself");
    }
  }
}

void check(const RobotFigure& figure) {
  const text::Require require{"RobotFigure: "};
  require(!figure.links.empty(), "there must be links");
  check_tree(figure);
  for (const RobotFigure::Joint& joint : figure.joints) {
    const std::string name = "joint '" + joint.name + "': ";
    require(joint.X_PJ.matrix().allFinite() && joint.X_JC.matrix().allFinite() &&
                joint.axis_J.allFinite() && std::isfinite(joint.start) &&
                std::isfinite(joint.lower.value_or(0)) && std::isfinite(joint.upper.value_or(0)),
            name + "it is not finite");
    require(!joint.leader || *joint.leader < figure.joints.size(), name + "there is no leader");
    for (const double c : joint.coefficients) require(std::isfinite(c), name + "it is not finite");
  }
  for (const RobotFigure::Shape& shape : figure.shapes) {
    require(shape.link < figure.links.size() && shape.mesh < figure.meshes.size(),
            "a shape has no link or mesh");
    require(shape.opacity > 0 && shape.opacity <= 1, "opacity must be above 0, at most 1");
    require(shape.X_LS.matrix().allFinite(), "a shape's pose is not finite");
  }
  for (const RobotFigure::Posture& posture : figure.postures) {
    for (const auto& [joint, position] : posture.positions) {
      require(joint < figure.joints.size() && std::isfinite(position),
              "posture '" + posture.name + "': there is no such joint or position");
    }
  }
}

Json joint_json(const RobotFigure::Joint& joint) {
  Json one = Json::object();
  one.set("name", joint.name);
  one.set("kind", kKindWords[static_cast<int>(joint.kind)]);
  one.set("parent", joint.parent);
  one.set("child", joint.child);
  one.set("pose", pose_json(joint.X_PJ));
  one.set("child_pose", pose_json(joint.X_JC));
  one.set("axis", numbers({joint.axis_J.x(), joint.axis_J.y(), joint.axis_J.z()}));
  one.set("lower", limit_json(joint.lower));
  one.set("upper", limit_json(joint.upper));
  one.set("start", joint.start);
  one.set("leader", joint.leader ? Json(*joint.leader) : Json::null());
  Json coefficients = Json::array();
  for (const double c : joint.coefficients) coefficients.add(c);
  one.set("coefficients", coefficients);
  one.set("words", joint.words);
  return one;
}

Json shape_json(const RobotFigure::Shape& shape) {
  Json one = Json::object();
  one.set("link", shape.link);
  one.set("mesh", shape.mesh);
  one.set("layer", shape.layer);
  one.set("color", color_text(shape.color));
  one.set("opacity", shape.opacity);
  one.set("pose", pose_json(shape.X_LS));
  return one;
}

Json posture_json(const RobotFigure::Posture& posture) {
  Json positions = Json::array();
  for (const auto& [joint, position] : posture.positions) {
    positions.add(numbers({static_cast<double>(joint), position}));
  }
  Json one = Json::object();
  one.set("name", posture.name);
  one.set("positions", positions);
  return one;
}

}  // namespace

std::string robot_figure_json(const RobotFigure& figure) {
  check(figure);
  Json links = Json::array(), joints = Json::array(), meshes = Json::array(),
       shapes = Json::array(), postures = Json::array();
  for (const RobotFigure::Link& link : figure.links) {
    Json one = Json::object();
    one.set("name", link.name);
    one.set("words", link.words);
    links.add(one);
  }
  for (const auto& joint : figure.joints) joints.add(joint_json(joint));
  for (const geometry::TriangleMesh& mesh : figure.meshes) {
    Json one = Json::object();
    set_mesh(one, mesh, "RobotFigure: ");
    meshes.add(one);
  }
  for (const auto& shape : figure.shapes) shapes.add(shape_json(shape));
  for (const auto& posture : figure.postures) postures.add(posture_json(posture));
  Json all = Json::object();
  all.set("links", links);
  all.set("joints", joints);
  all.set("meshes", meshes);
  all.set("shapes", shapes);
  all.set("postures", postures);
  return for_script(all);
}

}  // namespace prehend::report
