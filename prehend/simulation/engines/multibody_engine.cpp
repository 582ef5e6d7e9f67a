#include "prehend/simulation/engines/multibody_engine.h"

#include <cmath>

namespace prehend::simulation::engines {
namespace {

const double kGamma = 1 - 1 / std::sqrt(2.0);

// Every number of a state but touches, which vary in number, and what follows from the others.
template <class State, class Visit>
void visit_multibody_state(State& state, Visit visit) {
  visit(state.time);
  for (auto& X : state.X_WB) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 4; ++c) visit(X.matrix()(r, c));
    }
  }
  for (auto& momentum : state.momenta) {
    for (int k = 0; k < 6; ++k) visit(momentum[k]);
  }
  for (auto* values : {&state.positions, &state.velocities}) {
    for (Eigen::Index i = 0; i < values->size(); ++i) visit((*values)[i]);
  }
  for (auto& pad : state.pads) visit_pad_state(pad, visit);
}

// Whether the same bodies press on one another in as many points.
bool press_alike(const MultibodyState& a, const MultibodyState& b) {
  const auto next = [](auto& at, const auto& touches) {
    while (at != touches.end() && !(at->normal_force > 0)) ++at;
    return at != touches.end();
  };
  auto i = a.touches.begin(), j = b.touches.begin();
  while (true) {
    const bool more_a = next(i, a.touches), more_b = next(j, b.touches);
    if (more_a != more_b) return false;
    if (!more_a) return true;
    if (i->a != j->a || i->b != j->b) return false;
    ++i;
    ++j;
  }
}

// Pieces touch nothing but pads.
void refuse_pieces(const EngineScene& scene) {
  int touching = scene.ground ? 1 : 0;
  for (int b = 0; b < static_cast<int>(scene.bodies.size()); ++b) {
    if (scene.bodies[b].collides && !has_pads(scene, b)) ++touching;
  }
  for (const EngineBody& body : scene.bodies) {
    if (body.shape.kind != EngineShape::Kind::kConvexPieces || !body.collides || touching < 2) {
      continue;
    }
    throw UnsupportedScene(
        "native: body '" + body.name +
        "' is made of convex pieces, which touch pads alone here; World and RobotWorld have meshes "
        "as they are");
  }
}

// What a step needs of a touch of the step before.
constexpr std::size_t kTouchNumbers = 14;

}  // namespace

std::string MultibodyEngine::version() const { return "prehend, multibody"; }

void check_native_solver(const EngineScene& scene) {
  if (scene.solver.empty() || scene.solver == "first_order" || scene.solver == "second_order") {
    return;
  }
  throw UnsupportedScene("native: solver '" + scene.solver +
                         "' is none of first_order, second_order");
}

void MultibodyEngine::load(const EngineScene& scene) {
  if (scene.pad_method != PadMethod::kTexelLaw) {
    throw UnsupportedScene("native: its pads follow the texel law");
  }
  check_native_solver(scene);
  refuse_pieces(scene);
  second_order_ = scene.solver == "second_order";
  scene_ = scene;
  system_ = std::make_unique<Multibody>(scene);
  state_ = system_->initial_state();
}

void MultibodyEngine::step() {
  const double h = scene_.step;
  bool first_order = !second_order_;
  if (second_order_) {
    system_->implicit_euler(state_, kGamma * h, state_, first_);
    // The second stage starts from the first's slope alone, which an impact is not.
    first_order = !press_alike(state_, first_);
    if (!first_order) {
      system_->extrapolate(state_, first_, (1 - kGamma) / kGamma, extrapolated_);
      system_->implicit_euler(extrapolated_, kGamma * h, first_, next_);
      next_.time = state_.time + h;
      first_order = !press_alike(first_, next_);
    }
  }
  if (first_order) system_->implicit_euler(state_, h, state_, next_);
  std::swap(state_, next_);
}

std::vector<double> MultibodyEngine::pad_forces(int pad) const {
  std::vector<double> forces(scene_.pads.at(pad).layout.size(), 0.0);
  add_pad_forces(system_->pad_touches(), state_.pads, pad, forces);
  return forces;
}

std::vector<double> MultibodyEngine::save() const {
  std::vector<double> numbers;
  visit_multibody_state(state_, [&](const double& value) { numbers.push_back(value); });
  for (const TouchPoint& touch : state_.touches) {
    numbers.push_back(touch.a);
    numbers.push_back(touch.b);
    numbers.insert(numbers.end(), touch.p_A.data(), touch.p_A.data() + 3);
    numbers.insert(numbers.end(), touch.bristle.data(), touch.bristle.data() + 3);
    numbers.insert(numbers.end(), touch.turn.data(), touch.turn.data() + 3);
    numbers.insert(numbers.end(), {touch.normal_force, touch.unborne, touch.foreseen});
  }
  return numbers;
}

void MultibodyEngine::restore(const std::vector<double>& numbers) {
  MultibodyState state = state_;
  std::size_t count = 0;
  visit_multibody_state(state, [&](double&) { ++count; });
  if (numbers.size() < count || (numbers.size() - count) % kTouchNumbers != 0) {
    throw std::invalid_argument("native: the saved state is of another scene");
  }
  auto next = numbers.begin();
  visit_multibody_state(state, [&](double& value) { value = *next++; });
  for (PadLoad& load : state.pad_loads) load.is_near = true;  // so that nothing stays behind
  state.touches.clear();
  for (; next != numbers.end(); next += kTouchNumbers) {
    TouchPoint touch;
    touch.a = static_cast<int>(next[0]);
    touch.b = static_cast<int>(next[1]);
    touch.p_A = {next[2], next[3], next[4]};
    touch.bristle = {next[5], next[6], next[7]};
    touch.turn = {next[8], next[9], next[10]};
    touch.normal_force = next[11];
    touch.unborne = next[12];
    touch.foreseen = next[13];
    state.touches.push_back(touch);
  }
  state_ = state;
}

}  // namespace prehend::simulation::engines
