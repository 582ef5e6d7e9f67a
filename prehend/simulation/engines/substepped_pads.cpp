#include "prehend/simulation/engines/substepped_pads.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>

#include "prehend/contact/foam.h"
#include "prehend/contact/texel.h"
#include "prehend/simulation/engines/inertia.h"
#include "prehend/simulation/engines/pad_on_body.h"

namespace prehend::simulation::engines {
namespace {

using contact::PadLayout;
using contact::PadState;

constexpr double kSafety = 0.8;  // of the limit

// What a force on a point of the body moves at most [1/kg].
double point_mobility(const EngineScene& scene, int index) {
  const EngineBody& body = scene.bodies[index];
  if (body.is_fixed) return 0;
  const EngineJoint* joint = joint_of(scene, index);
  if (joint && joint->parent < 0 && joint->kind == EngineJoint::Kind::kPrismatic) {
    return 1 / body.mass;
  }
  // Half extents of the shape along the principal axes.
  const EngineShape& shape = body.shape;
  Eigen::Vector3d half = Eigen::Vector3d::Constant(shape.radius);
  if (shape.kind == EngineShape::Kind::kBox) half = 0.5 * shape.size;
  if (shape.kind == EngineShape::Kind::kCylinder) half.z() = 0.5 * shape.length;
  if (shape.kind == EngineShape::Kind::kCapsule) half.z() += 0.5 * shape.length;
  const bool in_pieces = shape.kind == EngineShape::Kind::kConvexPieces;
  if (in_pieces) {
    const Eigen::AlignedBox3d box = geometry::bounds(geometry::concatenated(*shape.pieces));
    half = box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs());
  }
  half = body.X_BS.linear().cwiseAbs() * half + body.X_BS.translation().cwiseAbs();
  const bool is_round = shape.kind != EngineShape::Kind::kBox && !in_pieces;
  const Eigen::Vector3d moments = principal_inertia(body);
  double worst = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = half[(axis + 1) % 3], b = half[(axis + 2) % 3];
    // Round about z, where the diagonal of the bounds is not reached.
    const bool circle = is_round && (axis == 2 || shape.kind == EngineShape::Kind::kSphere);
    const double square = circle ? std::max(a, b) * std::max(a, b) : a * a + b * b;
    worst = std::max(worst, body.mass * square / moments[axis]);
  }
  return (1 + 0.5 * worst) / body.mass;
}

struct Rates {
  double stiffness = 0;  // N/m
  double damping = 0;    // N s/m
};

// Of all the pad's texels together, the stiffer of normal and tangential.
Rates whole_pad(const EnginePad& pad) {
  const contact::TexelLaw& law = pad.law;
  contact::NormalResponse normal = contact::normal_response(law, pad.layout.thickness(), 0);
  for (const auto& term : law.memory.creep) {
    normal.stiffness += term.share * contact::memory_stiffness(law);
  }
  for (const auto& term : law.memory.hysteresis) {
    normal.stiffness += term.share * contact::memory_stiffness(law);
  }
  const double texels = pad.layout.area() / contact::kReferenceTexelArea;
  return {texels * std::max(normal.stiffness, law.bristle_stiffness),
          texels * std::max(normal.damping, law.bristle_damping + law.viscous_friction)};
}

}  // namespace

double substep_limit(const EngineScene& scene) {
  double limit = std::numeric_limits<double>::infinity();
  for (int b = 0; b < static_cast<int>(scene.bodies.size()); ++b) {
    if (has_pads(scene, b) || !scene.bodies[b].collides) continue;
    const double mobility = point_mobility(scene, b);
    Rates on_body, on_carrier;  // times mobility: 1/s^2, 1/s
    std::map<int, Rates> carriers;
    for (const EnginePad& pad : scene.pads) {
      const Rates rates = whole_pad(pad);
      on_body.stiffness += mobility * rates.stiffness;
      on_body.damping += mobility * rates.damping;
      const double of_carrier = point_mobility(scene, pad.body);
      Rates& sum = carriers[pad.body];
      sum.stiffness += of_carrier * rates.stiffness;
      sum.damping += of_carrier * rates.damping;
      on_carrier.stiffness = std::max(on_carrier.stiffness, sum.stiffness);
      on_carrier.damping = std::max(on_carrier.damping, sum.damping);
    }
    const double K = on_body.stiffness + on_carrier.stiffness;
    const double C = on_body.damping + on_carrier.damping;
    // 3 h^2 K + 2 h C = 4, in the form that does not cancel.
    if (K > 0) limit = std::min(limit, 4 / (C + std::sqrt(C * C + 12 * K)));
  }
  return limit;
}

SubsteppedPads::SubsteppedPads(std::unique_ptr<Engine> engine) : engine_(std::move(engine)) {}

void SubsteppedPads::load(const EngineScene& scene) {
  touches_.clear();
  states_.clear();
  substeps_ = 1;
  if (scene.pads.empty() || scene.pad_method == PadMethod::kOwnContacts) {
    engine_->load(scene);
    scene_ = scene;
    return;
  }
  const double longest = kSafety * substep_limit(scene);
  if (longest < kLeastSubstep) {
    std::ostringstream reason;
    reason << name() << ": with these pads and masses only steps below " << longest
           << " s are stable, less than " << kLeastSubstep << " s; take `native`";
    throw UnsupportedScene(reason.str());
  }
  substeps_ = std::max(1, static_cast<int>(std::ceil(scene.step / longest)));
  EngineScene plain = scene;
  plain.pads.clear();
  plain.step = scene.step / substeps_;
  const int count = static_cast<int>(scene.bodies.size());
  touched_.assign(count, 0);
  for (int b = 0; b < count; ++b) {
    if (!has_pads(scene, b)) continue;
    plain.bodies[b].collides = false;
    touched_[b] = 1;
  }
  engine_->load(plain);
  scene_ = scene;
  touches_ = PadOnBody::all(scene);
  for (const PadOnBody& touch : touches_) {
    states_.emplace_back(touch.layout, touch.law);
    touched_[touch.body] = 1;
  }
  wrenches_.assign(count, Vector6::Zero());
  with_pads_ = wrenches_;
  motions_.resize(count);
}

void SubsteppedPads::step() {
  for (int i = 0; i < substeps_; ++i) {
    if (!touches_.empty()) press(scene_.step / substeps_);
    engine_->step();
  }
}

void SubsteppedPads::press(double h) {
  with_pads_ = wrenches_;
  for (std::size_t b = 0; b < motions_.size(); ++b) {
    if (touched_[b]) motions_[b] = engine_->body(static_cast<int>(b));
  }
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    PadOnBody& touch = touches_[i];
    PadState& state = states_[i];
    const BodyMotion& carrier = motions_[touch.carrier];
    const BodyMotion& body = motions_[touch.body];
    const PadOnBody::Place place = touch.place(carrier.X_WB, body.X_WB);
    const Eigen::Matrix3d R_WP = place.X_WP.linear();
    Vector6 twist;
    twist.head<3>() =
        R_WP.transpose() * (body.velocity + body.angular_velocity.cross(place.arm_body) -
                            carrier.velocity - carrier.angular_velocity.cross(place.arm_carrier));
    twist.tail<3>() = R_WP.transpose() * (body.angular_velocity - carrier.angular_velocity);
    touch.response.pressing = 0;
    if (touch.find_depths(place, body.X_WB, 0, state)) {
      contact::respond(touch.layout, touch.law, h, twist, state, touch.scratch, touch.response);
    }
    if (touch.response.pressing == 0) {
      contact::release(touch.layout, touch.law, h, state);
      continue;
    }
    contact::advance(touch.layout, touch.law, h, twist, state, touch.scratch);
    const Vector6 wrench_P = touch.response.constant - touch.response.resistance * twist;
    const Eigen::Vector3d force = R_WP * wrench_P.head<3>();
    const Eigen::Vector3d torque = R_WP * wrench_P.tail<3>();
    with_pads_[touch.body].head<3>() += force;
    with_pads_[touch.body].tail<3>() += torque + place.arm_body.cross(force);
    with_pads_[touch.carrier].head<3>() -= force;
    with_pads_[touch.carrier].tail<3>() -= torque + place.arm_carrier.cross(force);
  }
  for (std::size_t b = 0; b < motions_.size(); ++b) {
    if (touched_[b] && !scene_.bodies[b].is_fixed) {
      engine_->set_body_wrench(static_cast<int>(b), with_pads_[b]);
    }
  }
}

void SubsteppedPads::set_joint_force(int joint, double force) {
  engine_->set_joint_force(joint, force);
}

void SubsteppedPads::set_body_wrench(int body, const Vector6& wrench_W) {
  if (!touches_.empty()) wrenches_.at(body) = wrench_W;
  engine_->set_body_wrench(body, wrench_W);
}

std::vector<double> SubsteppedPads::pad_forces(int pad) const {
  if (touches_.empty()) return engine_->pad_forces(pad);
  std::vector<double> forces(scene_.pads.at(pad).layout.size(), 0.0);
  add_pad_forces(touches_, states_, pad, forces);
  return forces;
}

std::vector<double> SubsteppedPads::save() const {
  std::vector<double> state;
  for (const PadState& pad : states_) {
    visit_pad_state(pad, [&](const double& value) { state.push_back(value); });
  }
  if (!touches_.empty()) {
    for (const Vector6& wrench : wrenches_) {
      state.insert(state.end(), wrench.data(), wrench.data() + 6);
    }
  }
  const std::vector<double> inner = engine_->save();
  state.insert(state.end(), inner.begin(), inner.end());
  return state;
}

void SubsteppedPads::restore(const std::vector<double>& state) {
  std::size_t own = touches_.empty() ? 0 : 6 * wrenches_.size();
  for (const PadState& pad : states_) visit_pad_state(pad, [&](const double&) { ++own; });
  if (state.size() < own) {
    throw std::invalid_argument(name() + ": the saved state is of another scene");
  }
  // The engine first: it refuses what is not of this scene.
  engine_->restore({state.begin() + static_cast<std::ptrdiff_t>(own), state.end()});
  auto next = state.begin();
  for (PadState& pad : states_) {
    visit_pad_state(pad, [&](double& value) { value = *next++; });
  }
  for (std::size_t b = 0; !touches_.empty() && b < wrenches_.size(); ++b, next += 6) {
    std::copy_n(next, 6, wrenches_[b].data());
  }
}

}  // namespace prehend::simulation::engines
