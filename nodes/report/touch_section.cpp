#include "nodes/report/touch_section.h"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "nodes/report/verdict.h"
#include "prehend/report/pictures.h"

namespace prehend::nodes {
namespace {

struct Shown {
  const msgs::TactileFrame* frame = nullptr;
  std::string when;
};

// By pad, what was predicted first: of a hand's many pads those that felt something at all, or were
// to feel it.
std::map<std::string, std::vector<Shown>> shown_frames(const Collected& collected,
                                                       const msgs::PredictedPercepts& predicted) {
  std::map<std::string, std::vector<Shown>> shown;
  for (const auto& pad : predicted.pads()) {
    shown[pad.image().header().frame_id()] = {{&pad.image(), "predicted"}};
  }
  for (const auto& snapshot : collected.snapshots) {
    for (const auto& [name, frame] : snapshot.pads) {
      if (frame.sum() > 0) shown[name];
    }
  }
  for (const auto& snapshot : collected.snapshots) {
    for (const auto& [name, frame] : snapshot.pads) {
      const auto pad = shown.find(name);
      if (pad != shown.end())
        pad->second.push_back({&frame, "end of " + to_string(snapshot.phase)});
    }
  }
  return shown;
}

}  // namespace

std::string in_words(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

void add_touch(report::Page& page, const Collected& collected) {
  const msgs::Grasp* grasp = executed_grasp(collected);
  const auto& predicted = grasp ? grasp->predicted() : msgs::PredictedPercepts::default_instance();
  if (!predicted.not_predicted().empty()) {
    page.add_paragraph("What the pads should feel was not predicted: " + predicted.not_predicted() +
                       ".");
  }
  const auto shown = shown_frames(collected, predicted);
  double full = 0;  // counts
  for (const auto& [name, frames] : shown) {
    for (const Shown& one : frames) {
      for (const auto count : one.frame->intensity()) full = std::max<double>(full, count);
    }
  }
  std::vector<geometry::ColorImage> pictures;
  std::vector<std::string> captions;
  for (const auto& [name, frames] : shown) {
    for (const Shown& one : frames) {
      const msgs::TactileFrame& frame = *one.frame;
      const std::vector<double> values(frame.intensity().begin(), frame.intensity().end());
      pictures.push_back(report::draw_tactile(values, static_cast<int>(frame.rows()),
                                              static_cast<int>(frame.columns()), full));
      captions.push_back(
          fmt::format("{} pad, {}: {:.1f} N", in_words(name), one.when, frame.sum()));
    }
  }
  if (collected.snapshots.empty()) page.add_paragraph("Nothing was touched.");
  page.add_pictures(pictures, captions);
}

}  // namespace prehend::nodes
