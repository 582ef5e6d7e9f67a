// The plug-in for DART: generalised coordinates, contacts as a boxed linear complementarity
// problem. Solvers: `dantzig` (direct pivoting) and `pgs` (projected Gauss-Seidel). Contacts are
// found by DART's adaptor to ODE's collision library, the one that knows all shapes.

#include <algorithm>
#include <iomanip>
#include <memory>
#include <sstream>
#include <string>

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <dart/collision/ode/OdeCollisionDetector.hpp>
#include <dart/config.hpp>
#include <dart/constraint/BoxedLcpConstraintSolver.hpp>
#include <dart/constraint/DantzigBoxedLcpSolver.hpp>
#include <dart/constraint/PgsBoxedLcpSolver.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/CapsuleShape.hpp>
#include <dart/dynamics/CylinderShape.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/MeshShape.hpp>
#include <dart/dynamics/PlaneShape.hpp>
#include <dart/dynamics/PrismaticJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/SphereShape.hpp>
#include <dart/dynamics/WeldJoint.hpp>
#include <dart/simulation/World.hpp>

#include "prehend/simulation/engines/engine.h"
#include "prehend/simulation/engines/inertia.h"

namespace prehend::simulation::engines {
namespace {

namespace dynamics = dart::dynamics;

// The piece as DART wants it, by way of text; ODE meets it as triangles.
dynamics::ShapePtr mesh_shape(const geometry::TriangleMesh& piece) {
  std::ostringstream text;
  text << std::setprecision(9);  // single precision on the other side
  for (const Eigen::Vector3d& p : piece.vertices) {
    text << "v " << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
  }
  for (const Eigen::Vector3i& t : piece.triangles) {
    text << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  }
  const std::string bytes = text.str();
  const aiScene* scene =
      aiImportFileFromMemory(bytes.data(), static_cast<unsigned>(bytes.size()),
                             aiProcess_JoinIdenticalVertices | aiProcess_GenSmoothNormals, "obj");
  if (!scene) throw UnsupportedScene(std::string("dart: ") + aiGetErrorString());
  return std::make_shared<dynamics::MeshShape>(Eigen::Vector3d::Ones(), scene);  // releases it
}

dynamics::ShapePtr shape_of(const EngineShape& shape) {
  switch (shape.kind) {
    case EngineShape::Kind::kBox:
      return std::make_shared<dynamics::BoxShape>(shape.size);
    case EngineShape::Kind::kSphere:
      return std::make_shared<dynamics::SphereShape>(shape.radius);
    case EngineShape::Kind::kCylinder:
      return std::make_shared<dynamics::CylinderShape>(shape.radius, shape.length);
    case EngineShape::Kind::kCapsule:
      return std::make_shared<dynamics::CapsuleShape>(shape.radius, shape.length);
    case EngineShape::Kind::kConvexPieces:
      break;  // mesh_shape
  }
  throw UnsupportedScene("dart: a shape of no kind");
}

class DartEngine : public Engine {
 public:
  std::string name() const override { return "dart"; }
  std::string version() const override { return DART_VERSION; }
  std::vector<std::string> solvers() const override { return {"dantzig", "pgs"}; }

  void load(const EngineScene& scene) override {
    refuse_pads_and_couplings(scene, "dart");
    scene_ = scene;
    world_ = dart::simulation::World::create();
    world_->setTimeStep(scene.step);
    world_->setGravity(scene.gravity);
    set_solver();
    nodes_.assign(scene.bodies.size(), nullptr);
    joints_.assign(scene.joints.size(), nullptr);
    if (scene.ground) add_ground();
    // Whole trees go into the world at once; parents stand before their children.
    std::vector<dynamics::SkeletonPtr> trees;
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
      const EngineJoint* joint = joint_of(static_cast<int>(b));
      dynamics::BodyNode* parent = joint && joint->parent >= 0 ? nodes_[joint->parent] : nullptr;
      dynamics::SkeletonPtr tree = parent ? parent->getSkeleton() : dynamics::Skeleton::create();
      if (!parent) {
        tree->setName("tree " + std::to_string(b));
        tree->enableSelfCollisionCheck();
        tree->disableAdjacentBodyCheck();
        trees.push_back(tree);
      }
      add_body(static_cast<int>(b), joint, parent, tree);
    }
    for (const auto& tree : trees) world_->addSkeleton(tree);
    forces_.assign(scene.joints.size(), 0.0);
    wrenches_.assign(scene.bodies.size(), Vector6::Zero());
  }

  void step() override {
    for (std::size_t j = 0; j < joints_.size(); ++j) joints_[j]->setCommand(0, forces_[j]);
    for (std::size_t b = 0; b < nodes_.size(); ++b) {
      nodes_[b]->setExtForce(wrenches_[b].head<3>());
      nodes_[b]->setExtTorque(wrenches_[b].tail<3>());
    }
    world_->step();
  }

  void set_joint_force(int joint, double force) override { forces_.at(joint) = force; }
  void set_body_wrench(int body, const Vector6& wrench) override { wrenches_.at(body) = wrench; }

  BodyMotion body(int index) const override {
    const dynamics::BodyNode& node = *nodes_.at(index);
    BodyMotion motion;
    motion.X_WB.matrix() = node.getWorldTransform().matrix();
    motion.velocity = node.getLinearVelocity();
    motion.angular_velocity = node.getAngularVelocity();
    return motion;
  }

  double joint_position(int joint) const override { return joints_.at(joint)->getPosition(0); }

  std::vector<double> save() const override {
    std::vector<double> state(forces_);
    for (const Vector6& wrench : wrenches_) {
      state.insert(state.end(), wrench.data(), wrench.data() + 6);
    }
    for (std::size_t i = 0; i < world_->getNumSkeletons(); ++i) {
      const dynamics::SkeletonPtr tree = world_->getSkeleton(i);
      for (const Eigen::VectorXd& values : {tree->getPositions(), tree->getVelocities()}) {
        state.insert(state.end(), values.data(), values.data() + values.size());
      }
    }
    return state;
  }

  void restore(const std::vector<double>& state) override {
    if (state.size() != save().size()) {
      throw std::invalid_argument("dart: the saved state is of another scene");
    }
    // A solver begins from what it found last: a new one begins as the saved run's first step did.
    set_solver();
    const double* next = state.data();
    std::copy_n(next, forces_.size(), forces_.begin());
    next += forces_.size();
    for (Vector6& wrench : wrenches_) {
      std::copy_n(next, 6, wrench.data());
      next += 6;
    }
    for (std::size_t i = 0; i < world_->getNumSkeletons(); ++i) {
      const dynamics::SkeletonPtr tree = world_->getSkeleton(i);
      const auto size = static_cast<Eigen::Index>(tree->getNumDofs());
      tree->setPositions(Eigen::Map<const Eigen::VectorXd>(next, size));
      tree->setVelocities(Eigen::Map<const Eigen::VectorXd>(next + size, size));
      next += 2 * size;
    }
  }

 private:
  void set_solver() {
    using namespace dart::constraint;
    BoxedLcpSolverPtr solver;
    if (scene_.solver.empty() || scene_.solver == "dantzig") {
      solver = std::make_shared<DantzigBoxedLcpSolver>();
    } else if (scene_.solver == "pgs") {
      solver = std::make_shared<PgsBoxedLcpSolver>();
    } else {
      throw UnsupportedScene("dart: solver '" + scene_.solver + "' is none of dantzig, pgs");
    }
    world_->setConstraintSolver(std::make_unique<BoxedLcpConstraintSolver>(solver, nullptr));
    world_->getConstraintSolver()->setCollisionDetector(
        dart::collision::OdeCollisionDetector::create());
  }

  const EngineJoint* joint_of(int body) const {
    const auto found = std::find_if(scene_.joints.begin(), scene_.joints.end(),
                                    [&](const EngineJoint& joint) { return joint.body == body; });
    return found == scene_.joints.end() ? nullptr : &*found;
  }

  void add_ground() {
    const dynamics::SkeletonPtr ground = dynamics::Skeleton::create("ground");
    dynamics::BodyNode* node = ground->createJointAndBodyNodePair<dynamics::WeldJoint>().second;
    add_shape(node, std::make_shared<dynamics::PlaneShape>(Eigen::Vector3d::UnitZ(), 0.0),
              scene_.ground_friction);
    ground->setMobile(false);
    world_->addSkeleton(ground);
  }

  static dynamics::ShapeNode* add_shape(dynamics::BodyNode* node, const dynamics::ShapePtr& shape,
                                        double friction) {
    dynamics::ShapeNode* placed =
        node->createShapeNodeWith<dynamics::CollisionAspect, dynamics::DynamicsAspect>(shape);
    placed->getDynamicsAspect()->setFrictionCoeff(friction);
    placed->getDynamicsAspect()->setRestitutionCoeff(0);
    return placed;
  }

  // Joint frames have the world's axes at the start.
  static void place_joint(dynamics::Joint::Properties& properties, const EngineJoint& joint,
                          const geometry::RigidTransform& X_WB,
                          const geometry::RigidTransform& X_WParent) {
    Eigen::Isometry3d X_WJ = Eigen::Isometry3d::Identity();
    X_WJ.translation() = joint.kind == EngineJoint::Kind::kPrismatic
                             ? Eigen::Vector3d(X_WB.translation())
                             : joint.anchor_W;
    properties.mT_ParentBodyToJoint.matrix() = (X_WParent.inverse() * X_WJ).matrix();
    properties.mT_ChildBodyToJoint.matrix() = (X_WB.inverse() * X_WJ).matrix();
  }

  void add_body(int index, const EngineJoint* joint, dynamics::BodyNode* parent,
                const dynamics::SkeletonPtr& tree) {
    const EngineBody& body = scene_.bodies[index];
    dynamics::BodyNode::Properties node_properties;
    node_properties.mName = "body " + std::to_string(index);
    const Eigen::Vector3d moments = principal_inertia(body);
    node_properties.mInertia.setMass(body.mass);
    node_properties.mInertia.setMoment(moments.asDiagonal());
    geometry::RigidTransform X_WParent = geometry::RigidTransform::Identity();
    if (parent) X_WParent = scene_.bodies[joint->parent].X_WB;
    if (!joint) {
      add_root(index, tree, node_properties);
    } else if (joint->kind == EngineJoint::Kind::kPrismatic) {
      dynamics::PrismaticJoint::Properties properties;
      place_joint(properties, *joint, body.X_WB, X_WParent);
      properties.mAxis = joint->axis_W;
      add_joined<dynamics::PrismaticJoint>(index, *joint, parent, tree, properties, node_properties,
                                           joint->axis_W.dot(body.velocity));
    } else {
      dynamics::RevoluteJoint::Properties properties;
      place_joint(properties, *joint, body.X_WB, X_WParent);
      properties.mAxis = joint->axis_W;
      add_joined<dynamics::RevoluteJoint>(index, *joint, parent, tree, properties, node_properties,
                                          joint->axis_W.dot(body.angular_velocity));
    }
    if (!body.collides) return;
    Eigen::Isometry3d X_BS;
    X_BS.matrix() = body.X_BS.matrix();
    const auto add = [&](const dynamics::ShapePtr& shape) {
      add_shape(nodes_[index], shape, body.friction)->setRelativeTransform(X_BS);
    };
    if (body.shape.kind == EngineShape::Kind::kConvexPieces) {
      for (const geometry::TriangleMesh& piece : *body.shape.pieces) add(mesh_shape(piece));
    } else {
      add(shape_of(body.shape));
    }
  }

  void add_root(int index, const dynamics::SkeletonPtr& tree,
                const dynamics::BodyNode::Properties& node_properties) {
    const EngineBody& body = scene_.bodies[index];
    Eigen::Isometry3d X_WB;
    X_WB.matrix() = body.X_WB.matrix();
    if (body.is_fixed) {
      dynamics::WeldJoint::Properties properties;
      properties.mT_ParentBodyToJoint = X_WB;
      nodes_[index] = tree->createJointAndBodyNodePair<dynamics::WeldJoint>(nullptr, properties,
                                                                            node_properties)
                          .second;
      return;
    }
    const auto [free, node] = tree->createJointAndBodyNodePair<dynamics::FreeJoint>(
        nullptr, dynamics::FreeJoint::Properties(), node_properties);
    free->setTransform(X_WB);
    free->setLinearVelocity(body.velocity);
    free->setAngularVelocity(body.angular_velocity);
    nodes_[index] = node;
  }

  template <class Joint, class Properties>
  void add_joined(int index, const EngineJoint& joint, dynamics::BodyNode* parent,
                  const dynamics::SkeletonPtr& tree, const Properties& properties,
                  const dynamics::BodyNode::Properties& node_properties, double rate) {
    const auto [made, node] =
        tree->createJointAndBodyNodePair<Joint>(parent, properties, node_properties);
    nodes_[index] = node;
    made->setVelocity(0, rate);
    joints_[&joint - scene_.joints.data()] = made;
  }

  EngineScene scene_;
  dart::simulation::WorldPtr world_;
  std::vector<dynamics::BodyNode*> nodes_;  // of the world
  std::vector<dynamics::Joint*> joints_;
  std::vector<double> forces_;
  std::vector<Vector6> wrenches_;
};

}  // namespace
}  // namespace prehend::simulation::engines

extern "C" {
int prehend_engine_interface() { return prehend::simulation::engines::kEngineInterface; }
prehend::simulation::engines::Engine* prehend_create_engine() {
  return new prehend::simulation::engines::DartEngine();
}
}
