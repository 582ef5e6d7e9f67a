// Our messages as viewers' types, and those types against their public numbers.

#include <cstring>

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include "foxglove/PackedElementField.pb.h"
#include "msgs/convert/foxglove_geometry.h"
#include "msgs/convert/foxglove_images.h"
#include "msgs/convert/foxglove_objects.h"
#include "msgs/convert/foxglove_robot.h"
#include "msgs/convert/geometry.h"
#include "prehend/geometry/errors.h"
#include "prehend/robot/platform.h"

namespace prehend::convert {
namespace {

using geometry::InputError;
using geometry::RigidTransform;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

msgs::TriangleMesh box() { return to_message(geometry::make_box({0.02, 0.04, 0.06})); }

std::string metadata(const ::foxglove::SceneEntity& entity, const std::string& key) {
  for (const auto& pair : entity.metadata()) {
    if (pair.key() == key) return pair.value();
  }
  return "absent";
}

TEST(Foxglove, TypesHaveTheirPublicNumbers) {
  using google::protobuf::FieldDescriptor;
  const auto* raw = ::foxglove::RawImage::descriptor();
  EXPECT_EQ(raw->file()->name(), "foxglove/RawImage.proto");
  EXPECT_EQ(raw->FindFieldByName("frame_id")->number(), 7);
  EXPECT_EQ(raw->FindFieldByName("width")->type(), FieldDescriptor::TYPE_FIXED32);
  EXPECT_EQ(raw->FindFieldByName("data")->number(), 6);
  const auto* cloud = ::foxglove::PointCloud::descriptor();
  EXPECT_EQ(cloud->FindFieldByName("point_stride")->type(), FieldDescriptor::TYPE_FIXED32);
  EXPECT_EQ(cloud->FindFieldByName("data")->number(), 6);
  const auto* entity = ::foxglove::SceneEntity::descriptor();
  EXPECT_EQ(entity->FindFieldByName("triangles")->number(), 12);
  EXPECT_EQ(entity->FindFieldByName("models")->number(), 14);
  EXPECT_EQ(::foxglove::PackedElementField::FLOAT32, 7);
  EXPECT_EQ(::foxglove::PackedElementField::UINT16, 3);
  const auto* triangles = ::foxglove::TriangleListPrimitive::descriptor();
  EXPECT_EQ(triangles->FindFieldByName("indices")->type(), FieldDescriptor::TYPE_FIXED32);
  EXPECT_NE(::foxglove::CameraCalibration::descriptor()->FindFieldByName("K"), nullptr);
}

TEST(Foxglove, AnObjectIsColouredByWhatItRestsOn) {
  msgs::ObjectModel model;
  model.set_id(3);
  model.set_valid(true);
  *model.mutable_mesh() = box();
  model.set_volume(4.8e-5);
  model.set_confidence(0.75);
  std::string origin(model.mesh().vertex_count(), char(msgs::SURFACE_SEEN));
  origin[1] = char(msgs::SURFACE_PREDICTED);
  origin[2] = char(msgs::SURFACE_ASSUMED);
  origin[3] = char(msgs::SURFACE_TOUCHED);
  model.set_vertex_origin(origin);
  const auto entity = object_entity(model);
  EXPECT_EQ(entity.id(), "object/3");
  EXPECT_EQ(entity.frame_id(), "object/3");
  ASSERT_EQ(entity.triangles_size(), 1);
  const auto& mesh = entity.triangles(0);
  EXPECT_EQ(mesh.points_size(), 8);
  EXPECT_EQ(mesh.indices_size(), 36);
  ASSERT_EQ(mesh.colors_size(), 8);
  EXPECT_NEAR(mesh.colors(0).g(), 0.69, 1e-9);
  EXPECT_NEAR(mesh.colors(1).b(), 0.95, 1e-9);
  EXPECT_NEAR(mesh.colors(2).r(), 0.62, 1e-9);
  EXPECT_NEAR(mesh.colors(3).r(), 1.0, 1e-9);
  for (const auto& color : mesh.colors()) EXPECT_EQ(color.a(), 1);
  EXPECT_EQ(metadata(entity, "volume"), "4.8e-05");
  EXPECT_EQ(metadata(entity, "confidence"), "0.75");
  EXPECT_EQ(metadata(entity, "problem"), "absent");
  double largest = 0;
  for (const auto& point : mesh.points()) largest = std::max(largest, std::abs(point.z()));
  EXPECT_NEAR(largest, 0.03, 1e-6);
}

TEST(Foxglove, AnObjectWithoutAMeshSaysWhy) {
  msgs::ObjectModel model;
  model.set_problem("too few points");
  const auto entity = object_entity(model);
  EXPECT_EQ(entity.triangles_size(), 0);
  EXPECT_EQ(metadata(entity, "problem"), "too few points");
}

TEST(Foxglove, DamagedMeshesAndCloudsAreRefused) {
  msgs::TriangleMesh mesh = box();
  mesh.set_vertex_count(3);
  EXPECT_THROW(foxglove_triangles(mesh), InputError);
  mesh = box();
  const std::uint32_t wrong = 8;
  std::memcpy(&mesh.mutable_data()->at(12 * 8), &wrong, sizeof wrong);
  EXPECT_THROW(foxglove_triangles(mesh), InputError);
  mesh.set_vertex_count(0xffffffff);
  mesh.set_triangle_count(0xffffffff);
  EXPECT_THROW(foxglove_triangles(mesh), InputError);
  msgs::ObjectHypotheses objects;
  auto& cloud = *objects.add_objects()->mutable_cloud();
  cloud.set_count(2);
  cloud.set_stride(12);
  cloud.set_data(std::string(23, '\0'));
  EXPECT_THROW(objects_cloud(objects), InputError);
  cloud.set_stride(1);
  cloud.set_data(std::string(2, '\0'));
  EXPECT_THROW(objects_cloud(objects), InputError);
}

TEST(Foxglove, ACloudHasPlacesColoursAndObjects) {
  msgs::ObjectHypotheses objects;
  auto& object = *objects.add_objects();
  object.set_id(5);
  object.mutable_cloud()->set_count(2);
  object.mutable_cloud()->set_stride(16);
  object.mutable_cloud()->set_has_color(true);
  std::string data(32, '\0');
  const float points[2][3] = {{0.1f, 0.2f, 0.3f}, {NAN, 0, 0}};
  std::memcpy(&data[0], points[0], 12);
  data[12] = 10;
  data[13] = 20;
  data[14] = 30;
  std::memcpy(&data[16], points[1], 12);
  object.mutable_cloud()->set_data(data);
  const auto cloud = objects_cloud(objects);
  ASSERT_EQ(cloud.data().size(), cloud.point_stride()) << "a point that is NaN is left out";
  float xyz[3];
  std::memcpy(xyz, cloud.data().data(), sizeof xyz);
  EXPECT_THAT(xyz, ElementsAre(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(cloud.data().substr(12, 4), "\x0a\x14\x1e\xff");
  EXPECT_EQ(cloud.data()[16], 5);
  EXPECT_EQ(cloud.fields(7).name(), "object");
  EXPECT_EQ(cloud.fields(7).offset(), 16u);
  EXPECT_EQ(cloud.pose().orientation().w(), 1);
}

TEST(Foxglove, AGraspsArrowEndsWhereItClosesAlongItsApproach) {
  msgs::GraspPlan plan;
  plan.set_id(2);
  for (int i = 0; i < 3; ++i) {
    auto& grasp = *plan.add_grasps();
    RigidTransform X = RigidTransform::Identity();
    X.translation() = Eigen::Vector3d(0.1, 0.2, 0.3);
    *grasp.mutable_x_wg() = to_message(X);
    *grasp.mutable_approach_direction() = to_message(Eigen::Vector3d(0, 0, -1));
    grasp.set_pregrasp_opening(0.06);
    grasp.set_score(1.0 - 0.1 * i);
  }
  const auto update = grasps_update(plan, 2, 4);
  EXPECT_EQ(update.deletions_size(), 3) << "ranks 2 and 3 of before, and 'none'";
  ASSERT_EQ(update.entities_size(), 2);
  const auto& entity = update.entities(0);
  EXPECT_EQ(entity.id(), "grasp/2/0");
  const auto& arrow = entity.arrows(0);
  Eigen::Quaterniond q(arrow.pose().orientation().w(), arrow.pose().orientation().x(),
                       arrow.pose().orientation().y(), arrow.pose().orientation().z());
  const Eigen::Vector3d tip =
      Eigen::Vector3d(arrow.pose().position().x(), arrow.pose().position().y(),
                      arrow.pose().position().z()) +
      q * Eigen::Vector3d(arrow.shaft_length() + arrow.head_length(), 0, 0);
  EXPECT_NEAR((tip - Eigen::Vector3d(0.1, 0.2, 0.3)).norm(), 0, 1e-9);
  EXPECT_EQ(entity.spheres_size(), 2);
  EXPECT_EQ(metadata(entity, "success probability"), "absent");
}

TEST(Foxglove, NoGraspSaysWhy) {
  msgs::GraspPlan plan;
  plan.set_problem("too wide");
  auto& rejection = *plan.add_rejections();
  rejection.set_reason("wider than the opening");
  rejection.set_count(7);
  const auto update = grasps_update(plan, 8, 0);
  ASSERT_EQ(update.entities_size(), 1);
  EXPECT_EQ(metadata(update.entities(0), "problem"), "too wide");
  EXPECT_THAT(metadata(update.entities(0), "ledger"), HasSubstr("7 x wider"));
}

TEST(Foxglove, ImagesKeepTheirBytes) {
  msgs::StereoPair pair;
  pair.set_width(2);
  pair.set_height(1);
  pair.set_channels(3);
  pair.set_data("abcdefghijkl");
  EXPECT_EQ(stereo_image(pair, Eye::kLeft).data(), "abcdef");
  const auto right = stereo_image(pair, Eye::kRight);
  EXPECT_EQ(right.data(), "ghijkl");
  EXPECT_EQ(right.encoding(), "rgb8");
  EXPECT_EQ(right.step(), 6u);
  pair.set_height(2);
  EXPECT_THROW(stereo_image(pair, Eye::kLeft), InputError);
  msgs::TactileFrame frame;
  frame.set_rows(1);
  frame.set_columns(2);
  frame.set_newton_per_count(0.5);
  frame.add_intensity(0);
  EXPECT_THROW(tactile_image(frame), InputError);
  frame.add_intensity(3);
  const auto image = tactile_image(frame);
  float newtons[2];
  ASSERT_EQ(image.data().size(), sizeof newtons);
  std::memcpy(newtons, image.data().data(), sizeof newtons);
  EXPECT_THAT(newtons, ElementsAre(0.f, 1.5f));
}

TEST(Foxglove, LinksOfAPlatformStandWhereItsChainHasThem) {
  const auto platform = robot::read_platform("config/robots/kr5_sdh.yaml");
  const auto chain = platform.arm_chain();
  Eigen::VectorXd q = chain.middle();
  std::map<std::string, double> positions;
  for (int i = 0; i < chain.size(); ++i) {
    q[i] += 0.1 * (i + 1);
    positions[chain.joints()[static_cast<std::size_t>(i)].name] = q[i];
  }
  const auto poses = link_poses(platform, positions);
  const auto flange = static_cast<std::size_t>(platform.model.link_index(platform.flange));
  const RigidTransform expected = platform.X_WB * chain.forward(q);
  EXPECT_TRUE(poses[flange].isApprox(expected, 1e-9));
  const auto update = robot_update(platform, 0);
  EXPECT_GT(update.entities_size(), 6);
  for (const auto& entity : update.entities()) {
    EXPECT_TRUE(entity.frame_locked());
    EXPECT_GT(entity.triangles(0).indices_size(), 0) << entity.id();
  }
}

}  // namespace
}  // namespace prehend::convert
