#include "prehend/simulation/clutter.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <yaml-cpp/yaml.h>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_files.h"
#include "prehend/simulation/clutter_scene.h"
#include "prehend/simulation/shapes.h"
#include "prehend/simulation/surface_gap.h"
#include "prehend/simulation/world.h"

namespace prehend::simulation {
namespace {

using geometry::RigidTransform;
using geometry::TriangleMesh;
namespace fs = std::filesystem;

ClutterSolid solid(const std::string& name, TriangleMesh mesh) {
  ClutterSolid made;
  made.name = name;
  made.mesh_B = std::make_shared<const TriangleMesh>(std::move(mesh));
  made.mass = 0.2;
  return made;
}

std::vector<ClutterSolid> few_solids() {
  return {solid("carton", make_standing_box({0.06, 0.045, 0.1})),
          solid("can", make_can(0.033, 0.1)), solid("tin", make_can(0.042, 0.035)),
          solid("book", make_standing_box({0.12, 0.08, 0.02}))};
}

ClutterOptions few(int count, std::uint64_t seed) {
  ClutterOptions options;
  options.count = count;
  options.seed = seed;
  return options;
}

RigidTransform at(double x, double y, double z) {
  RigidTransform X = RigidTransform::Identity();
  X.translation() = Eigen::Vector3d(x, y, z);
  return X;
}

TEST(SurfaceGap, OfBoxesAndBallsIsTheDistanceBetweenThem) {
  const SampledSurface box(make_standing_box({0.1, 0.06, 0.08})), ball(make_ball(0.03));
  SurfaceGap gap = surface_gap(box, at(0, 0, 0), box, at(0.13, 0.01, 0.02), 0.5);
  EXPECT_NEAR(gap.distance, 0.03, 1e-6);
  EXPECT_NEAR(gap.p_W.x(), 0.08, 1e-6) << "on the second";
  EXPECT_NEAR(gap.normal_W.x(), -1, 1e-6) << "out of the second";
  gap = surface_gap(ball, at(0, 0, 0.1), box, at(0, 0, 0), 0.5);
  EXPECT_NEAR(gap.distance, 0.02, 2e-4);
  EXPECT_NEAR(gap.normal_W.z(), 1, 1e-6);
  gap = surface_gap(box, at(0, 0, 0), box, at(1, 0, 0), 0.5);
  EXPECT_EQ(gap.distance, 0.5) << "no farther than asked";
  EXPECT_TRUE(surfaces_overlap(ball, at(0, 0, 0.02), box, at(0, 0, 0))) << "within it";
  EXPECT_TRUE(surfaces_overlap(box, at(0, 0, 0), box, at(0.05, 0, 0.01)));
  EXPECT_FALSE(surfaces_overlap(box, at(0, 0, 0), box, at(0.101, 0, 0)));
}

class DroppedClutter : public ::testing::TestWithParam<int> {
 protected:
  static ClutterOptions options() {
    ClutterOptions options = few(8, 7);
    switch (GetParam()) {
      case 1:
        options.touching = 0.9;
        break;
      case 2:
        options.stacked = 0.9;
        break;
      case 3:
        options.leaning = 0.6;
        break;
      case 4:
        options.tumbled = 1;
        options.touching = 0.5;
        break;
      default:
        options.size = {0.6, 0.6};
    }
    return options;
  }
};

// What lies stays there in a world of its own, in no other body, and where it may.
TEST_P(DroppedClutter, IsAtRestAndInNoOther) {
  const std::vector<ClutterSolid> solids = few_solids();
  const std::vector<ClutterBody> bodies = drop_clutter(solids, options());
  ASSERT_GE(bodies.size(), 6u);
  std::vector<SampledSurface> surfaces;
  for (const ClutterSolid& one : solids) surfaces.emplace_back(*one.mesh_B);
  Scene scene;
  scene.carrier.maximum.z() = 10;
  scene.carrier.start = {0, 0, 10};
  World world(scene);
  std::vector<RigidTransform> first;
  for (const ClutterBody& body : bodies) {
    world.add_object(body.name, geometry::transformed(*solids[body.solid].mesh_B, body.X_WB), 0.2);
    first.push_back(world.body(body.name).X_WB);
  }
  world.advance(2);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const RigidTransform X = first[i].inverse(Eigen::Isometry) * world.body(bodies[i].name).X_WB;
    EXPECT_LT(X.translation().norm(), 0.004) << bodies[i].name;
    EXPECT_LT(Eigen::AngleAxisd(X.linear()).angle(), 0.06) << bodies[i].name;
    EXPECT_LT(bodies[i].X_WB.translation().head<2>().cwiseAbs().maxCoeff(), 0.45);
    for (std::size_t k = 0; k < i; ++k) {
      const geometry::MeshQuery& other = surfaces[bodies[k].solid].query();
      const SampledSurface& own = surfaces[bodies[i].solid];
      const RigidTransform X_KI = bodies[k].X_WB.inverse(Eigen::Isometry) * bodies[i].X_WB;
      double deepest = 0;
      for (const Eigen::Vector3d& p : own.points()) {
        if (other.box().contains(X_KI * p)) {
          deepest = std::max(deepest, -other.signed_distance(X_KI * p));
        }
      }
      EXPECT_LT(deepest, 0.001) << bodies[i].name << " in " << bodies[k].name;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Kinds, DroppedClutter, ::testing::Range(0, 5));

TEST(Clutter, IsTheSameForTheSameSeedAndAnotherForAnother) {
  ClutterOptions options = few(4, 3);
  options.touching = 0.5;
  const auto a = drop_clutter(few_solids(), options), b = drop_clutter(few_solids(), options);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].name, b[i].name);
    EXPECT_EQ((a[i].X_WB.matrix() - b[i].X_WB.matrix()).norm(), 0);
  }
  options.seed = 4;
  const auto c = drop_clutter(few_solids(), options);
  ASSERT_FALSE(c.empty());
  EXPECT_NE(a[0].X_WB.translation(), c[0].X_WB.translation());
}

// The truth is measured, not what was asked for: shares show in it.
TEST(ClutterTruth, TellsWhatTouchesBearsAndHides) {
  const std::vector<ClutterSolid> solids = few_solids();
  const auto truths = [&](const ClutterOptions& options) {
    const auto bodies = drop_clutter(solids, options);
    return clutter_truth(solids, bodies, clutter_scene(solids, bodies, "meshes", 0, 1));
  };
  const auto count = [](const std::vector<ClutterTruth>& all, auto what) {
    return std::count_if(all.begin(), all.end(), what);
  };
  ClutterOptions options = few(5, 5);
  options.size = {0.6, 0.6};
  auto found = truths(options);
  ASSERT_EQ(found.size(), 5u);
  EXPECT_EQ(count(found, [](const auto& t) { return !t.touches.empty(); }), 0) << "all apart";
  EXPECT_EQ(count(found, [](const auto& t) { return t.lowest > 0.002; }), 0);
  options.touching = 1;
  found = truths(options);
  EXPECT_GE(count(found, [](const auto& t) { return !t.touches.empty(); }), 4);
  options.touching = 0;
  options.stacked = 1;
  found = truths(options);
  EXPECT_GE(count(found, [](const auto& t) { return !t.borne_by.empty(); }), 3);
  EXPECT_GE(count(found, [](const auto& t) { return t.lowest > 0.015; }), 3);
  options.stacked = 0;
  options.hidden = 1;
  found = truths(options);
  EXPECT_GE(count(found, [](const auto& t) { return t.visible() < 0.9; }), 1);
  for (const ClutterTruth& truth : found) EXPECT_LE(truth.pixels, truth.alone_pixels);
}

TEST(Clutter, OptionsOutOfRangeAreNamed) {
  const auto said = [](auto change) {
    ClutterOptions options;
    change(options);
    try {
      drop_clutter(few_solids(), options);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(said([](auto& o) { o.count = 13; }), ::testing::HasSubstr("count"));
  EXPECT_THAT(said([](auto& o) { o.stacked = NAN; }), ::testing::HasSubstr("stacked"));
  EXPECT_THAT(said([](auto& o) { o.stacked = o.touching = 0.6; }),
              ::testing::HasSubstr("touching + stacked"));
  EXPECT_THAT(said([](auto& o) { o.size.x() = 0; }), ::testing::HasSubstr("size"));
  EXPECT_THAT(said([](auto& o) { o.center.y() = 0.7; }), ::testing::HasSubstr("center"))
      << "beside the table";
  EXPECT_THROW(drop_clutter({}, {}), std::invalid_argument);
}

TEST(Clutter, ABodyLargerThanTheTableIsRefused) {
  EXPECT_THROW(drop_clutter({solid("door", make_standing_box({0.9, 0.04, 0.02}))}, {}),
               geometry::InputError);
}

// Fewer than asked for, where there is no room, and no endless search.
TEST(Clutter, EndsWhereThereIsNoRoom) {
  ClutterOptions options = few(12, 1);
  options.size = {0.13, 0.13};
  const auto bodies =
      drop_clutter({solid("carton", make_standing_box({0.07, 0.07, 0.1}))}, options);
  EXPECT_EQ(bodies.size(), 1u);
}

class ClutterFiles : public ::testing::Test {
 protected:
  ClutterFiles()
      : folder_(fs::temp_directory_path() / ("prehend_clutter_" + std::to_string(getpid()))) {
    fs::create_directories(folder_ / "meshes");
  }
  ~ClutterFiles() override { fs::remove_all(folder_); }
  std::string refused(double scale = 1) const {
    try {
      read_clutter_solids(folder_, scale);
    } catch (const geometry::InputError& error) {
      return error.what();
    }
    return "";
  }
  fs::path folder_;
};

TEST_F(ClutterFiles, AWrittenSceneIsTheSameWhenItIsReadAndSimulated) {
  const std::vector<ClutterSolid> solids = few_solids();
  ClutterOptions options = few(5, 9);
  options.leaning = 0.5;
  options.tumbled = 0.5;
  const auto bodies = drop_clutter(solids, options);
  const Scene scene = clutter_scene(solids, bodies, folder_ / "meshes", 1, 2);
  const auto truths = clutter_truth(solids, bodies, scene);
  write_clutter(folder_ / "heap.yaml", solids, bodies, truths, scene);
  EXPECT_TRUE(fs::exists(folder_ / "heap_truth.yaml"));
  const Scene read = read_scene(folder_ / "heap.yaml");
  EXPECT_LT((read.camera.eye - scene.camera.eye).norm(), 1e-5);
  EXPECT_NE(read.camera.eye, Scene{}.camera.eye) << "it is varied";
  EXPECT_NEAR(read.camera.noise, scene.camera.noise, 1e-5);
  EXPECT_NEAR(read.light.ambient, scene.light.ambient, 1e-5);
  ASSERT_EQ(read.objects.size(), bodies.size());
  World world(read);
  world.advance(1);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const RigidTransform X =
        bodies[i].X_WB.inverse(Eigen::Isometry) * world.body(bodies[i].name).X_WB;
    EXPECT_LT(X.translation().norm(), 0.004) << bodies[i].name;
    EXPECT_EQ(read.objects[i].texture.seed, scene.objects[i].texture.seed);
  }
}

// Regression: the truth of a mesh with such a name was no YAML.
TEST_F(ClutterFiles, NamesMayHaveAnyCharacters) {
  std::vector<ClutterSolid> solids = few_solids();
  solids.resize(1);
  solids.front().name = "it's: {a} #\"b\"";
  ClutterOptions options = few(3, 4);
  options.touching = 1;
  const auto bodies = drop_clutter(solids, options);
  const Scene scene = clutter_scene(solids, bodies, folder_ / "meshes", 0, 2);
  write_clutter(folder_ / "heap.yaml", solids, bodies, clutter_truth(solids, bodies, scene), scene);
  const YAML::Node truth = YAML::LoadFile((folder_ / "heap_truth.yaml").string());
  ASSERT_EQ(truth["objects"].size(), bodies.size());
  std::size_t touching = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    EXPECT_EQ(truth["objects"][i]["name"].as<std::string>(), bodies[i].name);
    EXPECT_EQ(truth["objects"][i]["solid"].as<std::string>(), solids.front().name);
    touching += truth["objects"][i]["touches"].size();
  }
  EXPECT_GT(touching, 0U);
}

// Whoever sets up a stereo camera sees to it.
TEST_F(ClutterFiles, BothImagesShowAllOfEachBody) {
  const std::vector<ClutterSolid> solids = few_solids();
  const auto seen_with_one_at = [&](double y) {
    ClutterBody body;
    body.name = "one";
    body.X_WB = RigidTransform(Eigen::Translation3d(0, y, 0));
    const CameraSetup setup = clutter_scene(solids, {body}, folder_ / "meshes", 0, 1).camera;
    const geometry::PinholeCamera& left = setup.camera.left;
    for (const Eigen::Vector3d& p_B : solids[body.solid].mesh_B->vertices) {
      const Eigen::Vector3d p = setup.X_WC().inverse() * (body.X_WB * p_B);
      EXPECT_GT(left.cx + left.fx * (p.x() - setup.camera.baseline) / p.z(), 0) << y;
      EXPECT_LT(left.cx + left.fx * p.x() / p.z(), left.width) << y;
    }
    return (setup.eye - setup.target).norm();
  };
  const CameraSetup usual;
  EXPECT_DOUBLE_EQ(seen_with_one_at(0), (usual.eye - usual.target).norm());
  // Beyond the left image, and beyond the right one alone.
  EXPECT_GT(seen_with_one_at(0.34), 1.02 * (usual.eye - usual.target).norm());
  EXPECT_GT(seen_with_one_at(-0.27), 1.02 * (usual.eye - usual.target).norm());
}

TEST_F(ClutterFiles, FoldersThatWillNotDoAreNamedWithTheMend) {
  fs::remove_all(folder_ / "meshes");
  EXPECT_THAT(refused(), ::testing::HasSubstr("has no mesh"));
  geometry::write_mesh_file(folder_ / "carton.ply", make_standing_box({60, 45, 100}));
  EXPECT_THAT(refused(), ::testing::AllOf(::testing::HasSubstr("carton.ply"),
                                          ::testing::HasSubstr("--scale")));
  EXPECT_EQ(refused(0.001), "");
  TriangleMesh open = make_standing_box({0.06, 0.045, 0.1});
  for (Eigen::Vector3i& t : open.triangles) std::swap(t[0], t[1]);
  geometry::write_mesh_file(folder_ / "turned.ply", open);
  EXPECT_THAT(refused(0.001), ::testing::HasSubstr("turned.ply"));
  fs::remove(folder_ / "turned.ply");
  // Regression: a box without its lid had two thirds of its mass.
  TriangleMesh holed = make_standing_box({60, 45, 100});
  holed.triangles.resize(holed.triangles.size() - 2);
  geometry::write_mesh_file(folder_ / "holed.ply", holed);
  EXPECT_THAT(refused(0.001), ::testing::AllOf(::testing::HasSubstr("holed.ply"),
                                               ::testing::HasSubstr("is not closed")));
  fs::rename(folder_ / "holed.ply", folder_ / "HOLED.PLY");
  EXPECT_THAT(refused(0.001), ::testing::HasSubstr("HOLED.PLY"));
  fs::remove(folder_ / "HOLED.PLY");
  geometry::write_mesh_file(folder_ / "carton.stl", make_standing_box({60, 45, 100}));
  EXPECT_THAT(refused(0.001), ::testing::HasSubstr("name of another mesh"));
  EXPECT_THROW(read_clutter_solids(folder_ / "nowhere"), geometry::InputError);
}

}  // namespace
}  // namespace prehend::simulation
