#pragma once

#include <string>
#include <utility>
#include <vector>

#include "prehend/robot/formats/json_record.h"
#include "prehend/robot/formats/robot_description.h"
#include "prehend/robot/formats/robot_record.h"

// Parts that writing and reading prehend's extension (extension.h) have in common.
namespace prehend::robot::formats {

inline constexpr int kExtensionVersion = 1;

using LinkPair = std::pair<std::string, std::string>;

/// Names of what the format needed besides, and the robot does not have.
struct Without {
  std::vector<std::string> links, joints, loops, actuators, sensors, manipulators, postures;
  std::vector<LinkPair> disabled_collisions;
};

template <class Visitor>
void fields(Visitor& v, Part<Visitor, Without>& without) {
  v.list("links", without.links);
  v.list("joints", without.joints);
  v.list("loops", without.loops);
  v.list("actuators", without.actuators);
  v.list("sensors", without.sensors);
  v.list("manipulators", without.manipulators);
  v.list("postures", without.postures);
  v.list("disabled_collisions", without.disabled_collisions);
}

template <class Record>
JsonValue json_of_record(const Record& record) {
  LossReport unused;
  JsonWriter writer("", unused);
  fields(writer, record);
  return std::move(writer.object());
}

template <class Record>
std::vector<std::string> names_in(const std::vector<Record>& records) {
  std::vector<std::string> names;
  for (const Record& one : records) names.push_back(one.name);
  return names;
}

/// Of two links, in whatever order.
inline bool is_same_pair(const LinkPair& one, const LinkPair& other) {
  return one == other || (one.first == other.second && one.second == other.first);
}

/// A fixed joint that only says where the child of the one above it stands goes into that.
/// @returns why it cannot; empty: it did
std::string merge_joint(RobotDescription& robot, const std::string& name);

}  // namespace prehend::robot::formats
