#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "prehend/robot/formats/robot_description.h"
#include "prehend/robot/formats/tracked_xml.h"

namespace prehend::robot::formats {

/// Names of links and joints, by their sids, that a model's extras say in full: XML's readers may
/// end a name at its first space.
std::map<std::string, std::string> collada_names_in(const XmlElement& model);

/// What OpenRAVE adds to a kinematics model or an articulated system ("COLLADA Robot Extensions",
/// 0.3.6): manipulators, motors, sensors, pairs of links that may touch, free parameters of joints.
class ColladaExtras {
 public:
  /// The link of "kmodel1/link0"; empty: it is not there.
  using LinkOf = std::function<std::string(const std::optional<std::string>& path)>;
  /// The joint of "kmodel1/joint0", or of an axis of it; null: it is not there.
  using JointOf = std::function<JointDescription*(const std::string& path)>;

  /// @param length metres of the document's unit
  ColladaExtras(TrackedXml& document, double length, LinkOf link_of, JointOf joint_of)
      : document_(document),
        length_(length),
        link_of_(std::move(link_of)),
        joint_of_(std::move(joint_of)) {}

  /// An <extra>, of any type and writer.
  void read(const XmlElement& extra, RobotDescription& robot);
  /// Links that are seen and touch nothing.
  const std::set<std::string>& untouched() const { return untouched_; }

 private:
  void read_collision(const XmlElement& technique, RobotDescription& robot);
  void read_manipulator(const XmlElement& extra, const XmlElement& technique,
                        RobotDescription& robot);
  void read_joint_info(const XmlElement& extra, const XmlElement& technique);
  void read_actuator(const XmlElement& extra, const XmlElement& technique, RobotDescription& robot);
  void read_sensor(const XmlElement& extra, const XmlElement& technique, RobotDescription& robot);
  std::optional<XmlElement> instanced(const std::optional<XmlElement>& instance);

  TrackedXml& document_;
  const double length_;
  LinkOf link_of_;
  JointOf joint_of_;
  std::set<std::string> untouched_;
};

}  // namespace prehend::robot::formats
