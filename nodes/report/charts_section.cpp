#include "nodes/report/charts_section.h"

#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "nodes/report/touch_section.h"
#include "prehend/report/charts.h"

namespace prehend::nodes {
namespace {

// Joints of arm and hand over time, each in a chart of its own.
void add_joint_charts(report::Page& page, const Collected& collected,
                      const std::vector<report::Marker>& markers) {
  for (const auto& [prefix, title] : {std::pair{"arm_", "Arm"}, std::pair{"hand_", "Hand"}}) {
    std::vector<report::Series> joints;
    for (const auto& [name, history] : collected.joints) {
      if (name.starts_with(prefix)) {
        joints.push_back({in_words(name.substr(std::string(prefix).size())), history});
      }
    }
    if (joints.empty()) continue;
    page.add_chart(
        report::draw_line_chart({title, "time [s]", "position [rad or m]", joints, markers}),
        fmt::format("Joints of the {}.", prefix[0] == 'a' ? "arm" : "hand"));
  }
}

}  // namespace

void add_charts(report::Page& page, const Collected& collected) {
  std::vector<report::Marker> markers;
  for (const auto& [time, phase] : collected.phases) markers.push_back({time, to_string(phase)});
  std::vector<report::Series> forces;
  for (const auto& [pad, sums] : collected.pad_sums)
    forces.push_back({in_words(pad) + " pad", sums});
  if (!collected.wrench_z.empty()) forces.push_back({"wrist, along approach", collected.wrench_z});
  if (!forces.empty()) {
    page.add_chart(report::draw_line_chart({"Forces", "time [s]", "force [N]", forces, markers}),
                   "What the pads and the wrist felt.");
  }
  add_joint_charts(page, collected, markers);
  if (!collected.opening.empty()) {
    History millimetres = collected.opening;
    for (auto& [time, value] : millimetres) value *= 1000;
    page.add_chart(
        report::draw_line_chart(
            {"Gripper", "time [s]", "opening [mm]", {{"opening", millimetres}}, markers}),
        "Opening of the gripper.");
  }
  std::vector<report::Series> heights;
  for (const auto& [name, body] : collected.bodies) {
    History millimetres = body.height;
    for (auto& [time, value] : millimetres) value *= 1000;
    heights.push_back({name, millimetres});
  }
  if (!heights.empty()) {
    page.add_chart(report::draw_line_chart({"Objects (the simulator's truth)", "time [s]",
                                            "height over the table [mm]", heights, markers}),
                   "How high each object was.");
  }
}

}  // namespace prehend::nodes
