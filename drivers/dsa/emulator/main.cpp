#include <memory>
#include <string>
#include <vector>

#include "drivers/dsa/emulator/controller.h"
#include "drivers/wire/faults/faulty_stream.h"
#include "drivers/wire/node/fault_parameters.h"
#include "drivers/wire/stream/emulated_line.h"
#include "drivers/wire/stream/served_device.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node_program.h"

namespace {

using namespace prehend;
using namespace prehend::drivers;
using namespace prehend::drivers::dsa;

constexpr std::size_t kPads = 2;

void run(graph::Node& node) {
  const auto line = node.declare_parameter<std::string>(
      {.name = "line",
       .default_value = "/tmp/prehend_dsa",
       .description = "the emulated serial line is made under this name; tcp:PORT: a TCP port",
       .read_only = true});
  ControllerOptions options;
  options.start_up = node.declare_parameter<double>(
      {.name = "start_up",
       .default_value = 0.0,
       .unit = "s",
       .minimum = 0,
       .maximum = 60,
       .description = "after power-on until it answers; 8 in the real device",
       .read_only = true});
  options.frame_rate = node.declare_parameter<double>({.name = "frame_rate",
                                                       .default_value = 30.0,
                                                       .unit = "1/s",
                                                       .minimum = 0.1,
                                                       .maximum = 1000,
                                                       .description = "at most",
                                                       .read_only = true});
  const auto rows = node.declare_parameter<int>({.name = "rows",
                                                 .default_value = 14,
                                                 .minimum = 1,
                                                 .maximum = 255,
                                                 .description = "of each pad",
                                                 .read_only = true});
  const auto columns = node.declare_parameter<int>({.name = "columns",
                                                    .default_value = 6,
                                                    .minimum = 1,
                                                    .maximum = 255,
                                                    .description = "of each pad",
                                                    .read_only = true});
  options.matrices.assign(kPads, {columns, rows, 3.4});
  auto stream = std::make_unique<FaultyStream>(make_emulated_line(line));
  FaultyStream& faulty = *stream;
  ServedDevice<Controller> controller(options, std::move(stream));
  const auto cells = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  std::vector<std::uint16_t> texels(kPads * cells);
  const auto feel = [&](std::size_t pad, const msgs::TactileFrame& frame) {
    if (static_cast<std::size_t>(frame.intensity_size()) != cells) {
      node.report(graph::Health::kError,
                  fmt::format("the world's pads have {} texels, not {}; set rows and columns",
                              frame.intensity_size(), cells));
      return;
    }
    std::copy(frame.intensity().begin(), frame.intensity().end(),
              texels.begin() + static_cast<std::ptrdiff_t>(pad * cells));
    controller.with_device([&](Controller& c, Time) { c.set_texels(texels); });
  };
  std::vector<graph::Subscription> subscriptions;
  for (std::size_t pad = 0; pad < kPads; ++pad) {
    subscriptions.push_back(node.subscribe<msgs::TactileFrame>(
        pad == 0 ? "/world/tactile/left" : "/world/tactile/right", graph::QoS::latest(),
        [&feel, pad](const graph::Received<msgs::TactileFrame>& frame) { feel(pad, *frame); }));
  }
  declare_line_faults(node, [&](const LineFaults& faults) { faulty.set_faults(faults); });
  declare_switch(node, "silent", "nothing that it says arrives", [&](bool on) {
    controller.with_device([on](Controller& c, Time) { c.set_silent(on); });
  });
  declare_switch(node, "deaf", "it reads nothing, so that the line's buffer fills up",
                 [&](bool on) { controller.set_deaf(on); });
  declare_switch(node, "reboot", "set to true: starts anew", [&](bool on) {
    if (on) controller.with_device([](Controller& c, Time now) { c.reboot(now); });
  });
  node.declare_parameter<int>({.name = "dead_texel",
                               .default_value = -1,
                               .minimum = -1,
                               .maximum = static_cast<int>(kPads * cells) - 1,
                               .description = "this one shows 0 from now on",
                               .on_change = [&](const int& index) {
                                 if (index < 0) return;
                                 controller.with_device([index](Controller& c, Time) {
                                   c.kill_texel(static_cast<std::size_t>(index));
                                 });
                               }});
  node.log_info("{} pads of {} x {} on {}", kPads, rows, columns, line);
  node.spin();
}

const graph::RegisteredNodeProgram registered(
    {"dsa_emulator",
     "Stands in for a Weiss DSACON32-m with two pads at the other end of its line; they feel what "
     "/world/tactile/left and /world/tactile/right show. Faults of the line and of the device are "
     "parameters that may be set while it runs."},
    run);

}  // namespace
