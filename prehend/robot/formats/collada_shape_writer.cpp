#include "prehend/robot/formats/collada_shape_writer.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <numbers>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

#include "prehend/robot/formats/collada_solid.h"
#include "prehend/robot/formats/shape_mesh.h"
#include "prehend/robot/formats/xml_text.h"

namespace prehend::robot::formats {
namespace {

using geometry::RigidTransform;

/// What OpenRAVE takes for no mass.
constexpr double kNoMass = 1e-9;  // kg

std::string float_text(double number) {
  std::array<char, 32> text{};
  const float rounded = static_cast<float>(number);
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), rounded == 0 ? 0 : rounded);
  return {text.data(), end.ptr};
}

std::string color_text(const std::array<double, 4>& color) {
  return fmt::format("{} {} {} {}", number_text(color[0]), number_text(color[1]),
                     number_text(color[2]), number_text(color[3]));
}

void write_accessor(const std::string& id, std::size_t count, ColladaText& text) {
  text.open("technique_common");
  text.open("accessor", xml_attribute("source", "#" + id + "_array") +
                            fmt::format(" count=\"{}\" stride=\"3\"", count));
  for (const char* name : {"X", "Y", "Z"}) {
    text.leaf("param", xml_attribute("name", name) + " type=\"float\"");
  }
  text.close();
  text.close();
}

/// A solid, or nothing of a mesh. @param is_body a body's is as thick along x as along y, which its
/// <radius> says; that of OpenRAVE's "geometry_info" is one number.
void write_solid(const Shape& shape, bool is_body, ColladaText& text) {
  const std::string radius = number_text(shape.radius);
  switch (shape.kind) {
    case Shape::Kind::kBox:
      text.open("box");
      text.leaf("half_extents", "", numbers_text(shape.size / 2));
      text.close();
      break;
    case Shape::Kind::kSphere:
      text.open("sphere");
      text.leaf("radius", "", radius);
      text.close();
      break;
    case Shape::Kind::kCylinder:
    case Shape::Kind::kCapsule:
      text.open(shape.kind == Shape::Kind::kCylinder ? "cylinder" : "capsule");
      text.leaf("height", "", number_text(shape.length));
      text.leaf("radius", "", is_body ? radius + " " + radius : radius);
      text.close();
      break;
    case Shape::Kind::kPlane:
      text.open("plane");
      text.leaf("equation", "", "0 0 1 0");
      text.close();
      break;
    case Shape::Kind::kMesh:
      break;
  }
}

/// What a mesh is, for those that know such solids.
void write_geometry_info(const Shape& shape, bool is_seen, ColladaText& text) {
  text.open("extra", " type=\"geometry_info\"");
  text.open("technique", " profile=\"OpenRAVE\"");
  write_solid(shape, false, text);
  text.open("visible");
  text.leaf("bool", "", is_seen ? "true" : "false");
  text.close();
  text.close();
  text.close();
}

}  // namespace

bool is_in_collada(const Shape& shape, bool is_seen) {
  if (shape.kind == Shape::Kind::kPlane) return !is_seen;
  if (shape.kind != Shape::Kind::kMesh) return has_inside(shape);
  constexpr double kMost = 1e30;  // m, within what floats are
  return shape.surface && !shape.surface->triangles.empty() &&
         std::all_of(shape.surface->vertices.begin(), shape.surface->vertices.end(),
                     [&](const Eigen::Vector3d& p) {
                       return p.cwiseProduct(shape.scale).cwiseAbs().maxCoeff() < kMost &&
                              p.cwiseProduct(shape.scale).allFinite();
                     });
}

bool is_heavy(const LinkDescription& link) {
  return link.inertial && link.inertial->mass > kNoMass;
}

ColladaShapeWriter::GeometryKey ColladaShapeWriter::key_of(const Shape& shape, bool is_seen) {
  const bool is_mesh = shape.kind == Shape::Kind::kMesh;
  const bool is_box = shape.kind == Shape::Kind::kBox;
  const bool is_round = !is_mesh && !is_box;
  const Eigen::Vector3d scale = is_mesh ? shape.scale : Eigen::Vector3d::Ones();
  const Eigen::Vector3d size = is_box ? shape.size : Eigen::Vector3d::Zero();
  const bool is_long = is_round && shape.kind != Shape::Kind::kSphere;
  return {static_cast<int>(shape.kind),
          is_mesh ? shape.surface.get() : nullptr,
          {scale.x(), scale.y(), scale.z()},
          {size.x(), size.y(), size.z()},
          is_round ? shape.radius : 0,
          is_long ? shape.length : 0,
          is_seen};
}

std::string ColladaShapeWriter::geometry(const Shape& shape, bool is_seen) {
  std::string& id = ids_[key_of(shape, is_seen)];
  if (id.empty()) {
    id = fmt::format("geometry{}", ids_.size() - 1);
    write_geometry(id, shape, is_seen);
  }
  return id;
}

void ColladaShapeWriter::write_geometry(const std::string& id, const Shape& shape, bool is_seen) {
  const geometry::TriangleMesh mesh = ShapeMeshes("").of(shape);
  ColladaText& text = geometries_;
  const std::string name = std::filesystem::path(shape.mesh).stem().string();
  text.open("geometry",
            xml_attribute("id", id) + (name.empty() ? "" : xml_attribute("name", name)));
  text.open("mesh");
  text.open("source", xml_attribute("id", id + "_positions"));
  std::string numbers;
  for (const Eigen::Vector3d& p : mesh.vertices) {
    for (int i = 0; i < 3; ++i) numbers += (numbers.empty() ? "" : " ") + float_text(p[i]);
  }
  text.leaf(
      "float_array",
      xml_attribute("id", id + "_array") + fmt::format(" count=\"{}\"", 3 * mesh.vertices.size()),
      numbers);
  write_accessor(id, mesh.vertices.size(), text);
  text.close();
  text.open("vertices", xml_attribute("id", id + "_vertices"));
  text.leaf("input", " semantic=\"POSITION\"" + xml_attribute("source", "#" + id + "_positions"));
  text.close();
  text.open("triangles", fmt::format(" count=\"{}\" material=\"surface\"", mesh.triangles.size()));
  text.leaf("input", " semantic=\"VERTEX\"" + xml_attribute("source", "#" + id + "_vertices") +
                         " offset=\"0\"");
  std::string corners;
  for (const Eigen::Vector3i& one : mesh.triangles) {
    corners += fmt::format("{}{} {} {}", corners.empty() ? "" : " ", one[0], one[1], one[2]);
  }
  text.leaf("p", "", corners);
  text.close();
  text.close();
  write_geometry_info(shape, is_seen, text);
  text.close();
}

std::string ColladaShapeWriter::material(const Shape& shape) {
  std::string& id = material_ids_[{shape.material, shape.color}];
  if (!id.empty()) return id;
  const std::size_t number = material_ids_.size() - 1;
  id = fmt::format("material{}", number);
  const std::string effect = fmt::format("effect{}", number);
  materials_.open("material", xml_attribute("id", id) + xml_attribute("name", shape.material));
  materials_.leaf("instance_effect", xml_attribute("url", "#" + effect));
  materials_.close();
  effects_.open("effect", xml_attribute("id", effect));
  effects_.open("profile_COMMON");
  effects_.open("technique", " sid=\"common\"");
  effects_.open("phong");
  if (shape.color) {
    effects_.open("diffuse");
    effects_.leaf("color", "", color_text(*shape.color));
    effects_.close();
    if ((*shape.color)[3] < 1) {
      effects_.open("transparent", " opaque=\"A_ONE\"");
      effects_.leaf("color", "", "1 1 1 " + number_text((*shape.color)[3]));
      effects_.close();
    }
  }
  for (int i = 0; i < 4; ++i) effects_.close();
  return id;
}

void ColladaShapeWriter::write_instance(const Shape& shape, const std::string& geometry,
                                        ColladaText& text) {
  std::string attributes = xml_attribute("url", "#" + geometry);
  if (!shape.name.empty()) attributes += xml_attribute("name", shape.name);
  if (!shape.color && shape.material.empty()) return text.leaf("instance_geometry", attributes);
  text.open("instance_geometry", attributes);
  text.open("bind_material");
  text.open("technique_common");
  text.leaf("instance_material",
            " symbol=\"surface\"" + xml_attribute("target", "#" + material(shape)));
  for (int i = 0; i < 3; ++i) text.close();
}

void ColladaShapeWriter::write_nodes(const LinkDescription& link, ColladaText& text) {
  const bool is_seen = std::any_of(link.visuals.begin(), link.visuals.end(),
                                   [](const Shape& one) { return is_in_collada(one, true); });
  std::map<std::string, const Shape*>& once = once_[link.name];
  for (const Shape& shape : is_seen ? link.visuals : link.collisions) {
    if (!is_in_collada(shape, true)) continue;
    const std::string id = geometry(shape, is_seen);
    const auto [known, is_new] = once.emplace(id, &shape);
    if (!is_new) known->second = nullptr;
    text.open("node");
    text.steps(shape.X_LS);
    write_instance(shape, id, text);
    text.close();
  }
}

void ColladaShapeWriter::write_touched_mesh(const LinkDescription& link, const Shape& shape,
                                            ColladaText& text) {
  // What is seen where it is touched is there once.
  const auto& once = once_[link.name];
  const auto seen = ids_.find(key_of(shape, true));
  const auto its = seen == ids_.end() ? once.end() : once.find(seen->second);
  const Shape* same = its == once.end() ? nullptr : its->second;
  const bool is_shared = same && same->X_LS.isApprox(shape.X_LS, 0) &&
                         (shape.name.empty() || shape.name == same->name) &&
                         (!shape.color || shape.color == same->color) &&
                         (shape.material.empty() || shape.material == same->material);
  if (is_shared) {
    text.leaf("instance_geometry", xml_attribute("url", "#" + its->first));
  } else {
    write_instance(shape, geometry(shape, false), text);
  }
}

void ColladaShapeWriter::write_shape(const LinkDescription& link, const Shape& shape,
                                     const RigidTransform& X_RL, ColladaText& text) {
  RigidTransform X = X_RL * shape.X_LS;
  // They stand along y there.
  if (shape.kind == Shape::Kind::kCylinder || shape.kind == Shape::Kind::kCapsule) {
    X.rotate(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX()));
  }
  text.open("shape");
  write_solid(shape, true, text);
  if (shape.kind == Shape::Kind::kMesh) write_touched_mesh(link, shape, text);
  text.steps(X);
  if (shape.kind != Shape::Kind::kMesh && !shape.name.empty()) {
    text.open("extra", " type=\"shape_info\"" + xml_attribute("name", shape.name));
    text.leaf("technique", " profile=\"prehend\"");
    text.close();
  }
  text.close();
}

void ColladaShapeWriter::write_bodies(const std::map<std::string, RigidTransform>& X_RL,
                                      ColladaText& text) {
  for (const LinkDescription& link : robot_.links) {
    const bool is_touched = std::any_of(link.collisions.begin(), link.collisions.end(),
                                        [](const Shape& one) { return is_in_collada(one, false); });
    if (!is_touched && !is_heavy(link)) continue;
    const std::string sid = fmt::format("rigid{}", bodies_.size());
    bodies_.emplace_back(link.name, sid);
    text.open("rigid_body", xml_attribute("sid", sid) + xml_attribute("name", link.name));
    text.open("technique_common");
    text.leaf("dynamic", "", "true");
    if (is_heavy(link)) {
      const Inertial& inertial = *link.inertial;
      RigidTransform X_LM = inertial.X_LI;
      Eigen::Vector3d principal = inertial.inertia.diagonal();
      if (!inertial.inertia.isDiagonal(0)) {
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertial.inertia);
        principal = solver.eigenvalues();
        Eigen::Matrix3d axes = solver.eigenvectors();
        if (axes.determinant() < 0) axes.col(0) *= -1;
        X_LM.linear() *= axes;
      }
      text.leaf("mass", "", number_text(inertial.mass));
      text.open("mass_frame");
      text.steps(X_RL.at(link.name) * X_LM);
      text.close();
      text.leaf("inertia", "", numbers_text(principal));
    }
    for (const Shape& shape : link.collisions) {
      if (is_in_collada(shape, false)) write_shape(link, shape, X_RL.at(link.name), text);
    }
    text.close();
    text.close();
  }
}

std::string ColladaShapeWriter::libraries() {
  std::string all;
  for (const auto& [name, library] : std::initializer_list<std::pair<const char*, ColladaText*>>{
           {"geometries", &geometries_}, {"effects", &effects_}, {"materials", &materials_}}) {
    const std::string lines = library->take();
    if (!lines.empty()) all += fmt::format(" <library_{0}>\n{1} </library_{0}>\n", name, lines);
  }
  return all;
}

}  // namespace prehend::robot::formats
