#pragma once

#include <string>

namespace prehend::robot::formats {

/// A URDF of most that a URDF says: four links, a joint that follows another, one that is fixed.
inline const std::string kUrdfArm = R"(<?xml version="1.0"?>
<robot name="arm">
  <material name="steel"><color rgba="0.5 0.5 0.6 1"/></material>
  <link name="base"/>
  <link name="upper">
    <inertial><origin xyz="0 0 0.1" rpy="0 0.1 0"/><mass value="2"/>
      <inertia ixx="0.02" ixy="0" ixz="0.001" iyy="0.02" iyz="0" izz="0.01"/></inertial>
    <visual><geometry><cylinder radius="0.04" length="0.2"/></geometry><material name="steel"/></visual>
    <collision name="hull"><origin xyz="0 0 0.1"/><geometry><box size="0.1 0.1 0.3"/></geometry></collision>
  </link>
  <link name="lower"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
  <link name="tip"/>
  <joint name="shoulder" type="revolute"><origin xyz="0.1 0 0.3" rpy="0.2 -0.4 1.5"/>
    <parent link="base"/><child link="upper"/><axis xyz="0 0.6 0.8"/>
    <limit lower="-2" upper="1.5" effort="30" velocity="2"/><dynamics damping="0.1" friction="0.2"/></joint>
  <joint name="elbow" type="prismatic"><origin xyz="0 0 0.2"/><parent link="upper"/><child link="lower"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.1" effort="10" velocity="0.5"/>
    <mimic joint="shoulder" multiplier="0.02" offset="0.03"/></joint>
  <joint name="end" type="fixed"><origin rpy="0 1.5707963267948966 0"/><parent link="lower"/><child link="tip"/></joint>
  <gazebo reference="upper"><mu1>0.2</mu1></gazebo>
</robot>)";

}  // namespace prehend::robot::formats
