// The plug-in for MuJoCo. Solvers: `default`, and `noslip` with elliptic cones and post-processing
// of friction.
// A pad by PadMethod::kOwnContacts becomes one small ball for each texel, with MuJoCo's softness.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iomanip>
#include <sstream>
#include <stdexcept>

#include <mujoco/mujoco.h>
#include <Eigen/Geometry>

#include "prehend/simulation/engines/engine.h"
#include "prehend/simulation/engines/inertia.h"

namespace prehend::simulation::engines {
namespace {

std::string text(const Eigen::Vector3d& v) {
  std::ostringstream out;
  out << std::setprecision(17) << v.x() << ' ' << v.y() << ' ' << v.z();
  return out.str();
}

std::string pose(const geometry::RigidTransform& X) {
  const Eigen::Quaterniond q(X.linear());
  std::ostringstream out;
  out << std::setprecision(17) << "pos=\"" << text(X.translation()) << "\" quat=\"" << q.w() << ' '
      << q.x() << ' ' << q.y() << ' ' << q.z() << '"';
  return out.str();
}

std::string geometry_of(const EngineShape& shape) {
  std::ostringstream out;
  out << std::setprecision(17);
  switch (shape.kind) {
    case EngineShape::Kind::kBox:
      out << "type=\"box\" size=\"" << text(0.5 * shape.size) << '"';
      break;
    case EngineShape::Kind::kSphere:
      out << "type=\"sphere\" size=\"" << shape.radius << '"';
      break;
    case EngineShape::Kind::kCylinder:
      out << "type=\"cylinder\" size=\"" << shape.radius << ' ' << 0.5 * shape.length << '"';
      break;
    case EngineShape::Kind::kCapsule:
      out << "type=\"capsule\" size=\"" << shape.radius << ' ' << 0.5 * shape.length << '"';
      break;
    case EngineShape::Kind::kConvexPieces:
      break;  // one geom each, see write_geoms
  }
  return out.str();
}

class MujocoEngine : public Engine {
 public:
  ~MujocoEngine() override { clear(); }
  std::string name() const override { return "mujoco"; }
  std::string version() const override { return mj_versionString(); }
  std::vector<std::string> solvers() const override { return {"default", "noslip"}; }

  void load(const EngineScene& scene) override {
    if (scene.pad_method == PadMethod::kTexelLaw && !scene.pads.empty()) {
      throw UnsupportedScene("mujoco: has no pads of its own");
    }
    clear();
    scene_ = scene;
    const std::string xml = document();
    char error[1000] = "";
    // The virtual file system is large: not on the stack.
    const auto files = std::make_unique<mjVFS>();
    mj_defaultVFS(files.get());
    mj_makeEmptyFileVFS(files.get(), "scene.xml", static_cast<int>(xml.size()));
    std::memcpy(files->filedata[files->nfile - 1], xml.data(), xml.size());
    model_ = mj_loadXML("scene.xml", files.get(), error, sizeof error);
    mj_deleteVFS(files.get());
    if (!model_) throw UnsupportedScene("mujoco: " + std::string(error));
    data_ = mj_makeData(model_);
    set_start_velocities();
    mj_forward(model_, data_);
  }

  void step() override {
    mj_step(model_, data_);
    stale_ = true;
    for (const int full : {mjWARN_CONTACTFULL, mjWARN_CNSTRFULL}) {
      if (data_->warning[full].number == 0) continue;
      throw std::runtime_error(
          "mujoco: more than 2000 contacts or 8000 constraints, the rest would be ignored; take "
          "fewer bodies or coarser shapes, or another engine");
    }
  }

  void set_joint_force(int joint, double force) override {
    data_->qfrc_applied[model_->jnt_dofadr[joint_id(joint)]] = force;
  }

  void set_body_wrench(int body, const Vector6& wrench) override {
    std::copy(wrench.data(), wrench.data() + 6, data_->xfrc_applied + 6 * body_id(body));
  }

  BodyMotion body(int index) const override {
    refresh();
    const int id = body_id(index);
    BodyMotion motion;
    const mjtNum *p = data_->xpos + 3 * id, *q = data_->xquat + 4 * id;
    motion.X_WB =
        geometry::make_transform(Eigen::Quaterniond(q[0], q[1], q[2], q[3]), {p[0], p[1], p[2]});
    mjtNum velocity[6];
    mj_objectVelocity(model_, data_, mjOBJ_BODY, id, velocity, 0);
    motion.angular_velocity = {velocity[0], velocity[1], velocity[2]};
    motion.velocity = {velocity[3], velocity[4], velocity[5]};
    return motion;
  }

  double joint_position(int joint) const override {
    return data_->qpos[model_->jnt_qposadr[joint_id(joint)]];
  }

  std::vector<double> pad_forces(int pad) const override {
    std::vector<double> forces(scene_.pads.at(pad).layout.size(), 0.0);
    const int first = mj_name2id(model_, mjOBJ_GEOM, texel_name(pad, 0).c_str());
    for (int c = 0; c < data_->ncon; ++c) {
      const mjContact& contact = data_->contact[c];
      mjtNum force[6];
      mj_contactForce(model_, data_, c, force);
      for (const int geom : {contact.geom1, contact.geom2}) {
        const int texel = geom - first;
        if (texel >= 0 && texel < static_cast<int>(forces.size())) forces[texel] += force[0];
      }
    }
    return forces;
  }

  std::vector<double> save() const override {
    std::vector<double> state{data_->time};
    state.insert(state.end(), data_->qpos, data_->qpos + model_->nq);
    state.insert(state.end(), data_->qvel, data_->qvel + model_->nv);
    state.insert(state.end(), data_->qacc_warmstart, data_->qacc_warmstart + model_->nv);
    state.insert(state.end(), data_->qfrc_applied, data_->qfrc_applied + model_->nv);
    state.insert(state.end(), data_->xfrc_applied, data_->xfrc_applied + 6 * model_->nbody);
    return state;
  }

  void restore(const std::vector<double>& state) override {
    const int size = 1 + model_->nq + 3 * model_->nv + 6 * model_->nbody;
    if (state.size() != static_cast<std::size_t>(size)) {
      throw std::invalid_argument("mujoco: the saved state is of another scene");
    }
    auto next = state.begin();
    const auto take = [&](mjtNum* to, int count) {
      std::copy(next, next + count, to);
      next += count;
    };
    take(&data_->time, 1);
    take(data_->qpos, model_->nq);
    take(data_->qvel, model_->nv);
    take(data_->qacc_warmstart, model_->nv);
    take(data_->qfrc_applied, model_->nv);
    take(data_->xfrc_applied, 6 * model_->nbody);
    stale_ = true;
  }

 private:
  void clear() {
    if (data_) mj_deleteData(data_);
    if (model_) mj_deleteModel(model_);
    data_ = nullptr;
    model_ = nullptr;
  }

  static std::string texel_name(int pad, int texel) {
    return "pad" + std::to_string(pad) + "_" + std::to_string(texel);
  }
  static std::string body_name(int i) { return "body" + std::to_string(i); }
  int body_id(int i) const { return mj_name2id(model_, mjOBJ_BODY, body_name(i).c_str()); }
  int joint_id(int j) const {
    return mj_name2id(model_, mjOBJ_JOINT, ("joint" + std::to_string(j)).c_str());
  }

  const EngineJoint* joint_of(int body, int& index) const {
    for (std::size_t j = 0; j < scene_.joints.size(); ++j) {
      if (scene_.joints[j].body != body) continue;
      index = static_cast<int>(j);
      return &scene_.joints[j];
    }
    return nullptr;
  }

  bool has_pads(int body) const {
    return std::any_of(scene_.pads.begin(), scene_.pads.end(),
                       [&](const EnginePad& pad) { return pad.body == body; });
  }

  // Contacts are given pair by pair: MuJoCo would take the larger friction of two.
  std::string document() const {
    std::ostringstream xml;
    xml << std::setprecision(17);
    const std::string solver = scene_.solver.empty() ? "default" : scene_.solver;
    const auto known = solvers();
    if (std::find(known.begin(), known.end(), solver) == known.end()) {
      throw UnsupportedScene("mujoco: solver '" + solver + "' is none of default, noslip");
    }
    const bool in_pieces = std::any_of(
        scene_.bodies.begin(), scene_.bodies.end(),
        [](const EngineBody& body) { return body.shape.kind == EngineShape::Kind::kConvexPieces; });
    xml << "<mujoco><compiler angle=\"radian\" boundmass=\"0\" boundinertia=\"0\"/>"
        << "<size nconmax=\"2000\" njmax=\"8000\"/>"
        << "<option timestep=\"" << scene_.step << "\" gravity=\"" << text(scene_.gravity) << '"'
        << (solver == "noslip"
                ? " noslip_iterations=\"50\" noslip_tolerance=\"1e-12\" cone=\"elliptic\""
                : "")
        << '>' << (in_pieces ? "<flag multiccd=\"enable\"/>" : "")
        << "</option><default><geom contype=\"0\" conaffinity=\"0\"/></default><asset>";
    write_meshes(xml);
    xml << "</asset><worldbody>";
    if (scene_.ground) xml << "<geom name=\"ground\" type=\"plane\" size=\"1 1 1\"/>";
    write_children(-1, xml);
    xml << "</worldbody><contact>";
    write_pairs(xml);
    xml << "</contact><equality>";
    write_couplings(xml);
    xml << "</equality></mujoco>";
    return xml.str();
  }

  void write_children(int parent, std::ostringstream& xml) const {
    for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
      const int i = static_cast<int>(b);
      const EngineBody& body = scene_.bodies[b];
      int index = -1;
      const EngineJoint* joint = joint_of(i, index);
      if ((joint ? joint->parent : -1) != parent) continue;
      const geometry::RigidTransform X_PB =
          parent < 0 ? body.X_WB : scene_.bodies[parent].X_WB.inverse() * body.X_WB;
      xml << "<body name=\"" << body_name(i) << "\" " << pose(X_PB) << '>';
      if (joint) {
        const bool slides = joint->kind == EngineJoint::Kind::kPrismatic;
        xml << "<joint name=\"joint" << index << "\" type=\"" << (slides ? "slide" : "hinge")
            << "\" axis=\"" << text(body.X_WB.linear().transpose() * joint->axis_W) << "\" pos=\""
            << text(slides ? Eigen::Vector3d(Eigen::Vector3d::Zero())
                           : Eigen::Vector3d(body.X_WB.inverse() * joint->anchor_W))
            << "\"/>";
      } else if (!body.is_fixed) {
        xml << "<freejoint/>";
      }
      xml << "<inertial pos=\"0 0 0\" mass=\"" << body.mass << "\" diaginertia=\""
          << text(principal_inertia(body)) << "\"/>";
      write_geoms(i, xml);
      write_texels(i, xml);
      write_children(i, xml);
      xml << "</body>";
    }
  }

  // MuJoCo's constraints are springs: as stiff as they may be at this step.
  void write_couplings(std::ostringstream& xml) const {
    for (std::size_t j = 0; j < scene_.joints.size(); ++j) {
      const EngineJoint& joint = scene_.joints[j];
      if (joint.follows < 0) continue;
      xml << "<joint joint1=\"joint" << j << "\" joint2=\"joint" << joint.follows
          << "\" polycoef=\"0 " << joint.ratio << " 0 0 0\" solref=\"" << 2 * scene_.step
          << " 1\" solimp=\"0.9999 0.9999 0.001\"/>";
    }
  }

  // A body has one geom, or one for each of its pieces.
  int geom_count(int body) const {
    const EngineShape& shape = scene_.bodies[body].shape;
    return shape.pieces && shape.kind == EngineShape::Kind::kConvexPieces
               ? static_cast<int>(shape.pieces->size())
               : 1;
  }
  static std::string geom_name(int body, int piece) {
    return "geom" + std::to_string(body) + '_' + std::to_string(piece);
  }

  // MuJoCo's contacts of meshes are those of their hulls, which it makes of the vertices.
  void write_meshes(std::ostringstream& xml) const {
    for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
      const EngineShape& shape = scene_.bodies[b].shape;
      if (shape.kind != EngineShape::Kind::kConvexPieces) continue;
      for (std::size_t k = 0; k < shape.pieces->size(); ++k) {
        xml << "<mesh name=\"" << geom_name(static_cast<int>(b), static_cast<int>(k))
            << "\" vertex=\"";
        for (const Eigen::Vector3d& p : (*shape.pieces)[k].vertices) xml << text(p) << ' ';
        xml << "\"/>";
      }
    }
  }

  void write_geoms(int body, std::ostringstream& xml) const {
    const EngineBody& of = scene_.bodies[body];
    for (int k = 0; k < geom_count(body); ++k) {
      const std::string name = geom_name(body, k);
      xml << "<geom name=\"" << name << "\" " << pose(of.X_BS) << ' ';
      if (of.shape.kind == EngineShape::Kind::kConvexPieces) {
        xml << "type=\"mesh\" mesh=\"" << name << '"';
      } else {
        xml << geometry_of(of.shape);
      }
      xml << "/>";
    }
  }

  void write_texels(int body, std::ostringstream& xml) const {
    for (std::size_t p = 0; p < scene_.pads.size(); ++p) {
      const EnginePad& pad = scene_.pads[p];
      if (pad.body != body) continue;
      const contact::PadLayout& layout = pad.layout;
      const double radius = 0.4 * std::sqrt(layout.area() / static_cast<double>(layout.cells()));
      for (std::size_t t = 0; t < layout.size(); ++t) {
        const Eigen::Vector3d p_P = layout.position(t) - radius * layout.normal(t);
        xml << "<geom name=\"" << texel_name(static_cast<int>(p), static_cast<int>(t))
            << "\" type=\"sphere\" size=\"" << radius << "\" mass=\"0\" pos=\""
            << text(pad.X_BP * p_P) << "\"/>";
      }
    }
  }

  void write_pair(const std::string& a, const std::string& b, double friction,
                  std::ostringstream& xml) const {
    xml << "<pair geom1=\"" << a << "\" geom2=\"" << b << "\" condim=\"4\" friction=\"" << friction
        << ' ' << friction << " 0.005 0.0001 0.0001\"/>";
  }

  void write_pairs(std::ostringstream& xml) const {
    const int count = static_cast<int>(scene_.bodies.size());
    const auto moves = [&](int i) {
      int joint = -1;
      return !scene_.bodies[i].is_fixed || joint_of(i, joint);
    };
    const auto passes = [&](int i) { return !scene_.bodies[i].collides; };
    for (int a = 0; a < count; ++a) {
      if (passes(a)) continue;
      if (scene_.ground && moves(a) && !has_pads(a)) {
        for (int k = 0; k < geom_count(a); ++k) {
          write_pair("ground", geom_name(a, k),
                     std::min(scene_.ground_friction, scene_.bodies[a].friction), xml);
        }
      }
      for (int b = a + 1; b < count; ++b) {
        int joint = -1;
        const EngineJoint* to_parent = joint_of(b, joint);
        if (passes(b)) continue;
        if ((!moves(a) && !moves(b)) || (to_parent && to_parent->parent == a)) continue;
        if (has_pads(a) && has_pads(b)) continue;
        const double friction = std::min(scene_.bodies[a].friction, scene_.bodies[b].friction);
        const int padded = has_pads(a) ? a : has_pads(b) ? b : -1;
        if (padded < 0) {
          for (int k = 0; k < geom_count(a); ++k) {
            for (int l = 0; l < geom_count(b); ++l) {
              write_pair(geom_name(a, k), geom_name(b, l), friction, xml);
            }
          }
        } else {
          write_pad_pairs(padded, padded == a ? b : a, friction, xml);
        }
      }
    }
  }

  void write_pad_pairs(int padded, int other, double friction, std::ostringstream& xml) const {
    for (std::size_t p = 0; p < scene_.pads.size(); ++p) {
      if (scene_.pads[p].body != padded) continue;
      const contact::PadLayout& layout = scene_.pads[p].layout;
      for (std::size_t t = 0; t < layout.size(); ++t) {
        if (layout.area(t) == 0) continue;
        for (int k = 0; k < geom_count(other); ++k) {
          write_pair(geom_name(other, k), texel_name(static_cast<int>(p), static_cast<int>(t)),
                     friction, xml);
        }
      }
    }
  }

  void set_start_velocities() {
    for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
      const int i = static_cast<int>(b);
      const EngineBody& body = scene_.bodies[b];
      int joint = -1;
      if (const EngineJoint* j = joint_of(i, joint)) {
        const double rate = j->kind == EngineJoint::Kind::kPrismatic
                                ? j->axis_W.dot(body.velocity)
                                : j->axis_W.dot(body.angular_velocity);
        data_->qvel[model_->jnt_dofadr[joint_id(joint)]] = rate;
      } else if (!body.is_fixed) {
        // A free joint turns in body coordinates.
        const Eigen::Vector3d w_B = body.X_WB.linear().transpose() * body.angular_velocity;
        mjtNum* qvel = data_->qvel + model_->body_dofadr[body_id(i)];
        std::copy(body.velocity.data(), body.velocity.data() + 3, qvel);
        std::copy(w_B.data(), w_B.data() + 3, qvel + 3);
      }
    }
  }

  // Positions of bodies are those of the step's start until they are asked for.
  void refresh() const {
    if (!stale_) return;
    mj_kinematics(model_, data_);
    mj_comPos(model_, data_);
    mj_comVel(model_, data_);
    stale_ = false;
  }

  EngineScene scene_;
  mjModel* model_ = nullptr;
  mjData* data_ = nullptr;
  mutable bool stale_ = false;
};

// MuJoCo's own writes a file into whatever folder the program runs in. What matters is refused in
// step().
void keep_no_log(const char* /*warning*/) {}

}  // namespace
}  // namespace prehend::simulation::engines

extern "C" {
int prehend_engine_interface() { return prehend::simulation::engines::kEngineInterface; }
prehend::simulation::engines::Engine* prehend_create_engine() {
  mju_user_warning = prehend::simulation::engines::keep_no_log;
  return new prehend::simulation::engines::MujocoEngine();
}
}
