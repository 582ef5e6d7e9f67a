#pragma once

#include <string>
#include <vector>

#include "drivers/barrett/driver/driver.h"
#include "drivers/barrett/driver/gcl/driver.h"
#include "drivers/wire/guardian/guardian.h"
#include "prehend/graph/node.h"

namespace prehend::drivers::barrett {

/// Of the node, for either model.
struct Settings {
  Model model = Model::kBh8_280;
  std::string wire;              // bus of a BH8-280, line of a BH8-262
  unsigned bit_rate = kBitRate;  // bit/s, of a bus; 0: as it is
  DriverOptions can;
  gcl::DriverOptions gcl;
  bool guardian = true;
  double guardian_time = Guardian::kPatience;  // s
  double hot = 55;                             // degree Celsius
  std::string platform, platforms;
  std::vector<std::string> axes, pads;
  std::vector<std::size_t> cells;  // where a puck's cells are, PadCells
  double most_torque = 2200;       // MT of a BH8-280, motor command of a BH8-262
  const Gearing& gearing() const { return model == Model::kBh8_280 ? can.gearing : gcl.gearing; }
  std::string other_joints;
};

/// The node's parameters.
/// @throws geometry::InputError for one that is given, but not of the model.
Settings declare_settings(graph::Node& node);

/// Of the emulators, too: turns of motors and encoders for one of the joint.
Gearing declare_gearing(graph::Node& node, Model model);

}  // namespace prehend::drivers::barrett
