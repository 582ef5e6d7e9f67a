#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "prehend/contact/pad_contact.h"
#include "prehend/simulation/carrier.h"
#include "prehend/simulation/contact_detection.h"
#include "prehend/simulation/contact_solver.h"
#include "prehend/simulation/gripper_axis.h"
#include "prehend/simulation/rigid_body.h"
#include "prehend/simulation/state_bytes.h"
#include "prehend/simulation/world.h"
#include "prehend/simulation/world_commands.h"
#include "prehend/simulation/world_engine.h"

/// The inside of World: for its own files only.
namespace prehend::simulation {

inline bool is_pad(std::uint32_t partner) { return partner == kLeftPad || partner == kRightPad; }
inline bool is_gripper(std::uint32_t partner) { return partner > kTable && partner <= kRightPad; }

/// One pad's texels on one body, between two steps.
struct PadTouch {
  PadTouch(const contact::PadLayout& layout, const contact::TexelLaw& law) : texels(layout, law) {}
  contact::PadState texels;
  bool presses = false;  // false: no bristle and no force

  template <class Archive>
  void archive(Archive& archive) {
    archive(presses, same_size(texels.bristle_u), same_size(texels.bristle_v),
            same_size(texels.normal_force), same_size(texels.friction_u),
            same_size(texels.friction_v));
    if (!texels.foam.empty()) archive(same_size(texels.foam));
  }
};

inline void clear(PadTouch& touch) {
  if (touch.presses) contact::release(touch.texels);
  touch.presses = false;
}

/// What is used within a step for it.
struct PadWork {
  PadWork(const contact::PadMount& pad, const BodyModel& body) : law(pad.law), scratch(pad.layout) {
    law.static_friction = body.pad_law.static_friction;
    law.dynamic_friction = body.pad_law.dynamic_friction;
  }
  contact::TexelLaw law;
  contact::PadScratch scratch;
  contact::PadResponse response;
  contact::MeshHits hits;
};

/// What an implicit stage changes.
struct Motion {
  std::vector<BodyState> bodies;
  std::vector<std::array<PadTouch, 2>> touches;  // of each body: left pad, right pad
  std::vector<StoredBristle> bristles;           // by key
  double slide = 0;                              // m, minus the opening
  double slide_velocity = 0;                     // m/s
  double slide_bristle = 0;                      // m

  template <class Archive>
  void archive(Archive& archive) {
    archive(same_size(bodies), same_size(touches), bristles, slide, slide_velocity, slide_bristle);
  }
};

struct World::State {
  std::int64_t steps = 0;
  std::vector<std::uint32_t> body_ids;
  Motion motion;
  Carrier carrier;
  GripperAxis gripper;
  std::array<PadElectronics, 2> pads;  // left, right
  std::array<TactileImage, 2> frames;  // the last ones, of pads that are not ideal
  double frame_age = 0;                // s
  std::optional<WrenchSensor> wrist;
  ContactWrench wrench;  // in G, as the wrist shows it
  double next_step = 0;  // s, proposed, of adaptive steps; 0: steps are fixed

  template <class Archive>
  void archive(Archive& archive) {
    archive(steps, same_size(body_ids));
    archive(motion, carrier, gripper, pads, frames, frame_age, wrench.force, wrench.torque);
    if (wrist) archive(*wrist);
    if (next_step > 0) archive(next_step);
  }
};

struct World::Implementation {
  Scene scene;
  std::vector<BodyModel> models;
  State state;
  std::uint64_t generation = 1;
  std::uint32_t next_id = 1;
  std::unique_ptr<WorldEngine> engine;  // null: native
  std::shared_ptr<const geometry::TriangleMesh> finger_mesh, housing_mesh, pad_mesh;
  bool shows_robot = true;  // to cameras

  // The gripper's pads and slide.
  std::array<contact::PadMount, 2> mounts;
  std::array<contact::PadReach, 2> reaches;
  contact::SlideModel slide_model;
  contact::SlideStep slide_step;
  double gripper_radius = 0;  // m, of a ball round G that holds it at any opening

  // Buffers of a step.
  ContactSolver solver;
  std::vector<std::array<PadWork, 2>> pad_work;  // of each body
  std::vector<ContactPoint> contacts, between;
  std::vector<PadContact> pads;
  std::array<contact::PadPlacement, 2> places;
  std::vector<SolverBody> solver_bodies;
  std::vector<StoredBristle> kept;
  GripperPlacement stage_start;
  Motion base, first;                             // of second-order steps
  std::unique_ptr<State> step_start, whole_step;  // of adaptive steps
  std::vector<char> free_standing;
  std::vector<double> forces;                  // N, of one pad's texels
  std::vector<WorldEngine::Vector6> wrenches;  // of the gripper on each body

  bool records = false;
  std::vector<WorldCommand> commands;

  explicit Implementation(const Scene& scene_in);
  // What a saved state must agree with.
  std::uint64_t description() const;
  void record(WorldCommand command);
  void make_gripper_meshes();
  GripperPlacement placement() const;
  double opening() const { return -state.motion.slide; }
  int index_of(const std::string& name) const;
  int index_or_throw(const std::string& name) const;
  void wake_all();
  bool in_reach(int i) const;
  BodyModel make_model(const std::string& name, const geometry::TriangleMesh& mesh_B, double mass,
                       double friction, const std::optional<FeltShape>& felt) const;
  void add(BodyModel model, const geometry::RigidTransform& X_WB);
  /// Asks the engine about an object in place of the one at `replaced` (-1: none).
  void require_possible(BodyModel model, const geometry::RigidTransform& X_WB, int replaced) const;
  void remove(int index);

  // True when body `i` has to be in this step's system.
  bool moves(int i) const;
  bool wake(int i);
  double reach_of(int i, double h) const;
  void detect(double h);
  void detect_pads(int i, double h);
  // Ends a stage of `h` [s] in which pad `k` was not near body `i`.
  void let_go(int i, int k, double h);
  void sort_contacts();
  // Both lists are sorted by key. Pads keep their bristles in their own frame.
  void fetch_bristles(const Eigen::Matrix3d& R_WG);
  void store_bristles(const Eigen::Matrix3d& R_WG);
  void fill_solver_bodies(const Motion& guess);
  // One implicit stage of length h whose end is `t_end` after the step's beginning. Its first
  // guess of the end's velocities: those of `guess`.
  void stage(double h, double t_end, const Motion& guess);
  void step_engine();
  void reload_engine();
  void refuse_with_engine(const char* what) const;
  void second_order(double h);
  void extrapolate();
  void step();
  std::int64_t advance_adaptively(std::int64_t ticks, const std::function<bool()>& ends);
  double most_steady(double h);
  void exact_step(double h);
  double difference(const Motion& a, const Motion& b) const;
  double load_on_slide() const;
  void fall_asleep(double h);
  void read_sensors(double h);
  TactileImage image(int pad, const TactileFrameReading& frame) const;
  const std::vector<double>& texel_forces(int pad);
  BodyReading reading(std::size_t i) const;
};

}  // namespace prehend::simulation
