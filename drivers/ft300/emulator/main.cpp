#include <memory>
#include <string>

#include "drivers/ft300/emulator/sensor.h"
#include "drivers/wire/faults/faulty_stream.h"
#include "drivers/wire/node/fault_parameters.h"
#include "drivers/wire/node/linger.h"
#include "drivers/wire/stream/emulated_line.h"
#include "drivers/wire/stream/served_device.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node_program.h"

namespace {

using namespace prehend;
using namespace prehend::drivers;
using namespace prehend::drivers::ft300;

void run(graph::Node& node) {
  const auto line = node.declare_parameter<std::string>(
      {.name = "line",
       .default_value = "/tmp/prehend_ft300",
       .description = "the emulated serial line is made under this name; tcp:PORT: Modbus TCP, as "
                      "by a gateway",
       .read_only = true});
  SensorOptions options;
  options.is_tcp = line.starts_with("tcp:");
  options.unit = static_cast<std::uint8_t>(
      node.declare_parameter<int>({.name = "unit",
                                   .default_value = 9,
                                   .minimum = 1,
                                   .maximum = 247,
                                   .description = "Modbus address that it answers to",
                                   .read_only = true}));
  LineFaultParameters line_faults(node);
  Switch silent(node, "silent", "nothing that it says arrives");
  Switch reboot(node, "reboot", "set to true: starts anew");
  std::unique_ptr<ServedDevice<Sensor>> sensor;  // made below: --help makes no line
  const auto subscription = node.subscribe<msgs::Wrench>(
      "/world/wrench", graph::QoS::latest(), [&](const graph::Received<msgs::Wrench>& message) {
        const auto& force = message->wrench().force();
        const auto& torque = message->wrench().torque();
        const Measurement measurement{{force.x(), force.y(), force.z()},
                                      {torque.x(), torque.y(), torque.z()}};
        sensor->with_device([&](Sensor& s, Time) { s.set_measurement(measurement); });
      });
  auto stream = std::make_unique<FaultyStream>(make_emulated_line(line));
  FaultyStream& faulty = *stream;
  sensor = std::make_unique<ServedDevice<Sensor>>(options, std::move(stream));
  line_faults.connect([&](const LineFaults& faults) { faulty.set_faults(faults); });
  silent.connect(
      [&](bool on) { sensor->with_device([on](Sensor& s, Time) { s.set_silent(on); }); });
  reboot.connect([&](bool on) {
    if (on) sensor->with_device([](Sensor& s, Time now) { s.reboot(now); });
  });
  node.log_info("unit {} on {}", options.unit, line);
  node.spin();
  linger();
}

const graph::RegisteredNodeProgram registered(
    {"ft300_emulator",
     "Stands in for a Robotiq FT 300 at the other end of its line, by Modbus RTU and its stream or "
     "Modbus TCP; it feels what /world/wrench shows. Faults of the line and of the device are "
     "parameters that may be set while it runs."},
    run);

}  // namespace
