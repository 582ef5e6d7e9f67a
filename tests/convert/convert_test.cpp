#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "msgs/convert/geometry.h"
#include "msgs/convert/images.h"
#include "msgs/convert/objects.h"
#include "prehend/geometry/errors.h"

namespace prehend::convert {
namespace {

using geometry::InputError;

TEST(Convert, PoseRoundTripAndBadQuaternion) {
  const auto X = geometry::make_transform(Eigen::Quaterniond(0.1, 0.2, -0.3, 0.9), {1, 2, 3});
  EXPECT_TRUE(from_message(to_message(X)).isApprox(X, 1e-12));
  msgs::Pose pose = to_message(X);
  pose.mutable_orientation()->set_w(5);
  EXPECT_THROW(from_message(pose), InputError);
  EXPECT_THROW(from_message(msgs::Pose{}), InputError);  // an all-zero quaternion
  pose = to_message(X);
  pose.mutable_position()->set_y(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THROW(from_message(pose), InputError);
}

TEST(Convert, CloudRoundTripInEveryCombination) {
  for (int fields = 0; fields < 4; ++fields) {
    geometry::PointCloud cloud;
    cloud.width = 2;
    cloud.height = 2;
    cloud.points = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {NAN, NAN, NAN}};
    if (fields & 1) cloud.colors = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {0, 255, 128}};
    if (fields & 2) cloud.normals.assign(4, Eigen::Vector3f::UnitY());
    const auto back = from_message(to_message(cloud));
    EXPECT_TRUE(back.organized());
    EXPECT_EQ(back.points[2], cloud.points[2]);
    EXPECT_TRUE(std::isnan(back.points[3].x()));
    EXPECT_EQ(back.colors, cloud.colors);
    EXPECT_EQ(back.normals, cloud.normals);
  }
}

TEST(Convert, CloudWithLyingCountsIsRefusedBeforeAnythingIsAllocated) {
  geometry::PointCloud cloud;
  cloud.points = {{1, 2, 3}};
  msgs::PointCloud message = to_message(cloud);
  message.set_count(4000000000u);
  EXPECT_THROW(from_message(message), InputError);
  message.set_count(1);
  message.set_stride(16);
  EXPECT_THROW(from_message(message), InputError);
  message.set_stride(12);
  message.set_width(3);
  message.set_height(3);
  EXPECT_THROW(from_message(message), InputError);
}

TEST(Convert, MeshRoundTripAndHostileIndices) {
  const auto box = geometry::make_box({0.5, 0.25, 1});
  const auto back = from_message(to_message(box));
  EXPECT_EQ(back.triangles, box.triangles);
  EXPECT_EQ(back.vertices, box.vertices);  // exact in float32
  auto bad = box;
  bad.triangles[3][1] = 8;
  EXPECT_THROW(from_message(to_message(bad)), InputError);
  msgs::TriangleMesh short_data = to_message(box);
  short_data.mutable_data()->pop_back();
  EXPECT_THROW(from_message(short_data), InputError);
}

TEST(Convert, CameraRefusesWhatCannotBe) {
  const geometry::StereoCamera camera{{640, 480, 500, 500, 320, 240}, 0.1};
  const auto X_WC = geometry::look_at({1, 0, 1}, {0, 0, 0});
  const auto message = to_message(camera, X_WC);
  EXPECT_DOUBLE_EQ(from_message(message).baseline, 0.1);
  EXPECT_TRUE(camera_pose(message)->isApprox(X_WC, 1e-12));
  EXPECT_FALSE(camera_pose(to_message(camera, std::nullopt)));
  auto bad = message;
  bad.set_fx(0);
  EXPECT_THROW(from_message(bad), InputError);
  bad = message;
  bad.set_width(1u << 30);
  EXPECT_THROW(from_message(bad), InputError);
  bad = message;
  bad.set_baseline(-0.1);
  EXPECT_THROW(from_message(bad), InputError);
}

TEST(Convert, StereoPairRoundTripGreyAndWrongSize) {
  StereoImages images{geometry::ColorImage(3, 2, {1, 2, 3}), geometry::ColorImage(3, 2, {4, 5, 6})};
  images.left.at(2, 1) = {9, 8, 7};
  const auto message = to_message(images);
  EXPECT_EQ(from_message(message).left.data, images.left.data);
  EXPECT_EQ(from_message(message).right.data, images.right.data);
  msgs::StereoPair grey;
  grey.set_width(2);
  grey.set_height(1);
  grey.set_channels(1);
  grey.set_data("\x01\x02\x03\x04");
  EXPECT_EQ(from_message(grey).right.at(1, 0), (geometry::Rgb{4, 4, 4}));
  grey.set_width(3);
  EXPECT_THROW(from_message(grey), InputError);
}

TEST(Convert, HypothesesKeepMasksAndDepth) {
  perception::SegmentedScene scene;
  scene.camera = {8, 6, 10, 10, 4, 3};
  scene.X_WC = geometry::look_at({1, 0, 1}, {0, 0, 0});
  scene.depth = geometry::DepthImage(8, 6, NAN);
  scene.depth.at(3, 2) = 0.73215f;
  perception::ObjectHypothesis object;
  object.id = 4;
  object.cloud_W.points = {{1, 2, 3}};
  object.mask = geometry::MaskImage(8, 6, 0);
  object.mask.at(3, 2) = object.mask.at(5, 4) = 255;
  object.touches_image_border = true;
  object.occluded_share = 0.25;
  object.may_be_several = true;
  scene.objects = {object};
  auto message = to_message(scene);
  EXPECT_EQ(message.objects(0).mask().size(), 9u);  // only the window
  const auto back = from_message(message);
  EXPECT_EQ(back.objects[0].mask.data, object.mask.data);
  EXPECT_TRUE(back.objects[0].touches_image_border);
  EXPECT_EQ(back.objects[0].occluded_share, 0.25);
  EXPECT_TRUE(back.objects[0].may_be_several);
  EXPECT_NEAR(back.depth.at(3, 2), 0.73215, 1e-4);
  EXPECT_TRUE(std::isnan(back.depth.at(0, 0)));
  message.mutable_objects(0)->set_mask_x(7);
  EXPECT_THROW(from_message(message), InputError);
}

TEST(Convert, CompletedShapeAndModelRoundTrip) {
  shape::CompletedShape shape;
  shape.cloud_W.points = {{1, 2, 3}, {4, 5, 6}};
  shape.origin = {shape::PointOrigin::kSeen, shape::PointOrigin::kMirrored};
  shape.symmetry.vote = 0.25;
  shape.support = {shape::PointSupport::kSeen, shape::PointSupport::kOccluded};
  shape.point_confidence = {1.f, 0.4f};
  shape.method = shape::CompletionMethod::kRotation;
  shape.refused = "mirror: two heads";
  shape.confidence = 0.6;
  shape.evidence.open_top = 0.3;
  shape.evidence.may_be_several = true;
  shape.planes = {shape.symmetry};
  shape.seen_space = {
      {2, 1, 500, 500, -7, 3}, geometry::look_at({1, 0, 1}, {0, 0, 0}), {2, 1, 0.7f}};
  shape.seen_space.empty_until.at(1, 0) = std::numeric_limits<float>::quiet_NaN();
  shape.bounds_W = {{Eigen::Vector3d::UnitY(), 0.3}};
  auto message = to_message(shape);
  EXPECT_EQ(from_message(message).origin, shape.origin);
  EXPECT_EQ(from_message(message).symmetry.vote, 0.25);
  const shape::CompletedShape received = from_message(message);
  EXPECT_EQ(received.support, shape.support);
  EXPECT_NEAR(received.point_confidence[1], 0.4, 0.5 / 255);
  EXPECT_NEAR(received.region_confidence[1], 0.4, 0.5 / 255);
  EXPECT_EQ(received.method, shape.method);
  EXPECT_EQ(received.refused, shape.refused);
  EXPECT_EQ(received.confidence, 0.6);
  EXPECT_TRUE(received.evidence.open_vessel());
  EXPECT_TRUE(received.evidence.may_be_several);
  EXPECT_EQ(received.planes.front().vote, 0.25);
  ASSERT_EQ(received.bounds_W.size(), 1u);
  EXPECT_EQ(received.bounds_W[0].normal, Eigen::Vector3d::UnitY());
  EXPECT_EQ(received.bounds_W[0].offset, 0.3);
  EXPECT_EQ(received.seen_space.camera.cx, -7);
  EXPECT_TRUE(received.seen_space.X_WC.isApprox(shape.seen_space.X_WC));
  EXPECT_NEAR(received.seen_space.empty_until.at(0, 0), 0.7, 1e-4);
  EXPECT_TRUE(std::isnan(received.seen_space.empty_until.at(1, 0)));
  auto odd = message;
  odd.clear_support();  // as from a sender that does not know it
  odd.clear_point_confidence();
  const shape::CompletedShape bare = from_message(odd);
  EXPECT_EQ(bare.support[1], shape::PointSupport::kUnseen);
  EXPECT_EQ(bare.point_confidence, (std::vector<float>{0, 0}));
  odd = message;
  odd.mutable_support()->pop_back();
  EXPECT_THROW(from_message(odd), InputError);
  odd = message;
  odd.mutable_seen_depth()->pop_back();
  EXPECT_THROW(from_message(odd), InputError);
  odd = message;
  odd.mutable_seen_camera()->clear_x_wc();
  EXPECT_THROW(from_message(odd), InputError);
  odd = message;
  odd.set_method("magic");
  EXPECT_THROW(from_message(odd), InputError);
  odd = message;
  *odd.add_alternatives() = message;
  EXPECT_EQ(from_message(odd).alternatives.front().origin, shape.origin);
  *odd.mutable_alternatives(0)->add_alternatives() = message;
  EXPECT_THROW(from_message(odd), InputError);
  message.mutable_origin()->pop_back();
  EXPECT_THROW(from_message(message), InputError);

  surface::ObjectModel model;
  model.mesh_W = geometry::make_box({0.5, 0.5, 0.25});
  model.mass_properties = geometry::mass_properties(model.mesh_W);
  model.convex_pieces_W = {model.mesh_W};
  model.alternatives_W = {geometry::make_box({0.5, 0.5, 0.125})};
  const auto back = from_message(to_message(model));
  ASSERT_EQ(back.alternatives_W.size(), 1u);
  EXPECT_EQ(back.alternatives_W.front().vertices, model.alternatives_W.front().vertices);
  EXPECT_TRUE(back.mass_properties.unit_density_inertia.isApprox(
      model.mass_properties.unit_density_inertia));
  EXPECT_EQ(back.convex_pieces_W.size(), 1u);
  EXPECT_TRUE(back.defects.watertight());
  EXPECT_TRUE(back.vertex_origin.empty());

  model.vertex_origin.assign(model.mesh_W.vertices.size(), surface::SurfaceOrigin::kSeen);
  model.vertex_origin.back() = surface::SurfaceOrigin::kAssumed;
  model.vertex_confidence.assign(model.mesh_W.vertices.size(), 0.8f);
  model.guessed_area = 0.3;
  auto whole = to_message(model);
  EXPECT_EQ(from_message(whole).vertex_origin, model.vertex_origin);
  EXPECT_NEAR(from_message(whole).vertex_confidence[2], 0.8, 0.5 / 255);
  EXPECT_EQ(from_message(whole).guessed_area, 0.3);
  whole.mutable_vertex_confidence()->pop_back();
  EXPECT_THROW(from_message(whole), InputError);
  whole = to_message(model);
  whole.mutable_vertex_origin()->back() = 17;
  EXPECT_THROW(from_message(whole), InputError);
}

}  // namespace
}  // namespace prehend::convert
