#pragma once

#include <string>
#include <vector>

#include "drivers/barrett/driver/driver.h"
#include "drivers/wire/guardian/guardian.h"
#include "prehend/graph/node.h"

namespace prehend::drivers::barrett {

struct Settings {
  std::string bus;
  unsigned bit_rate = kBitRate;  // bit/s; 0: as it is
  DriverOptions driver;
  bool guardian = true;
  double guardian_time = Guardian::kPatience;  // s
  double hot = 55;                             // degree Celsius
  std::string platform, platforms;
  std::vector<std::string> axes, pads;
  std::vector<std::size_t> cells;  // where a puck's cells are, PadCells
  double most_torque = 2200;       // MT
  std::string other_joints;
};

/// The node's parameters.
Settings declare_settings(graph::Node& node);

/// Of the emulator, too: turns of motors and encoders for one of the joint.
Gearing declare_gearing(graph::Node& node);

}  // namespace prehend::drivers::barrett
