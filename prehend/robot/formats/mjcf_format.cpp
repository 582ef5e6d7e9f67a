// MJCF (mujoco.readthedocs.io, "XML reference"), read by MuJoCo's own compiler: includes, defaults
// and generated inertias are its.

#include "prehend/robot/formats/format_makers.h"

#ifdef PREHEND_HAS_MUJOCO

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <mujoco/mujoco.h>
#include <unistd.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/extension.h"
#include "prehend/robot/formats/file_text.h"
#include "prehend/robot/formats/mjcf_size.h"
#include "prehend/robot/formats/mjcf_writer.h"
#include "prehend/robot/formats/xml_text.h"

namespace prehend::robot::formats {
namespace {

using geometry::InputError;
using geometry::RigidTransform;
using Kind = JointDescription::Kind;
using Model = std::unique_ptr<mjModel, void (*)(mjModel*)>;

Eigen::Vector3d vector_at(const mjtNum* numbers) { return {numbers[0], numbers[1], numbers[2]}; }

RigidTransform pose_at(const mjtNum* place, const mjtNum* turn) {
  return geometry::make_transform(Eigen::Quaterniond(turn[0], turn[1], turn[2], turn[3]),
                                  vector_at(place));
}

class MjcfReader {
 public:
  MjcfReader(const mjModel& model, std::string file, LossReport& loss)
      : m_(model), file_(std::move(file)), loss_(loss) {}

  RobotDescription read(const std::string& name) {
    robot_.name = name;
    for (int body = 0; body < m_.nbody; ++body) read_body(body);
    for (int geom = 0; geom < m_.ngeom; ++geom) read_geom(geom);
    read_equalities();
    read_actuators();
    read_sensors();
    for (int i = 0; i < m_.nexclude; ++i) {
      // Two bodies' indices, counted from 1 before MuJoCo 3.
      constexpr int kFirst = mjVERSION_HEADER < 300 ? 1 : 0;
      const int pair = m_.exclude_signature[i];
      robot_.disabled_collisions.emplace_back(
          name_of(mjOBJ_BODY, ((pair >> 16) & 0xFFFF) - kFirst, "body"),
          name_of(mjOBJ_BODY, (pair & 0xFFFF) - kFirst, "body"));
    }
    drop_others();
    return std::move(robot_);
  }

 private:
  std::string name_of(int type, int index, const char* kind) const {
    const char* name = mj_id2name(&m_, type, index);
    return name && *name ? name : fmt::format("{}{}", kind, index);
  }

  void read_body(int body) {
    LinkDescription link;
    link.name = name_of(mjOBJ_BODY, body, "body");
    loss_.keep("body");
    if (m_.body_mass[body] > 0) {
      Inertial inertial;
      inertial.mass = m_.body_mass[body];
      inertial.X_LI = pose_at(m_.body_ipos + 3 * body, m_.body_iquat + 4 * body);
      inertial.inertia = vector_at(m_.body_inertia + 3 * body).asDiagonal();
      link.inertial = inertial;
    }
    robot_.links.push_back(std::move(link));
    link_of_body_.push_back(robot_.links.size() - 1);
    if (body == 0) return;
    std::string above = name_of(mjOBJ_BODY, m_.body_parentid[body], "body");
    RigidTransform X = pose_at(m_.body_pos + 3 * body, m_.body_quat + 4 * body);
    const int count = m_.body_jntnum[body], first = m_.body_jntadr[body];
    const std::string name = robot_.links.back().name;
    if (count == 0) {
      JointDescription joint;
      joint.name = name + "_fixed";
      joint.parent = above;
      joint.child = name;
      joint.X_PJ = X;
      robot_.joints.push_back(std::move(joint));
    }
    for (int i = 0; i < count; ++i) {
      JointDescription joint = read_joint(first + i);
      const RigidTransform at = geometry::make_transform(Eigen::Quaterniond::Identity(),
                                                         vector_at(m_.jnt_pos + 3 * (first + i)));
      joint.parent = above;
      joint.child = i + 1 == count ? name : fmt::format("{}_between{}", name, i);
      joint.X_PJ = X * at;
      joint.X_JC = at.inverse();
      X = RigidTransform::Identity();
      above = joint.child;
      if (i + 1 < count) robot_.links.push_back({joint.child, {}, {}, {}});
      robot_.joints.push_back(std::move(joint));
    }
  }

  JointDescription read_joint(int index) {
    loss_.keep("joint");
    JointDescription joint;
    joint.name = name_of(mjOBJ_JOINT, index, "joint");
    const std::map<int, Kind> kinds{{mjJNT_FREE, Kind::kFloating},
                                    {mjJNT_BALL, Kind::kBall},
                                    {mjJNT_SLIDE, Kind::kPrismatic},
                                    {mjJNT_HINGE, Kind::kRevolute}};
    joint.kind = kinds.at(m_.jnt_type[index]);
    joint.axis_J = vector_at(m_.jnt_axis + 3 * index);
    if (m_.jnt_limited[index]) {
      joint.lower = m_.jnt_range[2 * index];
      joint.upper = m_.jnt_range[2 * index + 1];
    }
    const int dof = m_.jnt_dofadr[index];
    joint.damping = m_.dof_damping[dof];
    joint.friction = m_.dof_frictionloss[dof];
    if (m_.jnt_stiffness[index] != 0) {
      joint.stiffness = m_.jnt_stiffness[index];
      joint.rest = m_.qpos_spring[m_.jnt_qposadr[index]];
    }
    if (m_.dof_armature[dof] != 0) {
      loss_.drop(file_ + ": joint '" + joint.name + "'", "joint/@armature",
                 "a rotor's inertia is not kept");
    }
    const double zero = m_.qpos0[m_.jnt_qposadr[index]];
    const bool moves = joint.kind == Kind::kRevolute || joint.kind == Kind::kPrismatic;
    if (moves && zero != 0) {
      loss_.approximate(file_ + ": joint '" + joint.name + "'", "joint/@ref",
                        "positions count from the file's pose");
      if (joint.lower) *joint.lower -= zero;
      if (joint.upper) *joint.upper -= zero;
    }
    return joint;
  }

  /// A mesh as the compiler has it: scaled, its centre of mass at the origin.
  std::shared_ptr<const geometry::TriangleMesh> surface_of(int mesh) {
    auto& known = surfaces_[mesh];
    if (known) return known;
    geometry::TriangleMesh surface;
    const float* vertices = m_.mesh_vert + 3 * m_.mesh_vertadr[mesh];
    for (int i = 0; i < m_.mesh_vertnum[mesh]; ++i) {
      surface.vertices.emplace_back(vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2]);
    }
    const int* faces = m_.mesh_face + 3 * m_.mesh_faceadr[mesh];
    for (int i = 0; i < m_.mesh_facenum[mesh]; ++i) {
      surface.triangles.emplace_back(faces[3 * i], faces[3 * i + 1], faces[3 * i + 2]);
    }
    known = std::make_shared<const geometry::TriangleMesh>(std::move(surface));
    return known;
  }

  void read_geom(int geom) {
    Shape shape;
    shape.name = mj_id2name(&m_, mjOBJ_GEOM, geom) ? mj_id2name(&m_, mjOBJ_GEOM, geom) : "";
    shape.X_LS = pose_at(m_.geom_pos + 3 * geom, m_.geom_quat + 4 * geom);
    const mjtNum* size = m_.geom_size + 3 * geom;
    const std::string link = name_of(mjOBJ_BODY, m_.geom_bodyid[geom], "body");
    const std::string place = file_ + ": geom of '" + link + "'";
    switch (m_.geom_type[geom]) {
      case mjGEOM_BOX:
        shape.kind = Shape::Kind::kBox;
        shape.size = 2 * vector_at(size);
        break;
      case mjGEOM_SPHERE:
        shape.kind = Shape::Kind::kSphere;
        shape.radius = size[0];
        break;
      case mjGEOM_CAPSULE:
      case mjGEOM_CYLINDER:
        shape.kind =
            m_.geom_type[geom] == mjGEOM_CAPSULE ? Shape::Kind::kCapsule : Shape::Kind::kCylinder;
        shape.radius = size[0];
        shape.length = 2 * size[1];
        break;
      case mjGEOM_PLANE:
        shape.kind = Shape::Kind::kPlane;
        break;
      case mjGEOM_MESH:
        shape.kind = Shape::Kind::kMesh;
        shape.mesh = name_of(mjOBJ_MESH, m_.geom_dataid[geom], "mesh");
        shape.surface = surface_of(m_.geom_dataid[geom]);
        loss_.approximate(place, "geom (mesh)",
                          "the surface that MuJoCo has made of it, round its own centre");
        break;
      case mjGEOM_ELLIPSOID:
        shape.kind = Shape::Kind::kSphere;
        shape.radius = vector_at(size).maxCoeff();
        loss_.approximate(place, "geom (ellipsoid)", "a ball of its longest radius");
        break;
      default:
        return loss_.drop(place, "geom", "height fields are not kept");
    }
    loss_.keep("geom");
    const float* rgba = m_.geom_rgba + 4 * geom;
    shape.color = {{rgba[0], rgba[1], rgba[2], rgba[3]}};
    if (m_.geom_matid[geom] >= 0) {
      shape.material = name_of(mjOBJ_MATERIAL, m_.geom_matid[geom], "material");
      const float* color = m_.mat_rgba + 4 * m_.geom_matid[geom];
      shape.color = {{color[0], color[1], color[2], color[3]}};
    }
    LinkDescription& one = robot_.links[link_of_body_[m_.geom_bodyid[geom]]];
    const bool collides = m_.geom_contype[geom] != 0 || m_.geom_conaffinity[geom] != 0;
    (collides ? one.collisions : one.visuals).push_back(std::move(shape));
  }

  void read_equalities() {
    for (int i = 0; i < m_.neq; ++i) {
      const std::string name = name_of(mjOBJ_EQUALITY, i, "equality");
      const mjtNum* data = m_.eq_data + mjNEQDATA * i;
      const std::string place = file_ + ": equality '" + name + "'";
      if (m_.eq_type[i] == mjEQ_JOINT && m_.eq_obj2id[i] >= 0) {
        const std::string follower = name_of(mjOBJ_JOINT, m_.eq_obj1id[i], "joint");
        for (JointDescription& joint : robot_.joints) {
          if (joint.name != follower) continue;
          constexpr int kCoefficients = 5;  // q - q0 of positions at 0, from which ours count, too
          Follows follows{name_of(mjOBJ_JOINT, m_.eq_obj2id[i], "joint"), data[1], data[0]};
          follows.coefficients.assign(data, data + kCoefficients);
          while (follows.coefficients.size() > 2 && follows.coefficients.back() == 0) {
            follows.coefficients.pop_back();
          }
          joint.follows = std::move(follows);
        }
        loss_.keep("equality/joint");
      } else if (m_.eq_type[i] == mjEQ_CONNECT || m_.eq_type[i] == mjEQ_WELD) {
        Loop loop;
        loop.name = name;
        loop.kind = m_.eq_type[i] == mjEQ_CONNECT ? Loop::Kind::kPoint : Loop::Kind::kWeld;
        loop.first = name_of(mjOBJ_BODY, m_.eq_obj1id[i], "body");
        loop.second = name_of(mjOBJ_BODY, m_.eq_obj2id[i], "body");
        if (m_.eq_type[i] == mjEQ_CONNECT) loop.X_FirstLoop.translation() = vector_at(data);
        robot_.loops.push_back(std::move(loop));
        loss_.keep("equality/loop");
      } else {
        loss_.drop(place, "equality", "couplings of tendons and distances are not kept");
      }
    }
  }

  void read_actuators() {
    for (int i = 0; i < m_.nu; ++i) {
      const std::string name = name_of(mjOBJ_ACTUATOR, i, "actuator");
      if (m_.actuator_trntype[i] != mjTRN_JOINT && m_.actuator_trntype[i] != mjTRN_JOINTINPARENT) {
        loss_.drop(file_ + ": actuator '" + name + "'", "actuator",
                   "what moves tendons, sites or bodies is not kept");
        continue;
      }
      loss_.keep("actuator");
      Actuator actuator;
      actuator.name = name;
      actuator.joint = name_of(mjOBJ_JOINT, m_.actuator_trnid[2 * i], "joint");
      actuator.gear = m_.actuator_gear[6 * i];
      if (m_.actuator_forcelimited[i]) actuator.effort = m_.actuator_forcerange[2 * i + 1];
      actuator.control = m_.actuator_biastype[i] == mjBIAS_AFFINE ? "position" : "effort";
      for (JointDescription& joint : robot_.joints) {
        if (joint.name == actuator.joint && actuator.effort && !joint.effort) {
          joint.effort = *actuator.effort * std::abs(actuator.gear);
        }
      }
      robot_.actuators.push_back(std::move(actuator));
    }
  }

  void read_sensors() {
    for (int i = 0; i < m_.nsensor; ++i) {
      const std::string name = name_of(mjOBJ_SENSOR, i, "sensor");
      const std::map<int, const char*> kinds{{mjSENS_TOUCH, "touch"},
                                             {mjSENS_FORCE, "force"},
                                             {mjSENS_TORQUE, "torque"},
                                             {mjSENS_ACCELEROMETER, "accelerometer"},
                                             {mjSENS_GYRO, "gyro"}};
      const auto kind = kinds.find(m_.sensor_type[i]);
      if (kind == kinds.end() || m_.sensor_objtype[i] != mjOBJ_SITE) {
        loss_.drop(file_ + ": sensor '" + name + "'", "sensor",
                   "those of joints, tendons and frames are not kept");
        continue;
      }
      const int site = m_.sensor_objid[i];
      loss_.keep("sensor");
      robot_.sensors.push_back({name, kind->second,
                                name_of(mjOBJ_BODY, m_.site_bodyid[site], "body"),
                                pose_at(m_.site_pos + 3 * site, m_.site_quat + 4 * site),
                                2 * vector_at(m_.site_size + 3 * site)});
      seen_sites_.insert(site);
    }
    for (int i = 0; i < m_.ncam; ++i) {
      loss_.keep("camera");
      robot_.sensors.push_back({name_of(mjOBJ_CAMERA, i, "camera"), "camera",
                                name_of(mjOBJ_BODY, m_.cam_bodyid[i], "body"),
                                pose_at(m_.cam_pos + 3 * i, m_.cam_quat + 4 * i),
                                Eigen::Vector3d::Zero()});
    }
  }

  void drop_others() {
    const std::array<std::tuple<const char*, int, const char*>, 6> others{
        {{"site", m_.nsite - static_cast<int>(seen_sites_.size()), "places without a sensor"},
         {"tendon", m_.ntendon, "tendons are not kept"},
         {"keyframe", m_.nkey, "postures are not kept"},
         {"light", m_.nlight, "lights are not the robot's"},
         {"texture", m_.ntex, "textures are not kept"},
         {"skin", m_.nskin, "skins are not kept"}}};
    for (const auto& [what, count, why] : others) {
      for (int i = 0; i < count; ++i) loss_.drop(file_, what, why);
    }
  }

  const mjModel& m_;
  std::map<int, std::shared_ptr<const geometry::TriangleMesh>> surfaces_;  // by mesh
  const std::string file_;
  LossReport& loss_;
  RobotDescription robot_;
  std::vector<std::size_t> link_of_body_;
  std::set<int> seen_sites_;
};

class Mjcf : public RobotFormat {
 public:
  std::string name() const override { return "mjcf"; }
  bool recognises(const XmlElement& root) const override { return root.name() == "mujoco"; }
  std::string ending() const override { return ".mjcf"; }
  RobotDescription read(const std::filesystem::path& file, LossReport& loss) const override {
    refuse_mjcf_bomb(file);
    std::array<char, 1000> error{};
    // Its warnings, as of nan, would go into a file in the working folder.
    void (*const warn)(const char*) = std::exchange(mju_user_warning, [](const char*) {});
    const Model model(mj_loadXML(file.string().c_str(), nullptr, error.data(), error.size()),
                      mj_deleteModel);
    mju_user_warning = warn;
    for (char& c : error) {
      if (c == '\n') c = ' ';
    }
    if (!model) {
      throw InputError(
          file.string() + ": MuJoCo " + mj_versionString() + " does not read it: " + error.data(),
          "Mend it, or take what this version does not know out of it");
    }
    if (error[0] != '\0') {
      loss.approximate(file.string(), "mujoco", std::string("MuJoCo says: ") + error.data());
    }
    if (model->nbody <= 1) {
      throw InputError(file.string() + " has no body but the world", "Name a file that has some");
    }
    RobotDescription robot = MjcfReader(*model, file.string(), loss).read(file.stem().string());
    tree_order(robot);
    const int block = mj_name2id(model.get(), mjOBJ_TEXT, kBlock);
    if (block >= 0) {
      apply_extension(model->text_data + model->text_adr[block], place_of_block(file), robot, loss);
    }
    return robot;
  }
  bool can_write() const override { return true; }
  TakenMeshes taken_meshes() const override { return TakenMeshes::kAll; }
  std::string write(const RobotDescription& robot, LossReport& loss) const override {
    LossReport written;
    std::string text = mjcf_text(robot, written);
    const std::string block = extension_text(
        robot, [&] { return read_again(robot); }, written, loss);
    if (!block.empty()) {
      text.insert(text.rfind("</mujoco>"),
                  fmt::format("  <custom>\n    <text name=\"{}\" data=\"{}\"/>\n  </custom>\n",
                              kBlock, escaped(on_one_line(block))));
    }
    return text;
  }

 private:
  static constexpr const char* kBlock = "prehend";

  /// With the line, where it is in this file and not in one that it includes.
  static std::string place_of_block(const std::filesystem::path& file) {
    const std::string text = whole_file(file);
    const std::size_t at = text.find(fmt::format("name=\"{}\"", kBlock));
    if (at == std::string::npos) return file.string();
    return fmt::format("{}:{}", file.string(),
                       1 + std::count(text.begin(), text.begin() + static_cast<long>(at), '\n'));
  }

  /// What is read of the robot's text; its meshes, which are not written yet, are as they are.
  static RobotDescription read_again(const RobotDescription& robot) {
    RobotDescription boxes = robot;
    for (LinkDescription& link : boxes.links) {
      for (auto* shapes : {&link.visuals, &link.collisions}) {
        for (Shape& shape : *shapes) {
          if (shape.kind != Shape::Kind::kMesh) continue;
          shape.kind = Shape::Kind::kBox;
          shape.size = Eigen::Vector3d::Ones();
        }
      }
    }
    LossReport unused;
    const std::string text = mjcf_text(boxes, unused);
    std::string file = (std::filesystem::temp_directory_path() / "prehend_XXXXXX").string();
    const int descriptor = ::mkstemp(file.data());
    if (descriptor < 0) {
      throw InputError("'" + file + "' cannot be written, from which MuJoCo reads the robot again",
                       "Make room in that folder");
    }
    ::close(descriptor);
    const std::unique_ptr<const std::string, void (*)(const std::string*)> removed(
        &file, [](const std::string* name) { std::filesystem::remove(*name); });
    std::ofstream(file) << text;
    std::array<char, 1000> error{};
    const Model model(mj_loadXML(file.c_str(), nullptr, error.data(), error.size()),
                      mj_deleteModel);
    if (!model) {
      throw InputError(fmt::format("MuJoCo {} does not read the robot again: {}",
                                   mj_versionString(), error.data()),
                       "Mend the robot");
    }
    RobotDescription plain = MjcfReader(*model, file, unused).read("");
    tree_order(plain);
    for (LinkDescription& link : plain.links) {
      const LinkDescription* its = robot.link(link.name);
      if (!its) continue;
      take_meshes(link.visuals, its->visuals);
      take_meshes(link.collisions, its->collisions);
    }
    return plain;
  }

  static void take_meshes(std::vector<Shape>& plain, const std::vector<Shape>& robot) {
    for (std::size_t i = 0; i < std::min(plain.size(), robot.size()); ++i) {
      if (robot[i].kind != Shape::Kind::kMesh) continue;
      const Shape read = plain[i];
      plain[i] = robot[i];
      plain[i].name = read.name;
      plain[i].material = read.material;
      plain[i].color = read.color;
    }
  }
};

}  // namespace

std::unique_ptr<RobotFormat> mjcf_format() { return std::make_unique<Mjcf>(); }

}  // namespace prehend::robot::formats

#else

namespace prehend::robot::formats {
std::unique_ptr<RobotFormat> mjcf_format() { return nullptr; }
}  // namespace prehend::robot::formats

#endif
