#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <string>
#include <vector>

#include "drivers/dsa/driver/device.h"
#include "drivers/dsa/node/pads.h"
#include "drivers/wire/health/link_quality.h"
#include "drivers/wire/node/device_report.h"
#include "drivers/wire/node/wall_timer.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/node_program.h"
#include "prehend/robot/gripper_model.h"
#include "prehend/text/tree_file.h"

namespace {

using namespace prehend;
using namespace prehend::drivers;
using namespace prehend::drivers::dsa;

struct Settings {
  std::string line;
  unsigned baud = 115200;
  DriverOptions driver;
  std::vector<Pad> pads;
};

bool holds(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

std::vector<Pad> declare_pads(graph::Node& node) {
  const auto names = node.declare_parameter<std::vector<std::string>>(
      {.name = "pads",
       .default_value = {"left", "right"},
       .description = "names of the pads, published as /tactile/NAME",
       .read_only = true});
  const auto matrices = node.declare_parameter<std::vector<double>>(
      {.name = "matrices",
       .default_value = {0, 1},
       .minimum = 0,
       .maximum = 31,
       .description = "which matrix of the controller each pad is",
       .read_only = true});
  const auto flipped_rows = node.declare_parameter<std::vector<std::string>>(
      {.name = "flip_rows",
       .description = "pads whose row 0 is at the palm, not at the fingertip",
       .read_only = true});
  const auto flipped_columns = node.declare_parameter<std::vector<std::string>>(
      {.name = "flip_columns",
       .description = "pads whose columns run the other way",
       .read_only = true});
  const double newton_per_count = node.declare_parameter<double>(
      {.name = "newton_per_count",
       .default_value = robot::kDsaNewtonPerCount,
       .unit = "N",
       .minimum = 0,
       .description =
           "calibration: force of a texel for one count; that of the simulated pads, estimated",
       .read_only = true});
  const auto calibrations = node.declare_parameter<std::vector<std::string>>(
      {.name = "calibration",
       .description = "files that `prehend calibrate tactile` wrote, one for each pad; in place of "
                      "newton_per_count",
       .read_only = true});
  if (!calibrations.empty() && calibrations.size() != names.size()) {
    throw geometry::InputError(
        fmt::format("{} calibrations for {} pads", calibrations.size(), names.size()),
        "Give one file a pad, e.g. calibration:=\"[left.yaml, right.yaml]\"");
  }
  if (!calibrations.empty() && newton_per_count != robot::kDsaNewtonPerCount) {
    throw geometry::InputError("newton_per_count stands beside calibrations, which measured it",
                               "Keep one of the two");
  }
  if (names.size() != matrices.size()) {
    throw geometry::InputError(
        fmt::format("{} pads but {} matrices", names.size(), matrices.size()),
        "Give one matrix a pad, e.g. pads:=\"[left, right]\" matrices:=\"[0, 1]\"");
  }
  for (const auto* list : {&flipped_rows, &flipped_columns}) {
    for (const std::string& name : *list) {
      if (!holds(names, name)) {
        throw geometry::InputError("'" + name + "' is to be flipped, but is no pad",
                                   "Use the names of the parameter pads");
      }
    }
  }
  std::vector<Pad> pads;
  for (std::size_t i = 0; i < names.size(); ++i) {
    pads.push_back(
        {names[i], static_cast<std::size_t>(std::lround(matrices[i])),
         holds(flipped_rows, names[i]), holds(flipped_columns, names[i]), newton_per_count,
         calibrations.empty()
             ? std::nullopt
             : std::optional(robot::read_pad_calibration(text::tree_file(calibrations[i])))});
  }
  return pads;
}

Settings declare_settings(graph::Node& node) {
  Settings s;
  s.line = node.declare_parameter<std::string>(
      {.name = "line",
       .default_value = "/dev/ttyUSB0",
       .description = "serial line of the controller, or tcp://HOST:PORT (13000 in the vendor's "
                      "library)",
       .read_only = true});
  s.baud = static_cast<unsigned>(node.declare_parameter<int>({.name = "baud",
                                                              .default_value = 115200,
                                                              .unit = "bit/s",
                                                              .minimum = 1200,
                                                              .description = "of the serial line",
                                                              .read_only = true}));
  s.driver.run_length = node.declare_parameter<bool>(
      {.name = "run_length",
       .default_value = true,
       .description = "frames are run-length coded; else six pads give at most 11.7 a second",
       .read_only = true});
  s.driver.frame_rate =
      node.declare_parameter<int>({.name = "frame_rate",
                                   .default_value = 30,
                                   .unit = "1/s",
                                   .minimum = 1,
                                   .maximum = 65535,
                                   .description = "asked for; the firmware sends as fast as it can",
                                   .read_only = true});
  const double sensitivity = node.declare_parameter<double>(
      {.name = "sensitivity",
       .default_value = -1,
       .minimum = -1,
       .maximum = 1,
       .description = "of all pads, 0 to 1; negative: as the device has it",
       .read_only = true});
  if (sensitivity >= 0) s.driver.sensitivity = sensitivity;
  const int threshold = node.declare_parameter<int>(
      {.name = "threshold",
       .default_value = -1,
       .unit = "counts",
       .minimum = -1,
       .maximum = kFullScale,
       .description = "below which texels show 0; negative: as the device has it",
       .read_only = true});
  if (threshold >= 0) s.driver.threshold = threshold;
  s.driver.stale_time = node.declare_parameter<double>(
      {.name = "stale_time",
       .default_value = s.driver.stale_time,
       .unit = "s",
       .minimum = 0.05,
       .maximum = 60,
       .description = "without a frame, then it is reported and the stream begins anew",
       .read_only = true});
  s.pads = declare_pads(node);
  return s;
}

/// Health and counters, looked at in real time.
class Watcher {
 public:
  Watcher(graph::Node& node, Device& device)
      : node_(node),
        device_(device),
        report_(node),
        publisher_(node.advertise<msgs::DeviceStatus>("/tactile/device", graph::QoS::latched(1))),
        timer_(kPeriod, [this] { look(); }) {}
  /// Of frames that cannot be what the parameters say; "" when they can.
  void set_pads_problem(const std::string& words) {
    const std::lock_guard lock(mutex_);
    pads_problem_ = words;
  }

 private:
  static constexpr double kPeriod = 0.1;            // s
  static constexpr int kSample = 5, kPublish = 10;  // periods

  void look() {
    const DriverState state = device_.state();
    const Statistics s = device_.statistics();
    const std::uint64_t damaged = s.bad_frames + s.bad_checksums + s.lost_frames;
    if (state != DriverState::kStreaming) {
      quality_.restart();  // what is lost while it is away is no fault of the line
    } else if (looks_ % kSample == 0) {
      quality_.sample(s.frames, damaged + s.unanswered, 0, steady_now());
    }
    report_.tell(health(state));
    if (looks_++ % kPublish != 0) return;
    msgs::DeviceStatus status;
    status.mutable_header()->set_stamp(node_.clock().now());
    status.set_state(to_string(state));
    status.set_messages(s.frames);
    status.set_damaged(damaged);
    status.set_unanswered(s.unanswered);
    status.set_connections(s.restarts);
    status.set_rate(quality_.rate());
    status.set_damaged_part(quality_.harmed_part());
    publisher_.publish(status);
  }
  Health health(DriverState state) {
    const std::string trouble = device_.trouble();
    if (!trouble.empty()) return {Health::Level::kError, trouble};
    {
      const std::lock_guard lock(mutex_);
      if (!pads_problem_.empty()) return {Health::Level::kError, pads_problem_};
    }
    const Health health{Health::Level::kOk, to_string(state)};
    return state == DriverState::kStreaming ? with_warning(health, quality_.problem()) : health;
  }

  graph::Node& node_;
  Device& device_;
  DeviceReport report_;
  LinkQuality quality_;
  int looks_ = 0;
  std::mutex mutex_;  // guards pads_problem_
  std::string pads_problem_;
  graph::Publisher<msgs::DeviceStatus> publisher_;
  WallTimer timer_;
};

void run(graph::Node& node) {
  const Settings settings = declare_settings(node);
  DeviceReport report(node);
  std::vector<graph::Publisher<msgs::TactileFrame>> publishers;
  for (const Pad& pad : settings.pads) {
    publishers.push_back(
        node.advertise<msgs::TactileFrame>("/tactile/" + pad.name, graph::QoS::queue(50)));
  }
  std::atomic<Watcher*> watcher = nullptr;
  Device device(
      settings.driver, [&] { return open_byte_stream(settings.line, settings.baud); },
      [&](const Frame& frame, const std::vector<MatrixInfo>& matrices) {
        const std::int64_t stamp = node.clock().now();
        std::string problem;
        for (std::size_t i = 0; i < settings.pads.size(); ++i) {
          try {
            publishers[i].publish(pad_message(settings.pads[i], frame, matrices, stamp));
          } catch (const std::invalid_argument& error) {
            problem = error.what();
          }
        }
        if (watcher) watcher.load()->set_pads_problem(problem);
      },
      report.taker());
  Watcher watches(node, device);
  watcher = &watches;
  node.spin();
  watcher = nullptr;
}

const graph::RegisteredNodeProgram registered(
    {"dsa",
     "Reads the tactile pads of a Weiss DSACON32-m controller over a serial line or TCP, and "
     "publishes them as the simulated pads are: /tactile/left, /tactile/right, or whatever the "
     "parameter pads names. /tactile/device tells how good the line is."},
    run);

}  // namespace
