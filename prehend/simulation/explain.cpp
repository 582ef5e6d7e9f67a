#include "prehend/simulation/explain_parts.h"

#include <algorithm>
#include <cmath>

#include "prehend/simulation/world_implementation.h"

namespace prehend::simulation {
namespace {

// Farthest that the mesh of a ball or can lies inside the round surface, its bevels apart: at the
// middle of a facet's longest edge or of the facet.
double sagitta(const BodyModel& model) {
  const bool ball = model.felt.shape.kind() == contact::Shape::Kind::kSphere;
  const double radius = model.felt.shape.radius();
  const auto radius_at = [&](const Eigen::Vector3d& p) {
    const Eigen::Vector3d from_centre = p - model.felt.X_BS.translation();
    return ball ? from_centre.norm() : from_centre.head<2>().norm();
  };
  double most = 0;
  for (const Eigen::Vector3i& t : model.mesh->triangles) {
    const auto& v = model.mesh->vertices;
    const Eigen::Vector3d corners[] = {v[t[0]], v[t[1]], v[t[2]]};
    bool on_surface = true;
    for (const Eigen::Vector3d& p : corners) {
      on_surface = on_surface && radius_at(p) > radius * (1 - 1e-6);
    }
    if (!on_surface) continue;
    most = std::max(most, radius - radius_at((corners[0] + corners[1] + corners[2]) / 3));
    for (int k = 0; k < 3; ++k) {
      most = std::max(most, radius - radius_at((corners[k] + corners[(k + 1) % 3]) / 2));
    }
  }
  return most;
}

}  // namespace

std::string law_text(const contact::TexelLaw& law) {
  std::string result;
  switch (law.normal_law) {
    case contact::NormalLaw::kLinear:
      result =
          explained_text("linear spring %g N/m and damper %g N s/m", law.stiffness, law.damping);
      break;
    case contact::NormalLaw::kHuntCrossley:
      result = explained_text("Hunt-Crossley, exponent %g", law.exponent);
      break;
    case contact::NormalLaw::kTabulated:
      result = "measured compression curve";
      break;
  }
  result += law.bristle_law == contact::BristleLaw::kLuGre ? "; LuGre friction"
                                                           : "; elasto-plastic LuGre friction";
  if (law.return_map) result += ", never above mu_s Fn";
  for (const auto& term : law.memory.creep) {
    result += explained_text("; creep of %g %% in %g s", 100 * term.share, term.time);
  }
  for (const auto& term : law.memory.hysteresis) {
    result +=
        explained_text("; hysteresis of %g %% from %g mm on", 100 * term.share, 1e3 * term.depth);
  }
  return result;
}

const char* shape_text(contact::Shape::Kind kind) {
  switch (kind) {
    case contact::Shape::Kind::kBox:
      return "a box";
    case contact::Shape::Kind::kSphere:
      return "a ball";
    case contact::Shape::Kind::kCylinder:
      return "a cylinder";
    default:
      return "its mesh";
  }
}

void explain_primitive(const BodyModel& model, const std::string& who, Explanation& out) {
  const contact::Shape::Kind kind = model.felt.shape.kind();
  if (kind == contact::Shape::Kind::kMesh) return;
  const bool box = kind == contact::Shape::Kind::kBox;
  const double error = box ? 1e-9 : sagitta(model);
  std::string error_text = box ? "none but rounding, 1e-9 m"
                               : explained_text("at most %.3g um, the mesh's facets", 1e6 * error);
  if (kind == contact::Shape::Kind::kCylinder) {
    error_text += "; up to 2 mm at its rims, which the mesh has bevelled";
  }
  out.left_out.push_back({"mesh of " + model.name, "primitives", error, "m", error_text,
                          who + shape_text(kind) + ", which it is"});
}

namespace {

void explain_integration(const Scene& scene, Explanation& out) {
  if (scene.physics.adaptive) {
    out.modelled.push_back(
        {"time", explained_text(
                     "implicit steps of second order (SDIRK2), up to 0.1 s, for a tolerance of %g "
                     "um; at most %g ms while the drive speeds up or brakes",
                     1e6 * scene.physics.tolerance, 1e3 * scene.step)});
    return;
  }
  const bool second = scene.physics.integration == contact::Integration::kSecondOrder;
  out.modelled.push_back(
      {"time",
       explained_text("implicit steps of %g ms, %s; at most %d solutions each", 1e3 * scene.step,
                      second ? "second order (SDIRK2)" : "first order (backward Euler)",
                      scene.physics.most_iterations)});
}

void explain_engine(const Scene& scene, const WorldEngine* engine, Explanation& out) {
  if (!engine) {
    out.modelled.push_back({"engine", "native: all bodies that touch one another in one system"});
    return;
  }
  out.modelled.push_back(
      {"engine", scene.physics.engine + " (" + engine->version() + ")" +
                     (scene.physics.solver.empty() ? "" : ", solver " + scene.physics.solver) +
                     ": objects, table and what is between them; pads, fingers and drive are "
                     "native's and push the objects"});
}

void explain_gripper(const Scene& scene, Explanation& out) {
  const robot::TactilePadModel& pad = scene.gripper.pad;
  const ModelRules& rules = scene.physics.rules;
  const SpindleDriveModel drive = drive_of(scene.gripper, scene.drive);
  out.modelled.push_back(
      {"drive",
       explained_text("motor, gear and spindle: %g N/A, %g kg at the jaws, stiction %g N, at most "
                      "%g A and %g mm/s; both jaws on one slide",
                      drive.force_per_current(), drive.reflected_mass(), drive.static_friction,
                      drive.peak_current, 1e3 * drive.max_speed)});
  if (drive.thread) {
    const PowerScrew screw = drive.screw();
    out.modelled.push_back(
        {"thread of the drive",
         explained_text("friction of %.3g against and %.3g along the load: efficiency %.3g, %s",
                        screw.friction_against_load(), screw.friction_along_load(),
                        screw.efficiency(),
                        screw.is_self_locking() ? "locks itself" : "does not lock itself")});
  }
  out.modelled.push_back({"fingers, housing", "stiff boxes that touch objects' surface points"});
  out.modelled.push_back({"wrist", scene.wrench ? "force and torque sensor with its errors"
                                                : "forces and torques as they are"});
  if (rules.rigid_pads) {
    const double force = drive.force_per_current() * drive.nominal_current;
    const double give = force / (pad.rows * pad.columns * pad.law.stiffness);
    out.modelled.push_back({"pads", "stiff boxes with the pads' friction"});
    out.left_out.push_back(
        {explained_text("%d texels of both pads", 2 * pad.rows * pad.columns), "rigid_pads", give,
         "m",
         explained_text("at most %.3g mm that the foam gives way at %g N; no touch can be read",
                        1e3 * give, force),
         "physics.pads is rigid: nobody asks for touch"});
    return;
  }
  out.modelled.push_back(
      {"pads", explained_text("2 x %d x %d texels: %s; electronics %s", pad.rows, pad.columns,
                              law_text(scene.tactile.law_of(pad, 0)).c_str(),
                              scene.tactile.about().c_str())});
  if (rules.gate_texels) {
    out.left_out.push_back({explained_text("%d rays of the pads", 2 * pad.rows * pad.columns),
                            "gate_texels", 0, "m", "none: bitwise the same",
                            "in each step in which no object's bounds are within their reach"});
  }
}

void explain_object(const BodyModel& model, const BodyState& state, const Scene& scene,
                    const WorldEngine* engine, Explanation& out) {
  const ModelRules& rules = scene.physics.rules;
  if (const auto* pieces = engine ? engine->pieces(model) : nullptr) {
    out.modelled.push_back(
        {model.name + " in " + scene.physics.engine,
         explained_text(
             "%zu convex pieces that reach at most %.3g mm beyond its mesh; mass, centre and "
             "inertia are the mesh's",
             pieces->meshes_B->size(), 1e3 * pieces->concavity)});
  }
  const char* felt = rules.rigid_pads ? "its surface points" : shape_text(model.felt.shape.kind());
  out.modelled.push_back(
      {model.name,
       explained_text("rigid body of %g kg, %s; pads feel %s; %zu points touch the table, %zu "
                      "the gripper and others; mesh of %zu triangles",
                      model.mass, state.asleep ? "asleep until touched" : "free", felt,
                      model.hull_points.size(), model.surface_points.size(),
                      model.mesh->triangles.size())});
  if (state.asleep) {
    const double sinking =
        model.mass * std::abs(scene.gravity) /
        (static_cast<double>(carrying_points(model, state)) * model.table_law.stiffness);
    out.left_out.push_back(
        {"motion of " + model.name, "out_of_reach", sinking, "m",
         explained_text("at most %.3g um of sinking into the table", 1e6 * sinking),
         "the gripper cannot come there within the carrier's limits, and it "
         "stands stably; it wakes when something that moves touches it"});
  }
  if (!rules.rigid_pads) explain_primitive(model, "pads feel it as ", out);
}

void explain_rules(const Scene& scene, std::size_t n, bool any_mesh, Explanation& out) {
  const ModelRules& rules = scene.physics.rules;
  if (rules.remember_triangles && any_mesh && !rules.rigid_pads) {
    out.left_out.push_back({"rays on meshes", "remember_triangles", 0, "m",
                            "none: bitwise the same",
                            "while neither pad nor object moves by 4 nm they meet what they met"});
  }
  if (rules.skip_distant_pairs) {
    out.left_out.push_back(
        {explained_text("search for touching points of %zu pairs", n + n * (n - 1) / 2),
         "skip_distant_pairs", 0, "m", "none: bitwise the same",
         "in each step in which their bounds do not meet"});
  }
  if (rules.sleep && n > 0 && scene.physics.engine == "native") {
    out.left_out.push_back({"objects at rest", "sleep", 2e-5, "m",
                            "20 um of further settling, as measured; a slower roll is stopped",
                            "once an object has stood still on the table alone for 0.3 s"});
  }
  out.left_out.push_back({"the carrier's yielding", "", kNoBound, "m", "not known",
                          "the carrier moves as told, whatever pushes it"});
  out.left_out.push_back({"the motor's inductance", "", kNoBound, "m", "not known",
                          "its time constant is below a millisecond"});
  out.left_out.push_back({"objects' and fingers' bending", "", kNoBound, "m", "not known",
                          "only the pads' foam gives way; all else is rigid but for stiff springs "
                          "at the points that touch"});
  const auto say_off = [&](bool on, const char* name) {
    if (!on) out.rules_off.emplace_back(name);
  };
  say_off(rules.gate_texels, "gate_texels");
  say_off(rules.remember_triangles, "remember_triangles");
  say_off(rules.skip_distant_pairs, "skip_distant_pairs");
  say_off(rules.sleep, "sleep");
  say_off(rules.out_of_reach, "out_of_reach");
  say_off(rules.primitives, "primitives");
  say_off(rules.rigid_pads, "rigid_pads");
}

}  // namespace

Explanation World::explained() const {
  const Implementation& world = *implementation_;
  Explanation out;
  explain_engine(world.scene, world.engine.get(), out);
  explain_integration(world.scene, out);
  explain_gripper(world.scene, out);
  out.modelled.push_back(
      {"table", explained_text("the plane z = 0, friction %g", world.scene.table.friction)});
  bool any_mesh = false;
  for (std::size_t i = 0; i < world.models.size(); ++i) {
    const BodyModel& model = world.models[i];
    any_mesh = any_mesh || model.felt.shape.kind() == contact::Shape::Kind::kMesh;
    explain_object(model, world.state.motion.bodies[i], world.scene, world.engine.get(), out);
  }
  explain_rules(world.scene, world.models.size(), any_mesh, out);
  return out;
}

Explanation explain(const Scene& scene) {
  return scene.robot.empty() ? World(scene).explained() : explain_robot(scene);
}

}  // namespace prehend::simulation
