#include "prehend/simulation/engines/grasp_engine.h"

#include <algorithm>

#include "prehend/contact/pad_kernel.h"
#include "prehend/simulation/engines/inertia.h"
#include "prehend/simulation/engines/multibody_engine.h"
#include "prehend/simulation/engines/pad_on_body.h"

namespace prehend::simulation::engines {
namespace {

using contact::GraspModel;
using contact::GraspState;

// Points by which a box stands on the ground.
std::vector<Eigen::Vector3d> support_points(const EngineShape& shape) {
  std::vector<Eigen::Vector3d> points;
  for (int corner = 0; corner < 8; ++corner) {
    points.emplace_back(0.5 * (corner & 1 ? 1 : -1) * shape.size.x(),
                        0.5 * (corner & 2 ? 1 : -1) * shape.size.y(),
                        0.5 * (corner & 4 ? 1 : -1) * shape.size.z());
  }
  return points;
}

// Every number of a state, in one fixed order, read or written by `visit`.
template <class State, class Visit>
void visit_state(State& state, Visit visit) {
  visit(state.time);
  for (auto* vector : {&state.p_WB, &state.velocity, &state.angular_velocity}) {
    for (int k = 0; k < 3; ++k) visit((*vector)[k]);
  }
  for (int k = 0; k < 4; ++k) visit(state.q_WB.coeffs()[k]);
  for (auto* values : {&state.slide_position, &state.slide_velocity, &state.slide_bristle,
                       &state.slide_force, &state.ground_forces}) {
    for (auto& value : *values) visit(value);
  }
  for (auto& pad : state.pads) {
    for (auto* values : {&pad.depth, &pad.bristle_u, &pad.bristle_v, &pad.normal_force,
                         &pad.friction_u, &pad.friction_v}) {
      for (auto& value : *values) visit(value);
    }
  }
  for (auto& bristle : state.ground_bristles) {
    for (int k = 0; k < 3; ++k) visit(bristle[k]);
  }
}

}  // namespace

std::string GraspEngine::version() const { return "prehend, " + contact::vector_target(); }

std::string GraspEngine::why_not(const EngineScene& scene) {
  if (scene.pad_method != PadMethod::kTexelLaw) return "its pads follow the texel law";
  if (scene.joints.size() > GraspModel::kMostSlides) return "at most 6 joints";
  for (const EngineJoint& joint : scene.joints) {
    if (joint.kind != EngineJoint::Kind::kPrismatic || joint.parent != -1 || joint.follows >= 0) {
      return "only prismatic joints to the world that follow none";
    }
  }
  int free = 0;
  for (int i = 0; i < static_cast<int>(scene.bodies.size()); ++i) {
    const EngineBody& body = scene.bodies[i];
    const bool joined = joint_of(scene, i) != nullptr;
    if (joined || body.is_fixed) {
      if (body.collides && !has_pads(scene, i)) return "what is joined or fixed touches by pads";
      continue;
    }
    if (has_pads(scene, i)) return "pads on joined or fixed bodies";
    if (!body.X_BS.matrix().isIdentity(0) || !body.collides) return "a shape off centre";
    if (scene.ground && body.shape.kind != EngineShape::Kind::kBox) return "only boxes stand";
    ++free;
  }
  return free == 1 ? "" : "one free body";
}

void GraspEngine::load(const EngineScene& scene) {
  if (const std::string reason = why_not(scene); !reason.empty()) {
    throw UnsupportedScene("native, grasps: " + reason);
  }
  check_native_solver(scene);
  scene_ = scene;
  std::vector<int> joint_of_body(scene.bodies.size(), -1);
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    joint_of_body[scene.joints[j].body] = static_cast<int>(j);
  }
  free_body_ = 0;
  while (scene.bodies[free_body_].is_fixed || joint_of_body[free_body_] >= 0) ++free_body_;
  joint_forces_.assign(scene.joints.size(), 0.0);
  wrench_forces_ = joint_forces_;
  const EngineBody& body = scene.bodies[free_body_];
  GraspModel model;
  model.gravity = scene.gravity;
  model.mass = body.mass;
  model.inertia = principal_inertia(body).asDiagonal();
  model.shape = felt_shape(body.shape);
  model.X_WB = body.X_WB;
  if (scene.ground) {
    model.ground = contact::stiff_ground(body.mass, std::min(body.friction, scene.ground_friction),
                                         support_points(body.shape));
  }
  for (const EngineJoint& joint : scene.joints) {
    contact::SlideModel slide;
    slide.mass = scene.bodies[joint.body].mass;
    model.slides.push_back(slide);
  }
  for (const EnginePad& pad : scene.pads) {
    const EngineBody& carrier = scene.bodies[pad.body];
    contact::PadMount mount{pad.layout, mounted_law(pad, carrier, body), carrier.X_WB * pad.X_BP,
                            joint_of_body[pad.body], Eigen::Vector3d::Zero()};
    if (mount.slide >= 0) mount.direction_G = scene.joints[mount.slide].axis_W;
    model.pads.push_back(std::move(mount));
  }
  contact::StepOptions options;
  options.step = scene.step;
  options.integration =
      contact::integration_from_name(scene.solver.empty() ? solvers().front() : scene.solver);
  stepper_ = std::make_unique<contact::GraspStepper>(std::move(model), options);
  GraspState state = stepper_->state();
  state.velocity = body.velocity;
  state.angular_velocity = body.angular_velocity;
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    state.slide_velocity[j] =
        scene.joints[j].axis_W.dot(scene.bodies[scene.joints[j].body].velocity);
  }
  stepper_->set_state(state);
}

void GraspEngine::step() { stepper_->step(stepper_->state().time + scene_.step); }

void GraspEngine::set_joint_force(int joint, double force) {
  joint_forces_.at(joint) = force;
  push(joint);
}

// Of a body on a joint only what is along the axis moves it.
void GraspEngine::set_body_wrench(int body, const Vector6& wrench_W) {
  if (body == free_body_) return stepper_->system().set_body_wrench(wrench_W);
  for (std::size_t j = 0; j < scene_.joints.size(); ++j) {
    if (scene_.joints[j].body != body) continue;
    wrench_forces_[j] = scene_.joints[j].axis_W.dot(wrench_W.head<3>());
    push(static_cast<int>(j));
  }
}

void GraspEngine::push(int joint) {
  stepper_->system().set_command(joint, {.force = joint_forces_[joint] + wrench_forces_[joint]},
                                 stepper_->state().time);
}

BodyMotion GraspEngine::body(int index) const {
  const GraspState& state = stepper_->state();
  if (index == free_body_) return {state.X_WB(), state.velocity, state.angular_velocity};
  BodyMotion motion;
  motion.X_WB = scene_.bodies.at(index).X_WB;
  for (std::size_t j = 0; j < scene_.joints.size(); ++j) {
    if (scene_.joints[j].body != index) continue;
    motion.X_WB.translation() += state.slide_position[j] * scene_.joints[j].axis_W;
    motion.velocity = state.slide_velocity[j] * scene_.joints[j].axis_W;
  }
  return motion;
}

double GraspEngine::joint_position(int joint) const {
  return stepper_->state().slide_position.at(joint);
}

std::vector<double> GraspEngine::pad_forces(int pad) const {
  const auto& forces = stepper_->state().pads.at(pad).normal_force;
  const auto size =
      static_cast<std::ptrdiff_t>(stepper_->system().model().pads.at(pad).layout.size());
  return {forces.begin(), forces.begin() + size};
}

std::vector<double> GraspEngine::save() const {
  std::vector<double> numbers;
  visit_state(stepper_->state(), [&](const double& value) { numbers.push_back(value); });
  return numbers;
}

void GraspEngine::restore(const std::vector<double>& numbers) {
  GraspState state = stepper_->state();
  std::size_t count = 0;
  visit_state(state, [&](double&) { ++count; });
  if (numbers.size() != count) {
    throw std::invalid_argument("native: the saved state is of another scene");
  }
  auto next = numbers.begin();
  visit_state(state, [&](double& value) { value = *next++; });
  stepper_->set_state(state);
}

}  // namespace prehend::simulation::engines
