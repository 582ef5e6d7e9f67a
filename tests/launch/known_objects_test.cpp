// A known object takes the place of what was predicted of it; its grasps are remembered.

#include <gmock/gmock.h>
#include <signal.h>

#include <filesystem>
#include <fstream>
#include <mutex>
#include <vector>

#include "msgs/convert/geometry.h"
#include "msgs/convert/objects.h"
#include "msgs/grasp.pb.h"
#include "prehend/geometry/mesh_files.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"
#include "prehend/grasp/known/grasp_database.h"
#include "prehend/surface/model.h"
#include "tests/grasp/seen_object.h"
#include "tests/launch/supervision_fixture.h"

namespace prehend::testing {
namespace {

using std::chrono::seconds;
using ::testing::HasSubstr;

class KnownObjects : public SupervisionTest {
 protected:
  KnownObjects() {
    graph::NodeOptions options;
    options.name = "test";
    options.registry = registry_.endpoint();
    node_.emplace(options);
    objects_ = node_->advertise<msgs::ObjectHypotheses>("/objects", graph::QoS::latched());
    predicted_ = node_->advertise<msgs::ObjectModel>("/predicted_models", graph::QoS::latched(32));
    results_ = node_->advertise<msgs::CycleResult>("/cycle/result", graph::QoS::latched());
    models_ = node_->subscribe<msgs::ObjectModel>(
        "/models", graph::QoS::latched(32), [this](const graph::Received<msgs::ObjectModel>& m) {
          const std::lock_guard lock(mutex_);
          received_models_.push_back(*m);
        });
    plans_ = node_->subscribe<msgs::GraspPlan>("/plans", graph::QoS::latched(32),
                                               [this](const graph::Received<msgs::GraspPlan>& p) {
                                                 const std::lock_guard lock(mutex_);
                                                 received_plans_.push_back(*p);
                                               });
    node_->spin_in_background();
  }

  // A view of `mesh` standing at the origin, and a box as the model that is predicted of it.
  void publish(std::int64_t stamp, const geometry::TriangleMesh& mesh, double yaw) {
    X_WO_ = grasp::standing(mesh, yaw, {0, 0});
    const auto seen = grasp::view_of(mesh, X_WO_, {-0.35, -0.1, 0.4});
    perception::SegmentedScene scene{seen.camera, seen.X_WC, seen.depth, *seen.table_W, {}};
    geometry::MaskImage mask(seen.camera.width, seen.camera.height, 0);
    for (const auto& p_W : seen.cloud_W.points) {
      const Eigen::Vector2d pixel = seen.camera.project(seen.X_WC.inverse() * p_W.cast<double>());
      const int u = static_cast<int>(std::lround(pixel.x()));
      const int v = static_cast<int>(std::lround(pixel.y()));
      if (u >= 0 && v >= 0 && u < mask.width && v < mask.height) mask.at(u, v) = 255;
    }
    scene.objects.push_back({7, seen.cloud_W, mask, false, 0});
    auto objects = convert::to_message(scene);
    objects.mutable_header()->set_stamp(stamp);
    auto model = convert::to_message(surface::model_of_mesh(geometry::transformed(
        geometry::make_box({0.05, 0.05, 0.05}),
        geometry::make_transform(Eigen::Quaterniond::Identity(), {0, 0, 0.025}))));
    model.mutable_header()->set_stamp(stamp);
    model.set_id(7);
    model.set_object_count(1);
    *model.mutable_table() = convert::to_message(*seen.table_W);
    model.set_method("mirror");
    // The model comes first: it has to wait for its view.
    predicted_.publish(model);
    objects_.publish(objects);
  }
  bool have(std::size_t count) {
    return eventually(
        [&] {
          const std::lock_guard lock(mutex_);
          return received_models_.size() >= count && received_plans_.size() >= count;
        },
        seconds(60));
  }

  graph::Registry registry_{graph::RegistryOptions{.endpoint = "tcp://127.0.0.1:*"}};
  std::optional<graph::Node> node_;
  geometry::RigidTransform X_WO_;
  std::mutex mutex_;
  std::vector<msgs::ObjectModel> received_models_;
  std::vector<msgs::GraspPlan> received_plans_;
  graph::Publisher<msgs::ObjectHypotheses> objects_;
  graph::Publisher<msgs::ObjectModel> predicted_;
  graph::Publisher<msgs::CycleResult> results_;
  graph::Subscription models_, plans_;
};

TEST_F(KnownObjects, TakeTheirPlaceAndTheirGraspsAreRemembered) {
  const auto mesh = grasp::angle_iron();
  const std::string file = scratch_.path("angle_iron.ply"), database = scratch_.path("grasps.db");
  geometry::write_mesh_file(file, mesh);
  const std::string hash = grasp::content_hash(geometry::read_mesh_file(file));
  ChildProgram program(
      "container",
      {"--", "known_objects", "--param", "models:=" + scratch_.path(), "--", "grasp_planning",
       "--param", "database:=" + database, "--param", "gripper:=config/robots/pg70_dsa.yaml"},
      scratch_.path("output.txt"), registry_.endpoint());
  publish(1, mesh, 0.4);
  ASSERT_TRUE(have(1)) << program.output();
  {
    const std::lock_guard lock(mutex_);
    const auto& model = received_models_[0];
    EXPECT_EQ(model.known().name(), "angle_iron") << program.output();
    EXPECT_EQ(model.known().hash(), hash);
    EXPECT_EQ(model.id(), 7u);
    EXPECT_EQ(model.method(), "known");
    EXPECT_LT((convert::from_message(model.centroid()) -
               X_WO_ * geometry::mass_properties(mesh).center_of_mass)
                  .norm(),
              0.006);
    ASSERT_GT(received_plans_[0].grasps_size(), 0) << received_plans_[0].problem();
    EXPECT_EQ(received_plans_[0].grasps(0).generator(), "circles");
  }
  publish(2, mesh, 1.7);
  ASSERT_TRUE(have(2)) << program.output();
  {
    const std::lock_guard lock(mutex_);
    ASSERT_GT(received_plans_[1].grasps_size(), 0) << received_plans_[1].problem();
    EXPECT_EQ(received_plans_[1].grasps(0).generator(), "given");
    EXPECT_LT(received_plans_[1].candidates(), received_plans_[0].candidates() / 10);
  }
  msgs::CycleResult result;
  result.set_outcome(msgs::CycleResult::SUCCEEDED);
  result.set_object_id(7);
  result.set_grasp_index(0);
  result.set_attempts(1);
  results_.publish(result);
  EXPECT_TRUE(eventually(
      [&] {
        int successes = 0;
        for (const auto& grasp : grasp::GraspDatabase(database).grasps("pg70_dsa", hash)) {
          successes += grasp.successes;
        }
        return successes == 1;
      },
      seconds(30)))
      << program.output();

  // What is not known stays as it was predicted.
  publish(3, grasp::bottle(), 0);
  ASSERT_TRUE(have(3)) << program.output();
  ::kill(program.pid(), SIGINT);
  EXPECT_EQ(program.wait(seconds(30)), 0) << program.output();
  const std::lock_guard lock(mutex_);
  EXPECT_FALSE(received_models_[2].has_known());
  EXPECT_EQ(received_models_[2].method(), "mirror");
  EXPECT_THAT(program.output(), HasSubstr("is not angle_iron"));
}

// Of an empty folder none is known; what is put there counts from the next view on, and a file that
// is none leaves the others.
TEST_F(KnownObjects, WhatComesIntoTheFolderIsKnownFromThenOn) {
  const std::string folder = scratch_.path("models");
  std::filesystem::create_directories(folder);
  ChildProgram program("container",
                       {"--", "known_objects", "--param", "models:=" + folder, "--",
                        "grasp_planning", "--param", "gripper:=config/robots/pg70_dsa.yaml"},
                       scratch_.path("output.txt"), registry_.endpoint());
  const auto mesh = grasp::angle_iron();
  publish(1, mesh, 0.4);
  ASSERT_TRUE(have(1)) << program.output();
  geometry::write_mesh_file(folder + "/angle_iron.ply", mesh);
  publish(2, mesh, 0.4);
  ASSERT_TRUE(have(2)) << program.output();
  std::ofstream(folder + "/broken.ply") << "ply\nnonsense\n";
  publish(3, mesh, 0.4);
  ASSERT_TRUE(have(3)) << program.output();
  ::kill(program.pid(), SIGINT);
  EXPECT_EQ(program.wait(seconds(30)), 0) << program.output();
  const std::lock_guard lock(mutex_);
  EXPECT_FALSE(received_models_[0].has_known());
  EXPECT_EQ(received_models_[1].known().name(), "angle_iron");
  EXPECT_EQ(received_models_[2].known().name(), "angle_iron");
  EXPECT_THAT(program.output(), HasSubstr("broken.ply"));
}

TEST_F(KnownObjects, AFolderThatIsNotThereIsRefused) {
  ChildProgram program("known_objects", {"--param", "models:=" + scratch_.path("missing")},
                       scratch_.path("output.txt"), registry_.endpoint());
  EXPECT_EQ(program.wait(seconds(30)), 2);
  EXPECT_THAT(program.output(), HasSubstr("no meshes"));
}

}  // namespace
}  // namespace prehend::testing
