// A world's state and its commands, kept and brought back.

#include <fstream>
#include <sstream>
#include <stdexcept>

#include "prehend/contact/compression_curve.h"
#include "prehend/geometry/whole_file.h"
#include "prehend/simulation/state_frame.h"
#include "prehend/simulation/world_implementation.h"

namespace prehend::simulation {
namespace {

constexpr std::string_view kStateKind = "world-state";

}  // namespace

void World::Implementation::refuse_with_engine(const char* what) const {
  if (!engine) return;
  throw std::logic_error(std::string("a world with engine '") + scene.physics.engine +
                         "' cannot be " + what + ": that engine's state is its own. Take native");
}

std::shared_ptr<const World::State> World::save() const {
  implementation_->refuse_with_engine("saved");
  return std::make_shared<const State>(implementation_->state);
}

void World::restore(const State& state) {
  implementation_->refuse_with_engine("restored");
  if (state.body_ids != implementation_->state.body_ids) {
    throw std::invalid_argument("the saved state is of other objects than the world's");
  }
  implementation_->state = state;
  implementation_->contacts.clear();
  implementation_->pads.clear();
}

std::uint64_t World::Implementation::description() const {
  StateWriter writer;
  const auto put_law = [&](const contact::TexelLaw& law) {
    writer(law.stiffness, law.damping, law.bristle_stiffness, law.bristle_damping,
           law.viscous_friction, law.static_friction, law.dynamic_friction, law.stribeck_velocity,
           law.normal_law, law.exponent, law.bristle_law, law.elastic_limit, law.return_map);
    for (int i = 1; law.curve && i <= 32; ++i) writer(law.curve->force(1e-4 * i));
    for (const auto& term : law.memory.creep) writer(term.share, term.time);
    for (const auto& term : law.memory.hysteresis) writer(term.share, term.depth);
  };
  const PhysicsOptions& physics = scene.physics;
  writer(scene.step, scene.gravity, physics.integration, physics.velocity_tolerance,
         physics.most_iterations, physics.rules.gate_texels, physics.rules.remember_triangles,
         physics.rules.skip_distant_pairs, physics.rules.sleep, physics.rules.out_of_reach,
         physics.rules.primitives, physics.rules.rigid_pads);
  const robot::GripperModel& g = scene.gripper;
  writer(g.max_opening, g.max_speed, g.max_acceleration, g.nominal_current, g.max_current,
         g.force_per_current, g.friction_force, g.jaw_mass, g.finger_size, g.tip_margin,
         g.housing_size, g.pad.rows, g.pad.columns, g.pad.texel_pitch, g.pad.thickness,
         g.pad.newton_per_count, g.pad.full_scale);
  for (const contact::PadMount& mount : mounts) put_law(mount.law);
  const SpindleDriveModel& d = scene.drive;
  writer(d.supply, d.resistance, d.rotor_inertia, d.torque_constant, d.gear_ratio, d.spindle_lead,
         d.static_friction, d.coulomb_friction, d.viscous_friction, d.stribeck_velocity, d.ambient,
         d.thermal_resistance, d.thermal_capacity, d.hottest, d.servo_stiffness, d.velocity_gain);
  if (physics.adaptive) writer(physics.tolerance);
  if (d.thread) writer(d.thread->mean_diameter, d.thread->friction, d.thread->flank_angle);
  const CarrierModel& c = scene.carrier;
  writer(c.minimum, c.maximum, c.max_speed, c.max_acceleration, c.max_yaw_rate,
         c.max_yaw_acceleration, c.mounting_tilt);
  const TactileSensorOptions& t = scene.tactile.sensor;
  writer(t.threshold, t.gain_spread, t.pad_gain_spread, t.gains, t.zeros, t.spread, t.low_pass_time,
         t.latency, t.offset, t.drift, t.ageing, t.load_cycles, t.noise, t.dead, t.dead_rows,
         t.dead_columns, t.seed, scene.tactile.period, scene.wrench.has_value());
  if (scene.tactile.model) {
    writer(scene.tactile.sensor_name());
    for (const auto& [name, value] : scene.tactile.parameters) writer(name, value);
  }
  if (const auto& w = scene.wrench) {
    writer(w->force_noise, w->torque_noise, w->force_resolution, w->torque_resolution,
           w->force_range, w->torque_range, w->bias);
  }
  for (const BodyModel& model : models) {
    writer(model.id, model.name, model.mass, model.is_static, model.felt.shape.kind());
    for (const Eigen::Vector3d& v : model.mesh->vertices) writer(v);
    put_law(model.pad_law);
    put_law(model.table_law);
    put_law(model.rigid_law);
  }
  return fingerprint(writer.bytes());
}

std::string World::save_bytes() const {
  implementation_->refuse_with_engine("saved");
  StateWriter writer;
  writer(implementation_->description());
  writer(static_cast<std::uint64_t>(body_count()));
  for (const BodyModel& model : implementation_->models) writer(model.name);
  State state = implementation_->state;
  writer(state);
  return framed(kStateKind, writer.bytes());
}

void World::restore_bytes(std::string_view bytes, const std::string& what) {
  implementation_->refuse_with_engine("restored");
  Implementation& world = *implementation_;
  StateReader reader(unframed(kStateKind, bytes, what), what);
  const auto foreign = [&](const std::string& wrong) {
    throw geometry::InputError(what + " is of another scene: " + wrong,
                               "Restore it into a world of the scene it was saved from");
  };
  std::uint64_t description = 0, count = 0;
  reader(description, count);
  if (count != body_count()) {
    foreign("it has " + std::to_string(count) + " objects, the world " +
            std::to_string(body_count()));
  }
  for (const BodyModel& model : world.models) {
    std::string name;
    reader(name);
    if (name != model.name)
      foreign("it has '" + name + "' where the world has '" + model.name + "'");
  }
  if (description != world.description()) foreign("physics, gripper or an object's shape differ");
  State state = world.state;
  reader(state);
  if (reader.left() != 0) reader.fail("goes on after its end");
  restore(state);
}

void World::save_file(const std::filesystem::path& file) const {
  geometry::write_whole_file(file, save_bytes(), "The world's state");
}

void World::restore_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream bytes;
  if (std::filesystem::is_directory(file) || !in || !(bytes << in.rdbuf())) {
    throw geometry::InputError(file.string() + " cannot be read", "Check the path");
  }
  std::string text = bytes.str();
  if (!text.empty()) text.pop_back();  // the line's end after the bytes
  restore_bytes(text, file.string());
}

std::int64_t World::step_count() const { return implementation_->state.steps; }

void World::record_commands(bool on) {
  implementation_->records = on;
  if (on) implementation_->commands.clear();
}

const std::vector<WorldCommand>& World::recorded_commands() const {
  return implementation_->commands;
}

void World::Implementation::record(WorldCommand command) {
  if (!records) return;
  command.step = state.steps;
  commands.push_back(std::move(command));
}

}  // namespace prehend::simulation
