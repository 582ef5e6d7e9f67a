#include "prehend/simulation/engines/substepped_pads.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>

#include "prehend/contact/texel.h"
#include "prehend/simulation/engines/inertia.h"
#include "prehend/simulation/engines/pad_contact.h"

namespace prehend::simulation::engines {
namespace {

using contact::PadLayout;
using contact::PadState;

constexpr double kSafety = 0.8;  // of the limit

bool has_pads(const EngineScene& scene, int body) {
  return std::any_of(scene.pads.begin(), scene.pads.end(),
                     [&](const EnginePad& pad) { return pad.body == body; });
}

const EngineJoint* joint_of(const EngineScene& scene, int body) {
  for (const EngineJoint& joint : scene.joints) {
    if (joint.body == body) return &joint;
  }
  return nullptr;
}

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
  half = body.X_BS.linear().cwiseAbs() * half + body.X_BS.translation().cwiseAbs();
  const bool is_round = shape.kind != EngineShape::Kind::kBox;
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
  const contact::NormalResponse normal = contact::normal_response(law, pad.grid.thickness, 0);
  const double texels = pad.grid.width * pad.grid.length / contact::kReferenceTexelArea;
  return {texels * std::max(normal.stiffness, law.bristle_stiffness),
          texels * std::max(normal.damping, law.bristle_damping + law.viscous_friction)};
}

// Numbers of a pad's state that a step depends on.
template <class State, class Visit>
void visit_bristles(State& state, Visit visit) {
  for (auto* values : {&state.bristle_u, &state.bristle_v, &state.normal_force}) {
    for (auto& value : *values) visit(value);
  }
}

}  // namespace

struct SubsteppedPads::Touch {
  Touch(const EngineScene& scene, int pad_index, int body_index)
      : pad(pad_index),
        carrier(scene.pads[pad_index].body),
        body(body_index),
        X_BP(scene.pads[pad_index].X_BP),
        X_BS(scene.bodies[body_index].X_BS),
        layout(PadLayout::flat(scene.pads[pad_index].grid)),
        reach(layout),
        shape(felt_shape(scene.bodies[body_index].shape)),
        law(mounted_law(scene.pads[pad_index], scene.bodies[carrier], scene.bodies[body_index])),
        state(layout),
        scratch(layout) {}

  int pad, carrier, body;
  geometry::RigidTransform X_BP;  // on the carrier
  geometry::RigidTransform X_BS;  // on the body
  PadLayout layout;
  contact::PadReach reach;
  contact::Shape shape;
  contact::TexelLaw law;
  PadState state;
  contact::PadScratch scratch;
  contact::PadResponse response;
};

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
SubsteppedPads::~SubsteppedPads() = default;

void SubsteppedPads::load(const EngineScene& scene) {
  touches_.clear();
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
  for (int p = 0; p < static_cast<int>(scene.pads.size()); ++p) {
    for (int b = 0; b < count; ++b) {
      const bool moves = !scene.bodies[b].is_fixed || !scene.bodies[scene.pads[p].body].is_fixed;
      if (has_pads(scene, b) || !scene.bodies[b].collides || !moves) continue;
      touches_.emplace_back(scene, p, b);
      touched_[b] = 1;
    }
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
  for (Touch& touch : touches_) {
    const BodyMotion& carrier = motions_[touch.carrier];
    const BodyMotion& body = motions_[touch.body];
    const geometry::RigidTransform X_WP = carrier.X_WB * touch.X_BP;
    const geometry::RigidTransform X_WS = body.X_WB * touch.X_BS;
    PadState& state = touch.state;
    touch.response.pressing = 0;
    const Eigen::Vector3d p_WP = X_WP.translation();
    const Eigen::Vector3d arm_c = p_WP - carrier.X_WB.translation();
    const Eigen::Vector3d arm_b = p_WP - body.X_WB.translation();
    Vector6 twist;
    twist.head<3>() =
        X_WP.linear().transpose() * (body.velocity + body.angular_velocity.cross(arm_b) -
                                     carrier.velocity - carrier.angular_velocity.cross(arm_c));
    twist.tail<3>() =
        X_WP.linear().transpose() * (body.angular_velocity - carrier.angular_velocity);
    if (contact::find_depths(touch.layout, touch.reach, touch.shape,
                             X_WP.inverse(Eigen::Isometry) * X_WS, 0, state)) {
      contact::respond(touch.layout, touch.law, h, twist, state, touch.scratch, touch.response);
    }
    if (touch.response.pressing == 0) {
      visit_bristles(state, [](double& value) { value = 0; });
      continue;
    }
    contact::advance(touch.layout, touch.law, h, twist, state, touch.scratch);
    const Vector6 wrench_P = touch.response.constant - touch.response.resistance * twist;
    const Eigen::Vector3d force = X_WP.linear() * wrench_P.head<3>();
    const Eigen::Vector3d torque = X_WP.linear() * wrench_P.tail<3>();
    with_pads_[touch.body].head<3>() += force;
    with_pads_[touch.body].tail<3>() += torque + arm_b.cross(force);
    with_pads_[touch.carrier].head<3>() -= force;
    with_pads_[touch.carrier].tail<3>() -= torque + arm_c.cross(force);
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
  const contact::PadGrid& grid = scene_.pads.at(pad).grid;
  std::vector<double> forces(static_cast<std::size_t>(grid.rows) * grid.columns, 0.0);
  for (const Touch& touch : touches_) {
    if (touch.pad != pad) continue;
    for (std::size_t i = 0; i < forces.size(); ++i) forces[i] += touch.state.normal_force[i];
  }
  return forces;
}

std::vector<double> SubsteppedPads::save() const {
  std::vector<double> state;
  for (const Touch& touch : touches_) {
    visit_bristles(touch.state, [&](const double& value) { state.push_back(value); });
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
  for (const Touch& touch : touches_) own += 3 * touch.layout.padded_size();
  if (state.size() < own) {
    throw std::invalid_argument(name() + ": the saved state is of another scene");
  }
  // The engine first: it refuses what is not of this scene.
  engine_->restore({state.begin() + static_cast<std::ptrdiff_t>(own), state.end()});
  auto next = state.begin();
  for (Touch& touch : touches_) {
    visit_bristles(touch.state, [&](double& value) { value = *next++; });
  }
  for (std::size_t b = 0; !touches_.empty() && b < wrenches_.size(); ++b, next += 6) {
    std::copy_n(next, 6, wrenches_[b].data());
  }
}

}  // namespace prehend::simulation::engines
