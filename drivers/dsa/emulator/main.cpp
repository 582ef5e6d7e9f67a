#include <memory>
#include <string>
#include <vector>

#include "drivers/dsa/emulator/controller.h"
#include "drivers/wire/faults/faulty_stream.h"
#include "drivers/wire/node/fault_parameters.h"
#include "drivers/wire/node/linger.h"
#include "drivers/wire/stream/emulated_line.h"
#include "drivers/wire/stream/served_device.h"
#include "msgs/sensors.pb.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/node_program.h"

namespace {

using namespace prehend;
using namespace prehend::drivers;
using namespace prehend::drivers::dsa;

constexpr const char* kNobody = "-";

struct Settings {
  std::string line;
  ControllerOptions controller;
  std::vector<std::string> pads;  // of the world, one a matrix
};

Settings declare_settings(graph::Node& node) {
  Settings s;
  s.line = node.declare_parameter<std::string>(
      {.name = "line",
       .default_value = "/tmp/prehend_dsa",
       .description = "the emulated serial line is made under this name; tcp:PORT: a TCP port",
       .read_only = true});
  s.controller.start_up = node.declare_parameter<double>(
      {.name = "start_up",
       .default_value = 0.0,
       .unit = "s",
       .minimum = 0,
       .maximum = 60,
       .description = "after power-on until it answers; 8 in the real device",
       .read_only = true});
  s.controller.frame_rate = node.declare_parameter<double>({.name = "frame_rate",
                                                            .default_value = 30.0,
                                                            .unit = "1/s",
                                                            .minimum = 0.1,
                                                            .maximum = 1000,
                                                            .description = "at most",
                                                            .read_only = true});
  const auto matrices = node.declare_parameter<std::vector<std::string>>(
      {.name = "matrices",
       .default_value = {"6x14", "6x14"},
       .description = "columns x rows of each matrix, with @PITCH in mm when that is not 3.4; an "
                      "SDH-2 has [6x14, 6x13, 6x14, 6x13, 6x14, 6x13]",
       .read_only = true,
       .validate = [](const std::vector<std::string>& texts) {
         for (const std::string& text : texts) matrix_shape_from(text);
         return texts.empty() ? "a controller needs a matrix" : "";
       }});
  s.controller.matrices.clear();
  for (const std::string& text : matrices) {
    s.controller.matrices.push_back(matrix_shape_from(text));
  }
  s.pads = node.declare_parameter<std::vector<std::string>>(
      {.name = "pads",
       .default_value = {"left", "right"},
       .description = "whose /world/tactile/NAME each matrix feels; -: nobody's, as those beyond "
                      "the end of the list",
       .read_only = true});
  if (s.pads.size() > matrices.size()) {
    throw geometry::InputError(
        fmt::format("{} pads but {} matrices", s.pads.size(), matrices.size()),
        "Give matrices:= as many, e.g. \"[6x14, 6x14]\"");
  }
  s.pads.resize(matrices.size(), kNobody);
  return s;
}

void run(graph::Node& node) {
  const Settings settings = declare_settings(node);
  const auto& matrices = settings.controller.matrices;
  std::vector<std::size_t> begin{0};  // of each matrix' texels
  for (const MatrixShape& shape : matrices) {
    begin.push_back(begin.back() + static_cast<std::size_t>(shape.cells_x) *
                                       static_cast<std::size_t>(shape.cells_y));
  }
  LineFaultParameters line_faults(node);
  Switch silent(node, "silent", "nothing that it says arrives");
  Switch deaf(node, "deaf", "it reads nothing, so that the line's buffer fills up");
  Switch reboot(node, "reboot", "set to true: starts anew");
  LateParameter<int> dead_texel(node, {.name = "dead_texel",
                                       .default_value = -1,
                                       .minimum = -1,
                                       .maximum = static_cast<int>(begin.back()) - 1,
                                       .description = "this one shows 0 from now on"});
  std::unique_ptr<ServedDevice<Controller>> controller;  // made below: --help makes no line
  std::vector<std::uint16_t> texels(begin.back());
  const auto feel = [&](std::size_t matrix, const msgs::TactileFrame& frame) {
    const MatrixShape& shape = matrices[matrix];
    if (frame.rows() != static_cast<std::uint32_t>(shape.cells_y) ||
        frame.columns() != static_cast<std::uint32_t>(shape.cells_x) ||
        static_cast<std::size_t>(frame.intensity_size()) != begin[matrix + 1] - begin[matrix]) {
      node.report(graph::Health::kError,
                  fmt::format("the world's pad {} has {} x {} texels, but matrix {} has {} x {}. "
                              "Set matrices",
                              settings.pads[matrix], frame.columns(), frame.rows(), matrix,
                              shape.cells_x, shape.cells_y));
      return;
    }
    std::copy(frame.intensity().begin(), frame.intensity().end(),
              texels.begin() + static_cast<std::ptrdiff_t>(begin[matrix]));
    controller->with_device([&](Controller& c, Time) { c.set_texels(texels); });
  };
  std::vector<graph::Subscription> subscriptions;
  for (std::size_t i = 0; i < settings.pads.size(); ++i) {
    if (settings.pads[i] == kNobody) continue;
    subscriptions.push_back(node.subscribe<msgs::TactileFrame>(
        "/world/tactile/" + settings.pads[i], graph::QoS::latest(),
        [&feel, i](const graph::Received<msgs::TactileFrame>& frame) { feel(i, *frame); }));
  }
  auto stream = std::make_unique<FaultyStream>(make_emulated_line(settings.line));
  FaultyStream& faulty = *stream;
  controller = std::make_unique<ServedDevice<Controller>>(settings.controller, std::move(stream));
  line_faults.connect([&](const LineFaults& faults) { faulty.set_faults(faults); });
  silent.connect(
      [&](bool on) { controller->with_device([on](Controller& c, Time) { c.set_silent(on); }); });
  deaf.connect([&](bool on) { controller->set_deaf(on); });
  reboot.connect([&](bool on) {
    if (on) controller->with_device([](Controller& c, Time now) { c.reboot(now); });
  });
  dead_texel.connect([&](int index) {
    if (index < 0) return;
    controller->with_device(
        [index](Controller& c, Time) { c.kill_texel(static_cast<std::size_t>(index)); });
  });
  node.log_info("{} matrices with {} texels on {}", matrices.size(), begin.back(), settings.line);
  node.spin();
  linger();
}

const graph::RegisteredNodeProgram registered(
    {"dsa_emulator",
     "Stands in for a Weiss DSACON32-m at the other end of its line; its matrices feel what "
     "/world/tactile/left and /world/tactile/right show, or whatever pads names. Faults of the "
     "line and of the device are "
     "parameters that may be set while it runs."},
    run);

}  // namespace
