#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "drivers/wire/health/health.h"
#include "drivers/wire/health/link_quality.h"
#include "drivers/wire/node/device_report.h"
#include "drivers/wire/node/wall_timer.h"
#include "drivers/wire/time/time.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"

namespace prehend::drivers::camera {

/// What the nodes of cameras have in common.
struct ViewSettings {
  double rate = 0;        // 1/s of what is published, at most; 0: each
  double stale_time = 1;  // s
};
/// Declares `rate` and `stale_time`.
ViewSettings declare_view_settings(graph::Node& node);

/// The graph's time of something that happened at `stamp` of steady_now().
std::int64_t graph_stamp(const graph::Node& node, Time stamp);

/// What could not be done with the last view, for CameraReport::State. Thread-safe.
class ViewProblem {
 public:
  /// Calls `publish`; what it throws is the problem, until one that throws nothing.
  void shield(const std::function<void()>& publish);
  std::string words() const;  // "": none

 private:
  mutable std::mutex mutex_;
  std::string words_;
};

/// Health and counters of a camera, looked at in real time; health is also what /camera/device
/// says.
class CameraReport {
 public:
  struct State {
    std::string trouble;       // "" while images come
    std::string view_problem;  // what could not be done with the last one: another size
    std::string remark;        // what is not as asked for
    bool is_at_end = false;
    std::uint64_t views = 0, unpaired = 0, connections = 0;
  };
  /// `state` is called in a thread of its own.
  CameraReport(graph::Node& node, std::function<State()> state);

 private:
  void look();

  graph::Node& node_;
  std::function<State()> state_;
  DeviceReport report_;
  LinkQuality quality_;
  int looks_ = 0;
  graph::Publisher<msgs::DeviceStatus> publisher_;
  WallTimer timer_;
};

}  // namespace prehend::drivers::camera
