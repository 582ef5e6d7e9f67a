// Shapes and manipulators of COLLADA's robots.

#include <gmock/gmock.h>

#include <algorithm>
#include <numbers>

#include "prehend/geometry/triangle_mesh.h"
#include "prehend/robot/formats/shape_mesh.h"
#include "tests/robot/formats/robot_files.h"

namespace prehend::robot::formats {
namespace {

using geometry::RigidTransform;
using testing::AllOf;
using testing::HasSubstr;

using ColladaShapesOf = RobotFiles;

/// A tetrahedron with corners at the origin and 1 along each axis.
std::string tetrahedron(const std::string& primitive) {
  return R"(<geometry id="g"><mesh>
    <source id="p"><float_array id="a" count="16">9 0 0 0 7 1 0 0 7 0 1 0 7 0 0 1</float_array>
      <technique_common><accessor source="#a" count="4" stride="4" offset="1"/></technique_common></source>
    <source id="n"><float_array id="na" count="3">0 0 1</float_array></source>
    <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>)" +
         primitive + "</mesh></geometry>";
}
const std::string kInputs =
    "<input semantic='VERTEX' source='#v' offset='1'/><input semantic='NORMAL' source='#n' "
    "offset='0'/>";
const std::string kTriangles =
    "<triangles count='4' material='m'>" + kInputs +
    "<p>0 0 0 2 0 1  0 0 0 1 0 3  0 0 0 3 0 2  0 1 0 2 0 3</p></triangles>";

/// In centimetres; a post, on which an arm turns about z, as the scene shows it by 30 degrees.
std::string turning(const std::string& geometries, const std::string& body = "",
                    const std::string& extra = "") {
  return R"(<COLLADA version="1.5.0"><asset><unit meter="0.01"/></asset>
  <library_geometries>)" +
         geometries + R"(</library_geometries>
  <library_effects><effect id="e"><profile_COMMON><technique sid="t"><phong><ambient><color>1 1 1 1</color></ambient>
    <diffuse><color>0.2 0.4 0.6 1</color></diffuse></phong></technique></profile_COMMON></effect></library_effects>
  <library_materials><material id="red"><instance_effect url="#e"/></material></library_materials>
  <library_nodes><node id="post_node" sid="post" name="any"><translate>0 0 5</translate>
    <node id="arm_node" name="other"><translate>10 0 0</translate><rotate sid="turning">0 0 1 30</rotate>
      <node id="plate"><translate>0 0 2</translate><scale>1 1 -2</scale>
        <instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="m" target="#red"/>
        </technique_common></bind_material></instance_geometry></node>
      <instance_geometry url="#g"/></node></node></library_nodes>
  <library_visual_scenes><visual_scene id="s"><node id="top" sid="top"><translate>100 0 0</translate>
    <rotate>0 0 1 90</rotate><instance_node url="#post_node" sid="inside"/></node></visual_scene></library_visual_scenes>
  <library_kinematics_models><kinematics_model id="k" name="crane"><technique_common>
    <joint sid="j0" name="turn"><revolute sid="axis0"><axis>0 0 1</axis></revolute></joint>
    <link sid="l0" name="post"><attachment_full joint="k/j0"><translate>10 0 0</translate><link sid="l1" name="arm"/>
    </attachment_full></link></technique_common></kinematics_model></library_kinematics_models>
  <library_articulated_systems><articulated_system id="a"><kinematics>
    <instance_kinematics_model url="#k" sid="ki"><newparam sid="of_a"><SIDREF>a/ki/j0/axis0</SIDREF></newparam>
    </instance_kinematics_model></kinematics>)" +
         extra + R"(</articulated_system></library_articulated_systems>
  <library_kinematics_scenes><kinematics_scene id="ks"><instance_articulated_system url="#a">
    <bind symbol="of_scene"><param ref="a/of_a"/></bind></instance_articulated_system></kinematics_scene></library_kinematics_scenes>
  <library_physics_models><physics_model id="p"><rigid_body sid="b"><technique_common><mass>2</mass>)" +
         body + R"(</technique_common></rigid_body></physics_model></library_physics_models>
  <library_physics_scenes><physics_scene id="ps"><instance_physics_model url="#p">
    <instance_rigid_body body="b" target="#arm_node"/></instance_physics_model></physics_scene></library_physics_scenes>
  <scene><instance_visual_scene url="#s"/><instance_kinematics_scene url="#ks">
    <bind_kinematics_model node="top/inside"><param>x</param></bind_kinematics_model>
    <bind_joint_axis target="top/turning"><axis><param>of_scene</param></axis></bind_joint_axis>
  </instance_kinematics_scene></scene></COLLADA>)";
}

Eigen::AlignedBox3d box_of(const Shape& shape) {
  return geometry::bounds(geometry::transformed(ShapeMeshes(".").of(shape), shape.X_LS));
}

TEST_F(ColladaShapesOf, LinksStandInTheirFrames) {
  const RobotDescription crane = read("crane.dae", turning(tetrahedron(kTriangles)));
  const LinkDescription& arm = *crane.link("arm");
  EXPECT_TRUE(crane.link("post")->visuals.empty());
  ASSERT_EQ(arm.visuals.size(), 2U) << loss_.text();
  ASSERT_EQ(arm.collisions.size(), 2U);  // what is seen is touched
  // The joint's angle in the scene is no part of the shape: it is as at 0.
  const Eigen::AlignedBox3d own = box_of(arm.visuals[0]);
  EXPECT_TRUE(own.min().isZero(1e-9)) << own.min().transpose();
  EXPECT_TRUE(own.max().isApprox(Eigen::Vector3d::Constant(0.01), 1e-6)) << own.max().transpose();
  EXPECT_EQ(arm.visuals[0].mesh, "arm_0");
  // Scaled and mirrored by its node, over the arm's origin; its outside is still outside.
  const Eigen::AlignedBox3d plate = box_of(arm.visuals[1]);
  EXPECT_NEAR(plate.min().z(), 0, 1e-9);
  EXPECT_NEAR(plate.max().z(), 0.02, 1e-9);
  for (const Shape& shape : arm.visuals) {
    const auto mesh = ShapeMeshes(".").of(shape);
    EXPECT_GT(geometry::mass_properties(mesh).volume, 0);
    EXPECT_TRUE(geometry::find_defects(mesh).watertight());
  }
  ASSERT_TRUE(arm.visuals[1].color);
  EXPECT_EQ((*arm.visuals[1].color)[2], 0.6);
  EXPECT_EQ(arm.inertial->mass, 2);
  EXPECT_THAT(loss_.text(), AllOf(HasSubstr("normals, colours and textures"), HasSubstr("lit")));
}

TEST_F(ColladaShapesOf, OpacityIsByTransparencyAndNotByTheDiffuseAlpha) {
  const std::string whole = turning(tetrahedron(kTriangles));
  const auto opacity = [&](const std::string& light) {
    std::string text = whole;
    const std::string diffuse = "<diffuse><color>0.2 0.4 0.6 1</color></diffuse>";
    text.replace(text.find(diffuse), diffuse.size(), light);
    return (*read("crane.dae", text).link("arm")->visuals[1].color)[3];
  };
  const std::string diffuse = "<diffuse><color>0.2 0.4 0.6 0</color></diffuse>";
  const std::string half = "<transparency><float>0.5</float></transparency>";
  EXPECT_EQ(opacity(diffuse), 1);
  EXPECT_EQ(opacity(diffuse + half), 1);
  EXPECT_EQ(opacity(diffuse + "<transparent><color>1 1 1 0.5</color></transparent>" + half), 0.25);
  EXPECT_EQ(
      opacity(diffuse + "<transparent opaque='A_ZERO'><color>1 1 1 0.5</color></transparent>"),
      0.5);
  EXPECT_NEAR(opacity(diffuse +
                      "<transparent opaque='RGB_ZERO'><color>1 1 1 0</color></transparent>" + half),
              0.5, 1e-5);
}

TEST_F(ColladaShapesOf, PolygonsAreTriangles) {
  for (const std::string& primitive :
       {"<polylist material='m'>" + kInputs +
            "<vcount>3 3 3 3</vcount><p>0 0 0 2 0 1  0 0 0 1 0 3  0 0 0 3 0 2  0 1 0 2 0 "
            "3</p></polylist>",
        "<polygons material='m'>" + kInputs +
            "<p>0 0 0 2 0 1</p><p>0 0 0 1 0 3</p><p>0 0 0 3 0 2</p><p>0 1 0 2 0 3</p></polygons>",
        "<tristrips material='m'>" + kInputs + "<p>0 0 0 2 0 1 0 3 0 0 0 2</p></tristrips>",
        "<trifans material='m'>" + kInputs +
            "<p>0 0 0 1 0 3 0 2 0 1</p><p>0 1 0 2 0 3</p></trifans>"}) {
    const RobotDescription crane = read("crane.dae", turning(tetrahedron(primitive)));
    ASSERT_EQ(crane.link("arm")->visuals.size(), 2U) << primitive;
    const auto mesh = ShapeMeshes(".").of(crane.link("arm")->visuals[0]);
    EXPECT_EQ(mesh.triangles.size(), 4U) << primitive;
    EXPECT_TRUE(geometry::find_defects(mesh).watertight()) << primitive;
    EXPECT_NEAR(geometry::mass_properties(mesh).volume, 1e-6 / 6, 1e-12) << primitive;
  }
}

TEST_F(ColladaShapesOf, ShapesOfABodyAreItsCollisions) {
  const RobotDescription crane =
      read("crane.dae",
           turning(tetrahedron(kTriangles),
                   "<shape><translate>10 0 0</translate><box><half_extents>1 2 3"
                   "</half_extents></box></shape><shape><instance_geometry url='#g'/></shape>"
                   "<shape><cylinder><radius>1 1</radius><height>4</height></cylinder></shape>"));
  const LinkDescription& arm = *crane.link("arm");
  EXPECT_EQ(arm.visuals.size(), 2U);
  ASSERT_EQ(arm.collisions.size(), 3U);
  // In the root's frame, from which the arm is 10 cm away.
  EXPECT_TRUE(arm.collisions[0].X_LS.isApprox(RigidTransform::Identity(), 1e-12));
  EXPECT_TRUE(arm.collisions[0].size.isApprox(Eigen::Vector3d(0.02, 0.04, 0.06), 1e-12));
  EXPECT_TRUE(box_of(arm.collisions[1]).min().isZero(1e-9));  // where it is seen
  EXPECT_EQ(arm.collisions[1].mesh, arm.visuals[0].mesh);     // one file for both
  EXPECT_NEAR(box_of(arm.collisions[2]).sizes().y(), 0.04, 1e-9);
}

TEST_F(ColladaShapesOf, ManipulatorsNameToolAndClosingDirections) {
  const std::string extra = R"(<extra type="manipulator" name="grip"><technique profile="OpenRAVE">
      <frame_origin link="k/l0"/><frame_tip link="k/l1"><translate>0 0 3</translate><direction>0 0 1</direction></frame_tip>
      <gripper_joint joint="k/j0"><chucking_direction axis="./axis0"><float>-1</float></chucking_direction></gripper_joint>
      <gripper_joint joint="k/gone"/></technique></extra>
    <extra type="manipulator" name="none"><technique profile="OpenRAVE"><frame_origin link="k/nil_link"/></technique></extra>
    <extra type="collision"><technique profile="OpenRAVE"><ignore_link_pair link0="k/l0" link1="k/l1"/></technique></extra>)";
  const RobotDescription crane = read("crane.dae", turning(tetrahedron(kTriangles), "", extra));
  ASSERT_EQ(crane.manipulators.size(), 1U);
  const Manipulator& grip = crane.manipulators[0];
  EXPECT_EQ(grip.base, "post");
  EXPECT_EQ(grip.tip, "arm");
  EXPECT_NEAR(grip.X_TipTool.translation().z(), 0.03, 1e-12);
  ASSERT_EQ(grip.closing.size(), 1U);
  EXPECT_EQ(grip.closing[0], (std::pair<std::string, double>("turn", -1)));
  ASSERT_EQ(crane.disabled_collisions.size(), 1U);
  EXPECT_THAT(loss_.text(), AllOf(HasSubstr("its joint is not there"),
                                  HasSubstr("its links are not there"), HasSubstr("direction")));
  for (const char* format : {"urdf", "sdf"}) {
    LossReport written;
    format_named(format).write(crane, written);
    EXPECT_THAT(written.text(), HasSubstr("1 manipulator")) << format;
  }
}

TEST_F(ColladaShapesOf, BadMeshesAreRefusedInWords) {
  const auto error_of_mesh = [&](const std::string& primitive) {
    return error_of("crane.dae", turning(tetrahedron(primitive)));
  };
  const auto list = [](const std::string& p) {
    return "<triangles>" + kInputs + "<p>" + p + "</p></triangles>";
  };
  EXPECT_THAT(error_of_mesh(list("0 0 0 1 0 4")), HasSubstr("index 4 is none of the 4 points"));
  EXPECT_THAT(error_of_mesh(list("0 0 0 1 0 -1")), HasSubstr("index -1"));
  EXPECT_THAT(error_of_mesh(list("0 0 0 1 0 1e300")), HasSubstr("is none of the 4 points"));
  EXPECT_THAT(error_of_mesh(list("0 0 0 1 0 nan")), HasSubstr("'nan' is no number"));
  EXPECT_THAT(error_of_mesh(list("0 0 0")), HasSubstr("rows of 2"));
  EXPECT_THAT(error_of_mesh(list("0 0 0 1")), HasSubstr("lacks corners"));
  EXPECT_THAT(error_of_mesh("<triangles><p>0 1 2</p></triangles>"), HasSubstr("VERTEX"));
  EXPECT_THAT(
      error_of_mesh("<polylist>" + kInputs + "<vcount>1000000000</vcount><p>0 0</p></polylist>"),
      HasSubstr("not in <p>"));
  const auto error_of_text = [&](const std::string& from, const std::string& to) {
    std::string text = turning(tetrahedron(kTriangles));
    text.replace(text.find(from), from.size(), to);
    return error_of("crane.dae", text);
  };
  EXPECT_THAT(error_of_text("source=\"#p\"", "source=\"#q\""),
              HasSubstr("source '#q' is not there"));
  EXPECT_THAT(error_of_text("url=\"#g\"", "url=\"#h\""), HasSubstr("geometry '#h' is not there"));
  EXPECT_THAT(error_of_text("url=\"#post_node\"", "url=\"#top\""), HasSubstr("ring"));
  EXPECT_THAT(error_of_text("url=\"#post_node\"", "url=\"#nowhere\""), HasSubstr("'#nowhere'"));
  EXPECT_THAT(error_of_text("count=\"4\" stride=\"4\"", "count=\"1000000000\" stride=\"4\""),
              HasSubstr("are not in 16 numbers"));
  EXPECT_THAT(error_of_text("stride=\"4\"", "stride=\"0\""), HasSubstr("stride 0"));
  EXPECT_THAT(error_of_text("offset=\"1\"", "offset=\"-1\""), HasSubstr("no count"));
}

TEST_F(ColladaShapesOf, ManipulatorsOfOpenRaveXmlAreKept) {
  const RobotDescription robot = read("r.robot.xml", R"(<Robot name="r"><KinBody>
    <Body name="palm"/><Body name="finger"/>
    <Joint name="f" type="hinge"><Body>palm</Body><Body>finger</Body><limitsdeg>0 90</limitsdeg></Joint></KinBody>
    <Manipulator name="hand"><base>palm</base><effector>palm</effector><translation>0 0 0.1</translation>
      <joints>f</joints><closingdirection>-1</closingdirection></Manipulator>
    <Manipulator name="gone"><base>palm</base><effector>wrist</effector></Manipulator></Robot>)");
  ASSERT_EQ(robot.manipulators.size(), 1U);
  EXPECT_EQ(robot.manipulators[0].closing[0], (std::pair<std::string, double>("f", -1)));
  EXPECT_EQ(robot.manipulators[0].X_TipTool.translation().z(), 0.1);
  EXPECT_THAT(loss_.text(), HasSubstr("its links are not there"));
}

// Each node holds the next ten times: a billion of them, in a kilobyte.
TEST_F(ColladaShapesOf, NodesThatGrowAreRefused) {
  std::string nodes;
  for (int level = 0; level < 9; ++level) {
    nodes += "<node id='n" + std::to_string(level) + "'>";
    for (int i = 0; i < 10; ++i) {
      nodes += "<instance_node url='#n" + std::to_string(level + 1) + "'/>";
    }
    nodes += "</node>";
  }
  std::string text = turning(tetrahedron(kTriangles));
  const std::string library = "<library_nodes>";
  text.replace(text.find(library), library.size(), library + nodes + "<node id='n9'/>");
  text.replace(text.find("url=\"#post_node\""), 16, "url=\"#n0\"");
  EXPECT_THAT(error_of("crane.dae", text), HasSubstr("more than 100000 nodes"));
}

/// The gap between boxes that are around two links in the robot's frame [m].
double gap(const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b) {
  return std::max(0.0, (a.min() - b.max()).cwiseMax(b.min() - a.max()).maxCoeff());
}

// Links join at their joints when these are at 0, what is seen and what is touched are in one
// place, and the whole is as large as the robot.
TEST_F(ColladaShapesOf, RobotsOfOthersHoldTogether) {
  if (shared_model("openrave").empty()) GTEST_SKIP() << "no shared models";
  const struct {
    const char* name;
    double least, most;  // m, longest side
  } robots[] = {{"openrave/pumaarm.zae", 1.4, 2.2},
                {"openrave/shadow-hand.zae", 0.15, 0.3},
                {"openrave/barrett-wam-sensors.zae", 1.0, 2.0},
                {"openrave/kuka-youbot.zae", 0.5, 1.0},
                {"openrave/man1.zae", 1.4, 2.1},
                {"openrave/ikfast_fail4.dae", 6.9, 7.1},
                {"openhrp/nextage_description/models/main.dae", 0.8, 2.0}};
  for (const auto& [name, least, most] : robots) {
    SCOPED_TRACE(name);
    LossReport loss;
    RobotDescription robot = read_robot(shared_model(name), loss);
    for (JointDescription& joint : robot.joints) joint.follows.reset();
    const auto poses = link_poses(robot, {});
    std::map<std::string, Eigen::AlignedBox3d> seen;
    Eigen::AlignedBox3d whole;
    for (const LinkDescription& link : robot.links) {
      Eigen::AlignedBox3d touched;
      for (const Shape& shape : link.visuals) {
        seen[link.name].extend(geometry::bounds(
            geometry::transformed(ShapeMeshes(".").of(shape), poses.at(link.name) * shape.X_LS)));
      }
      for (const Shape& shape : link.collisions) {
        touched.extend(geometry::bounds(
            geometry::transformed(ShapeMeshes(".").of(shape), poses.at(link.name) * shape.X_LS)));
      }
      if (seen.count(link.name) == 0) continue;
      whole.extend(seen[link.name]);
      EXPECT_LT((touched.min() - seen[link.name].min()).cwiseAbs().maxCoeff(), 1e-4) << link.name;
      EXPECT_LT((touched.max() - seen[link.name].max()).cwiseAbs().maxCoeff(), 1e-4) << link.name;
    }
    double widest = 0;
    std::string where;
    for (const JointDescription& joint : robot.joints) {
      const auto parent = seen.find(joint.parent), child = seen.find(joint.child);
      if (parent == seen.end() || child == seen.end()) continue;
      const double its = gap(parent->second, child->second);
      if (its > widest) where = joint.name;
      widest = std::max(widest, its);
    }
    EXPECT_GT(whole.sizes().maxCoeff(), least);
    EXPECT_LT(whole.sizes().maxCoeff(), most);
    EXPECT_LT(widest, 0.02) << where;
  }
}

}  // namespace
}  // namespace prehend::robot::formats
