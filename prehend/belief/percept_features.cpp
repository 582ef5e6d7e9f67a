#include "prehend/belief/percept_features.h"

#include <algorithm>
#include <cmath>

namespace prehend::belief {
namespace {

constexpr double kLeastWeight = 0.2;     // N: below it the wrist's noise is all
constexpr double kLeastViewArea = 1e-4;  // m^2: below it a picture shows nothing of an object

class FeatureList {
 public:
  void number(const char* sense, const std::string& part, const std::string& kind,
              std::optional<double> value) {
    features.push_back({sense, part, kind, value, false});
  }
  void yes_or_no(const char* sense, const std::string& part, const std::string& kind,
                 std::optional<bool> value) {
    std::optional<double> number;
    if (value) number = *value ? 1 : 0;
    features.push_back({sense, part, kind, number, true});
  }
  void wrench(const std::string& moment, const std::optional<Wrench>& wrench) {
    for (int axis = 0; axis < 3; ++axis) {
      std::optional<double> force, torque;
      if (wrench) {
        force = wrench->force[axis];
        torque = wrench->torque[axis];
      }
      number("wrist", "wrist", "force " + moment, force);
      number("wrist", "wrist", "torque " + moment, torque);
    }
  }
  std::vector<PerceptFeature> features;
};

const char* const kMomentNames[] = {"closed", "lifted"};

}  // namespace

const std::vector<std::string>& percept_senses() {
  static const std::vector<std::string> senses{"tactile", "contact", "joints", "time",
                                               "wrist",   "weight",  "view"};
  return senses;
}

const std::vector<PerceptKind>& percept_kinds() {
  static const std::vector<PerceptKind> kinds{
      {"log force closed", 0.3, 0.1},   {"log force lifted", 0.3, 0.1},
      {"across closed", 0.002, 0.0005}, {"across lifted", 0.002, 0.0005},
      {"along closed", 0.002, 0.0005},  {"along lifted", 0.002, 0.0005},
      {"log area closed", 0.3, 0.1},    {"log area lifted", 0.3, 0.1},
      {"closure", 0.02, 0.005},         {"joint closed", 0.03, 0.005},
      {"joint lifted", 0.03, 0.005},    {"stopped", 0.1, 0.02},
      {"force closing", 0.3, 0.05},     {"force closed", 0.5, 0.1},
      {"force lifted", 0.5, 0.1},       {"torque closing", 0.03, 0.005},
      {"torque closed", 0.05, 0.01},    {"torque lifted", 0.05, 0.01},
      {"log weight", 0.3, 0.05},        {"view across", 0.003, 0.0005},
      {"view away", 0.004, 0.001},      {"view spread", 0.002, 0.0005},
      {"log view area", 0.2, 0.03},
  };
  return kinds;
}

std::vector<PerceptFeature> percept_features(const Percepts& percepts, double touch_force) {
  FeatureList list;
  for (const PerceivedPad& pad : percepts.pads) {
    bool has_sensor = false;
    for (std::size_t moment = 0; moment < pad.at.size(); ++moment) {
      const std::string when = kMomentNames[moment];
      const PadImage& image = pad.at[moment];
      const bool present = !image.texels.empty();
      has_sensor = has_sensor || present;
      const bool touches = present && image.force >= touch_force;
      list.yes_or_no("tactile", pad.name, "touches " + when,
                     present ? std::optional(touches) : std::nullopt);
      std::optional<double> force, across, along, area;
      if (touches) {
        force = std::log(image.force);
        across = image.center_P.x();
        along = image.center_P.y();
        if (image.area > 0) area = std::log(image.area);
      }
      list.number("tactile", pad.name, "log force " + when, force);
      list.number("tactile", pad.name, "across " + when, across);
      list.number("tactile", pad.name, "along " + when, along);
      list.number("tactile", pad.name, "log area " + when, area);
    }
    list.yes_or_no("contact", pad.name, "touched",
                   has_sensor ? std::optional(pad.touched_at.has_value()) : std::nullopt);
    list.number("contact", pad.name, "closure", has_sensor ? pad.touched_at : std::nullopt);
  }
  for (const PerceivedMotor& motor : percepts.motors) {
    for (std::size_t moment = 0; moment < motor.at.size(); ++moment) {
      list.number("joints", motor.name, std::string("joint ") + kMomentNames[moment],
                  motor.at[moment]);
    }
    list.number("time", motor.name, "stopped", motor.stopped_after);
  }
  list.wrench("closing", percepts.closing);
  for (std::size_t moment = 0; moment < percepts.wrist.size(); ++moment) {
    list.wrench(kMomentNames[moment], percepts.wrist[moment]);
  }
  std::optional<double> weight;
  if (percepts.weight) weight = std::log(std::max(kLeastWeight, *percepts.weight));
  list.number("weight", "wrist", "log weight", weight);
  const bool shown = percepts.view && percepts.view->area > 0;
  list.yes_or_no("view", "camera", "shown", percepts.view ? std::optional(shown) : std::nullopt);
  const auto of_view = [&](const std::string& kind, double value) {
    list.number("view", "camera", kind, shown ? std::optional(value) : std::nullopt);
  };
  const PerceivedView view = percepts.view.value_or(PerceivedView{});
  of_view("view across", view.center_C.x());
  of_view("view across", view.center_C.y());
  of_view("view away", view.center_C.z());
  of_view("view spread", view.spread.x());
  of_view("view spread", view.spread.y());
  // Nothing of it is much less than it was to be, not just a yes for a no.
  std::optional<double> view_area;
  if (percepts.view) view_area = std::log(std::max(kLeastViewArea, view.area));
  list.number("view", "camera", "log view area", view_area);
  return list.features;
}

}  // namespace prehend::belief
