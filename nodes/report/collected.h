#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "msgs/belief.pb.h"
#include "msgs/geometry.pb.h"
#include "msgs/grasp.pb.h"
#include "msgs/objects.pb.h"
#include "msgs/percepts.pb.h"
#include "msgs/sensors.pb.h"
#include "msgs/touch.pb.h"
#include "msgs/truth.pb.h"
#include "prehend/control/cycle.h"
#include "prehend/geometry/rigid_transform.h"

namespace prehend::nodes {

/// A value over the graph's time [s].
using History = std::vector<std::pair<double, double>>;

/// What it was at `time` [s], or the last time before. @pre not empty, in the order of time
template <class Value>
const Value& value_at(const std::vector<std::pair<double, Value>>& history, double time) {
  const auto after = std::upper_bound(history.begin(), history.end(), time,
                                      [](double t, const auto& entry) { return t < entry.first; });
  return after == history.begin() ? after->second : std::prev(after)->second;
}

/// Where a body was over time.
struct BodyHistory {
  History height;      // m, lowest point over the table
  History horizontal;  // m, from where it was first seen
  std::vector<std::pair<double, geometry::RigidTransform>> poses;  // X_WB over the graph's time [s]
  double start_x = 0;                                              // m
  double start_y = 0;
};

/// The pads at the end of one phase of the cycle, by their names.
struct TactileSnapshot {
  control::Phase phase = control::Phase::kWaiting;
  std::map<std::string, msgs::TactileFrame> pads;
  std::map<std::string, msgs::PadTouch> touch;  // what they mean; empty: no node says it
};

/// What went over the graph, as far as the report shows it.
struct Collected {
  std::optional<msgs::StereoPair> stereo;
  std::vector<msgs::PointCloud> clouds;  // recorded, images with colours; one of each view
  std::optional<msgs::CameraInfo> camera;
  std::optional<msgs::ObjectHypotheses> objects;
  std::map<std::uint32_t, msgs::CompletedShape> shapes;  // by object
  std::map<std::uint32_t, msgs::ObjectModel> models;
  std::map<std::uint32_t, msgs::GraspPlan> plans;
  std::vector<msgs::Belief> beliefs;  // as they came
  // By stamp and object, the newest of a run: as it was predicted, and as it is believed.
  std::map<std::pair<std::int64_t, std::uint32_t>, msgs::ObjectModel> predicted, believed;
  std::vector<msgs::ObjectModel> held;  // of what was turned before the camera, after each look
  std::vector<msgs::Surprise> surprises;
  std::vector<msgs::PerceptSurprise> percept_surprises;  // as they came
  std::optional<msgs::CycleResult> result;
  std::optional<msgs::Task> task;

  std::vector<std::pair<double, control::Phase>> phases;  // when each began
  bool on_prediction = false;  // what was grasped are predicted meshes, put into a simulation
  std::map<std::string, msgs::TactileFrame> pads;  // newest, by pad
  std::map<std::string, msgs::PadCells> cells;     // where they are, by pad, where the robot says
  std::map<std::string, msgs::PadTouch> touch;     // newest, by pad
  std::vector<TactileSnapshot> snapshots;
  std::map<std::string, History> pad_sums;  // N, by pad
  std::map<std::string, History> joints;    // rad or m, of arm and hand
  History opening;                          // m, of a parallel gripper
  History wrench_z;                         // N, along the hand's z axis
  std::map<std::string, BodyHistory> bodies;
  msgs::TruthShapes true_shapes;  // of the bodies, where a simulation says them
  std::vector<std::string> log;   // warnings and errors, "node: text"
};

}  // namespace prehend::nodes
