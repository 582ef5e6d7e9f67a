// Pads of hands' files: flat, laid on a link, regions of meshes.

#include <cmath>

#include <gtest/gtest.h>

#include "prehend/geometry/mesh_files.h"
#include "prehend/robot/hand_model.h"
#include "prehend/robot/pad_surface.h"
#include "robot_file.h"

namespace prehend::robot {
namespace {

class HandPads : public RobotFile {
 protected:
  std::string error_of_hand(const std::string& file, const std::string& from,
                            const std::string& to) const {
    return error_of([&] { read_hand_model(changed(file, from, to)); });
  }
  void expect_refused(const std::string& file, const std::string& from, const std::string& to,
                      const std::string& says) const {
    const std::string error = error_of_hand(file, from, to);
    EXPECT_NE(error.find(says), std::string::npos) << to << ": " << error;
    EXPECT_NE(error.find(file + ":"), std::string::npos) << "with its line: " << error;
  }
};

TEST_F(HandPads, OfTheBarrettHandHave24CellsEach) {
  const HandModel hand = read_hand_model("config/robots/bh8.yaml");
  ASSERT_EQ(hand.pads.size(), 4u);
  for (const HandPad& pad : hand.pads) {
    EXPECT_EQ(pad.layout->cells(), 24u) << pad.name;
    EXPECT_EQ(static_cast<int>(pad.layout->size()), pad.model.rows * pad.model.columns);
    // 4095 counts are 16 N/cm2.
    const double cell = pad.model.texel_pitch * pad.model.texel_pitch;
    EXPECT_NEAR(pad.model.newton_per_count, 1e4 * cell / 256, 5e-3 * pad.model.newton_per_count);
    for (std::size_t i = 0; i < pad.layout->size(); ++i) {
      if (pad.layout->area(i) == 0) continue;
      EXPECT_NEAR(pad.layout->z[i], 0.001, 1e-9) << "raised over flat faces";
      EXPECT_NEAR(pad.layout->nz[i], 1, 1e-9);
    }
  }
  EXPECT_TRUE(hand.pads[0].covers({0, 0.01, 0}, {0, 0, 1}));
  EXPECT_FALSE(hand.pads[0].covers({0, 0.01, 0}, {0, 0, -1})) << "from behind";
  EXPECT_FALSE(hand.pads[0].covers({0.02, 0.01, 0}, {0, 0, 1})) << "beside it";
}

TEST_F(HandPads, OfTheSdh2StayFlat) {
  for (const HandPad& pad : read_hand_model("config/robots/sdh2.yaml").pads) {
    EXPECT_TRUE(pad.layout->is_flat());
    EXPECT_EQ(pad.layout->rows(), pad.model.rows);
    EXPECT_EQ(pad.length(), pad.model.length());
  }
}

TEST_F(HandPads, OfTheProbeAreTheVerticesOfItsTip) {
  const HandModel hand = read_hand_model("config/robots/ball_probe.yaml");
  ASSERT_EQ(hand.pads.size(), 1u);
  const HandPad& pad = hand.pads.front();
  EXPECT_EQ(pad.layout->size(), 193u) << "8 rings of 24 and the pole";
  EXPECT_EQ(pad.model.rows, 1);
  EXPECT_EQ(pad.model.columns, 193);
  EXPECT_NEAR(pad.layout->area(), 2 * M_PI * 1e-4, 0.02 * pad.layout->area());
  EXPECT_EQ(pad.X_LP.matrix(), geometry::RigidTransform::Identity().matrix());
  EXPECT_NEAR(pad.length(), 0.02, 1e-9);
  for (std::size_t i = 0; i < pad.layout->size(); ++i) {
    EXPECT_NEAR(pad.layout->position(i).norm(), 0.01, 1e-7);
    EXPECT_GE(pad.layout->position(i).z(), -1e-9) << "not of the rod";
  }
  EXPECT_TRUE(pad.covers({0, 0, 0.01}, {0, 0, 1}));
  EXPECT_FALSE(pad.covers({0, 0, -0.02}, {1, 0, 0}));
}

TEST_F(HandPads, MayBeOfAFileBesideTheRobots) {
  geometry::write_mesh_file(folder_ / "cap.ply", geometry::make_sphere(8, 16));
  const HandModel hand = read_hand_model(
      changed("ball_probe.yaml", "surface: {group: tip}",
              "surface: {mesh: cap.ply, scale: 0.001, origin: {xyz: [0, 0, 0.002]}}"));
  const contact::PadLayout& layout = *hand.pads.front().layout;
  for (std::size_t i = 0; i < layout.size(); ++i) {
    EXPECT_NEAR((layout.position(i) - Eigen::Vector3d(0, 0, 0.002)).norm(), 0.008, 1e-7);
  }
}

// Every kind of shape that a link may have.
TEST(LayOnLink, FollowsBoxesCylindersBallsAndMeshes) {
  const contact::PadGrid grid{6, 4, 0.008, 0.012, 0.002};
  geometry::RigidTransform X_LP = geometry::RigidTransform::Identity();
  X_LP.translation() = Eigen::Vector3d(0.001, 0.002, 0.01);
  Link link{"tip", 0, {CollisionShape{}}};
  CollisionShape& shape = link.shapes.front();
  shape.size = Eigen::Vector3d(0.04, 0.04, 0.02);
  contact::PadLayout pad = lay_on_link(link, X_LP, grid);
  EXPECT_NEAR(pad.area(), 0.008 * 0.012, 1e-12);
  for (const double z : pad.z) EXPECT_NEAR(z, 0, 1e-12);

  shape.kind = CollisionShape::Kind::kMesh;
  shape.solid = std::make_shared<geometry::TriangleMesh>(geometry::make_box({0.04, 0.04, 0.02}));
  X_LP.translation() = Eigen::Vector3d(0, 0, 0.01);  // rays on the mesh's edges, too
  pad = lay_on_link(link, X_LP, grid);
  for (const double z : pad.z) EXPECT_NEAR(z, 0, 1e-9);

  const auto expect_round = [&](double radius, bool along_y) {
    const contact::PadLayout round = lay_on_link(link, X_LP, grid);
    for (std::size_t i = 0; i < round.size(); ++i) {
      Eigen::Vector3d p = X_LP * round.position(i), n = round.normal(i);
      if (along_y) p.y() = n.y() = 0;
      EXPECT_NEAR(p.norm(), radius, 1e-9);
      EXPECT_GT(n.normalized().dot(p.normalized()), 0.999);
    }
  };
  shape.kind = CollisionShape::Kind::kSphere;
  shape.radius = 0.012;
  expect_round(0.012, false);
  shape.kind = CollisionShape::Kind::kCylinder;
  shape.length = 0.04;
  shape.X_LS.linear() = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  expect_round(0.012, true);
  // Where the box stands over the cylinder, the cells are on the box.
  link.shapes.push_back({});
  link.shapes.back().size = Eigen::Vector3d(0.04, 0.04, 0.03);
  for (const double z : lay_on_link(link, X_LP, grid).z) EXPECT_NEAR(z, 0.005, 1e-12);
}

TEST_F(HandPads, RefuseALaidGridThatDoesNotLieOnItsLink) {
  const std::string place = "surface: link, raised: 0.001,\n     center: [0.028, 0, 0.0095]";
  const auto moved = [](const std::string& center) {
    return "surface: link, raised: 0.001,\n     center: " + center;
  };
  expect_refused("bh8.yaml", place, moved("[0.035, 0, 0.0095]"), "row 0, column 0 lies beside");
  expect_refused("bh8.yaml", place, moved("[0.035, 0, 0.0095]"), "finger_1_outer_link");
  expect_refused("bh8.yaml", place, moved("[0.028, 0, 0.2]"), "lies beside");
  expect_refused("bh8.yaml", place, moved("[0.028, 0, -0.02]"), "lies beside");
  expect_refused("bh8.yaml", "raised: 0.001, without", "raised: 0.004, without", "raised");
  expect_refused("bh8.yaml", "[6, 3]]", "[7, 3]]", "row 7, column 3");
  expect_refused("bh8.yaml", "[6, 3]]", "[6]]", "[[row, column]");
  expect_refused("bh8.yaml", "surface: link, raised: 0.001,\n", "surface: round,\n",
                 "neither `link` nor");
  expect_refused("bh8.yaml", "texel_pitch: 0.006, thickness: 0.003", "thickness: 0", "thickness");
}

TEST_F(HandPads, RefuseARegionThatIsNotThere) {
  const std::string place = "surface: {group: tip}";
  expect_refused("ball_probe.yaml", place, "surface: {group: tipp}", "The nearest is 'tip'");
  expect_refused("ball_probe.yaml", place, "surface: {material: tip}", "no material 'tip'");
  expect_refused("ball_probe.yaml", place, "surface: {painted: [255, 0, 0]}", "no PLY");
  expect_refused("ball_probe.yaml", place, "surface: {painted: [256, 0, 0]}", "no colour");
  expect_refused("ball_probe.yaml", place, "surface: {group: tip, material: a}", "twice");
  expect_refused("ball_probe.yaml", place, "surface: {gruop: tip}", "group");
  expect_refused("ball_probe.yaml", place, "surface: {mesh: none.obj, group: tip}", "none.obj");
  expect_refused("ball_probe.yaml", place,
                 "surface: {mesh: ball_probe.obj, scale: 1000, group: tip}", "m long");
  expect_refused("ball_probe.yaml", place, "surface: {mesh: ball_probe.obj, scale: 0}", "scale");
  expect_refused("ball_probe.yaml", place, "surface: {group: tip, scale: 0.001}", "scale");
  expect_refused("ball_probe.yaml", place + "\n", place + "\n    center: [0, 0, 0]\n", "center");
  expect_refused("ball_probe.yaml", "pad: {thickness: 0.003", "pad: {rows: 3, thickness: 0.003",
                 "rows does not apply");
  expect_refused("ball_probe.yaml", "thickness: 0.003", "thickness: -0.003", "thickness");
  expect_refused("ball_probe.yaml", "link: tip\n", "link: housing\n", "no mesh");
  std::ofstream(folder_ / "flat.obj") << "v 0 0 0\nv 1 0 0\nv 2 0 0\ng a\nf 1 2 3\n";
  expect_refused("ball_probe.yaml", place, "surface: {mesh: flat.obj, scale: 0.01, group: a}",
                 "no area");
  std::ofstream(folder_ / "twice.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\ng a\nf 1 2 3\nf 1 3 2\n";
  expect_refused("ball_probe.yaml", place, "surface: {mesh: twice.obj, scale: 0.01, group: a}",
                 "mean normal");
}

TEST_F(HandPads, RefuseOneAnothersPlaces) {
  const std::string more =
      "pads:\n  second:\n    {link: palm, surface: link, center: [0.01, 0.003, 0.085],\n"
      "     normal: [0, 0, 1], toward_tip: [1, 0, 0], pad: {rows: 2, columns: 2}}\n";
  expect_refused("bh8.yaml", "pads:\n", more, "overlap");
  expect_refused("bh8.yaml", "pads:\n", more, "'second' and 'palm'");
}

}  // namespace
}  // namespace prehend::robot
