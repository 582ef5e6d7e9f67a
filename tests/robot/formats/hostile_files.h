#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/model_check.h"
#include "prehend/robot/formats/shape_mesh.h"
#include "tests/robot/formats/robot_files.h"

namespace prehend::robot::formats {

/// One small robot, of links a and b and a joint j between them, as each format says it.
struct SmallFile {
  std::string name, text;
};

/// @param link name of the second link, as the file has it
inline std::vector<SmallFile> small_files(const std::string& link = "b") {
  return {
      {"r.urdf",
       "<robot name='r'><link name='a'/><link name='" + link +
           "'><inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' "
           "izz='1'/></inertial></link><joint name='j' type='revolute'><parent link='a'/>"
           "<child link='" +
           link +
           "'/><origin xyz='1 2 3'/><axis xyz='0 0 1'/><limit lower='-1' upper='1'/>"
           "</joint></robot>"},
      {"r.sdf", "<sdf version='1.7'><model name='r'><link name='a'/><link name='" + link +
                    "'><pose>1 2 3 0 0 0</pose><inertial><mass>1</mass></inertial></link>"
                    "<joint name='j' type='revolute'><parent>a</parent><child>" +
                    link +
                    "</child><axis><xyz>0 0 1</xyz><limit><lower>-1</lower><upper>1</upper>"
                    "</limit></axis></joint></model></sdf>"},
      {"mjcf.xml", "<mujoco><worldbody><body name='a'><body name='" + link +
                       "' pos='1 2 3'><joint name='j' range='-1 1' limited='true'/><geom "
                       "size='1'/></body></body></worldbody></mujoco>"},
      {"simox.xml", "<Robot Type='r' RootNode='a'><RobotNode name='a'><Child name='" + link +
                        "'/></RobotNode><RobotNode name='" + link +
                        "'><Transform><Translation x='1' y='2' z='3' units='m'/></Transform>"
                        "<Joint type='revolute'><Limits unit='radian' lo='-1' hi='1'/></Joint>"
                        "</RobotNode></Robot>"},
      {"kinbody.xml", "<KinBody name='r'><Body name='a'/><Body name='" + link +
                          "'><translation>1 2 3</translation><mass type='custom'><total>1</total>"
                          "</mass></Body><Joint name='j' type='hinge'><Body>a</Body><Body>" +
                          link +
                          "</Body><axis>0 0 1</axis><limits>-1 1</limits></Joint></KinBody>"},
      {"graspit.xml",
       "<robot type='Hand'><palm>p.xml</palm><dof type='r'><maxEffort>1</maxEffort></dof><chain>"
       "<joint type='Revolute'><theta>d0+1</theta><d>1</d><a>2</a><alpha>3</alpha>"
       "<minValue>-1</minValue><maxValue>1</maxValue></joint>"
       "<link dynamicJointType='Revolute'>" +
           link + ".xml</link></chain></robot>"},
      {"r.dae",
       "<COLLADA version='1.5.0'><library_kinematics_models><kinematics_model id='k' "
       "name='r'><technique_common><joint sid='j' name='j'><revolute sid='axis0'><axis>"
       "0 0 1</axis><limits><min>-1</min><max>1</max></limits></revolute></joint><link "
       "sid='a' name='a'><attachment_full joint='k/j'><translate>1 2 3</translate><link "
       "sid='b' name='" +
           link +
           "'/></attachment_full></link></technique_common></kinematics_model>"
           "</library_kinematics_models></COLLADA>"},
      {"r.robot.json",
       R"({"prehend_robot": 1, "name": "r", "links": [{"name": "a"}, {"name": ")" + link +
           R"("}], "joints": [{"name": "j", "kind": "revolute", "parent": "a", "child": ")" + link +
           R"(", "pose": {"position": [1, 2, 3]}, "axis": [0, 0, 1], "lower": -1, "upper": 1}]})"}};
}

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

inline std::string repeated(const std::string& text, std::size_t count) {
  std::string all;
  all.reserve(text.size() * count);
  for (std::size_t i = 0; i < count; ++i) all += text;
  return all;
}

/// Tests of files of strangers who mean harm.
class HostileFiles : public RobotFiles {
 protected:
  static bool has_mujoco() {
    return std::any_of(robot_formats().begin(), robot_formats().end(),
                       [](const auto& one) { return one->name() == "mjcf"; });
  }
  static std::vector<SmallFile> files(const std::string& link = "b") {
    std::vector<SmallFile> all = small_files(link);
    std::erase_if(all,
                  [](const SmallFile& one) { return one.name == "mjcf.xml" && !has_mujoco(); });
    return all;
  }
  /// As `prehend model check` and `convert` do: read, checked, mended, written in every format.
  /// @returns the words of a refusal; empty: it went through
  std::string went_through(const std::string& name, const std::string& text) {
    try {
      RobotDescription robot = read(name, text);
      check_model(robot, folder_);
      mend_model(robot, folder_);
      difference(robot, robot, 2);
      for (const auto& format : robot_formats()) {
        if (!format->can_write()) continue;
        LossReport loss;
        RobotDescription copy = robot;
        take_out_meshes(copy, folder_, "out", loss, format->taken_meshes());
        EXPECT_FALSE(format->write(copy, loss).empty());
      }
    } catch (const geometry::InputError& error) {
      EXPECT_FALSE(error.problem().empty());
      return error.what();
    }
    return {};
  }
  std::string findings_of(const RobotDescription& robot) {
    std::string all;
    for (const ModelFinding& one : check_model(robot, folder_)) {
      all += one.place + ": " + one.what + "\n";
    }
    return all;
  }
};

}  // namespace prehend::robot::formats
