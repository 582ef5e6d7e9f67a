#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "prehend/simulation/carrier.h"
#include "prehend/simulation/contact_detection.h"
#include "prehend/simulation/contact_solver.h"
#include "prehend/simulation/gripper_drive.h"
#include "prehend/simulation/rigid_body.h"
#include "prehend/simulation/world.h"

/// The inside of World: for its own files only.
namespace prehend::simulation {

struct PadReading {
  std::vector<double> force;  // N, rows * columns
};

inline bool is_pad(std::uint32_t partner) { return partner == kLeftPad || partner == kRightPad; }
inline bool is_gripper(std::uint32_t partner) { return partner > kTable && partner <= kRightPad; }

struct World::State {
  std::int64_t steps = 0;
  std::vector<std::uint32_t> body_ids;
  std::vector<BodyState> bodies;
  Carrier carrier;
  GripperDrive drive;
  std::vector<StoredBristle> bristles;  // by key
  std::array<PadReading, 2> pads;
  ContactWrench wrench;  // in G
};

struct World::Implementation {
  Scene scene;
  std::vector<BodyModel> models;
  State state;
  std::uint64_t generation = 1;
  std::uint32_t next_id = 1;
  std::shared_ptr<const geometry::TriangleMesh> finger_mesh, housing_mesh, pad_mesh;
  std::vector<ContactPoint> contacts;  // of the last step

  explicit Implementation(const Scene& scene_in);
  void make_gripper_meshes();
  GripperPlacement placement() const;
  int index_of(const std::string& name) const;
  int index_or_throw(const std::string& name) const;
  void wake_all();
  void add(BodyModel model, const geometry::RigidTransform& X_WB);
  void remove(int index);
  // True when body `i` has to be in this step's system.
  bool moves(int i) const;
  void detect();
  bool wake(int i);
  // Both lists are sorted by key. Pads keep their bristles in their own frame.
  void fetch_bristles(const Eigen::Matrix3d& R_WG);
  void store_bristles(const Eigen::Matrix3d& R_WG);
  std::vector<SolverBody> solver_bodies() const;
  void step();
  void fall_asleep(double h);
  void read_sensors(const GripperPlacement& gripper);
  BodyReading reading(std::size_t i) const;
};

}  // namespace prehend::simulation
