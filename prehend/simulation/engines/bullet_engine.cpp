// The plug-in for Bullet: sequential impulses.

#include <algorithm>
#include <array>
#include <memory>
#include <string>

#include <btBulletDynamicsCommon.h>
#include <Eigen/Geometry>

#include "prehend/simulation/engines/engine.h"
#include "prehend/simulation/engines/inertia.h"

namespace prehend::simulation::engines {
namespace {

constexpr std::size_t kBodyNumbers = 13 + 6;
constexpr double kHullMargin = 1e-4;  // m

// Debian's Bullet computes in single precision.
btScalar to_bullet(double value) { return static_cast<btScalar>(value); }
btVector3 to_bullet(const Eigen::Vector3d& v) {
  return {to_bullet(v.x()), to_bullet(v.y()), to_bullet(v.z())};
}
Eigen::Vector3d from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

btTransform to_bullet(const geometry::RigidTransform& X) {
  const Eigen::Quaterniond q(X.linear());
  return btTransform(
      btQuaternion(to_bullet(q.x()), to_bullet(q.y()), to_bullet(q.z()), to_bullet(q.w())),
      to_bullet(Eigen::Vector3d(X.translation())));
}

// Bullet multiplies the frictions of two bodies; here the smaller one counts.
btScalar smaller_friction(const btCollisionObject* a, const btCollisionObject* b) {
  return std::min(a->getFriction(), b->getFriction());
}

class BulletEngine : public Engine {
 public:
  BulletEngine() { gCalculateCombinedFrictionCallback = smaller_friction; }
  ~BulletEngine() override { clear(); }
  std::string name() const override { return "bullet"; }
  std::string version() const override { return std::to_string(btGetVersion()); }
  std::vector<std::string> solvers() const override { return {"sequential_impulse"}; }

  void load(const EngineScene& scene) override {
    refuse_pads_and_couplings(scene, "bullet");
    if (!scene.solver.empty() && scene.solver != solvers().front()) {
      throw UnsupportedScene("bullet: solver '" + scene.solver + "' is not sequential_impulse");
    }
    clear();
    scene_ = scene;
    world_ = std::make_unique<World>();
    world_->world.setGravity(to_bullet(scene.gravity));
    if (scene.ground) {
      EngineBody ground;
      ground.is_fixed = true;
      ground.friction = scene.ground_friction;
      ground_ = make_body(ground, std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), 0));
    }
    for (const EngineBody& body : scene.bodies) {
      bodies_.push_back(make_body(body, make_placed_shape(body)));
    }
    for (const EngineJoint& joint : scene.joints) add_joint(joint);
    forces_.assign(scene.joints.size(), 0.0);
    wrenches_.assign(scene.bodies.size(), Vector6::Zero());
  }

  void step() override {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      bodies_[i]->applyCentralForce(to_bullet(Eigen::Vector3d(wrenches_[i].head<3>())));
      bodies_[i]->applyTorque(to_bullet(Eigen::Vector3d(wrenches_[i].tail<3>())));
    }
    for (std::size_t j = 0; j < forces_.size(); ++j) push(scene_.joints[j], forces_[j]);
    world_->world.stepSimulation(to_bullet(scene_.step), 0);
  }

  void set_joint_force(int joint, double force) override { forces_.at(joint) = force; }
  void set_body_wrench(int body, const Vector6& wrench) override { wrenches_.at(body) = wrench; }

  BodyMotion body(int index) const override {
    const btRigidBody& body = *bodies_.at(index);
    const btTransform& X = body.getCenterOfMassTransform();
    const btQuaternion q = X.getRotation();
    BodyMotion motion;
    motion.X_WB = geometry::make_transform(Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()),
                                           from_bullet(X.getOrigin()));
    motion.velocity = from_bullet(body.getLinearVelocity());
    motion.angular_velocity = from_bullet(body.getAngularVelocity());
    return motion;
  }

  // From the bodies' poses: along or about the axis, which moves with the parent.
  double joint_position(int index) const override {
    const EngineJoint& joint = scene_.joints.at(index);
    const geometry::RigidTransform start = scene_.bodies[joint.body].X_WB;
    geometry::RigidTransform parent_motion = geometry::RigidTransform::Identity();
    if (joint.parent >= 0) {
      parent_motion = body(joint.parent).X_WB * scene_.bodies[joint.parent].X_WB.inverse();
    }
    const geometry::RigidTransform moved =
        parent_motion.inverse() * body(joint.body).X_WB * start.inverse();
    if (joint.kind == EngineJoint::Kind::kPrismatic) {
      return joint.axis_W.dot(moved * start.translation() - start.translation());
    }
    const Eigen::AngleAxisd turn(moved.linear());
    return turn.angle() * turn.axis().dot(joint.axis_W);
  }

  std::vector<double> save() const override {
    std::vector<double> state(forces_);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const BodyMotion motion = body(static_cast<int>(i));
      const Eigen::Quaterniond q(motion.X_WB.linear());
      const Eigen::Vector3d p = motion.X_WB.translation();
      state.insert(state.end(), p.data(), p.data() + 3);
      state.insert(state.end(), q.coeffs().data(), q.coeffs().data() + 4);
      state.insert(state.end(), motion.velocity.data(), motion.velocity.data() + 3);
      state.insert(state.end(), motion.angular_velocity.data(), motion.angular_velocity.data() + 3);
      state.insert(state.end(), wrenches_[i].data(), wrenches_[i].data() + 6);
    }
    return state;
  }

  // The impulses that Bullet keeps in its contacts from step to step are not in the state: a
  // restored run begins without them and differs a little from the one that went on.
  void restore(const std::vector<double>& state) override {
    if (state.size() != forces_.size() + kBodyNumbers * bodies_.size()) {
      throw std::invalid_argument("bullet: the saved state is of another scene");
    }
    const EngineScene scene = scene_;
    load(scene);
    const double* next = state.data();
    std::copy_n(next, forces_.size(), forces_.begin());
    next += forces_.size();
    for (std::size_t i = 0; i < bodies_.size(); ++i, next += kBodyNumbers) {
      const Eigen::Map<const Eigen::Vector3d> p(next), v(next + 7), w(next + 10);
      const btTransform X = to_bullet(
          geometry::make_transform(Eigen::Quaterniond(next[6], next[3], next[4], next[5]), p));
      bodies_[i]->setCenterOfMassTransform(X);
      bodies_[i]->setInterpolationWorldTransform(X);
      bodies_[i]->setLinearVelocity(to_bullet(Eigen::Vector3d(v)));
      bodies_[i]->setAngularVelocity(to_bullet(Eigen::Vector3d(w)));
      std::copy_n(next + 13, 6, wrenches_[i].data());
    }
  }

 private:
  struct World {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  };

  void clear() {
    if (!world_) return;
    for (auto& joint : joints_) world_->world.removeConstraint(joint.get());
    for (auto& body : bodies_) world_->world.removeRigidBody(body.get());
    if (ground_) world_->world.removeRigidBody(ground_.get());
    joints_.clear();
    bodies_.clear();
    ground_.reset();
    shapes_.clear();
    world_.reset();
  }

  // The shape in the body's frame: a compound where it is made of pieces or stands elsewhere.
  std::unique_ptr<btCollisionShape> make_placed_shape(const EngineBody& body) {
    const bool in_pieces = body.shape.kind == EngineShape::Kind::kConvexPieces;
    if (!in_pieces && body.X_BS.matrix().isIdentity(0)) return make_shape(body.shape);
    auto placed = std::make_unique<btCompoundShape>();
    const auto add = [&](std::unique_ptr<btCollisionShape> shape) {
      placed->addChildShape(to_bullet(body.X_BS), shape.get());
      shapes_.push_back(std::move(shape));
    };
    if (in_pieces) {
      for (const geometry::TriangleMesh& piece : *body.shape.pieces) add(make_hull(piece));
    } else {
      add(make_shape(body.shape));
    }
    return placed;
  }

  // Bullet's margin of 4 cm is made for metres. It lies round a hull, not within as a box's.
  static std::unique_ptr<btCollisionShape> make_hull(const geometry::TriangleMesh& piece) {
    auto hull = std::make_unique<btConvexHullShape>();
    for (const Eigen::Vector3d& p : piece.vertices) hull->addPoint(to_bullet(p), false);
    hull->recalcLocalAabb();
    hull->setMargin(to_bullet(kHullMargin));
    hull->initializePolyhedralFeatures();
    return hull;
  }

  static std::unique_ptr<btCollisionShape> make_shape(const EngineShape& shape) {
    switch (shape.kind) {
      case EngineShape::Kind::kBox: {
        auto box = std::make_unique<btBoxShape>(to_bullet(Eigen::Vector3d(0.5 * shape.size)));
        // Bullet's margin of 4 cm is made for metres.
        box->setMargin(to_bullet(0.01 * shape.size.minCoeff()));
        box->initializePolyhedralFeatures();  // so that it lies on hulls by more than a point
        return box;
      }
      case EngineShape::Kind::kSphere:
        return std::make_unique<btSphereShape>(to_bullet(shape.radius));
      case EngineShape::Kind::kCylinder:
        return std::make_unique<btCylinderShapeZ>(
            to_bullet(Eigen::Vector3d(shape.radius, shape.radius, 0.5 * shape.length)));
      case EngineShape::Kind::kCapsule:
        return std::make_unique<btCapsuleShapeZ>(to_bullet(shape.radius), to_bullet(shape.length));
      case EngineShape::Kind::kConvexPieces:
        break;  // make_placed_shape
    }
    throw UnsupportedScene("bullet: a shape of no kind");
  }

  std::unique_ptr<btRigidBody> make_body(const EngineBody& body,
                                         std::unique_ptr<btCollisionShape> shape) {
    const double mass = body.is_fixed ? 0.0 : body.mass;
    const Eigen::Vector3d inertia =
        body.is_fixed ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : principal_inertia(body);
    btRigidBody::btRigidBodyConstructionInfo info(to_bullet(mass), nullptr, shape.get(),
                                                  to_bullet(inertia));
    info.m_startWorldTransform = to_bullet(body.X_WB);
    info.m_friction = to_bullet(body.friction);
    auto made = std::make_unique<btRigidBody>(info);
    made->setActivationState(DISABLE_DEACTIVATION);
    if (!body.is_fixed) {
      made->setLinearVelocity(to_bullet(body.velocity));
      made->setAngularVelocity(to_bullet(body.angular_velocity));
    }
    const int group = btBroadphaseProxy::DefaultFilter;
    world_->world.addRigidBody(made.get(), group, body.collides ? group : 0);
    shapes_.push_back(std::move(shape));
    return made;
  }

  // Frames whose x (slider) or z (hinge) is the joint's axis.
  void add_joint(const EngineJoint& joint) {
    const bool slides = joint.kind == EngineJoint::Kind::kPrismatic;
    const geometry::RigidTransform& X_WB = scene_.bodies[joint.body].X_WB;
    geometry::RigidTransform X_WJ = geometry::RigidTransform::Identity();
    X_WJ.linear() = Eigen::Quaterniond::FromTwoVectors(
                        slides ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ(), joint.axis_W)
                        .toRotationMatrix();
    X_WJ.translation() = slides ? Eigen::Vector3d(X_WB.translation()) : joint.anchor_W;
    btRigidBody& parent =
        joint.parent < 0 ? btTypedConstraint::getFixedBody() : *bodies_[joint.parent];
    const btTransform in_parent =
        to_bullet(joint.parent < 0 ? X_WJ : scene_.bodies[joint.parent].X_WB.inverse() * X_WJ);
    const btTransform in_body = to_bullet(X_WB.inverse() * X_WJ);
    if (slides) {
      auto slider = std::make_unique<btSliderConstraint>(parent, *bodies_[joint.body], in_parent,
                                                         in_body, true);
      slider->setLowerLinLimit(1);  // lower above upper: free along the axis
      slider->setUpperLinLimit(-1);
      slider->setLowerAngLimit(0);
      slider->setUpperAngLimit(0);
      slider->setDampingDirLin(0);
      joints_.push_back(std::move(slider));
    } else {
      joints_.push_back(std::make_unique<btHingeConstraint>(parent, *bodies_[joint.body], in_parent,
                                                            in_body, true));
    }
    world_->world.addConstraint(joints_.back().get(), true);
  }

  void push(const EngineJoint& joint, double force) {
    Eigen::Vector3d axis = joint.axis_W;
    if (joint.parent >= 0) {
      axis = body(joint.parent).X_WB.linear() *
             (scene_.bodies[joint.parent].X_WB.linear().transpose() * axis);
    }
    const btVector3 along = to_bullet(Eigen::Vector3d(force * axis));
    btRigidBody* parent = joint.parent >= 0 ? bodies_[joint.parent].get() : nullptr;
    if (joint.kind == EngineJoint::Kind::kPrismatic) {
      bodies_[joint.body]->applyCentralForce(along);
      if (parent) parent->applyCentralForce(-along);
    } else {
      bodies_[joint.body]->applyTorque(along);
      if (parent) parent->applyTorque(-along);
    }
  }

  EngineScene scene_;
  std::unique_ptr<World> world_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::unique_ptr<btRigidBody> ground_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<std::unique_ptr<btTypedConstraint>> joints_;
  std::vector<double> forces_;
  std::vector<Vector6> wrenches_;
};

}  // namespace
}  // namespace prehend::simulation::engines

extern "C" {
int prehend_engine_interface() { return prehend::simulation::engines::kEngineInterface; }
prehend::simulation::engines::Engine* prehend_create_engine() {
  return new prehend::simulation::engines::BulletEngine();
}
}
