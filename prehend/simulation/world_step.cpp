// One step of the world: what touches, how it moves, what falls asleep.

#include <algorithm>
#include <cmath>

#include "prehend/contact/rotation.h"
#include "prehend/contact/sdirk.h"
#include "prehend/simulation/world_implementation.h"

namespace prehend::simulation {

using geometry::RigidTransform;

namespace {

// A body that touches only the table and has not moved for this long is left out of the system
// until something that moves touches it.
constexpr double kSleepTime = 0.3;    // s
constexpr double kStillSpeed = 2e-4;  // m/s, of any point of the body

}  // namespace

// How near [m] the gripper must be for anything of it to touch body `i` within twice the step.
double World::Implementation::reach_of(int i, double h) const {
  const BodyState& body = state.motion.bodies[i];
  const double distance = (body.p_WBcm - stage_start.X_WG.translation()).norm() + gripper_radius;
  const double speed = (body.velocity - stage_start.velocity).norm() +
                       body.angular_velocity.norm() * (distance + models[i].radius) +
                       std::abs(stage_start.yaw_rate) * (distance + models[i].radius) +
                       std::abs(state.motion.slide_velocity);
  const double drive = slide_step.most_force(0, state.motion.slide, state.motion.slide_velocity);
  return 2 * h * (speed + h * (std::abs(scene.gravity) + drive / slide_model.mass));
}

void World::Implementation::detect_pads(int i, double h) {
  const BodyState& body = state.motion.bodies[i];
  const BodyModel& model = models[i];
  const RigidTransform X_WS = body_pose(model, body) * model.felt.X_BS;
  const ModelRules& rules = scene.physics.rules;
  const double drive = slide_step.most_force(0, state.motion.slide, state.motion.slide_velocity);
  for (int k : {0, 1}) {
    // As far as speeds, gravity and the drive can bring it within the step.
    const contact::Vector6 twist =
        contact::relative_twist(mounts[k], places[k], state.motion.slide_velocity, body.velocity,
                                body.angular_velocity, body.p_WBcm);
    const double acceleration =
        std::abs(scene.gravity) + drive / slide_model.mass * mounts[k].direction_G.norm();
    const double look_ahead =
        2 * h * (twist.head<3>().norm() + twist.tail<3>().norm() * model.radius + h * acceleration);
    PadTouch& touch = state.motion.touches[i][k];
    PadWork& work = pad_work[i][k];
    const bool met = contact::find_depths(
        mounts[k].layout, reaches[k], model.felt.shape, places[k].X_PW() * X_WS, look_ahead,
        touch.texels, rules.gate_texels, rules.remember_triangles ? &work.hits : nullptr);
    if (!met) {
      let_go(i, k, h);
      continue;
    }
    wake(i);
    pads.push_back(
        {i, &mounts[k], &places[k], &work.law, &touch.texels, &work.scratch, &work.response});
  }
}

void World::Implementation::let_go(int i, int k, double h) {
  PadTouch& touch = state.motion.touches[i][k];
  if (!touch.presses && touch.texels.foam.empty()) return;
  touch.presses = false;
  contact::release(mounts[k].layout, mounts[k].law, h, touch.texels);
}

void World::Implementation::detect(double h) {
  contacts.clear();
  pads.clear();
  const ModelRules& rules = scene.physics.rules;
  const int count = static_cast<int>(models.size());
  for (int i = 0; i < count; ++i) {
    if (rules.skip_distant_pairs && !near_gripper(models[i], state.motion.bodies[i], scene.gripper,
                                                  stage_start, reach_of(i, h))) {
      for (const int k : {0, 1}) let_go(i, k, h);
      continue;
    }
    detect_gripper(models[i], state.motion.bodies[i], i, scene.gripper, stage_start,
                   rules.rigid_pads, contacts);
    if (!rules.rigid_pads) detect_pads(i, h);
  }
  for (const ContactPoint& contact : contacts) wake(contact.a);
  if (engine) return sort_contacts();
  // Waking spreads from body to body.
  bool woken = true;
  while (woken) {
    woken = false;
    between.clear();
    for (int i = 0; i < count; ++i) {
      for (int j = i + 1; j < count; ++j) {
        if (!moves(i) && !moves(j)) continue;
        const std::size_t before = between.size();
        detect_bodies(models[i], state.motion.bodies[i], i, models[j], state.motion.bodies[j], j,
                      rules.skip_distant_pairs, between);
        if (between.size() == before) continue;
        const bool woke_i = wake(i), woke_j = wake(j);
        woken = woken || woke_i || woke_j;
      }
    }
  }
  contacts.insert(contacts.end(), between.begin(), between.end());
  for (int i = 0; i < count; ++i) {
    if (moves(i)) detect_table(models[i], state.motion.bodies[i], i, h, contacts);
  }
  sort_contacts();
}

void World::Implementation::sort_contacts() {
  std::sort(contacts.begin(), contacts.end(),
            [](const ContactPoint& x, const ContactPoint& y) { return x.key < y.key; });
}

bool World::Implementation::wake(int i) {
  if (!state.motion.bodies[i].asleep) return false;
  state.motion.bodies[i].asleep = false;
  state.motion.bodies[i].still_time = 0;
  return true;
}

void World::Implementation::fetch_bristles(const Eigen::Matrix3d& R_WG) {
  auto stored = state.motion.bristles.begin();
  for (ContactPoint& contact : contacts) {
    while (stored != state.motion.bristles.end() && stored->key < contact.key) ++stored;
    if (stored == state.motion.bristles.end() || stored->key != contact.key) continue;
    const Eigen::Vector3d z =
        is_pad(contact.partner) ? Eigen::Vector3d(R_WG * stored->bristle) : stored->bristle;
    contact.bristle = z - contact.normal.dot(z) * contact.normal;
  }
}

void World::Implementation::store_bristles(const Eigen::Matrix3d& R_WG) {
  // Sleeping bodies' table contacts are not detected; their bristles wait.
  kept.clear();
  for (const StoredBristle& stored : state.motion.bristles) {
    const auto id = static_cast<std::uint32_t>(stored.key >> 40);
    for (std::size_t i = 0; i < models.size(); ++i) {
      if (models[i].id == id && state.motion.bodies[i].asleep) kept.push_back(stored);
    }
  }
  for (const ContactPoint& contact : contacts) {
    if (contact.bristle.isZero(0)) continue;
    kept.push_back({contact.key, is_pad(contact.partner)
                                     ? Eigen::Vector3d(R_WG.transpose() * contact.bristle)
                                     : contact.bristle});
  }
  std::sort(kept.begin(), kept.end(),
            [](const StoredBristle& x, const StoredBristle& y) { return x.key < y.key; });
  std::swap(state.motion.bristles, kept);
}

void World::Implementation::fill_solver_bodies(const Motion& guess) {
  solver_bodies.resize(models.size());
  for (std::size_t i = 0; i < models.size(); ++i) {
    const BodyModel& model = models[i];
    const BodyState& body = state.motion.bodies[i];
    SolverBody& solver_body = solver_bodies[i];
    solver_body.is_free = moves(static_cast<int>(i));
    solver_body.center = body.p_WBcm;
    if (!solver_body.is_free) continue;
    solver_body.mass = model.mass;
    solver_body.radius = model.radius;
    solver_body.inertia = model.inertia;
    solver_body.q_WB = body.q_WB;
    solver_body.force = Eigen::Vector3d(0, 0, -scene.gravity * model.mass);
    if (engine) {
      solver_body.force += engine->reaction(i).head<3>();
      solver_body.torque = engine->reaction(i).tail<3>();
    }
    solver_body.velocity = body.velocity;
    solver_body.angular_velocity = body.angular_velocity;
    solver_body.velocity_guess = guess.bodies[i].velocity;
    solver_body.angular_velocity_guess = guess.bodies[i].angular_velocity;
  }
}

void World::Implementation::stage(double h, double t_end, const Motion& guess) {
  Motion& motion = state.motion;
  // The gripper is where its velocity would have it come from to where it is at the end.
  const RigidTransform X_WG_end = state.carrier.pose_after(t_end);
  const double yaw_rate = state.carrier.yaw_rate_after(t_end);
  const Eigen::Vector3d angular(0, 0, yaw_rate);
  stage_start = {X_WG_end, state.carrier.velocity_after(t_end), yaw_rate, opening()};
  stage_start.X_WG.translation() -= h * stage_start.velocity;
  stage_start.X_WG.linear() =
      contact::rotation_by(-h * angular).toRotationMatrix() * X_WG_end.linear();
  for (int k : {0, 1}) {
    places[k] =
        contact::place_pad(mounts[k], X_WG_end, stage_start.velocity, angular, motion.slide, h);
  }
  detect(h);
  fetch_bristles(stage_start.X_WG.linear());
  fill_solver_bodies(guess);
  SolverSlide slide;
  slide.step = &slide_step;
  slide.mass = slide_model.mass;
  slide.lower = -scene.gripper.max_opening;
  slide.position = motion.slide;
  slide.bristle = motion.slide_bristle;
  slide.end_time = t_end;
  slide.velocity = motion.slide_velocity;
  slide.velocity_guess = guess.slide_velocity;
  solver.solve(h, slide, solver_bodies, contacts, pads);

  if (engine) step_engine();
  for (std::size_t i = 0; !engine && i < models.size(); ++i) {
    if (!solver_bodies[i].is_free) continue;
    motion.bodies[i].velocity = solver_bodies[i].velocity;
    motion.bodies[i].angular_velocity = solver_bodies[i].angular_velocity;
    integrate(h, motion.bodies[i]);
  }
  for (const PadContact& pad : pads) {
    const int k = pad.place == &places[0] ? 0 : 1;
    PadTouch& touch = motion.touches[pad.body][k];
    touch.presses = touch.presses || pad.response->pressing > 0;
    if (pad.response->pressing == 0) clear(touch);
  }
  motion.slide_velocity = slide.velocity;
  motion.slide += h * slide.velocity;
  motion.slide_bristle = slide_step.advanced_bristle(slide.bristle, h, slide.velocity);
  store_bristles(stage_start.X_WG.linear());
}

// Moves the objects by the engine under what the gripper does to them in this stage.
void World::Implementation::step_engine() {
  wrenches.assign(models.size(), WorldEngine::Vector6::Zero());
  const auto push = [&](int body, const Eigen::Vector3d& point, const Eigen::Vector3d& force) {
    wrenches[body].head<3>() += force;
    wrenches[body].tail<3>() += (point - solver_bodies[body].center).cross(force);
  };
  for (const ContactPoint& contact : contacts) push(contact.a, contact.point, contact.force);
  for (const PadContact& pad : pads) {
    if (pad.response->pressing == 0) continue;
    push(pad.body, pad.place->p_WP, pad.wrench_W.head<3>());
    wrenches[pad.body].tail<3>() += pad.wrench_W.tail<3>();
  }
  engine->step(wrenches, models, state.motion.bodies);
}

void World::Implementation::reload_engine() {
  if (engine) engine->load(models, state.motion.bodies);
}

void World::Implementation::second_order(double h) {
  const double part = contact::kSdirkGamma * h;
  base = state.motion;
  stage(part, part, state.motion);
  std::swap(first, state.motion);
  extrapolate();
  stage(part, h, first);
}

// From base and first into the state. A body that was woken in the first stage was at rest in base.
void World::Implementation::extrapolate() {
  Motion& out = state.motion;
  out = first;
  for (std::size_t i = 0; i < models.size(); ++i) {
    for (int k : {0, 1}) {
      contact::sdirk_keep_foam(first.touches[i][k].texels, out.touches[i][k].texels);
    }
    if (!moves(static_cast<int>(i))) continue;
    const auto motion = [i](const Motion& m) {
      const BodyState& body = m.bodies[i];
      return contact::RigidMotion{body.p_WBcm, body.q_WB, body.velocity, body.angular_velocity};
    };
    const contact::RigidMotion body =
        contact::sdirk_extrapolated(motion(base), motion(first), models[i].inertia);
    out.bodies[i].p_WBcm = body.p_WB;
    out.bodies[i].q_WB = body.q_WB;
    out.bodies[i].velocity = body.velocity;
    out.bodies[i].angular_velocity = body.angular_velocity;
    for (int k : {0, 1}) {
      if (!first.touches[i][k].presses) continue;
      contact::sdirk_extrapolate(base.touches[i][k].texels, first.touches[i][k].texels,
                                 out.touches[i][k].texels);
    }
  }
  out.slide = contact::sdirk_extrapolated(base.slide, first.slide);
  out.slide_velocity = contact::sdirk_extrapolated(base.slide_velocity, first.slide_velocity);
  out.slide_bristle = contact::sdirk_extrapolated(base.slide_bristle, first.slide_bristle);
  // Contacts that are new had none in base.
  auto before = base.bristles.begin();
  for (StoredBristle& stored : out.bristles) {
    while (before != base.bristles.end() && before->key < stored.key) ++before;
    const bool known = before != base.bristles.end() && before->key == stored.key;
    const Eigen::Vector3d old = known ? before->bristle : Eigen::Vector3d(Eigen::Vector3d::Zero());
    stored.bristle = contact::sdirk_extrapolated(old, stored.bristle);
  }
}

void World::Implementation::step() {
  if (scene.physics.adaptive) {
    advance_adaptively(1, [] { return false; });
    return;
  }
  const double h = scene.step;
  state.carrier.begin_step(h);
  slide_step.set_command(
      state.gripper.begin_step(h, state.motion.slide, state.motion.slide_velocity), 0);
  if (scene.physics.integration == contact::Integration::kSecondOrder) {
    second_order(h);
  } else {
    stage(h, h, state.motion);
  }
  if (scene.drive.thread) state.gripper.observe_load(load_on_slide());
  read_sensors(h);
  fall_asleep(h);
  state.gripper.end_step(h, state.motion.slide, state.motion.slide_velocity);
  state.carrier.end_step(h);
  ++state.steps;
}

// What pads and fingers felt in the last stage, against closing [N].
double World::Implementation::load_on_slide() const {
  double load = 0;
  for (const ContactPoint& contact : contacts) load += contact.force.dot(contact.slide_motion);
  for (const PadContact& pad : pads) {
    if (pad.response->pressing == 0) continue;
    const Eigen::Vector3d motion = stage_start.X_WG.linear() * pad.mount->direction_G;
    load += pad.wrench_W.head<3>().dot(motion);
  }
  return load;
}

void World::Implementation::fall_asleep(double h) {
  if (!scene.physics.rules.sleep || engine) return;
  free_standing.assign(models.size(), true);
  for (const ContactPoint& contact : contacts) {
    if (contact.partner != kTable) free_standing[contact.a] = false;
    if (contact.b >= 0) free_standing[contact.b] = false;
  }
  for (const PadContact& pad : pads) free_standing[pad.body] = false;
  for (std::size_t i = 0; i < models.size(); ++i) {
    BodyState& body = state.motion.bodies[i];
    if (!moves(static_cast<int>(i))) continue;
    const double fastest =
        body.velocity.norm() + body.angular_velocity.norm() * models[i].box.sizes().norm();
    const bool still = free_standing[i] && body.touches_table && fastest < kStillSpeed;
    body.still_time = still ? body.still_time + h : 0.0;
    if (body.still_time < kSleepTime) continue;
    body.asleep = true;
    body.velocity.setZero();
    body.angular_velocity.setZero();
  }
}

}  // namespace prehend::simulation
