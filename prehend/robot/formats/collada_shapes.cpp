#include "prehend/robot/formats/collada_shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/collada_elements.h"
#include "prehend/robot/formats/collada_solid.h"

namespace prehend::robot::formats {
namespace {

using geometry::RigidTransform;
using geometry::TriangleMesh;

constexpr std::size_t kMostNodes = 100000;
constexpr std::size_t kMostBakedPoints = 10000000;

std::vector<std::string> split_path(const std::string& path) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    if (end > begin && path.substr(begin, end - begin) != ".") {
      parts.push_back(path.substr(begin, end - begin));
    }
    begin = end + 1;
  }
  return parts;
}

bool is_step(const std::string& name) {
  static const std::set<std::string> kSteps{"lookat", "matrix", "rotate",
                                            "scale",  "skew",   "translate"};
  return kSteps.count(name) != 0;
}

bool is_rigid(const Eigen::Matrix3d& M) {
  constexpr double kRounded = 1e-5;  // numbers in files have few digits
  return M.determinant() > 0 &&
         (M.transpose() * M - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kRounded;
}

RigidTransform rigid(const Eigen::Affine3d& X) {
  return geometry::make_transform(Eigen::Quaterniond(X.linear()).normalized(), X.translation());
}

}  // namespace

std::string ColladaShapes::link_of_node(const std::string& id) const {
  const auto found = links_of_nodes_.find(id);
  return found == links_of_nodes_.end() ? std::string() : found->second;
}

std::map<std::string, std::string> ColladaShapes::read_parameters(const XmlElement& root) const {
  std::map<std::string, std::string> references;
  const auto read = [&](const XmlElement& instance) {
    know_names(instance);
    for (const XmlElement& one : instance.children("newparam")) {
      const std::string sid = one.attribute("sid").value_or("");
      if (const auto target = one.child("SIDREF")) {
        references[sid] = target->text();
      } else if (number_in(one).value_or(0) != 0) {
        one.drop("where joints stand in the scene");
      }
    }
    for (const XmlElement& one : instance.children("bind")) {
      const std::string symbol = one.attribute("symbol").value_or("");
      if (const auto param = one.child("param")) {
        references[symbol] = param->attribute("ref").value_or(param->text());
      } else if (const auto target = one.child("SIDREF")) {
        references[symbol] = target->text();
      } else {
        one.drop("where joints stand in the scene");
      }
    }
  };
  for (const XmlElement& library : root.children("library_kinematics_scenes")) {
    for (const XmlElement& scene : library.children("kinematics_scene")) {
      know_names(scene);
      for (const char* kind : {"instance_articulated_system", "instance_kinematics_model"}) {
        for (const XmlElement& one : scene.children(kind)) read(one);
      }
    }
  }
  for (const XmlElement& library : root.children("library_articulated_systems")) {
    for (const XmlElement& system : library.children("articulated_system")) {
      know_names(system);
      for (const char* part : {"kinematics", "motion"}) {
        const auto holder = system.child(part);
        if (!holder) continue;
        for (const char* kind : {"instance_articulated_system", "instance_kinematics_model"}) {
          for (const XmlElement& one : holder->children(kind)) read(one);
        }
      }
    }
  }
  return references;
}

void ColladaShapes::read_bindings(const ColladaLinks& links) {
  const XmlElement root = document_.root();
  const auto references = read_parameters(root);
  const auto scene = root.child("scene");
  const auto instance = scene ? scene->child("instance_kinematics_scene") : std::nullopt;
  if (!instance) return;
  know_names(*instance);
  for (const XmlElement& one : instance->children("bind_kinematics_model")) {
    std::string node = one.attribute("node").value_or("");
    if (node.starts_with("#")) node.erase(0, 1);
    one.child("param");
    refuse_many_links(roots_.size() + 1, one.place());
    if (!split_path(node).empty()) roots_.push_back({split_path(node), links.root});
  }
  for (const XmlElement& one : instance->children("bind_joint_axis")) {
    const auto axis = one.child("axis");
    // By a parameter: where that says other than 0, that is told there.
    if (const auto value = one.child("value"); value && !value->child("param")) {
      value->drop("where joints stand in the scene");
    }
    const auto path = split_path(one.attribute("target").value_or(""));
    if (!axis || path.empty()) continue;
    std::optional<XmlElement> word = axis->child("param");
    if (!word) word = axis->child("SIDREF");
    std::string name = word ? word->text() : axis->text();
    // A parameter refers to one of the system below, that at last to the axis.
    constexpr int kMostSteps = 16;
    for (int step = 0; step < kMostSteps; ++step) {
      const auto found = references.find(part_of(name, 0));
      if (found == references.end() || found->second == name) break;
      name = found->second;
    }
    const std::string link = links.moved_by(name);
    if (link.empty()) {
      one.drop("its joint '" + name + "' is not there");
      continue;
    }
    refuse_many_links(axes_.size() + 1, one.place());
    axes_.push_back({path, link});
    bound_links_.insert(link);
  }
}

std::optional<XmlElement> ColladaShapes::shown_scene() {
  const XmlElement root = document_.root();
  if (const auto scene = root.child("scene")) {
    if (const auto instance = scene->child("instance_visual_scene")) {
      if (auto shown = document_.by_url(instance->attribute("url").value_or(""))) return shown;
    }
  }
  const auto library = root.child("library_visual_scenes");
  return library ? library->child("visual_scene") : std::nullopt;
}

const ColladaShapes::Binding* ColladaShapes::bound(const std::vector<Binding>& bindings,
                                                   const std::vector<std::string>& labels,
                                                   const std::string& label) const {
  for (const Binding& one : bindings) {
    if (one.path.back() != label) continue;
    const bool is_below =
        std::all_of(one.path.begin(), one.path.end() - 1, [&](const std::string& part) {
          return std::find(labels.begin(), labels.end(), part) != labels.end();
        });
    if (is_below) return &one;
  }
  return nullptr;
}

void ColladaShapes::move(const XmlElement& step, Eigen::Affine3d& X) const {
  const std::string kind = step.name();
  if (kind == "translate") {
    const auto n = step.text_numbers(3);
    X.translate(length_ * Eigen::Vector3d(n[0], n[1], n[2]));
  } else if (kind == "rotate") {
    const auto n = step.text_numbers(4);
    const Eigen::Vector3d axis(n[0], n[1], n[2]);
    if (axis.norm() > 1e-9) {
      X.rotate(Eigen::AngleAxisd(std::numbers::pi / 180 * n[3], axis.normalized()));
    }
  } else if (kind == "scale") {
    const auto n = step.text_numbers(3);
    X.scale(Eigen::Vector3d(n[0], n[1], n[2]));
  } else if (kind == "matrix") {
    const auto n = step.text_numbers(16);
    Eigen::Affine3d given = Eigen::Affine3d::Identity();
    given.linear() << n[0], n[1], n[2], n[4], n[5], n[6], n[8], n[9], n[10];
    given.translation() = length_ * Eigen::Vector3d(n[3], n[7], n[11]);
    X = X * given;
  } else if (kind == "lookat" || kind == "skew") {
    step.drop("such a step is not read");
  }
}

void ColladaShapes::visit(const XmlElement& node, Place place, int depth,
                          const ColladaLinks& links) {
  constexpr int kDeepest = 200;
  if (depth > kDeepest) node.fail("nodes are in a ring, or too deep in one another", "Mend it");
  if (++nodes_ > kMostNodes) {
    node.fail(fmt::format("the scene has more than {} nodes", kMostNodes), "Leave some away");
  }
  for (const char* label : {"id", "sid"}) {
    if (const auto word = node.attribute(label)) place.own_labels.push_back(*word);
  }
  place.labels.insert(place.labels.end(), place.own_labels.begin(), place.own_labels.end());
  bool is_tied = false;
  for (const std::string& label : std::exchange(place.own_labels, {})) {
    const Binding* root = bound(roots_, place.labels, label);
    if (!root) continue;
    place.link = root->link;
    is_tied = true;
  }
  for (const XmlElement& one : node.children()) {
    if (one.name() == "node" || one.name().starts_with("instance_")) continue;
    if (!is_step(one.name())) {
      one.drop("it is of its writer's own");
      continue;
    }
    const auto sid = one.attribute("sid");
    const Binding* axis = sid ? bound(axes_, place.labels, *sid) : nullptr;
    if (axis) {  // as at 0; the last is the nearest, where all joints above are written out
      place.link = axis->link;
      is_tied = true;
    } else {
      move(one, place.X_S);
    }
  }
  const std::string name = node.attribute("name").value_or("");
  if (!is_tied && links.X_RL.count(name) != 0 && bound_links_.count(name) == 0) {
    place.link = name;
    is_tied = true;
  }
  if (is_tied) X_SN_.emplace(place.link, place.X_S);
  if (const auto id = node.attribute("id")) links_of_nodes_[*id] = place.link;
  for (const XmlElement& one : node.children("instance_geometry")) {
    instances_.push_back({one, place.link, place.X_S});
  }
  for (const char* other : {"instance_controller", "instance_camera", "instance_light"}) {
    for (const XmlElement& one : node.children(other)) one.drop("only geometry is read of a node");
  }
  for (const XmlElement& one : node.children("node")) visit(one, place, depth + 1, links);
  for (const XmlElement& one : node.children("instance_node")) {
    const std::string url = one.attribute("url").value_or("");
    one.attribute("name");
    const auto target = document_.by_url(url);
    if (!target) {
      if (!url.starts_with("#")) {
        one.drop("it is in another document");
        continue;
      }
      one.fail("node '" + url + "' is not there", "Mend its url");
    }
    Place inside = place;
    if (const auto sid = one.attribute("sid")) inside.own_labels.push_back(*sid);
    visit(*target, inside, depth + 1, links);
  }
}

void ColladaShapes::read_visuals(const ColladaLinks& links, RobotDescription& robot) {
  read_bindings(links);
  const auto scene = shown_scene();
  if (!scene) return;
  scene->attribute("name");
  for (const XmlElement& node : scene->children("node")) visit(node, {}, 0, links);
  // Where the root is in the scene, by the root's node or else by any other's.
  auto anchor = X_SN_.find(links.root);
  if (anchor == X_SN_.end()) anchor = X_SN_.begin();
  Eigen::Affine3d X_SR = Eigen::Affine3d::Identity();
  if (anchor != X_SN_.end()) {
    X_SR = rigid(anchor->second) * links.X_RL.at(anchor->first).inverse();
  }
  for (const Instance& one : instances_) {
    if (one.link.empty()) {
      one.element.drop("its node is of no link");
      continue;
    }
    const Eigen::Affine3d X_LG =
        Eigen::Affine3d(links.X_RL.at(one.link).inverse()) * X_SR.inverse() * one.X_SG;
    const std::vector<Shape> shapes = shapes_of(one.element, X_LG, one.link);
    placed_[{one.link, one.element.attribute("url").value_or("")}].push_back(shapes);
    for (const Shape& shape : shapes) {
      for (LinkDescription& link : robot.links) {
        if (link.name != one.link) continue;
        if (geometries_.of(one.element).is_seen) link.visuals.push_back(shape);
        // As OpenRAVE has it: what is seen of a link is touched, too.
        link.collisions.push_back(shape);
      }
    }
  }
}

std::vector<Shape> ColladaShapes::read_body(const XmlElement& technique, const RigidTransform& X_LR,
                                            const std::string& link) {
  std::vector<Shape> shapes;
  for (const XmlElement& element : technique.children("shape")) {
    const RigidTransform X_LS = X_LR * collada_steps(element, length_);
    for (const char* other : {"mass", "density", "hollow", "physics_material"}) {
      if (const auto one = element.child(other)) one->drop("the body's own are read");
    }
    if (const auto instance = element.child("instance_geometry")) {
      const auto seen = placed_.find({link, instance->attribute("url").value_or("")});
      if (seen != placed_.end() && !seen->second.empty()) {
        const std::vector<Shape>& its = seen->second.front();
        shapes.insert(shapes.end(), its.begin(), its.end());
        seen->second.erase(seen->second.begin());
        continue;
      }
      for (Shape& one : shapes_of(*instance, X_LS, link)) shapes.push_back(std::move(one));
      continue;
    }
    auto shape = collada_solid(element, length_);
    if (!shape) {
      element.drop("it is none of a mesh, box, sphere, cylinder, capsule, plane");
      continue;
    }
    // It stands along y there.
    if (shape->kind == Shape::Kind::kCylinder || shape->kind == Shape::Kind::kCapsule) {
      shape->X_LS.rotate(Eigen::AngleAxisd(-std::numbers::pi / 2, Eigen::Vector3d::UnitX()));
    }
    shape->X_LS = X_LR * shape->X_LS;
    for (const XmlElement& extra : element.children("extra")) {
      const bool is_named = extra.attribute("type").value_or("") == "shape_info";
      const auto own = extra.child("technique");
      if (is_named && own && own->attribute("profile").value_or("") == "prehend") {
        shape->name = extra.attribute("name").value_or("");
      } else {
        extra.drop("it is of its writer's own");
      }
    }
    shapes.push_back(std::move(*shape));
  }
  return shapes;
}

std::vector<Shape> ColladaShapes::shapes_of(const XmlElement& instance, const Eigen::Affine3d& X_LG,
                                            const std::string& link) {
  ColladaGeometries::Geometry& its = geometries_.of(instance);
  std::vector<Shape> shapes;
  const std::string own_name = instance.attribute("name").value_or("");
  const auto materials = materials_.bound_by(instance);
  for (ColladaGeometries::Part& part : its.parts) {
    Shape shape;
    shape.name = own_name;
    shape.kind = Shape::Kind::kMesh;
    shape.surface = part.surface;
    if (its.primitive && is_rigid(X_LG.linear())) {
      shape = *its.primitive;
      shape.name = own_name;
      shape.X_LS = rigid(X_LG) * shape.X_LS;
    } else if (is_rigid(X_LG.linear())) {
      if (part.name.empty()) part.name = fmt::format("{}_{}", link, counts_[link]++);
      shape.mesh = part.name;
      shape.X_LS = rigid(X_LG);
    } else {
      TriangleMesh turned = *part.surface;
      baked_points_ += turned.vertices.size();
      if (baked_points_ > kMostBakedPoints) {
        instance.fail("meshes that are scaled by their nodes have more than ten million points",
                      "Scale fewer of them");
      }
      for (Eigen::Vector3d& p : turned.vertices) p = X_LG * p;
      if (X_LG.linear().determinant() < 0) {
        for (Eigen::Vector3i& triangle : turned.triangles) std::swap(triangle[1], triangle[2]);
      }
      shape.surface = std::make_shared<const TriangleMesh>(std::move(turned));
      shape.mesh = fmt::format("{}_{}", link, counts_[link]++);
    }
    const auto material = materials.find(part.symbol);
    if (material != materials.end()) {
      shape.color = materials_.color(material->second);
      shape.material = material->second.attribute("name").value_or(
          material->second.attribute("id").value_or(""));
    }
    shapes.push_back(std::move(shape));
  }
  return shapes;
}

}  // namespace prehend::robot::formats
