#include "tests/system/carried.h"

#include <algorithm>
#include <cmath>

#include "msgs/sensors.pb.h"

namespace prehend::testing {

Carried carried_body(const std::map<std::string, std::vector<Recorded>>& recording) {
  struct Path {
    double first_height = 0, highest = 0;  // m
    msgs::Vector3 start, end;
    double end_height = 0;
    bool touches_table = false;
  };
  std::map<std::string, Path> paths;
  Carried carried;
  for (const auto& truth : decode_all<msgs::GroundTruth>(recording, "/ground_truth")) {
    for (const auto& body : truth.bodies()) {
      auto [it, is_new] = paths.try_emplace(body.name());
      Path& path = it->second;
      if (is_new) {
        path.first_height = path.highest = body.height();
        path.start = body.x_wb().position();
      }
      path.highest = std::max(path.highest, body.height());
      path.end = body.x_wb().position();
      path.end_height = body.height();
      path.touches_table = body.touches_table();
      if (body.height() > 0.05 && body.touches_left_pad() && body.touches_right_pad()) {
        carried.both_pads_in_the_air = true;
      }
    }
  }
  for (const auto& [name, path] : paths) {
    const double raised = path.highest - path.first_height;
    if (!carried.name.empty() && raised <= carried.raised) continue;
    carried.name = name;
    carried.raised = raised;
    carried.moved = std::hypot(path.end.x() - path.start.x(), path.end.y() - path.start.y());
    carried.last_height = path.end_height;
    carried.last_x = path.end.x();
    carried.last_y = path.end.y();
    carried.touches_table = path.touches_table;
  }
  return carried;
}

}  // namespace prehend::testing
