// Grasps tried as DexGraspBench tries them: what must hold, what cannot, and the program around it.

#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

#include "eval/grasp/dexgrasp_case.h"
#include "eval/grasp/dexgrasp_report.h"
#include "eval/grasp/share_bounds.h"
#include "eval/grasp/trial_setup.h"
#include "prehend/geometry/mesh_files.h"
#include "prehend/grasp/planner.h"
#include "prehend/simulation/engines/registry.h"
#include "prehend/simulation/shapes.h"
#include "prehend/text/tree_file.h"
#include "tests/eval/temporary_folder.h"

namespace prehend::eval {
namespace {

const Eigen::Vector3d kDexBox(0.06, 0.04, 0.1);  // m

robot::HandModel dex_pg70() {
  return robot::read_hand_model(text::tree_file("config/robots/pg70.yaml"));
}

// Jaws about the box's upper half, from above: their tips stay clear of a table.
grasp::Grasp jaws_about_box(const robot::HandModel& hand, double force) {
  grasp::Grasp grasp;
  grasp.X_WG.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  grasp.X_WG.translation() = Eigen::Vector3d(0, 0, 0.75 * kDexBox.z());
  const robot::Preshape& open = hand.preshapes.front();
  grasp.preshape = open.name;
  grasp.X_WH = grasp.X_WG * (hand.X_HP * open.X_PG).inverse();
  grasp.open = open.open;
  grasp.closed = Eigen::VectorXd::Constant(1, 0.5 * kDexBox.y());
  grasp.closed_all = hand.all_positions(grasp.closed);
  grasp.force = force;
  return grasp;
}

class DexGrasp : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!simulation::engines::EngineRegistry().has("mujoco")) {
      GTEST_SKIP() << "the engine mujoco is not installed";
    }
  }
  DexOutcome outcome(const DexProtocol& protocol, DexTest test, const Eigen::Vector3d& beside) {
    const DexHand hand(dex_pg70(), protocol.friction);
    geometry::TriangleMesh box = simulation::make_standing_box(kDexBox);
    for (Eigen::Vector3d& p : box.vertices) p += beside;
    const DexObject object(box, {box}, protocol);
    return run_dex_trial(hand, object, jaws_about_box(hand.model, 20), test, protocol);
  }
};

TEST_F(DexGrasp, ABoxBetweenJawsHolds) {
  for (const DexTest test : {DexTest::kForceClosure, DexTest::kTabletop}) {
    const DexOutcome one = outcome({}, test, Eigen::Vector3d::Zero());
    EXPECT_TRUE(one.held) << to_string(test) << one.lost;
    EXPECT_LT(one.shift, 0.002) << to_string(test);
    EXPECT_EQ(one.start_depth, 0);
    EXPECT_LT(one.depth, 0.002);
    EXPECT_EQ(one.self_depth, 0);
  }
}

// 20 N of each jaw bear mu 40 N; the pull is 1 N.
TEST_F(DexGrasp, WithoutFrictionItIsLost) {
  DexProtocol slippery;
  slippery.friction = 0.001;
  EXPECT_FALSE(outcome(slippery, DexTest::kForceClosure, Eigen::Vector3d::Zero()).held);
  const DexOutcome lifted = outcome(slippery, DexTest::kTabletop, Eigen::Vector3d::Zero());
  EXPECT_FALSE(lifted.held);
  EXPECT_EQ(lifted.lost, "lift");
  EXPECT_NEAR(lifted.shift, slippery.lift, 0.005);  // it stayed where it was
}

TEST_F(DexGrasp, NothingBetweenTheJawsIsLost) {
  const DexOutcome one = outcome({}, DexTest::kTabletop, {0.15, 0, 0});
  EXPECT_FALSE(one.held);
  EXPECT_EQ(one.depth, 0);
  EXPECT_NEAR(one.shift, 0.1, 0.002);
}

TEST_F(DexGrasp, WhatStandsInTheHandFailsAtItsStart) {
  const DexOutcome one = outcome({}, DexTest::kForceClosure, {0, 0.03, 0});
  EXPECT_FALSE(one.held);
  EXPECT_EQ(one.lost, "start");
  EXPECT_GT(one.start_depth, 0.01);
}

TEST(Penetration, OfBoxesIsTheirOverlap) {
  const ConvexSolids cube({geometry::make_box({0.1, 0.1, 0.1})});
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.translation() = Eigen::Vector3d(0.093, 0.01, 0.02);
  EXPECT_NEAR(penetration(cube, cube, X), 0.007, 1e-12);
  X.translation().x() = 0.11;
  EXPECT_EQ(penetration(cube, cube, X), 0);
}

// No corner of either is in the other.
TEST(Penetration, OfBarsThatCrossIsSeen) {
  const ConvexSolids along_x({geometry::make_box({0.2, 0.02, 0.02})});
  const ConvexSolids along_y({geometry::make_box({0.02, 0.2, 0.02})});
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.translation().z() = 0.015;
  EXPECT_NEAR(penetration(along_x, along_y, X), 0.005, 1e-12);
  // Turned about their lengths they meet with edges: diagonals of 14.1 mm each side.
  X.linear() = Eigen::AngleAxisd(M_PI / 4, Eigen::Vector3d::UnitY()).toRotationMatrix();
  geometry::TriangleMesh turned = geometry::make_box({0.2, 0.02, 0.02});
  for (Eigen::Vector3d& p : turned.vertices) {
    p = Eigen::AngleAxisd(M_PI / 4, Eigen::Vector3d::UnitX()) * p;
  }
  const ConvexSolids edge_up({turned});
  X.translation().z() = 2 * 0.01 * std::sqrt(2.0) + 1e-4;
  EXPECT_EQ(penetration(edge_up, along_y, X), 0) << "apart by 0.1 mm, across two edges";
  X.translation().z() -= 0.001 + 1e-4;
  EXPECT_GE(penetration(edge_up, along_y, X), 0.001 - 1e-12);
  EXPECT_EQ(penetration(ConvexSolids({}), along_x, X), 0);
}

TEST(DexGraspFigures, IntervalsAreWilsons) {
  // Newcombe 1998, "Two-sided confidence intervals for the single proportion", table I, method 3.
  EXPECT_NEAR(share_bounds(81, 263).low, 0.2553, 5e-5);
  EXPECT_NEAR(share_bounds(81, 263).high, 0.3662, 5e-5);
  EXPECT_NEAR(share_bounds(0, 20).high, 0.1611, 5e-5);
  EXPECT_EQ(share_bounds(0, 20).low, 0);
}

TEST(DexGraspFigures, GraspsThatAreAlikeCountOnce) {
  const robot::HandModel hand = dex_pg70();
  std::vector<grasp::Grasp> grasps(4, jaws_about_box(hand, 20));
  grasps[1].X_WH.translation().x() += 0.004;
  grasps[2].X_WH.translation().x() += 0.006;
  grasps[3].closed[0] += 0.0021;
  EXPECT_EQ(distinct_grasps(hand, grasps), 3);
}

struct DexRunOfProgram {
  int exit = 0;
  std::string said;
};

DexRunOfProgram run_program(const std::string& arguments, const std::filesystem::path& folder) {
  const std::filesystem::path out = folder / "said.txt";
  const std::string command =
      std::string(PREHEND_EVAL_DEXGRASP) + " " + arguments + " > '" + out.string() + "' 2>&1";
  const int status = std::system(command.c_str());
  std::ifstream stream(out);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1,
          {std::istreambuf_iterator<char>(stream), {}}};
}

std::string content_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST_F(DexGrasp, TheProgramNamesWhatItIsNotGiven) {
  const testing::TemporaryFolder folder;
  const DexRunOfProgram hand = run_program("--hand pg71", folder.path);
  EXPECT_NE(hand.exit, 0);
  EXPECT_NE(hand.said.find("pg71"), std::string::npos) << hand.said;
  EXPECT_NE(hand.said.find("pg70"), std::string::npos) << hand.said;
  const DexRunOfProgram meshes =
      run_program("--meshes '" + folder.path.string() + "'", folder.path);
  EXPECT_NE(meshes.exit, 0);
  EXPECT_NE(meshes.said.find(folder.path.string()), std::string::npos) << meshes.said;
  const DexRunOfProgram engine = run_program("--engine mujocco", folder.path);
  EXPECT_NE(engine.exit, 0);
  EXPECT_NE(engine.said.find("mujoco"), std::string::npos) << engine.said;
  const DexRunOfProgram solver = run_program("--solver nosleep", folder.path);
  EXPECT_NE(solver.exit, 0);
  EXPECT_NE(solver.said.find("noslip"), std::string::npos) << solver.said;
}

TEST_F(DexGrasp, OneProcessOrTwoWriteTheSameBytes) {
  const testing::TemporaryFolder folder;
  const std::filesystem::path meshes = folder.path / "meshes";
  std::filesystem::create_directories(meshes);
  geometry::write_mesh_file(meshes / "box.obj", simulation::make_standing_box(kDexBox));
  std::string first;
  for (const char* processes : {"1", "2"}) {
    const std::filesystem::path out = folder.path / processes;
    const DexRunOfProgram run = run_program(
        "--hand pg70 --grasps 2 --meshes '" + meshes.string() + "' --out '" + out.string() +
            "' --json '" + (out / "totals.json").string() + "' --processes " + processes,
        folder.path);
    ASSERT_EQ(run.exit, 0) << run.said;
    const std::string all = content_of(out / "trials.csv") + content_of(out / "cases.csv") +
                            content_of(out / "totals.json") + content_of(out / "index.html");
    EXPECT_NE(all.find("force_closure"), std::string::npos);
    if (first.empty()) first = all;
    EXPECT_EQ(all, first);
  }
}

}  // namespace
}  // namespace prehend::eval
