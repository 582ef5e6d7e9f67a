// An object that nobody knew is turned before the camera, and known from then on; as launched for
// people.

#include <cmath>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "prehend/geometry/mesh_files.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/geometry/surface_samples.h"
#include "prehend/grasp/known/grasp_database.h"
#include "tests/system/launched.h"

namespace prehend::testing {
namespace {

/// Distance of a point to the surface of a can that stands on z = 0 [m].
double to_can(const Eigen::Vector3d& p, double radius, double height) {
  const double beyond = std::hypot(p.x(), p.y()) - radius;
  const double over = std::max(-p.z(), p.z() - height);
  if (beyond <= 0 && over <= 0) return -std::max(beyond, over);
  return std::hypot(std::max(beyond, 0.0), std::max(over, 0.0));
}

// The demo's scene: the SDH-2 takes its can, of which one look shows less than half.
TEST(Inspect, TurnsAnUnknownObjectIntoAKnownOne) {
  const ScratchFolder scratch;
  const auto known = scratch.path() / "known", database = scratch.path() / "grasps.db";
  std::filesystem::create_directories(known);
  const auto launch = [&](const std::string& task) {
    const auto out = scratch.path() / task;
    std::filesystem::create_directories(out);
    return run_program("prehend",
                       {"launch", "launch/demo.yaml", "platform:=kr5_sdh", "task:=" + task,
                        "speed:=0", "record:=false", "known_objects:=" + known.string(),
                        "store:=" + (task == "inspect" ? known.string() : std::string()),
                        "database:=" + database.string(), "out:=" + out.string(), "--log-dir",
                        (out / "log").string()},
                       std::chrono::seconds(300));
  };
  const Outcome looked = launch("inspect");
  ASSERT_EQ(looked.exit_code, 0) << looked.output;
  EXPECT_NE(looked.output.find("no object is known yet"), std::string::npos) << looked.output;
  std::ifstream in(scratch.path() / "inspect" / "report.html");
  const std::string page{std::istreambuf_iterator<char>(in), {}};
  EXPECT_NE(page.find("What was seen in the hand"), std::string::npos);
  EXPECT_EQ(page.find("could not be drawn"), std::string::npos);
  const auto file = known / "object-1.ply";
  ASSERT_TRUE(std::filesystem::exists(file)) << looked.output;
  const geometry::TriangleMesh mesh_O = geometry::read_mesh_file(file);
  EXPECT_TRUE(geometry::find_defects(mesh_O).watertight());
  // It stands in the middle of its frame; the scene says how large it is.
  double sum = 0;
  const auto samples = geometry::surface_samples(mesh_O, 2000, 1);
  for (const auto& sample : samples) sum += to_can(sample.point, 0.048, 0.09);
  EXPECT_LT(sum / static_cast<double>(samples.size()), 0.0025);
  const auto stored = grasp::GraspDatabase(database).grasps("sdh2", grasp::content_hash(mesh_O));
  ASSERT_FALSE(stored.empty());
  int attempts = 0, successes = 0;
  for (const grasp::StoredGrasp& one : stored) {
    attempts += one.attempts;
    successes += one.successes;
  }
  EXPECT_EQ(attempts, 1);
  EXPECT_EQ(successes, 1);

  const Outcome again = launch("work_cycle");
  ASSERT_EQ(again.exit_code, 0) << again.output;
  EXPECT_NE(again.output.find("is object-1"), std::string::npos) << again.output;
}

// The camera on the arm sees another side of the object first; both looks are of one object, and it
// is lifted by what they say, and by a grip of which the pads do not foretell that it slips.
TEST(LookFromElsewhere, TheArmBringsItsCameraThereAndPicksByBothLooks) {
  const ScratchFolder scratch;
  const Outcome outcome =
      run_program("prehend",
                  {"launch", "launch/demo.yaml", "platform:=kr5_sdh_camera", "home:=home",
                   "task:=look_and_pick", "scene:=spray_bottle", "speed:=0", "record:=false",
                   "minimum_stability:=0.3", "out:=" + scratch.path().string(), "--log-dir",
                   (scratch.path() / "log").string()},
                  std::chrono::seconds(300));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  for (const char* said : {"bringing the camera to where it sees another side of it",
                           "it is looked at from elsewhere", "contacts and 1 looks before",
                           "seen again: grasping object", "put down; the hand is empty"}) {
    EXPECT_NE(outcome.output.find(said), std::string::npos) << said << "\n" << outcome.output;
  }
}

// A camera's robot that cannot turn what it holds puts it back, and says why.
TEST(Inspect, AStageSaysThatItCannotTurnIt) {
  const ScratchFolder scratch;
  const auto store = scratch.path() / "store";
  const Outcome outcome = run_program(
      "prehend",
      {"launch", "launch/demo.yaml", "platform:=stage_pg70", "task:=inspect", "speed:=0",
       "record:=false", "store:=" + store.string(), "out:=" + scratch.path().string(), "--log-dir",
       (scratch.path() / "log").string()},
      std::chrono::seconds(200));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_NE(outcome.output.find("not looked at"), std::string::npos) << outcome.output;
  EXPECT_TRUE(std::filesystem::is_empty(store));
}

}  // namespace
}  // namespace prehend::testing
