// The plug-in for the Open Dynamics Engine. Solvers: `quickstep` (iterative) and `step` (direct).

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <vector>

#include <ode/ode.h>
#include <Eigen/Geometry>

#include "prehend/simulation/engines/engine.h"
#include "prehend/simulation/engines/inertia.h"

namespace prehend::simulation::engines {
namespace {

constexpr int kMostContacts = 16;        // of a pair of primitives
constexpr int kMostPieceContacts = 512;  // of a pair with a piece, of which kMostContacts are kept
constexpr std::size_t kBodyNumbers = 13 + 6;
constexpr std::size_t kGround = static_cast<std::size_t>(-1);

class OdeEngine : public Engine {
 public:
  OdeEngine() {
    // Once for all engines; never closed, since that would end the others too.
    static const bool initialised = dInitODE2(0) != 0;
    if (!initialised) throw UnsupportedScene("ode: could not be initialised");
  }
  ~OdeEngine() override { clear(); }
  std::string name() const override { return "ode"; }
  std::string version() const override { return dGetConfiguration(); }
  std::vector<std::string> solvers() const override { return {"quickstep", "step"}; }

  void load(const EngineScene& scene) override {
    refuse_pads_and_couplings(scene, "ode");
    direct_ = scene.solver == "step";
    if (!scene.solver.empty() && !direct_ && scene.solver != "quickstep") {
      throw UnsupportedScene("ode: solver '" + scene.solver + "' is none of quickstep, step");
    }
    clear();
    scene_ = scene;
    dRandSetSeed(0);  // of the iterative solver's order
    world_ = dWorldCreate();
    space_ = dSimpleSpaceCreate(nullptr);
    contacts_ = dJointGroupCreate(0);
    dWorldSetGravity(world_, scene.gravity.x(), scene.gravity.y(), scene.gravity.z());
    dWorldSetAutoDisableFlag(world_, 0);
    if (scene.ground) {
      dGeomSetData(dCreatePlane(space_, 0, 0, 1, 0), reinterpret_cast<void*>(kGround));
    }
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) add_body(i);
    for (std::size_t j = 0; j < scene.joints.size(); ++j) add_joint(scene.joints[j]);
    forces_.assign(scene.joints.size(), 0.0);
    wrenches_.assign(scene.bodies.size(), Vector6::Zero());
  }

  void step() override {
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      if (scene_.joints[j].kind == EngineJoint::Kind::kPrismatic) {
        dJointAddSliderForce(joints_[j], forces_[j]);
      } else {
        dJointAddHingeTorque(joints_[j], forces_[j]);
      }
    }
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (!bodies_[i]) continue;
      const Vector6& w = wrenches_[i];
      dBodyAddForce(bodies_[i], w[0], w[1], w[2]);
      dBodyAddTorque(bodies_[i], w[3], w[4], w[5]);
    }
    dSpaceCollide(space_, this, [](void* self, dGeomID a, dGeomID b) {
      static_cast<OdeEngine*>(self)->touch(a, b);
    });
    if (direct_) {
      dWorldStep(world_, scene_.step);
    } else {
      dWorldQuickStep(world_, scene_.step);
    }
    dJointGroupEmpty(contacts_);
  }

  void set_joint_force(int joint, double force) override { forces_.at(joint) = force; }
  void set_body_wrench(int body, const Vector6& wrench) override { wrenches_.at(body) = wrench; }

  BodyMotion body(int index) const override {
    BodyMotion motion;
    const dBodyID body = bodies_.at(index);
    if (!body) {
      motion.X_WB = scene_.bodies[index].X_WB;
      return motion;
    }
    const dReal *p = dBodyGetPosition(body), *q = dBodyGetQuaternion(body);
    const dReal *v = dBodyGetLinearVel(body), *w = dBodyGetAngularVel(body);
    motion.X_WB =
        geometry::make_transform(Eigen::Quaterniond(q[0], q[1], q[2], q[3]), {p[0], p[1], p[2]});
    motion.velocity = {v[0], v[1], v[2]};
    motion.angular_velocity = {w[0], w[1], w[2]};
    return motion;
  }

  double joint_position(int joint) const override {
    return scene_.joints.at(joint).kind == EngineJoint::Kind::kPrismatic
               ? dJointGetSliderPosition(joints_[joint])
               : dJointGetHingeAngle(joints_[joint]);
  }

  std::vector<double> save() const override {
    std::vector<double> state(forces_);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      std::array<double, kBodyNumbers> numbers{};
      if (bodies_[i]) {
        std::copy_n(dBodyGetPosition(bodies_[i]), 3, numbers.begin());
        std::copy_n(dBodyGetQuaternion(bodies_[i]), 4, numbers.begin() + 3);
        std::copy_n(dBodyGetLinearVel(bodies_[i]), 3, numbers.begin() + 7);
        std::copy_n(dBodyGetAngularVel(bodies_[i]), 3, numbers.begin() + 10);
      }
      std::copy_n(wrenches_[i].data(), 6, numbers.begin() + 13);
      state.insert(state.end(), numbers.begin(), numbers.end());
    }
    state.push_back(static_cast<double>(dRandGetSeed()));
    return state;
  }

  void restore(const std::vector<double>& state) override {
    if (state.size() != forces_.size() + kBodyNumbers * bodies_.size() + 1) {
      throw std::invalid_argument("ode: the saved state is of another scene");
    }
    const double* next = state.data();
    std::copy_n(next, forces_.size(), forces_.begin());
    next += forces_.size();
    for (std::size_t i = 0; i < bodies_.size(); ++i, next += kBodyNumbers) {
      std::copy_n(next + 13, 6, wrenches_[i].data());
      if (!bodies_[i]) continue;
      const dQuaternion q{next[3], next[4], next[5], next[6]};
      dBodySetPosition(bodies_[i], next[0], next[1], next[2]);
      dBodySetQuaternion(bodies_[i], q);
      dBodySetLinearVel(bodies_[i], next[7], next[8], next[9]);
      dBodySetAngularVel(bodies_[i], next[10], next[11], next[12]);
    }
    dRandSetSeed(static_cast<unsigned long>(*next));
  }

 private:
  void clear() {
    if (!world_) return;
    dJointGroupDestroy(contacts_);
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
    world_ = nullptr;
    bodies_.clear();
    joints_.clear();
    for (const dTriMeshDataID mesh : meshes_) dGeomTriMeshDataDestroy(mesh);
    meshes_.clear();
    corners_.clear();
  }

  std::vector<dGeomID> make_geoms(const EngineShape& shape) {
    switch (shape.kind) {
      case EngineShape::Kind::kBox:
        return {dCreateBox(space_, shape.size.x(), shape.size.y(), shape.size.z())};
      case EngineShape::Kind::kSphere:
        return {dCreateSphere(space_, shape.radius)};
      case EngineShape::Kind::kCylinder:
        return {dCreateCylinder(space_, shape.radius, shape.length)};
      case EngineShape::Kind::kCapsule:
        return {dCreateCapsule(space_, shape.radius, shape.length)};
      case EngineShape::Kind::kConvexPieces:
        break;
    }
    if (!dCheckConfiguration("ODE_EXT_trimesh")) {
      throw UnsupportedScene("ode: is built without triangle meshes, which pieces need");
    }
    // As triangles: ODE's convex solids meet no cylinders, and one another but badly.
    std::vector<dGeomID> geoms;
    for (const geometry::TriangleMesh& piece : *shape.pieces) {
      Corners& corners = *corners_.emplace_back(std::make_unique<Corners>());
      for (const Eigen::Vector3d& p : piece.vertices) {
        corners.vertices.insert(corners.vertices.end(), p.data(), p.data() + 3);
      }
      for (const Eigen::Vector3i& t : piece.triangles) {
        for (const int index : t) corners.triangles.push_back(static_cast<dTriIndex>(index));
      }
      meshes_.push_back(dGeomTriMeshDataCreate());
      dGeomTriMeshDataBuildDouble(meshes_.back(), corners.vertices.data(), 3 * sizeof(double),
                                  static_cast<int>(piece.vertices.size()), corners.triangles.data(),
                                  static_cast<int>(corners.triangles.size()),
                                  3 * sizeof(dTriIndex));
      geoms.push_back(dCreateTriMesh(space_, meshes_.back(), nullptr, nullptr, nullptr));
    }
    return geoms;
  }

  void add_body(std::size_t i) {
    const EngineBody& body = scene_.bodies[i];
    const Eigen::Quaterniond q(body.X_WB.linear());
    const dQuaternion quaternion{q.w(), q.x(), q.y(), q.z()};
    const Eigen::Vector3d p = body.X_WB.translation();
    dBodyID id = nullptr;
    if (!body.is_fixed) {
      id = dBodyCreate(world_);
      const Eigen::Vector3d inertia = principal_inertia(body);
      dMass mass;
      dMassSetParameters(&mass, body.mass, 0, 0, 0, inertia.x(), inertia.y(), inertia.z(), 0, 0, 0);
      dBodySetMass(id, &mass);
      dBodySetLinearVel(id, body.velocity.x(), body.velocity.y(), body.velocity.z());
      dBodySetAngularVel(id, body.angular_velocity.x(), body.angular_velocity.y(),
                         body.angular_velocity.z());
    }
    if (id) {
      dBodySetPosition(id, p.x(), p.y(), p.z());
      dBodySetQuaternion(id, quaternion);
    }
    for (const dGeomID geom : make_geoms(body.shape)) {
      dGeomSetData(geom, reinterpret_cast<void*>(i));
      if (id) {
        dGeomSetBody(geom, id);
        place(geom, body.X_BS, dGeomSetOffsetPosition, dGeomSetOffsetQuaternion);
      } else {
        place(geom, body.X_WB * body.X_BS, dGeomSetPosition, dGeomSetQuaternion);
      }
      if (!body.collides) dGeomDisable(geom);
    }
    bodies_.push_back(id);
  }

  template <class SetPosition, class SetQuaternion>
  static void place(dGeomID geom, const geometry::RigidTransform& X, SetPosition set_position,
                    SetQuaternion set_quaternion) {
    const Eigen::Quaterniond q(X.linear());
    const dQuaternion quaternion{q.w(), q.x(), q.y(), q.z()};
    set_position(geom, X.translation().x(), X.translation().y(), X.translation().z());
    set_quaternion(geom, quaternion);
  }

  void add_joint(const EngineJoint& joint) {
    const dBodyID parent = joint.parent < 0 ? nullptr : bodies_[joint.parent];
    const bool slides = joint.kind == EngineJoint::Kind::kPrismatic;
    const dJointID id =
        slides ? dJointCreateSlider(world_, nullptr) : dJointCreateHinge(world_, nullptr);
    dJointAttach(id, bodies_[joint.body], parent);
    const Eigen::Vector3d &a = joint.axis_W, &p = joint.anchor_W;
    if (slides) {
      dJointSetSliderAxis(id, a.x(), a.y(), a.z());
    } else {
      dJointSetHingeAnchor(id, p.x(), p.y(), p.z());
      dJointSetHingeAxis(id, a.x(), a.y(), a.z());
    }
    joints_.push_back(id);
  }

  double friction_of(dGeomID geom) const {
    const auto index = reinterpret_cast<std::size_t>(dGeomGetData(geom));
    return index == kGround ? scene_.ground_friction : scene_.bodies[index].friction;
  }

  // Also a body and its fixed parent, which ODE knows as the world.
  bool are_joined(dGeomID a, dGeomID b) const {
    const auto i = reinterpret_cast<std::size_t>(dGeomGetData(a));
    const auto j = reinterpret_cast<std::size_t>(dGeomGetData(b));
    if (i == kGround || j == kGround) return false;
    const int first = static_cast<int>(std::min(i, j)), second = static_cast<int>(std::max(i, j));
    return std::any_of(scene_.joints.begin(), scene_.joints.end(), [&](const EngineJoint& joint) {
      return joint.body == second && joint.parent == first;
    });
  }

  void touch(dGeomID a, dGeomID b) {
    const dBodyID body_a = dGeomGetBody(a), body_b = dGeomGetBody(b);
    if (!body_a && !body_b) return;
    if (dGeomGetData(a) == dGeomGetData(b)) return;  // pieces of one body
    if (are_joined(a, b)) return;
    const bool in_pieces = dGeomGetClass(a) == dTriMeshClass || dGeomGetClass(b) == dTriMeshClass;
    found_.resize(in_pieces ? kMostPieceContacts : kMostContacts);
    int count =
        dCollide(a, b, static_cast<int>(found_.size()), found_.data(), sizeof(dContactGeom));
    if (count > kMostContacts) {
      keep_apart(count);
      count = kMostContacts;
    }
    for (int i = 0; i < count; ++i) {
      dContact contact{};
      contact.geom = found_[i];
      contact.surface.mode = dContactApprox1;
      contact.surface.mu = std::min(friction_of(a), friction_of(b));
      dJointAttach(dJointCreateContact(world_, contacts_, &contact), body_a, body_b);
    }
  }

  // Puts first the deepest of the found contacts and those farthest from what stands there already.
  void keep_apart(int count) {
    const auto p = [&](int i) { return Eigen::Map<const Eigen::Vector3d>(found_[i].pos); };
    const auto deeper = [](const dContactGeom& a, const dContactGeom& b) {
      return a.depth < b.depth;
    };
    std::iter_swap(found_.begin(),
                   std::max_element(found_.begin(), found_.begin() + count, deeper));
    std::vector<double> distance(count, std::numeric_limits<double>::infinity());
    for (int kept = 1; kept < kMostContacts; ++kept) {
      int farthest = kept;
      for (int i = kept; i < count; ++i) {
        distance[i] = std::min(distance[i], (p(i) - p(kept - 1)).squaredNorm());
        if (distance[i] > distance[farthest]) farthest = i;
      }
      std::swap(found_[kept], found_[farthest]);
      std::swap(distance[kept], distance[farthest]);
    }
  }

  // What a mesh of triangles keeps pointing at.
  struct Corners {
    std::vector<double> vertices;
    std::vector<dTriIndex> triangles;
  };

  EngineScene scene_;
  bool direct_ = false;
  dWorldID world_ = nullptr;
  dSpaceID space_ = nullptr;
  dJointGroupID contacts_ = nullptr;
  std::vector<dBodyID> bodies_;  // null: fixed
  std::vector<dJointID> joints_;
  std::vector<dTriMeshDataID> meshes_;
  std::vector<std::unique_ptr<Corners>> corners_;
  std::vector<dContactGeom> found_;  // of the pair that is looked at
  std::vector<double> forces_;
  std::vector<Vector6> wrenches_;
};

}  // namespace
}  // namespace prehend::simulation::engines

extern "C" {
int prehend_engine_interface() { return prehend::simulation::engines::kEngineInterface; }
prehend::simulation::engines::Engine* prehend_create_engine() {
  return new prehend::simulation::engines::OdeEngine();
}
}
