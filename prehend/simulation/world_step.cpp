// One step of the world: what touches, how it moves, what falls asleep.

#include <algorithm>

#include "prehend/simulation/world_implementation.h"

namespace prehend::simulation {
namespace {

// A body that touches only the table and has not moved for this long is left out of the system
// until something that moves touches it.
constexpr double kSleepTime = 0.3;    // s
constexpr double kStillSpeed = 2e-4;  // m/s, of any point of the body

}  // namespace

void World::Implementation::detect() {
  contacts.clear();
  const GripperPlacement gripper = placement();
  const int count = static_cast<int>(models.size());
  for (int i = 0; i < count; ++i) {
    detect_gripper(models[i], state.bodies[i], i, scene.gripper, gripper, contacts);
  }
  for (const ContactPoint& contact : contacts) wake(contact.a);
  // Waking spreads from body to body.
  bool woken = true;
  std::vector<ContactPoint> between;
  while (woken) {
    woken = false;
    between.clear();
    for (int i = 0; i < count; ++i) {
      for (int j = i + 1; j < count; ++j) {
        if (!moves(i) && !moves(j)) continue;
        const std::size_t before = between.size();
        detect_bodies(models[i], state.bodies[i], i, models[j], state.bodies[j], j, between);
        if (between.size() > before) woken = wake(i) || wake(j) || woken;
      }
    }
  }
  contacts.insert(contacts.end(), between.begin(), between.end());
  for (int i = 0; i < count; ++i) {
    if (moves(i)) detect_table(models[i], state.bodies[i], i, scene.step, contacts);
  }
  std::sort(contacts.begin(), contacts.end(),
            [](const ContactPoint& x, const ContactPoint& y) { return x.key < y.key; });
}

bool World::Implementation::wake(int i) {
  if (!state.bodies[i].asleep) return false;
  state.bodies[i].asleep = false;
  state.bodies[i].still_time = 0;
  return true;
}

void World::Implementation::fetch_bristles(const Eigen::Matrix3d& R_WG) {
  auto stored = state.bristles.begin();
  for (ContactPoint& contact : contacts) {
    while (stored != state.bristles.end() && stored->key < contact.key) ++stored;
    if (stored == state.bristles.end() || stored->key != contact.key) continue;
    const Eigen::Vector3d z =
        is_pad(contact.partner) ? Eigen::Vector3d(R_WG * stored->bristle) : stored->bristle;
    contact.bristle = z - contact.normal.dot(z) * contact.normal;
  }
}

void World::Implementation::store_bristles(const Eigen::Matrix3d& R_WG) {
  // Sleeping bodies' table contacts are not detected; their bristles wait.
  std::vector<StoredBristle> kept;
  for (const StoredBristle& stored : state.bristles) {
    const auto id = static_cast<std::uint32_t>(stored.key >> 40);
    for (std::size_t i = 0; i < models.size(); ++i) {
      if (models[i].id == id && state.bodies[i].asleep) kept.push_back(stored);
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
  state.bristles = std::move(kept);
}

std::vector<SolverBody> World::Implementation::solver_bodies() const {
  std::vector<SolverBody> bodies(models.size());
  for (std::size_t i = 0; i < models.size(); ++i) {
    const BodyModel& model = models[i];
    const BodyState& body = state.bodies[i];
    SolverBody& solver_body = bodies[i];
    solver_body.is_free = moves(static_cast<int>(i));
    solver_body.center = body.p_WBcm;
    if (!solver_body.is_free) continue;
    const Eigen::Matrix3d R = body.q_WB.toRotationMatrix();
    solver_body.mass = model.mass;
    solver_body.inertia_W = R * model.inertia * R.transpose();
    solver_body.force = Eigen::Vector3d(0, 0, -scene.gravity * model.mass);
    solver_body.torque =
        -body.angular_velocity.cross(solver_body.inertia_W * body.angular_velocity);
    solver_body.velocity = body.velocity;
    solver_body.angular_velocity = body.angular_velocity;
  }
  return bodies;
}

void World::Implementation::step() {
  const double h = scene.step;
  state.carrier.begin_step(h);
  state.drive.begin_step(h);
  detect();
  const GripperPlacement gripper = placement();
  fetch_bristles(gripper.X_WG.linear());
  std::vector<SolverBody> bodies = solver_bodies();
  double jaw_velocity = state.drive.velocity();
  solve_contacts(h, state.drive, bodies, contacts, jaw_velocity);
  read_sensors(gripper);
  store_bristles(gripper.X_WG.linear());
  for (std::size_t i = 0; i < models.size(); ++i) {
    if (!bodies[i].is_free) continue;
    state.bodies[i].velocity = bodies[i].velocity;
    state.bodies[i].angular_velocity = bodies[i].angular_velocity;
    integrate(h, state.bodies[i]);
  }
  fall_asleep(h);
  state.drive.end_step(h, jaw_velocity);
  state.carrier.end_step(h);
  ++state.steps;
}

void World::Implementation::fall_asleep(double h) {
  std::vector<bool> free_standing(models.size(), true);
  for (const ContactPoint& contact : contacts) {
    if (contact.partner != kTable) free_standing[contact.a] = false;
    if (contact.b >= 0) free_standing[contact.b] = false;
  }
  for (std::size_t i = 0; i < models.size(); ++i) {
    BodyState& body = state.bodies[i];
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
