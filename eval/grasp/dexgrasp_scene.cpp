#include "eval/grasp/dexgrasp_scene.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "eval/grasp/dexgrasp_squeeze.h"

namespace prehend::eval {
namespace {

using geometry::RigidTransform;
using simulation::RobotBodies;
using simulation::engines::EngineBody;
using simulation::engines::EngineJoint;
using simulation::engines::EngineShape;

constexpr double kCarriedMass = 100;   // kg: what a lifted hand weighs, so that fingers do not
                                       // move it
constexpr double kLeastEffort = 0.05;  // share of the motors', of plans that need next to nothing
// m, that jaws go on beyond where the plan says that they touch, pressing no harder: drives press
// by their current, wherever it is that they touch.
constexpr double kFurtherSlide = 0.005;
constexpr double kLeastWay = 1e-6;  // rad or m, from open to touching, that has a direction

class SceneBuilder {
 public:
  SceneBuilder(const DexHand& hand, const grasp::Grasp& grasp, const DexProtocol& protocol)
      : hand_(hand), bodies_(hand.bodies), grasp_(grasp), protocol_(protocol) {
    open_ = hand.model.all_positions(grasp.open);
    bodies_.link_poses(grasp.X_WH, open_, X_WL_);
  }

  DexScene build(const DexObject& object, DexTest test) {
    if (!hand_.model.gripper && !protocol_.equal_efforts) {
      balanced_ = balanced_squeeze(hand_, grasp_, object.body().X_WB.translation(),
                                   object.solids_B().bounds().diagonal().norm() / 2,
                                   protocol_.mass * protocol_.acceleration, protocol_.safety);
    }
    out_.scene.step = protocol_.step;
    out_.scene.gravity.setZero();  // the object's weight is a force like others
    out_.scene.ground = test == DexTest::kTabletop;
    out_.scene.ground_friction = protocol_.friction;
    out_.scene.solver = protocol_.solver;
    add_bodies();
    if (test == DexTest::kTabletop) add_carrier();
    add_joints();
    out_.object = static_cast<int>(out_.scene.bodies.size());
    out_.scene.bodies.push_back(object.body());
    return std::move(out_);
  }

 private:
  void add_bodies() {
    std::vector<int> link_of(bodies_.bodies.size(), -1);
    for (std::size_t l = 0; l < bodies_.body_of_link.size(); ++l) {
      int& link = link_of[static_cast<std::size_t>(bodies_.body_of_link[l])];
      if (link < 0) link = static_cast<int>(l);
    }
    for (std::size_t b = 0; b < bodies_.bodies.size(); ++b) {
      EngineBody body = bodies_.bodies[b];
      const auto link = static_cast<std::size_t>(link_of[b]);
      body.X_WB = X_WL_[link] * bodies_.X_BL[link].inverse(Eigen::Isometry);
      body.collides = !hand_.pieces_B[b].empty();
      if (body.collides) {
        body.shape.kind = EngineShape::Kind::kConvexPieces;
        body.shape.pieces =
            std::make_shared<const std::vector<geometry::TriangleMesh>>(hand_.pieces_B[b]);
        body.X_BS = RigidTransform::Identity();
      } else {
        body.shape = {};
      }
      out_.hand.push_back(static_cast<int>(b));
      out_.scene.bodies.push_back(body);
    }
  }

  void add_carrier() {
    EngineBody& root = out_.scene.bodies.front();
    root.is_fixed = false;
    root.mass = kCarriedMass;
    out_.carrier = 0;
    out_.carried_mass = kCarriedMass;
    for (const EngineBody& body : out_.scene.bodies) {
      if (&body != &root) out_.carried_mass += body.mass;
    }
    EngineJoint up;
    up.body = 0;
    up.axis_W = Eigen::Vector3d::UnitZ();
    out_.scene.joints.push_back(up);
  }

  void add_joints() {
    const int first = static_cast<int>(out_.scene.joints.size());
    const std::vector<robot::Joint>& joints = bodies_.model.joints;
    for (std::size_t e = 0; e < bodies_.joints.size(); ++e) {
      const auto of =
          std::find(bodies_.engine_joint.begin(), bodies_.engine_joint.end(), static_cast<int>(e));
      const auto j = static_cast<std::size_t>(of - bodies_.engine_joint.begin());
      const robot::Joint& joint = joints[j];
      EngineJoint engine = bodies_.joints[e];
      const RigidTransform X_WJ = X_WL_[static_cast<std::size_t>(joint.parent)] * joint.X_PJ;
      engine.axis_W = (X_WJ.linear() * joint.axis_J).normalized();
      engine.anchor_W = X_WJ.translation();
      if (engine.follows >= 0) engine.follows += first;
      add_rotor(engine, bodies_.mechanics[e].rotor_inertia);
      out_.scene.joints.push_back(engine);
      if (engine.follows < 0) add_servo(first + static_cast<int>(e), j);
    }
  }

  // Engines know none: it is the link's own.
  void add_rotor(const EngineJoint& joint, double inertia) {
    EngineBody& body = out_.scene.bodies[static_cast<std::size_t>(joint.body)];
    if (joint.kind == EngineJoint::Kind::kPrismatic) {
      body.mass += inertia;
    } else {
      body.moments.array() += inertia;
    }
  }

  void add_servo(int joint, std::size_t j) {
    const robot::Joint& of = bodies_.model.joints[j];
    const auto index = static_cast<Eigen::Index>(j);
    const bool slides = of.kind == robot::Joint::Kind::kPrismatic;
    DexServo servo;
    servo.joint = joint;
    servo.touch = grasp_.closed_all[index] - open_[index];
    servo.stiffness = slides ? protocol_.slide_stiffness : protocol_.stiffness;
    servo.damping = 2 * std::sqrt(servo.stiffness * inertia_at(joint));
    servo.effort = of.max_effort;
    set_rates(j, &servo);
    if (balanced_.size() > 0) {
      servo.squeezed = servo.touch + balanced_[index] / servo.stiffness;
    } else {
      press_by_share(slides, &servo);
    }
    out_.closing = std::max(out_.closing, servo.closing_to_touch());
    out_.servos.push_back(servo);
  }

  // By the preshape; a joint that breaks away follows until its leader touches.
  void set_rates(std::size_t j, DexServo* servo) const {
    const robot::HandModel& hand = hand_.model;
    const robot::Preshape& preshape = hand.preshape(grasp_.preshape);
    const auto rate_of = [&](int joint) {
      const auto at = std::find(hand.actuated.begin(), hand.actuated.end(), joint);
      if (at == hand.actuated.end()) return 0.0;
      return preshape.closing[static_cast<std::size_t>(at - hand.actuated.begin())].rate;
    };
    servo->rate = rate_of(static_cast<int>(j));
    for (const robot::Breakaway& breakaway : hand.breakaways) {
      if (breakaway.joint != static_cast<int>(j)) continue;
      const double leader = rate_of(breakaway.leader);
      if (leader == 0) continue;
      servo->rate = leader * hand.model.joints[j].mimic->multiplier;
      servo->later = (grasp_.closed_all[breakaway.leader] - open_[breakaway.leader]) / leader;
      servo->later_rate = leader * breakaway.rate;
    }
  }

  // What the plan does not close keeps its place.
  void press_by_share(bool slides, DexServo* servo) const {
    servo->squeezed = servo->touch;
    // What is as wide as the hand opens is touched at once.
    const double way_to_close = std::abs(servo->touch) > kLeastWay ? servo->touch : servo->rate;
    if (way_to_close == 0) return;
    double effort = servo->effort;
    if (grasp_.force > 0) {
      effort = std::min(effort, 2 * grasp_.force);  // of both jaws' pads
    } else if (grasp_.effort > 0) {
      effort *= std::clamp(grasp_.effort, kLeastEffort, 1.0);
    }
    double way = effort / servo->stiffness;
    if (slides) {
      servo->effort = effort;
      way += kFurtherSlide;
    }
    servo->squeezed += std::copysign(way, way_to_close);
  }

  // Of the link alone: those beyond it make its loop slower, not less stable.
  double inertia_at(int joint) const {
    const EngineJoint& of = out_.scene.joints[static_cast<std::size_t>(joint)];
    const EngineBody& body = out_.scene.bodies[static_cast<std::size_t>(of.body)];
    if (of.kind == EngineJoint::Kind::kPrismatic) return body.mass;
    const Eigen::Vector3d axis_B = body.X_WB.linear().transpose() * of.axis_W;
    const Eigen::Vector3d arm = of.axis_W.cross(body.X_WB.translation() - of.anchor_W);
    return axis_B.cwiseAbs2().dot(body.moments) + body.mass * arm.squaredNorm();
  }

  const DexHand& hand_;
  const RobotBodies& bodies_;
  const grasp::Grasp& grasp_;
  const DexProtocol& protocol_;
  Eigen::VectorXd open_;      // of all joints of the model
  Eigen::VectorXd balanced_;  // the same, efforts that squeeze; empty: by the motors' share
  std::vector<RigidTransform> X_WL_;
  DexScene out_;
};

}  // namespace

double DexServo::closed_by(double closing) const {
  const double way = rate * std::min(closing, later) + later_rate * std::max(0.0, closing - later);
  // What the preshape does not move, or not to there, goes there at once.
  if (way * touch <= 0 && closing > 0) return rate * touch > 0 ? 0 : touch;
  return touch < 0 ? std::max(way, touch) : std::min(way, touch);
}

double DexServo::closing_to_touch() const {
  if (rate * touch <= 0) return 0;
  const double before = touch / rate;
  if (before <= later || later_rate * touch <= 0) return before;
  return later + (touch - rate * later) / later_rate;
}

DexScene dex_scene(const DexHand& hand, const DexObject& object, const grasp::Grasp& grasp,
                   DexTest test, const DexProtocol& protocol) {
  return SceneBuilder(hand, grasp, protocol).build(object, test);
}

}  // namespace prehend::eval
