#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "eval/grasp/dexgrasp_hand.h"
#include "eval/grasp/penetration.h"
#include "prehend/grasp/grasp.h"
#include "prehend/simulation/engines/engine.h"

/// Grasps tried as DexGraspBench tries them (github.com/JYChen18/DexGraspBench, of "BODex: Scalable
/// and Efficient Robotic Dexterous Grasp Synthesis Using Bilevel Optimization", ICRA 2025): a free
/// body of 100 g and a hand that is held by nothing but its pose.
namespace prehend::eval {

enum class DexTest {
  kForceClosure,  // no table; held against a force along each of +-x, +-y, +-z in turn
  kTabletop,      // from the table upwards
};
const char* to_string(DexTest test);

/// The figures are the benchmark's, except where it says so.
struct DexProtocol {
  double mass = 0.1;                       // kg
  double friction = 0.6;                   // of all there is; turning about a contact: the engine's
  double acceleration = 10;                // m/s^2, that the force on the object stands for
  double stage = 0.4;                      // s, of closing, of squeezing and of lifting, each
  double wait = 2;                         // s, under each force
  double lift = 0.1;                       // m
  double farthest_shift = 0.05;            // m, < : the object held
  double farthest_turn = 15 * M_PI / 180;  // rad, < : the same
  double deepest_start = 0.01;             // m, of the open hand in the object: more fails
  double stiffness = 5;                    // N m/rad, of the fingers' loops
  double slide_stiffness = 2e4;            // N/m, the same of jaws: ours
  double step = 0.002;  // s; ours, the benchmark's is 0.004 with implicit damping
  std::string engine = "mujoco";
  /// Of the engine; empty: its first. MuJoCo's first lets what is held creep under a steady load.
  std::string solver = "noslip";
  /// Of the forces that squeeze over those that just bear the pull; pads press as planned.
  double safety = 3;
  /// All motors squeeze with the plan's share of what they can, in place of with forces that cancel
  /// each other: as arms' cycles do, whose gears do not give way.
  bool equal_efforts = false;
};

/// An object where it stands before it is grasped.
class DexObject {
 public:
  /// @param pieces_W convex, that cover `mesh_W`
  /// @throws geometry::InputError for a mesh that encloses no volume.
  DexObject(const geometry::TriangleMesh& mesh_W,
            const std::vector<geometry::TriangleMesh>& pieces_W, const DexProtocol& protocol);

  const simulation::engines::EngineBody& body() const { return body_; }
  const ConvexSolids& solids_B() const { return *solids_B_; }

 private:
  simulation::engines::EngineBody body_;
  std::shared_ptr<const ConvexSolids> solids_B_;
};

struct DexOutcome {
  bool held = false;
  double shift = 0;        // m, of the object's centre by the end, or when it was lost
  double turn = 0;         // rad, the same
  double start_depth = 0;  // m, of the open hand in the object
  double depth = 0;        // m, of the hand in the object when it has squeezed
  double self_depth = 0;   // m, of parts of the hand in one another then
  std::string lost;        // "", "start", or under which force: "-x", ..., "lift"
};

/// Closes the hand, whose root stays at the grasp's pose, from where it opens to where the plan
/// says that it touches, squeezes, and applies the test's loads. The test's table is z = 0.
/// Deterministic. Cost: some 0.1 to 5 s of one core.
/// @throws std::invalid_argument naming the known engines, simulation::engines::UnsupportedScene
/// for an engine that cannot do hands.
DexOutcome run_dex_trial(const DexHand& hand, const DexObject& object, const grasp::Grasp& grasp,
                         DexTest test, const DexProtocol& protocol);

}  // namespace prehend::eval
