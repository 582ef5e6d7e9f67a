#include "prehend/perception/recorded_cloud.h"

#include <algorithm>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "tests/perception/synthetic_view.h"

namespace prehend::perception {
namespace {

using geometry::CloudFile;
using geometry::InputError;
using geometry::RigidTransform;
using ::testing::HasSubstr;
using testing::standing_box;
using testing::SyntheticView;
using testing::table_top;

SyntheticView scene_view() {
  SyntheticView view;
  view.boxes = {table_top(), standing_box(-0.1, 0, {0.1, 0.1, 0.15}),
                standing_box(0.15, 0.05, {0.08, 0.08, 0.1})};
  return view;
}

CloudFile file_of(geometry::PointCloud cloud) {
  CloudFile file;
  file.cloud = std::move(cloud);
  return file;
}

RigidTransform half_turn_about_x() {
  return geometry::make_transform({0, 1, 0, 0}, Eigen::Vector3d::Zero());
}

std::string all_notes(const RecordedCloud& recorded) {
  std::string notes;
  for (const std::string& note : recorded.notes) notes += note + "\n";
  return notes;
}

void expect_scene(const RecordedCloud& recorded) {
  EXPECT_FALSE(recorded.hypothetical_table_C);
  const SegmentedScene scene = segment_recorded_cloud(recorded);
  EXPECT_EQ(scene.objects.size(), 2U);
  EXPECT_NEAR(scene.X_WC.translation().z(), 0.6, 0.01);
}

TEST(InterpretRecordedCloud, PlainOpticalFrame) {
  const RecordedCloud recorded = interpret_recorded_cloud(file_of(render(scene_view())));
  EXPECT_TRUE(recorded.X_FC.isApprox(RigidTransform::Identity()));
  EXPECT_NEAR(recorded.camera.fx, 300, 0.1);
  EXPECT_TRUE(recorded.notes.empty()) << all_notes(recorded);
  expect_scene(recorded);
}

TEST(InterpretRecordedCloud, HeaderThatLiesIsIgnored) {
  CloudFile file = file_of(render(scene_view()));
  file.viewpoint = half_turn_about_x();
  const RecordedCloud recorded = interpret_recorded_cloud(file);
  EXPECT_TRUE(recorded.X_FC.isApprox(RigidTransform::Identity()));
  EXPECT_THAT(all_notes(recorded), HasSubstr("VIEWPOINT is ignored"));
  expect_scene(recorded);
}

TEST(InterpretRecordedCloud, CameraAlongMinusZ) {
  const geometry::PointCloud turned =
      geometry::transformed(render(scene_view()), half_turn_about_x());
  for (const bool organized : {true, false}) {
    const RecordedCloud recorded =
        interpret_recorded_cloud(file_of(organized ? turned : geometry::without_invalid(turned)));
    EXPECT_TRUE(recorded.X_FC.linear().isApprox(half_turn_about_x().linear(), 1e-9));
    EXPECT_THAT(all_notes(recorded), HasSubstr("turned"));
    expect_scene(recorded);
  }
}

// Mounted on its head: the first row of its image shows what is nearest.
TEST(InterpretRecordedCloud, CameraUpsideDown) {
  const RigidTransform roll = geometry::make_transform({0, 0, 0, 1}, Eigen::Vector3d::Zero());
  geometry::PointCloud rolled = geometry::transformed(render(scene_view()), roll);
  std::reverse(rolled.points.begin(), rolled.points.end());
  std::reverse(rolled.colors.begin(), rolled.colors.end());
  for (const bool organized : {true, false}) {
    const RecordedCloud recorded =
        interpret_recorded_cloud(file_of(organized ? rolled : geometry::without_invalid(rolled)));
    expect_scene(recorded);
    EXPECT_THAT(all_notes(recorded), HasSubstr("on its head"));
  }
}

TEST(InterpretRecordedCloud, WorldFrameWithAnHonestHeader) {
  const SyntheticView view = scene_view();
  const geometry::PointCloud cloud_W = geometry::transformed(render(view), view.X_WC);
  CloudFile file = file_of(geometry::without_invalid(cloud_W));
  file.viewpoint = view.X_WC;
  const RecordedCloud recorded = interpret_recorded_cloud(file);
  EXPECT_TRUE(recorded.X_FC.isApprox(view.X_WC, 1e-9));
  expect_scene(recorded);
}

TEST(InterpretRecordedCloud, GivenViewpointWins) {
  const SyntheticView view = scene_view();
  CloudFile file = file_of(geometry::transformed(render(view), view.X_WC));
  file.viewpoint = half_turn_about_x();
  RecordedCloudOptions options;
  options.viewpoint = view.X_WC;
  const RecordedCloud recorded = interpret_recorded_cloud(file, options);
  EXPECT_TRUE(recorded.X_FC.isApprox(view.X_WC));
  EXPECT_TRUE(recorded.cloud_C.organized());
  EXPECT_NEAR(recorded.camera.fx, 300, 0.1);
  expect_scene(recorded);
}

TEST(InterpretRecordedCloud, SceneWithoutACameraGetsAVirtualOne) {
  const SyntheticView view = scene_view();
  const RecordedCloud recorded = interpret_recorded_cloud(
      file_of(geometry::without_invalid(geometry::transformed(render(view), view.X_WC))));
  EXPECT_THAT(all_notes(recorded), HasSubstr("viewpoint is unknown"));
  EXPECT_EQ(segment_recorded_cloud(recorded).objects.size(), 2U);
}

TEST(InterpretRecordedCloud, LabelsStayWithTheirPoints) {
  CloudFile file = file_of(render(scene_view()));
  for (std::size_t i = 0; i < file.cloud.size(); ++i) {
    file.labels.push_back(static_cast<std::uint32_t>(i));
  }
  file.has_labels = true;
  EXPECT_EQ(interpret_recorded_cloud(file).labels, file.labels);
  file.cloud.height = file.cloud.width = 0;  // unorganized: invalid points go
  const RecordedCloud recorded = interpret_recorded_cloud(file);
  ASSERT_EQ(recorded.labels.size(), recorded.cloud_C.size());
  for (std::size_t k = 0; k < recorded.labels.size(); k += 1000) {
    EXPECT_EQ(recorded.cloud_C.points[k], file.cloud.points[recorded.labels[k]]);
  }
}

TEST(ThinnedRecordedCloud, ShowsTheSameScene) {
  CloudFile file = file_of(render(scene_view()));
  for (std::size_t i = 0; i < file.cloud.size(); ++i) {
    file.labels.push_back(static_cast<std::uint32_t>(i));
  }
  file.has_labels = true;
  const RecordedCloud recorded = interpret_recorded_cloud(file);
  const RecordedCloud half = thinned(recorded, static_cast<int>(recorded.cloud_C.size() / 4));
  EXPECT_EQ(half.cloud_C.width, recorded.cloud_C.width / 2);
  EXPECT_NEAR(half.camera.fx, recorded.camera.fx / 2, 1e-9);
  expect_scene(half);
  ASSERT_EQ(half.labels.size(), half.cloud_C.size());
  for (std::size_t k = 0; k < half.labels.size(); k += 100) {
    if (!geometry::is_finite(half.cloud_C.points[k])) continue;
    EXPECT_EQ(half.cloud_C.points[k], recorded.cloud_C.points[half.labels[k]]);
  }
  EXPECT_EQ(thinned(recorded, 0).cloud_C.size(), recorded.cloud_C.size());
  file.cloud.height = file.cloud.width = 0;
  const RecordedCloud no_image = interpret_recorded_cloud(file);
  EXPECT_EQ(thinned(no_image, 1000).cloud_C.size(), no_image.cloud_C.size());
}

TEST(InterpretRecordedCloud, SingleObjectStandsOnAHypotheticalTable) {
  SyntheticView view;
  view.boxes = {standing_box(0, 0, {0.07, 0.06, 0.2})};
  geometry::PointCloud cloud_W =
      geometry::without_invalid(geometry::transformed(render(view), view.X_WC));
  for (Eigen::Vector3f& p : cloud_W.points) p.z() -= 0.1F;  // centred, as models are
  for (const bool with_up : {true, false}) {
    RecordedCloudOptions options;
    if (with_up) options.up = Eigen::Vector3d(0, 0, 2);
    const RecordedCloud recorded = interpret_recorded_cloud(file_of(cloud_W), options);
    ASSERT_TRUE(recorded.hypothetical_table_C);
    EXPECT_THAT(all_notes(recorded), HasSubstr("hypothetical table"));
    const SegmentedScene scene = segment_recorded_cloud(recorded);
    ASSERT_EQ(scene.objects.size(), 1U);
    EXPECT_GT(scene.objects[0].cloud_W.size(), cloud_W.size() * 9 / 10);
    Eigen::AlignedBox3f box;
    for (const Eigen::Vector3f& p : scene.objects[0].cloud_W.points) box.extend(p);
    EXPECT_NEAR(box.min().z(), 0.0, 0.002);
    // The long axis of a half-seen surface leans a little.
    EXPECT_NEAR(box.max().z(), 0.2, with_up ? 0.002 : 0.05);
    EXPECT_FALSE(scene.objects[0].touches_image_border);
  }
}

TEST(InterpretRecordedCloud, OfAModelSeenFromAllSidesOneSideIsKept) {
  geometry::PointCloud cloud;
  for (double angle = 0; angle < 6.28; angle += 0.04) {
    for (double z = -0.06; z <= 0.06; z += 0.0015) {
      cloud.points.push_back(
          Eigen::Vector3d(0.03 * std::cos(angle), 0.03 * std::sin(angle), z).cast<float>());
    }
  }
  const RecordedCloud recorded = interpret_recorded_cloud(file_of(cloud));
  EXPECT_THAT(all_notes(recorded), HasSubstr("hidden from the virtual camera"));
  const Eigen::Vector3d eye = recorded.X_FC.translation();
  const geometry::PointCloud kept_F = geometry::transformed(recorded.cloud_C, recorded.X_FC);
  EXPECT_GT(kept_F.size(), cloud.size() / 3);
  EXPECT_LT(kept_F.size(), 2 * cloud.size() / 3);
  std::size_t behind = 0;
  for (const Eigen::Vector3f& p : kept_F.points) {
    behind += p.head<2>().cast<double>().dot(eye.head<2>().normalized()) < -0.01;
  }
  // Looking into the open top shows a little of the far wall's inside.
  EXPECT_LT(static_cast<double>(behind), 0.3 * static_cast<double>(kept_F.size()));
}

TEST(InterpretRecordedCloud, SingleObjectCanBeForced) {
  RecordedCloudOptions options;
  options.table.kind = TableChoice::Kind::kNone;
  const RecordedCloud recorded = interpret_recorded_cloud(file_of(render(scene_view())), options);
  EXPECT_TRUE(recorded.hypothetical_table_C);
  EXPECT_EQ(segment_recorded_cloud(recorded).objects.size(), 1U);
}

TEST(InterpretRecordedCloud, TheTableCanBeGiven) {
  // In the camera's frame, which is the file's: 0.6 m under the camera, as the scene has it.
  const geometry::PointCloud cloud = render(scene_view());
  const Table found = find_table(cloud);
  RecordedCloudOptions options;
  options.table = {TableChoice::Kind::kPlane, found.plane_C};
  const RecordedCloud recorded = interpret_recorded_cloud(file_of(cloud), options);
  ASSERT_TRUE(recorded.given_table_C);
  expect_scene(recorded);
  options.table.plane_F.offset += 100;
  EXPECT_THROW(segment_recorded_cloud(interpret_recorded_cloud(file_of(cloud), options)),
               InputError);
}

// Nothing else is in view: "no table" was said, or a face was taken for one and the body was gone.
TEST(InterpretRecordedCloud, AnOrganizedCloudOfOneBodyIsOneBody) {
  SyntheticView view;
  view.boxes = {standing_box(0, 0, {0.07, 0.16, 0.2})};
  const geometry::PointCloud cloud = render(view);
  ASSERT_TRUE(cloud.organized());
  const RecordedCloud recorded = interpret_recorded_cloud(file_of(cloud));
  EXPECT_TRUE(recorded.hypothetical_table_C);
  const SegmentedScene scene = segment_recorded_cloud(recorded);
  ASSERT_EQ(scene.objects.size(), 1U);
  std::size_t finite = 0;
  for (const Eigen::Vector3f& p : cloud.points) finite += geometry::is_finite(p);
  EXPECT_EQ(scene.objects[0].cloud_W.size(), finite);
  RecordedCloudOptions options;
  options.table.kind = TableChoice::Kind::kFind;
  EXPECT_FALSE(interpret_recorded_cloud(file_of(cloud), options).hypothetical_table_C);
}

TEST(InterpretRecordedCloud, ZerosAreInvalid) {
  geometry::PointCloud cloud = render(scene_view());
  for (Eigen::Vector3f& p : cloud.points) {
    if (!geometry::is_finite(p)) p.setZero();
  }
  expect_scene(interpret_recorded_cloud(file_of(cloud)));
}

TEST(InterpretRecordedCloud, OneWildPointIsNothing) {
  geometry::PointCloud cloud = geometry::without_invalid(render(scene_view()));
  cloud.points.emplace_back(0.0F, 0.0F, 900.0F);
  expect_scene(interpret_recorded_cloud(file_of(cloud)));
}

TEST(ReadRecordedCloudOptions, TakesWordsAndNamesWhatIsWrong) {
  const RecordedCloudOptions none = read_recorded_cloud_options(1, "", "", "");
  EXPECT_EQ(none.table.kind, TableChoice::Kind::kAuto);
  EXPECT_FALSE(none.viewpoint || none.up);
  const RecordedCloudOptions all =
      read_recorded_cloud_options(0.001, "1 2 3 1 0 0 0", "0 0 1", "0 0 2 1");
  EXPECT_EQ(all.table.kind, TableChoice::Kind::kPlane);
  EXPECT_EQ(all.table.plane_F.normal, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(all.table.plane_F.offset, 0.5);
  EXPECT_EQ(all.viewpoint->translation(), Eigen::Vector3d(1, 2, 3));
  const auto error = [](const std::string& viewpoint, const std::string& up,
                        const std::string& table) {
    try {
      read_recorded_cloud_options(1, viewpoint, up, table);
    } catch (const InputError& wrong) {
      return std::string(wrong.what());
    }
    return std::string("no error");
  };
  EXPECT_THAT(error("", "", "no"), HasSubstr("auto, find, none"));
  EXPECT_THAT(error("", "", "0 0 0 1"), HasSubstr("without a direction"));
  EXPECT_THAT(error("", "", "0 0 1"), HasSubstr("a b c d"));
  EXPECT_THAT(error("1 2 3", "", ""), HasSubstr("viewpoint"));
  EXPECT_THAT(error("1 2 3 0 0 0 0", "", ""), HasSubstr("quaternion"));
  EXPECT_THAT(error("", "0 0 nan", ""), HasSubstr("up"));
}

std::string error_of(const geometry::PointCloud& cloud, const RecordedCloudOptions& options = {}) {
  try {
    interpret_recorded_cloud(file_of(cloud), options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

geometry::PointCloud points(std::vector<Eigen::Vector3f> values) {
  geometry::PointCloud cloud;
  cloud.points = std::move(values);
  return cloud;
}

TEST(InterpretRecordedCloud, SaysWhatIsWrong) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(error_of({}), HasSubstr("empty"));
  EXPECT_THAT(error_of(points(std::vector<Eigen::Vector3f>(9, {nan, nan, nan}))), HasSubstr("NaN"));
  EXPECT_THAT(error_of(points({{0.1F, 0.2F, 1.0F}})), HasSubstr("one valid point"));
  EXPECT_THAT(error_of(points(std::vector<Eigen::Vector3f>(50, {0.1F, 0.2F, 1.0F}))),
              HasSubstr("one point"));
  std::vector<Eigen::Vector3f> line;
  std::vector<Eigen::Vector3f> plane;
  for (int i = 0; i < 400; ++i) {
    line.emplace_back(0.001F * static_cast<float>(i), 0.002F * static_cast<float>(i), 1.0F);
    plane.emplace_back(0.01F * static_cast<float>(i % 20), 0.01F * static_cast<float>(i / 20),
                       1.0F);
  }
  EXPECT_THAT(error_of(points(line)), HasSubstr("collinear"));
  EXPECT_THAT(error_of(points(plane)), HasSubstr("coplanar"));
}

TEST(InterpretRecordedCloud, Millimetres) {
  geometry::PointCloud cloud = render(scene_view());
  for (Eigen::Vector3f& p : cloud.points) p *= 1000.0F;
  EXPECT_THAT(error_of(cloud), AllOf(HasSubstr("1.03 m if in millimetres"), HasSubstr("0.001")));
  RecordedCloudOptions options;
  options.scale = 0.001;
  expect_scene(interpret_recorded_cloud(file_of(cloud), options));
  // Centimetres were told to be millimetres, and that was obeyed.
  for (Eigen::Vector3f& p : cloud.points) p *= 0.1F;
  EXPECT_THAT(error_of(cloud), HasSubstr("1.03 m if in centimetres"));
  options.scale = 0.001;
  EXPECT_THAT(all_notes(interpret_recorded_cloud(file_of(cloud), options)),
              HasSubstr("is the scale right?"));
  for (Eigen::Vector3f& p : cloud.points) p *= 1e-5F;
  EXPECT_THAT(error_of(cloud), HasSubstr("scale"));
}

TEST(InterpretRecordedCloud, MirroredImage) {
  geometry::PointCloud cloud = render(scene_view());
  for (Eigen::Vector3f& p : cloud.points) p.x() = -p.x();
  EXPECT_THAT(error_of(cloud), HasSubstr("mirrored"));
}

TEST(InterpretRecordedCloud, RejectsBadOptions) {
  RecordedCloudOptions options;
  options.scale = 0;
  EXPECT_THROW(interpret_recorded_cloud({}, options), std::invalid_argument);
  options = {};
  options.up = Eigen::Vector3d::Zero();
  EXPECT_THROW(interpret_recorded_cloud({}, options), std::invalid_argument);
  RecordedCloudOptions behind;
  behind.viewpoint = geometry::look_at({0, 0, -1}, {0, 0, -2}, Eigen::Vector3d::UnitY());
  EXPECT_THAT(error_of(render(scene_view()), behind), HasSubstr("in front"));
}

}  // namespace
}  // namespace prehend::perception
