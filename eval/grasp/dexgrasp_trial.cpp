#include "eval/grasp/dexgrasp_trial.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "eval/grasp/dexgrasp_scene.h"
#include "prehend/geometry/errors.h"
#include "prehend/simulation/engines/registry.h"

namespace prehend::eval {
namespace {

using geometry::RigidTransform;
using simulation::engines::Engine;
using simulation::engines::EngineJoint;
using simulation::engines::EngineShape;
using simulation::engines::Vector6;

constexpr double kCarrierRate = 60;  // rad/s, of the loop that lifts
constexpr int kLooks = 10;           // at the object under each force, as the benchmark does

struct DexPull {
  const char* name;
  Eigen::Vector3d direction_W;
};
const std::array<DexPull, 6> kPulls{{{"-x", -Eigen::Vector3d::UnitX()},
                                     {"+x", Eigen::Vector3d::UnitX()},
                                     {"-y", -Eigen::Vector3d::UnitY()},
                                     {"+y", Eigen::Vector3d::UnitY()},
                                     {"-z", -Eigen::Vector3d::UnitZ()},
                                     {"+z", Eigen::Vector3d::UnitZ()}}};

// Without a jerk at either end; s within 0 and 1.
double eased(double s) { return s * s * s * (10 + s * (6 * s - 15)); }

class DexRun {
 public:
  DexRun(const DexHand& hand, const DexObject& object, const grasp::Grasp& grasp, DexTest test,
         const DexProtocol& protocol)
      : hand_(hand),
        object_(object),
        protocol_(protocol),
        scene_(dex_scene(hand, object, grasp, test, protocol)),
        engine_(simulation::engines::EngineRegistry().create(protocol.engine)) {
    simulation::engines::validate(scene_.scene);
    engine_->load(scene_.scene);
    for (const DexServo& servo : scene_.servos) before_.push_back(position(servo));
    for (const auto& pieces : hand.pieces_B) solids_.emplace_back(pieces);
    X_start_ = X_WO();
  }

  DexOutcome run(DexTest test) {
    out_.start_depth = depth_in_object();
    if (out_.start_depth > protocol_.deepest_start) {
      out_.lost = "start";
      return out_;
    }
    if (test == DexTest::kTabletop) {
      pull(-Eigen::Vector3d::UnitZ());
      close();
      lift();
    } else {
      close();
      bear_pulls();
    }
    return out_;
  }

 private:
  RigidTransform X_WO() const { return engine_->body(scene_.object).X_WB; }
  double position(const DexServo& servo) const { return engine_->joint_position(servo.joint); }

  void pull(const Eigen::Vector3d& direction_W) {
    Vector6 wrench = Vector6::Zero();
    wrench.head<3>() = protocol_.mass * protocol_.acceleration * direction_W;
    engine_->set_body_wrench(scene_.object, wrench);
  }

  // For `seconds`; `each` is told the share that is gone.
  void advance(double seconds, const std::function<void(double)>& each) {
    const auto steps = std::max(1L, std::lround(seconds / protocol_.step));
    for (long i = 1; i <= steps; ++i) {
      each(static_cast<double>(i) / static_cast<double>(steps));
      for (std::size_t k = 0; k < scene_.servos.size(); ++k) drive(k);
      carry();
      engine_->step();
    }
  }

  void drive(std::size_t k) {
    const DexServo& servo = scene_.servos[k];
    const double now = position(servo);
    const double rate = (now - before_[k]) / protocol_.step;
    before_[k] = now;
    const double target = share_ <= 1 ? servo.closed_by(share_ * scene_.closing)
                                      : servo.touch + (share_ - 1) * (servo.squeezed - servo.touch);
    const double effort = servo.stiffness * (target - now) - servo.damping * rate;
    engine_->set_joint_force(servo.joint, std::clamp(effort, -servo.effort, servo.effort));
  }

  void carry() {
    if (scene_.carrier < 0) return;
    const double now = engine_->joint_position(scene_.carrier);
    const double rate = (now - carried_before_) / protocol_.step;
    const double wanted_rate = (wanted_ - wanted_before_) / protocol_.step;
    carried_before_ = now;
    wanted_before_ = wanted_;
    engine_->set_joint_force(scene_.carrier,
                             scene_.carried_mass * kCarrierRate *
                                 (kCarrierRate * (wanted_ - now) + 2 * (wanted_rate - rate)));
  }

  void close() {
    advance(protocol_.stage, [this](double s) { share_ = s; });
    advance(protocol_.stage, [this](double s) { share_ = 1 + s; });
    out_.depth = depth_in_object();
    out_.self_depth = self_depth();
  }

  void bear_pulls() {
    const std::vector<double> squeezed = engine_->save();
    const std::vector<double> before = before_;
    for (const DexPull& one : kPulls) {
      engine_->restore(squeezed);
      before_ = before;
      pull(one.direction_W);
      for (int i = 0; i < kLooks; ++i) {
        advance(protocol_.wait / kLooks, [](double) {});
        if (!holds(X_start_, one.name)) return;
      }
    }
    out_.held = true;
  }

  void lift() {
    advance(protocol_.stage, [this](double s) { wanted_ = protocol_.lift * eased(s); });
    advance(protocol_.stage, [](double) {});  // until the hand is there
    RigidTransform X_up = X_start_;
    X_up.translation().z() += protocol_.lift;
    out_.held = holds(X_up, "lift");
  }

  bool holds(const RigidTransform& X_wanted, const char* under) {
    const RigidTransform X = X_WO();
    const double shift = (X.translation() - X_wanted.translation()).norm();
    const double turn = Eigen::AngleAxisd(X_wanted.linear().transpose() * X.linear()).angle();
    out_.shift = std::max(out_.shift, shift);
    out_.turn = std::max(out_.turn, turn);
    // Written so that what is not a number is lost.
    const bool held = shift < protocol_.farthest_shift && turn < protocol_.farthest_turn;
    if (!held) out_.lost = under;
    return held;
  }

  double depth_in_object() const {
    double deepest = 0;
    const RigidTransform X_OW = X_WO().inverse(Eigen::Isometry);
    for (std::size_t b = 0; b < solids_.size(); ++b) {
      deepest = std::max(deepest, penetration(object_.solids_B(), solids_[b],
                                              X_OW * engine_->body(scene_.hand[b]).X_WB));
    }
    return deepest;
  }

  // Links that a joint joins may overlap at it.
  double self_depth() const {
    double deepest = 0;
    for (std::size_t a = 0; a < solids_.size(); ++a) {
      const RigidTransform X_AW = engine_->body(scene_.hand[a]).X_WB.inverse(Eigen::Isometry);
      for (std::size_t b = a + 1; b < solids_.size(); ++b) {
        if (are_joined(static_cast<int>(a), static_cast<int>(b))) continue;
        deepest = std::max(deepest, penetration(solids_[a], solids_[b],
                                                X_AW * engine_->body(scene_.hand[b]).X_WB));
      }
    }
    return deepest;
  }

  bool are_joined(int a, int b) const {
    return std::any_of(
        hand_.bodies.joints.begin(), hand_.bodies.joints.end(), [&](const EngineJoint& joint) {
          return std::min(joint.parent, joint.body) == a && std::max(joint.parent, joint.body) == b;
        });
  }

  const DexHand& hand_;
  const DexObject& object_;
  const DexProtocol& protocol_;
  DexScene scene_;
  std::unique_ptr<Engine> engine_;
  std::vector<ConvexSolids> solids_;  // of the hand's bodies
  RigidTransform X_start_;            // of the object
  std::vector<double> before_;        // positions of the servos' joints a step ago
  double share_ = 0;                  // 0: open, 1: where it touches, 2: squeezed
  double wanted_ = 0, wanted_before_ = 0, carried_before_ = 0;  // m, of the carrier
  DexOutcome out_;
};

}  // namespace

const char* to_string(DexTest test) {
  return test == DexTest::kForceClosure ? "force_closure" : "tabletop";
}

DexObject::DexObject(const geometry::TriangleMesh& mesh_W,
                     const std::vector<geometry::TriangleMesh>& pieces_W,
                     const DexProtocol& protocol) {
  const geometry::MassProperties of = geometry::mass_properties(mesh_W);
  if (!(of.volume > 0)) {
    throw geometry::InputError("The mesh of an object encloses no volume",
                               "Close it, with triangles counter-clockwise seen from outside");
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(of.unit_density_inertia);
  body_.name = "object";
  body_.X_WB.linear() = axes.eigenvectors();
  if (body_.X_WB.linear().determinant() < 0) body_.X_WB.linear().col(0) *= -1;
  body_.X_WB.translation() = of.center_of_mass;
  body_.mass = protocol.mass;
  body_.moments = axes.eigenvalues() * (protocol.mass / of.volume);
  body_.friction = protocol.friction;
  std::vector<geometry::TriangleMesh> pieces_B;
  for (const geometry::TriangleMesh& piece : pieces_W) {
    pieces_B.push_back(geometry::transformed(piece, body_.X_WB.inverse(Eigen::Isometry)));
  }
  solids_B_ = std::make_shared<const ConvexSolids>(pieces_B);
  body_.shape.kind = EngineShape::Kind::kConvexPieces;
  body_.shape.pieces =
      std::make_shared<const std::vector<geometry::TriangleMesh>>(std::move(pieces_B));
}

DexOutcome run_dex_trial(const DexHand& hand, const DexObject& object, const grasp::Grasp& grasp,
                         DexTest test, const DexProtocol& protocol) {
  return DexRun(hand, object, grasp, test, protocol).run(test);
}

}  // namespace prehend::eval
