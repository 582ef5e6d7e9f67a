// A physics engine in a shared library: one body over the ground, which its corners meet by springs
// and dampers. Explicit (Euler and Cromer), in sub-steps that are short for its springs.

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "prehend/simulation/engines/engine.h"
#include "prehend/simulation/engines/inertia.h"

namespace {

namespace engines = prehend::simulation::engines;
using Eigen::Vector3d;
using engines::EngineShape;
using engines::UnsupportedScene;

constexpr double kFrequency = 300;    // rad/s, of the whole body on its springs
constexpr double kSubstep = 2e-5;     // s, at most
constexpr double kMargin = 1e-3;      // m
constexpr double kSlideSpeed = 1e-3;  // m/s, from which friction is whole

class LoneBody final : public engines::Engine {
 public:
  std::string name() const override { return "lone_body"; }
  std::string version() const override { return "1"; }
  std::vector<std::string> solvers() const override { return {"explicit"}; }

  void load(const engines::EngineScene& scene) override {
    engines::refuse_pads_and_couplings(scene, "lone_body");
    if (!scene.joints.empty()) throw UnsupportedScene("lone_body: has no joints");
    if (!scene.solver.empty() && scene.solver != "explicit") {
      throw UnsupportedScene("lone_body: solver '" + scene.solver + "' is not explicit");
    }
    if (scene.bodies.size() > 1) throw UnsupportedScene("lone_body: has one body, as it says");
    scene_ = scene;
    wrench_.setZero();
    if (scene.bodies.empty()) return;
    const engines::EngineBody& body = scene.bodies.front();
    p_ = body.X_WB.translation();
    q_ = Eigen::Quaterniond(body.X_WB.linear());
    v_ = body.velocity;
    w_ = body.angular_velocity;
    moments_ = engines::principal_inertia(body);
    corners_B_.clear();
    reach_ = 0;
    for (const Vector3d& corner_S : corners(body.shape)) {
      corners_B_.push_back(body.X_BS * corner_S);
      reach_ = std::max(reach_, corners_B_.back().norm());
    }
  }

  void step() override {
    if (scene_.bodies.empty() || scene_.bodies.front().is_fixed) return;
    // What is so high now does not come down within the step.
    const double falls = scene_.step * (v_.norm() + w_.norm() * reach_) + kMargin;
    low_B_.clear();
    for (const Vector3d& corner : corners_B_) {
      if (p_.z() + (q_ * corner).z() < falls) low_B_.push_back(corner);
    }
    const int count = static_cast<int>(std::ceil(scene_.step / kSubstep));
    for (int i = 0; i < count; ++i) substep(scene_.step / count);
  }

  void set_joint_force(int, double) override { throw std::out_of_range("lone_body: no joints"); }
  void set_body_wrench(int, const engines::Vector6& wrench) override { wrench_ = wrench; }
  double joint_position(int) const override { throw std::out_of_range("lone_body: no joints"); }

  engines::BodyMotion body(int) const override {
    return {prehend::geometry::make_transform(q_, p_), v_, w_};
  }

  std::vector<double> save() const override {
    std::vector<double> state(q_.coeffs().data(), q_.coeffs().data() + 4);
    for (const Vector3d* v : {&p_, &v_, &w_}) state.insert(state.end(), v->data(), v->data() + 3);
    state.insert(state.end(), wrench_.data(), wrench_.data() + 6);
    return state;
  }

  void restore(const std::vector<double>& state) override {
    if (state.size() != 19) {
      throw std::invalid_argument("lone_body: the saved state is of another scene");
    }
    const double* next = state.data();
    std::copy_n(next, 4, q_.coeffs().data());
    next += 4;
    for (Vector3d* v : {&p_, &v_, &w_}) {
      std::copy_n(next, 3, v->data());
      next += 3;
    }
    std::copy_n(next, 6, wrench_.data());
  }

 private:
  // What meets the ground of a shape.
  static std::vector<Vector3d> corners(const EngineShape& shape) {
    std::vector<Vector3d> points;
    switch (shape.kind) {
      case EngineShape::Kind::kBox:
        for (int i = 0; i < 8; ++i) {
          const Vector3d sign(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
          points.push_back(0.5 * sign.cwiseProduct(shape.size));
        }
        return points;
      case EngineShape::Kind::kCylinder:
        for (int i = 0; i < 64; ++i) {
          const double angle = M_PI / 16 * (i % 32);
          points.emplace_back(shape.radius * std::cos(angle), shape.radius * std::sin(angle),
                              (i < 32 ? -0.5 : 0.5) * shape.length);
        }
        return points;
      case EngineShape::Kind::kConvexPieces:
        for (const prehend::geometry::TriangleMesh& piece : *shape.pieces) {
          points.insert(points.end(), piece.vertices.begin(), piece.vertices.end());
        }
        return points;
      case EngineShape::Kind::kSphere:
      case EngineShape::Kind::kCapsule:
        break;
    }
    throw UnsupportedScene("lone_body: nothing round");
  }

  void substep(double h) {
    const engines::EngineBody& body = scene_.bodies.front();
    const Eigen::Matrix3d R = q_.toRotationMatrix();
    Vector3d force = wrench_.head<3>() + body.mass * scene_.gravity, torque = wrench_.tail<3>();
    std::vector<Vector3d> touching;
    for (const Vector3d& corner : low_B_) {
      const Vector3d arm = R * corner;
      if (scene_.ground && body.collides && p_.z() + arm.z() < 0) touching.push_back(arm);
    }
    const double share = body.mass / static_cast<double>(std::max<std::size_t>(touching.size(), 1));
    for (const Vector3d& arm : touching) {
      const Vector3d speed = v_ + w_.cross(arm);
      const double spring = -kFrequency * kFrequency * share * (p_.z() + arm.z());
      const double normal = std::max(0.0, spring - 2 * kFrequency * share * speed.z());
      const Vector3d sliding(speed.x(), speed.y(), 0);
      const double friction = std::min(body.friction, scene_.ground_friction) * normal;
      const Vector3d push =
          normal * Vector3d::UnitZ() - friction / std::max(sliding.norm(), kSlideSpeed) * sliding;
      force += push;
      torque += arm.cross(push);
    }
    v_ += h / body.mass * force;
    const Vector3d w_B = R.transpose() * w_;
    const Vector3d spin = moments_.cwiseProduct(w_B);
    w_ += h * (R * (R.transpose() * torque - w_B.cross(spin)).cwiseQuotient(moments_));
    p_ += h * v_;
    const double angle = h * w_.norm();
    if (angle > 0) q_ = (Eigen::AngleAxisd(angle, w_.normalized()) * q_).normalized();
  }

  engines::EngineScene scene_;
  std::vector<Vector3d> corners_B_, low_B_;
  double reach_ = 0;  // m, of the corners from the centre of mass
  Vector3d p_ = Vector3d::Zero(), v_ = Vector3d::Zero(), w_ = Vector3d::Zero();
  Vector3d moments_ = Vector3d::Ones();
  Eigen::Quaterniond q_ = Eigen::Quaterniond::Identity();
  engines::Vector6 wrench_ = engines::Vector6::Zero();
};

}  // namespace

extern "C" {

int prehend_engine_interface() { return engines::kEngineInterface; }

engines::Engine* prehend_create_engine() { return new LoneBody; }
}
