#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include "eval/data_sets.h"
#include "eval/hard_objects.h"
#include "eval/household_objects.h"
#include "eval/implicit_mesh.h"
#include "eval/structured_light.h"
#include "eval/varied_scenes.h"
#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_files.h"
#include "tests/eval/temporary_folder.h"

namespace prehend::eval {
namespace {

TEST(ImplicitMesh, BallHasTheVolumeAndIsClosed) {
  const double radius = 0.05;
  const Implicit ball = [radius](const Eigen::Vector3d& p) { return p.norm() - radius; };
  const Eigen::AlignedBox3d box(Eigen::Vector3d::Constant(-0.06), Eigen::Vector3d::Constant(0.06));
  const geometry::TriangleMesh mesh = mesh_of(ball, box, 0.003);
  EXPECT_TRUE(geometry::find_defects(mesh).watertight())
      << geometry::find_defects(mesh).to_string();
  const double volume = 4.0 / 3 * std::numbers::pi * std::pow(radius, 3);
  EXPECT_NEAR(geometry::mass_properties(mesh).volume, volume, 0.005 * volume);
}

TEST(ImplicitMesh, SurfaceThroughGridPointsStaysManifold) {
  // The faces of the box lie in planes of the grid.
  const Implicit box = [](const Eigen::Vector3d& p) {
    return solids::rounded_box(p, Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(0.04), 0);
  };
  const geometry::TriangleMesh mesh =
      mesh_of(box, {Eigen::Vector3d::Constant(-0.04), Eigen::Vector3d::Constant(0.04)}, 0.005);
  EXPECT_TRUE(geometry::find_defects(mesh).watertight());
  EXPECT_NEAR(geometry::mass_properties(mesh).volume, 6.4e-5, 0.05 * 6.4e-5);  // edges are bevelled
}

TEST(ImplicitMesh, RefusesWhatHasNoInsideOrReachesOut) {
  const Eigen::AlignedBox3d box(Eigen::Vector3d::Constant(-1), Eigen::Vector3d::Constant(1));
  const auto constant = [](double value) {
    return [value](const Eigen::Vector3d&) { return value; };
  };
  EXPECT_THROW(mesh_of(constant(1), box, 0.5), geometry::InputError);
  EXPECT_THROW(mesh_of(constant(-1), box, 0.5), geometry::InputError);
  EXPECT_THROW(mesh_of(constant(std::nan("")), box, 0.5), geometry::InputError);
  EXPECT_THROW(mesh_of(constant(1), box, 0), std::invalid_argument);
  EXPECT_THROW(mesh_of(constant(1), box, 1e-9), std::invalid_argument);
}

TEST(HardObjects, AreClosedRestOnTheTableAndHaveNamesOfTheirOwn) {
  std::set<std::string> names;
  for (const auto& objects : {hard_objects(), held_out_objects()}) {
    EXPECT_EQ(objects.size(), 18U);
    for (const EvaluationObject& object : objects) {
      SCOPED_TRACE(object.name);
      EXPECT_TRUE(names.insert(object.name).second);
      double lowest = geometry::bounds(*object.mesh_B).min().z();
      EXPECT_TRUE(geometry::find_defects(*object.mesh_B).watertight());
      EXPECT_GT(geometry::mass_properties(*object.mesh_B).volume, 0);
      for (const auto& other : object.viewing.others_B) {
        EXPECT_TRUE(geometry::find_defects(*other).watertight());
        lowest = std::min(lowest, geometry::bounds(*other).min().z());
      }
      EXPECT_NEAR(lowest, 0, 0.003);
    }
  }
}

TEST(VariedScenes, AreClosedStandOnTheTableAndFollowFromTheirSeed) {
  const std::vector<EvaluationObject> scenes = varied_scenes(3);
  ASSERT_EQ(scenes.size(), 18U);
  std::set<std::string> names;
  for (const EvaluationObject& object : scenes) {
    SCOPED_TRACE(object.name);
    EXPECT_TRUE(names.insert(object.name).second);
    EXPECT_EQ(object.viewing.textures.size(), 1 + object.viewing.others_B.size());
    EXPECT_GE(object.viewing.elevation, 15);
    EXPECT_LE(object.viewing.elevation, 75);
    std::vector<std::shared_ptr<const geometry::TriangleMesh>> bodies = object.viewing.others_B;
    bodies.push_back(object.mesh_B);
    double lowest = 1;
    for (const auto& body : bodies) {
      EXPECT_TRUE(geometry::find_defects(*body).watertight());
      EXPECT_GT(geometry::mass_properties(*body).volume, 0);
      lowest = std::min(lowest, geometry::bounds(*body).min().z());
    }
    EXPECT_NEAR(lowest, 0, 0.003);
  }
  const std::vector<EvaluationObject> again = varied_scenes(3), others = varied_scenes(4);
  int alike = 0;
  for (std::size_t k = 0; k < scenes.size(); ++k) {
    EXPECT_EQ(scenes[k].mesh_B->vertices, again[k].mesh_B->vertices);
    EXPECT_EQ(scenes[k].viewing.elevation, again[k].viewing.elevation);
    alike += scenes[k].mesh_B->vertices == others[k].mesh_B->vertices ? 1 : 0;
  }
  EXPECT_EQ(alike, 0);
}

TEST(VariedScenes, BodiesOfAStackStandOnEachOther) {
  for (const std::uint64_t seed : {1, 2}) {
    for (const EvaluationObject& object : varied_scenes(seed)) {
      if (object.name.find("stack") == std::string::npos) continue;
      SCOPED_TRACE(object.name);
      std::vector<Eigen::AlignedBox3d> boxes{geometry::bounds(*object.mesh_B)};
      for (const auto& other : object.viewing.others_B) boxes.push_back(geometry::bounds(*other));
      std::sort(boxes.begin(), boxes.end(),
                [](const auto& a, const auto& b) { return a.min().z() < b.min().z(); });
      EXPECT_EQ(object.name.back() - '0', static_cast<int>(boxes.size()));
      EXPECT_NEAR(boxes.front().min().z(), 0, 0.003);
      for (std::size_t k = 1; k < boxes.size(); ++k) {
        EXPECT_NEAR(boxes[k].min().z(), boxes[k - 1].max().z(), 0.003);
      }
    }
  }
}

TEST(DataSets, ResultsAreOfTheMeshAndTheViewingNotOfTheName) {
  EvaluationObject object = household_objects().front();
  const auto name_of = [](const EvaluationObject& one) {
    const std::vector<DataSet> sets = make_data_sets("household", {one});
    return make_cases(sets, 1, 1).front().result_name();
  };
  const std::string before = name_of(object);
  EXPECT_EQ(name_of(object), before);
  EvaluationObject larger = object;
  geometry::TriangleMesh mesh = *object.mesh_B;
  mesh.vertices.front().x() += 1e-6;
  larger.mesh_B = std::make_shared<geometry::TriangleMesh>(std::move(mesh));
  EXPECT_NE(name_of(larger), before);
  EvaluationObject lower = object;
  lower.viewing.elevation = 20;
  EXPECT_NE(name_of(lower), before);
}

// Depth as Khoshelham and Oude Elberink measured it: deviation and steps grow with its square.
TEST(StructuredLight, NoiseGrowsWithTheSquareOfDepthAndDarkThingsGiveNone) {
  const geometry::PinholeCamera camera{320, 240, 280, 280, 159.5, 119.5};
  const auto deviation_at = [&](float depth) {
    const geometry::DepthImage wall(camera.width, camera.height, depth);
    const geometry::Image<std::int16_t> labels(camera.width, camera.height, -1);
    const geometry::DepthImage seen = structured_light(wall, labels, camera, {});
    double sum = 0, squares = 0, count = 0;
    for (const float z : seen.data) {
      if (!std::isfinite(z)) continue;
      sum += z;
      squares += static_cast<double>(z) * z;
      ++count;
    }
    EXPECT_GT(count, 0.9 * static_cast<double>(seen.data.size()));
    EXPECT_NEAR(sum / count, depth, 1e-3);
    return std::sqrt(squares / count - sum / count * sum / count);
  };
  EXPECT_NEAR(deviation_at(2) / deviation_at(1), 4, 0.4);
  const geometry::DepthImage wall(camera.width, camera.height, 1);
  const geometry::Image<std::int16_t> dark(camera.width, camera.height, 0);
  StructuredLightNoise noise;
  noise.missing = 0.4;
  const geometry::DepthImage seen = structured_light(wall, dark, camera, noise);
  const auto lost =
      std::count_if(seen.data.begin(), seen.data.end(), [](float z) { return !std::isfinite(z); });
  EXPECT_NEAR(static_cast<double>(lost) / static_cast<double>(seen.data.size()), 0.4, 0.05);
}

TEST(HouseholdObjects, AreTwelveClosedSolidsOnTheTable) {
  const std::vector<EvaluationObject> objects = household_objects();
  ASSERT_EQ(objects.size(), 12U);
  std::set<std::string> names;
  for (const EvaluationObject& object : objects) {
    SCOPED_TRACE(object.name);
    names.insert(object.name);
    const geometry::TriangleMesh& mesh = *object.mesh_B;
    EXPECT_TRUE(geometry::find_defects(mesh).watertight())
        << geometry::find_defects(mesh).to_string();
    EXPECT_GT(geometry::mass_properties(mesh).volume, 0);
    const Eigen::AlignedBox3d bounds = geometry::bounds(mesh);
    EXPECT_NEAR(bounds.min().z(), 0, 1e-12);
    EXPECT_NEAR(bounds.center().head<2>().norm(), 0, 1e-12);
    EXPECT_GT(bounds.sizes().maxCoeff(), 0.06);
    EXPECT_LT(bounds.sizes().maxCoeff(), 0.25);
  }
  EXPECT_EQ(names.size(), 12U);
  const std::vector<DataSet> sets = make_data_sets("household", objects);
  EXPECT_EQ(sets.size(), 16U);
  EXPECT_EQ(make_cases(sets, 8, 1).size(), 128U);
  for (const DataSet& set : sets) {
    EXPECT_NEAR(geometry::bounds(*set.mesh_B).min().z(), 0, 1e-12) << set.name;
  }
}

TEST(HouseholdObjects, BoxAndCanHaveTheirVolumes) {
  for (const EvaluationObject& object : household_objects()) {
    const double volume = geometry::mass_properties(*object.mesh_B).volume;
    if (object.name == "cereal_box") {
      EXPECT_NEAR(volume, 0.06 * 0.15 * 0.21, 0.01 * volume);
    }
    if (object.name == "can") {
      EXPECT_NEAR(volume, std::numbers::pi * 0.033 * 0.033 * 0.106, 0.01 * volume);
    }
  }
}

TEST(ObjectsOfFolder, TakesClosedMeshesAndNamesBadOnes) {
  const testing::TemporaryFolder folder;
  EXPECT_THROW(objects_of_folder(folder.path), geometry::InputError);
  geometry::TriangleMesh box = geometry::make_box({0.05, 0.06, 0.2});
  geometry::write_mesh_file(folder.path / "tall.ply", box);
  geometry::write_mesh_file(folder.path / "flat.obj", geometry::make_box({0.2, 0.1, 0.05}));
  const std::vector<EvaluationObject> objects = objects_of_folder(folder.path);
  ASSERT_EQ(objects.size(), 2U);
  EXPECT_EQ(objects[0].name, "flat");
  EXPECT_FALSE(objects[0].lies_too);
  EXPECT_EQ(objects[1].name, "tall");
  EXPECT_TRUE(objects[1].lies_too);

  box.triangles.pop_back();
  geometry::write_mesh_file(folder.path / "open.ply", box);
  EXPECT_THROW(objects_of_folder(folder.path), geometry::InputError);
  std::filesystem::remove(folder.path / "open.ply");
  geometry::write_mesh_file(folder.path / "millimetres.ply", geometry::make_box({50, 60, 200}));
  EXPECT_THROW(objects_of_folder(folder.path), geometry::InputError);
}

}  // namespace
}  // namespace prehend::eval
